// The sparse voxel grid and the walk through it. Layout, units and the rule of a step: mod.rs beside this file, which
// also prints the constants GRID_* above this text.

struct Grid {
    // World position of the low corner of cell 0, m.
    origin: vec3f,
    // Side of a cell, m.
    voxel_size: f32,
    // Per axis.
    cells: vec3i,
    // 0: h(n) of thin voxels, 1: one voxel, 2: h(n) of conservative ones.
    elevation: u32,
    // Bricks of 8^3 cells per axis.
    bricks: vec3i,
    // First word of the brick table.
    table_at: u32,
    // Groups of 4^3 bricks per axis.
    groups: vec3i,
    // First word of the groups' masks.
    groups_at: u32,
    // Regions of 4^3 groups per axis.
    regions: vec3i,
    // First word of the bricks.
    bricks_at: u32,
    // 1: planes are where surfaces are, 0: they only tell sides.
    contours: u32,
    // Words per record.
    record_words: u32,
    // Records before the grid's own, where a buffer holds those of several.
    first_record: u32,
    // Of packed points, per cell.
    point_steps: f32,
    // Cell 0 on its lattice.
    low: vec3i,
    // Where levels are nested: half the side of the box around the viewer that it is for, m.
    reach: f32,
    // World position of the low corner of the lattice's cell 0, m.
    lattice: vec3f,
}

@group(1) @binding(16) var<storage, read> grid_structure: array<u32>;

fn grid_index(p: vec3i, size: vec3i) -> u32 {
    return u32(p.x + size.x * (p.y + size.y * p.z));
}

// Side of the largest empty aligned block of a 4^3 mask that holds p (0..3 per axis), given by the mask's word that does:
// 0 = p is occupied, 1 or 2. Two z layers per word, so that an
// aligned 2^3 block never spans words.
fn grid_empty_side_within(layers: u32, p: vec3i) -> i32 {
    let bit = u32(p.x + 4 * p.y + 16 * (p.z & 1));
    if (((layers >> bit) & 1u) != 0u) {
        return 0;
    }
    let corner = u32((p.x & 2) + 4 * (p.y & 2));
    return select(1, 2, ((layers >> corner) & 0x00330033u) == 0u);
}

// The same of a mask as a whole, that may be empty: 4.
fn grid_empty_side(mask: vec2u, p: vec3i) -> i32 {
    if ((mask.x | mask.y) == 0u) {
        return 4;
    }
    return grid_empty_side_within(select(mask.x, mask.y, p.z >= 2), p);
}

fn grid_mask(at: u32) -> vec2u {
    return vec2u(grid_structure[at], grid_structure[at + 1u]);
}

// Which of a brick's eight 4^3 masks holds the cell, in Morton order.
fn grid_part(cell: vec3i) -> u32 {
    let p = (cell >> vec3u(2u)) & vec3i(1);
    return u32(p.x + 2 * p.y + 4 * p.z);
}

// Where a cell stands among the 512 of its brick: by mask, then by bit.
fn grid_cell_index(cell: vec3i) -> u32 {
    let p = cell & vec3i(3);
    return 64u * grid_part(cell) + u32(p.x + 4 * p.y + 16 * p.z);
}

// The cell that stands there in a brick, given by the index of its brick cell.
fn grid_cell(brick: u32, index: u32) -> vec3i {
    let size = vec3u(grid.bricks);
    let corner = vec3u(brick, brick / size.x, brick / (size.x * size.y)) % vec3u(size.xy, 0xffffffffu);
    let part = (vec3u(index) >> vec3u(6u, 7u, 8u)) & vec3u(1u);
    let p = (vec3u(index) >> vec3u(0u, 2u, 4u)) & vec3u(3u);
    return vec3i(8u * corner + 4u * part + p);
}

// What the table says about the brick of a cell of the grid.
fn grid_entry(cell: vec3i) -> u32 {
    return grid_structure[grid.table_at + grid_index(cell >> vec3u(3u), grid.bricks)];
}

// First word of the brick that holds the cell; the brick must not be empty.
fn grid_brick_at(cell: vec3i) -> u32 {
    return grid.bricks_at + GRID_BRICK_WORDS * (grid_entry(cell) & GRID_SLOTS);
}

// Side of the largest empty block around a cell of the grid, a power of two up to 128; 0 = the cell is occupied. One word
// is read, and of a part of a brick that is not empty a second: loads are what a step costs.
fn grid_block(cell: vec3i) -> i32 {
    let entry = grid_entry(cell);
    if (entry >= GRID_EMPTY) {
        return i32(entry - GRID_EMPTY);
    }
    let part = grid_part(cell);
    if (((entry >> (GRID_PARTS_BIT + part)) & 1u) == 0u) {
        return 4;
    }
    let word = GRID_BRICK_WORDS * (entry & GRID_SLOTS) + 2u * part + ((u32(cell.z) >> 1u) & 1u);
    return grid_empty_side_within(grid_structure[grid.bricks_at + word], cell & vec3i(3));
}

fn grid_occupied(cell: vec3i) -> bool {
    if (any(cell < vec3i(0)) || any(cell >= grid.cells)) {
        return false;
    }
    return grid_block(cell) == 0;
}

// Index of the record of an occupied cell, given by its brick's first word, its part and its bit in there: base of the
// brick, voxels in the masks before its own, bits before its own.
fn grid_record_in(brick: u32, part: u32, bit: u32) -> u32 {
    let mask = grid_mask(brick + 2u * part);
    let prefix = (grid_structure[brick + GRID_PREFIX_WORD + part / 2u] >> (16u * (part & 1u))) & 0xffffu;
    let below = (1u << (bit & 31u)) - 1u;
    let rank = select(countOneBits(mask.x & below), countOneBits(mask.x) + countOneBits(mask.y & below), bit >= 32u);
    return grid_first_record() + grid_structure[brick + GRID_BASE_WORD] + prefix + rank;
}

fn grid_record(cell: vec3i) -> u32 {
    let p = cell & vec3i(3);
    return grid_record_in(grid_brick_at(cell), grid_part(cell), u32(p.x + 4 * p.y + 16 * p.z));
}

// A point of the world in cells, moved to the grain `steps` of rasterizers. Rounded on the lattice: a grid elsewhere on it
// has the same triangles.
fn grid_moved(point: vec3f, steps: f32) -> vec3f {
    return round((point - grid.lattice) / grid.voxel_size * steps) / steps - vec3f(grid.low);
}

// How far above a surface a path starts, m: the least distance along its unit face normal that is surely outside the
// surface's own voxels, (|n|_1 + |n|_inf) / 2 voxels where they are thin, |n|_1 where not; the paper says one voxel.
fn grid_elevation(n: vec3f) -> f32 {
    let a = abs(n);
    let sum = a.x + a.y + a.z;
    let height = select(sum, 0.5 * (sum + max(a.x, max(a.y, a.z))), grid.elevation == 0u);
    return grid.voxel_size * select(height, 1.0, grid.elevation == 1u);
}
