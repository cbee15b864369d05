// Marks bricks and votes for winners, one fragment per covered column. Rules and formulas: mod.rs beside this file.

struct RasterParams {
    // The slots of this batch.
    first_slot: u32,
    slot_count: u32,
    // 1: the one round that is allowed a read-modify-write.
    atomic_round: u32,
    // Axes each triangle is projected along: 3, or 1 for the one its normal is longest on.
    axes: u32,
    // Records before the batch.
    first_record: u32,
}

// Whether this kernel draws the triangles with masks and blends, or the others: software adapters run both sides of a
// branch, and most triangles need no texture here.
override raster_holes: bool = false;

@group(0) @binding(1) var<uniform> params: RasterParams;
// Per brick cell: 1 where something is.
@group(3) @binding(0) var<storage, read_write> out_marks: array<atomic<u32>>;
// Per cell of a batch: the complement of the least key, 0 = empty.
@group(3) @binding(1) var<storage, read_write> out_keys: array<atomic<u32>>;
// 1 where some key became smaller in this round.
@group(3) @binding(2) var<storage, read_write> out_changed: atomic<u32>;

struct RasterCorner {
    @builtin(position) position: vec4f,
    @location(0) @interpolate(flat) triangle: u32,
    // 0..2, the axis columns run along.
    @location(1) @interpolate(flat) axis: u32,
    // Column and depth of the first corner, cells.
    @location(2) @interpolate(flat) base: vec3f,
    // Cells of depth per column; distance from the plane per cell of depth.
    @location(3) @interpolate(flat) slope: vec3f,
    // Depth of the nearest and the farthest corner, cells.
    @location(4) @interpolate(flat) range: vec2f,
}

// Columns and depth of a point for an axis: (y, z, x), (z, x, y) or (x, y, z).
fn raster_turn(p: vec3f, axis: u32) -> vec3f {
    return select(select(p, p.zxy, axis == 1u), p.yzx, axis == 0u);
}

fn raster_turn_back(p: vec3i, axis: u32) -> vec3i {
    return select(select(p, p.yzx, axis == 1u), p.zxy, axis == 0u);
}

fn raster_corner(vertex: u32) -> vec3f {
    return round((mesh_position(vertex) - grid.origin) / grid.voxel_size * RASTER_GRAIN) / RASTER_GRAIN;
}

fn raster_has_holes(triangle: u32) -> bool {
    return (materials[mesh_material(triangle)].flags & (MATERIAL_MASK | MATERIAL_BLEND)) != 0u;
}

fn raster_is_finite(p: vec3f) -> bool {
    return all((bitcast<vec3u>(p) & vec3u(0x7f800000u)) != vec3u(0x7f800000u));
}

@vertex
fn raster_vertex(@builtin(vertex_index) index: u32) -> RasterCorner {
    let triangle = index / (3u * params.axes);
    let vertices = mesh_triangle(triangle);
    let a = raster_corner(vertices.x);
    let b = raster_corner(vertices.y);
    let c = raster_corner(vertices.z);
    let n = cross(b - a, c - a);
    let size = abs(n);
    var out: RasterCorner;
    out.triangle = triangle;
    out.axis = 2u;
    if (params.axes == 3u) {
        out.axis = index / 3u % 3u;
    } else if (size.x * RASTER_PREFERENCE >= max(size.y, size.z)) {
        out.axis = 0u;
    } else if (size.y * RASTER_PREFERENCE >= size.z) {
        out.axis = 1u;
    }
    let normal = raster_turn(n, out.axis);
    // Nothing to draw: the other kernel's, no area, or corners that are no numbers.
    if (raster_has_holes(triangle) != raster_holes || normal.z == 0.0
        || !raster_is_finite(a) || !raster_is_finite(b) || !raster_is_finite(c)) {
        out.position = vec4f(0.0, 0.0, 0.5, 1.0);
        return out;
    }
    let behind = vec3f(0.0, 0.0, select(RASTER_TIE, -RASTER_TIE, normal.z > 0.0));
    let corners = array<vec3f, 3>(
        raster_turn(a, out.axis) + behind,
        raster_turn(b, out.axis) + behind,
        raster_turn(c, out.axis) + behind,
    );
    out.base = corners[0];
    out.slope = vec3f(-normal.xy / normal.z, abs(normal.z) / length(normal));
    out.range = vec2f(
        min(corners[0].z, min(corners[1].z, corners[2].z)),
        max(corners[0].z, max(corners[1].z, corners[2].z)),
    );
    // One pixel per column, rows downwards.
    let side = f32(max(grid.cells.x, max(grid.cells.y, grid.cells.z)));
    let at = corners[index % 3u].xy * (2.0 / side);
    out.position = vec4f(at.x - 1.0, 1.0 - at.y, 0.5, 1.0);
    return out;
}

struct RasterCell {
    inside: bool,
    cell: vec3i,
    // Distance of the plane from the cell's centre, 0..1/2.
    miss: f32,
}

fn raster_cell(in: RasterCorner) -> RasterCell {
    let column = floor(in.position.xy);
    let depth = clamp(in.base.z + dot(in.slope.xy, column + 0.5 - in.base.xy), in.range.x, in.range.y);
    let layer = floor(depth);
    let cell = raster_turn_back(vec3i(vec3f(column, layer)), in.axis);
    let inside = all(cell >= vec3i(0)) && all(cell < grid.cells);
    return RasterCell(inside, cell, in.slope.z * abs(depth - layer - 0.5));
}

// 0 emits, 1 opaque, 2 lets something through; 3 is not there at all.
fn raster_class(triangle: u32, cell: vec3i) -> u32 {
    let material = mesh_material(triangle);
    var share = 1.0;
    if (raster_holes) {
        let area = grid.voxel_size * grid.voxel_size;
        share = material_surface(material, voxel_point(triangle, cell), area).coverage;
    }
    if (share < VOXEL_LEAST_COVERAGE) {
        return 3u;
    }
    if (any(materials[material].emission > vec3f(0.0))) {
        return 0u;
    }
    return select(1u, 2u, share < 1.0 || materials[material].transmission > 0.0);
}

@fragment
fn raster_mark(in: RasterCorner) {
    let found = raster_cell(in);
    if (!found.inside || raster_class(in.triangle, found.cell) == 3u) {
        return;
    }
    atomicStore(&out_marks[grid_index(found.cell >> vec3u(3u), grid.bricks)], 1u);
}

@fragment
fn raster_vote(in: RasterCorner) {
    let found = raster_cell(in);
    if (!found.inside) {
        return;
    }
    let entry = grid_entry(found.cell);
    let slot = entry & GRID_SLOTS;
    let local = slot - params.first_slot;
    if (entry >= GRID_EMPTY || slot < params.first_slot || local >= params.slot_count) {
        return;
    }
    let kind = raster_class(in.triangle, found.cell);
    if (kind == 3u) {
        return;
    }
    let nearness = min(u32(128.0 * found.miss), 63u);
    let vote = ~((kind << 30u) | (nearness << 24u) | in.triangle);
    let at = GRID_BRICK_CELLS * local + grid_cell_index(found.cell);
    if (atomicLoad(&out_keys[at]) >= vote) {
        return;
    }
    if (params.atomic_round == 1u) {
        atomicMax(&out_keys[at], vote);
    } else {
        atomicStore(&out_keys[at], vote);
    }
    atomicStore(&out_changed, 1u);
}

// Cosine between normals of triangles that are one surface: 30 degrees.
const RASTER_FLAT = 0.8660254;

// By record of the batch: 1 = surfaces meet in it at an angle.
@group(3) @binding(3) var<storage, read_write> out_bends: array<atomic<u32>>;

// Unit normal in the order of the corners; cells are cubes.
fn raster_normal(triangle: u32) -> vec3f {
    let v = mesh_triangle(triangle);
    let a = mesh_position(v.x);
    let n = cross((mesh_position(v.y) - a) / grid.voxel_size, (mesh_position(v.z) - a) / grid.voxel_size);
    return n / max(length(n), 1e-30);
}

@fragment
fn raster_bend(in: RasterCorner) {
    let found = raster_cell(in);
    if (!found.inside) {
        return;
    }
    let entry = grid_entry(found.cell);
    let slot = entry & GRID_SLOTS;
    let local = slot - params.first_slot;
    if (entry >= GRID_EMPTY || slot < params.first_slot || local >= params.slot_count) {
        return;
    }
    let key = ~atomicLoad(&out_keys[GRID_BRICK_CELLS * local + grid_cell_index(found.cell)]);
    let winner = key & 0xffffffu;
    // What lets light through keeps its plane: a cube would be met once where glass is crossed twice.
    if ((key >> 30u) == 2u || winner == in.triangle || abs(dot(raster_normal(winner), raster_normal(in.triangle))) > RASTER_FLAT) {
        return;
    }
    if (raster_class(in.triangle, found.cell) != 3u) {
        atomicStore(&out_bends[grid_record(found.cell) - params.first_record], 1u);
    }
}
