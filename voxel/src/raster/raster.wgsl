// Marks bricks, votes for winners and finds bends, per fragment the cells that a snippet finds: `RasterCorner`,
// `raster_vertex`, `raster_cell`. Rules and formulas: mod.rs beside this file.

struct RasterParams {
    // The slots of this batch.
    first_slot: u32,
    slot_count: u32,
    // 1: the one round that is allowed a read-modify-write.
    atomic_round: u32,
    // Axes each triangle is projected along: 3, or 1 for the one its normal is longest on.
    axes: u32,
    // Of bends.
    flat: f32,
    apart: f32,
    first_moving: u32,
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

struct RasterCell {
    inside: bool,
    cell: vec3i,
    // 6 bits, smaller is nearer to the cell's centre.
    nearness: u32,
}

// Columns and depth of a point for an axis: (y, z, x), (z, x, y) or (x, y, z).
fn raster_turn(p: vec3f, axis: u32) -> vec3f {
    return select(select(p, p.zxy, axis == 1u), p.yzx, axis == 0u);
}

fn raster_turn_back(p: vec3i, axis: u32) -> vec3i {
    return select(select(p, p.yzx, axis == 1u), p.zxy, axis == 0u);
}

fn raster_corner(vertex: u32) -> vec3f {
    return grid_moved(mesh_position(vertex), RASTER_GRAIN);
}

fn raster_has_holes(triangle: u32) -> bool {
    return (materials[mesh_material(triangle)].flags & (MATERIAL_MASK | MATERIAL_BLEND)) != 0u;
}

fn raster_is_finite(p: vec3f) -> bool {
    return all((bitcast<vec3u>(p) & vec3u(0x7f800000u)) != vec3u(0x7f800000u));
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
    for (var i = 0u; i < raster_cell_count(in); i += 1u) {
        raster_mark_cell(in, raster_cell(in, i));
    }
}

fn raster_mark_cell(in: RasterCorner, found: RasterCell) {
    if (!found.inside || raster_class(in.triangle, found.cell) == 3u) {
        return;
    }
    atomicStore(&out_marks[grid_index(found.cell >> vec3u(3u), grid.bricks)], 1u);
}

@fragment
fn raster_vote(in: RasterCorner) {
    for (var i = 0u; i < raster_cell_count(in); i += 1u) {
        raster_vote_cell(in, raster_cell(in, i));
    }
}

fn raster_vote_cell(in: RasterCorner, found: RasterCell) {
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
    let vote = ~((kind << 30u) | (found.nearness << 24u) | in.triangle);
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

// Per cell of a batch a bit: it has no plane.
@group(3) @binding(3) var<storage, read_write> out_bends: array<atomic<u32>>;

@fragment
fn raster_bend(in: RasterCorner) {
    for (var i = 0u; i < raster_cell_count(in); i += 1u) {
        raster_bend_cell(in, raster_cell(in, i));
    }
}

fn raster_bend_cell(in: RasterCorner, found: RasterCell) {
    if (!found.inside) {
        return;
    }
    let entry = grid_entry(found.cell);
    let slot = entry & GRID_SLOTS;
    let local = slot - params.first_slot;
    if (entry >= GRID_EMPTY || slot < params.first_slot || local >= params.slot_count) {
        return;
    }
    let at = GRID_BRICK_CELLS * local + grid_cell_index(found.cell);
    let bend = Bend(params.flat, params.apart, params.first_moving);
    let v = mesh_triangle(in.triangle);
    let own = bend_normal(mesh_position(v.x), mesh_position(v.y), mesh_position(v.z));
    if (bend_is(bend, atomicLoad(&out_keys[at]), in.triangle, own, found.cell) && raster_class(in.triangle, found.cell) != 3u) {
        atomicOr(&out_bends[at >> 5u], 1u << (at & 31u));
    }
}
