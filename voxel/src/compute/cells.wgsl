// Visits the cells that the triangles of each brick meet, and hands them to compute_meet: votes.wgsl, bends.wgsl. Steps and formulas: mod.rs beside this file.

// Whether this kernel takes the triangles with masks and blends, or the others.
override compute_holes: bool = false;
// Whether it asks only if there is any cell.
override compute_marks: bool = false;

// Per chunk: brick cell, first of its triangles in in_lists, how many.
@group(2) @binding(4) var<storage, read> in_chunks: array<vec4u>;
@group(2) @binding(5) var<storage, read> in_lists: array<u32>;

fn compute_has_holes(triangle: u32) -> bool {
    return (materials[mesh_material(triangle)].flags & (MATERIAL_MASK | MATERIAL_BLEND)) != 0u;
}

// 0 emits, 1 opaque, 2 lets something through; 3 is not there at all.
fn compute_class(triangle: u32, cell: vec3i) -> u32 {
    let material = mesh_material(triangle);
    var share = 1.0;
    if (compute_holes) {
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

// Least keys of the chunk, complemented; the first word alone tells that there is one where only that is asked.
var<workgroup> compute_keys: array<atomic<u32>, 512>;

// The cells of a brick that a triangle meets, one row of columns in `rows`.
fn compute_cells(triangle: u32, brick: vec3i, row: i32, rows: i32) {
    if (compute_has_holes(triangle) != compute_holes) {
        return;
    }
    let is_thin = compute_is_thin();
    var t = sat_triangle(triangle, is_thin);
    // From the brick's low corner: small numbers, whose products are exact.
    let corner = vec3f(8 * brick);
    t.a -= corner;
    t.b -= corner;
    t.c -= corner;
    let size = vec3f(min(grid.cells - 8 * brick, vec3i(8)));
    let first = vec3i(floor(sat_turn(clamp(min(t.a, min(t.b, t.c)) - t.slack, vec3f(0.0), size), t.axis)));
    let last = vec3i(floor(sat_turn(clamp(max(t.a, max(t.b, t.c)) + t.slack, vec3f(-1.0), size - 1.0), t.axis)));
    // Lists are generous: it may end before this brick begins.
    if (any(first > last)) {
        return;
    }
    let scale = 1.0 / length(t.normal);
    // Rows are dealt out from the first that the triangle has.
    for (var v = first.y + row; v <= last.y; v += rows) {
        for (var u = first.x; u <= last.x; u += 1) {
            let depths = sat_depths(t, vec2f(vec2i(u, v)) + 0.5, 0.5, t.slack, is_thin);
            let bounds = vec2f(f32(first.z), f32(last.z));
            // One more on either side, that rounding may have taken; the test below decides.
            let span = vec2i(clamp(floor(depths - 0.5) + vec2f(0.0, 1.0), bounds.xx, bounds.yy));
            for (var w = span.x; w <= span.y; w += 1) {
                let local = sat_turn_back(vec3i(u, v, w), t.axis);
                let center = vec3f(local) + 0.5;
                if (!sat_overlaps(t, center, 0.5, t.slack, is_thin)) {
                    continue;
                }
                let cell = 8 * brick + local;
                let kind = compute_class(triangle, cell);
                if (kind == 3u) {
                    continue;
                }
                if (compute_marks) {
                    atomicStore(&compute_keys[0], 1u);
                    return;
                }
                let miss = abs(dot(t.normal, t.a - center)) * scale;
                let nearness = min(u32(select(COMPUTE_STEPS_CONSERVATIVE, COMPUTE_STEPS_THIN, is_thin) * miss), 63u);
                compute_meet(triangle, t.normal * scale, cell, (kind << 30u) | (nearness << 24u) | triangle);
            }
        }
    }
}

// The triangles of a chunk, dealt out to 64 invocations: where they are few, eight to each, a row of columns apiece.
fn compute_chunk(chunk: vec4u, local: u32) {
    let size = vec3u(grid.bricks);
    let brick = vec3i(vec3u(chunk.x, chunk.x / size.x, chunk.x / (size.x * size.y)) % vec3u(size.xy, 0xffffffffu));
    let share = select(1u, 8u, chunk.z <= 32u);
    for (var i = local / share; i < chunk.z; i += 64u / share) {
        if (compute_marks && atomicLoad(&compute_keys[0]) != 0u) {
            return;
        }
        compute_cells(in_lists[chunk.y + i], brick, i32(local % share), i32(share));
    }
}

fn compute_chunk_of(group: vec3u) -> vec4u {
    let index = group.x + params.row * group.y;
    return select(in_chunks[min(index, params.count - 1u)], vec4u(0u), index >= params.count);
}

// Of the chunk's brick, in the batch; one behind them where the brick is in another.
fn compute_slot_of(chunk: vec4u) -> u32 {
    let entry = grid_structure[grid.table_at + chunk.x];
    let slot = (entry & GRID_SLOTS) - params.first_slot;
    return select(slot, params.slot_count, entry >= GRID_EMPTY || slot >= params.slot_count);
}
