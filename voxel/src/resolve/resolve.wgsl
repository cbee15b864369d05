// One invocation per occupied voxel: looks at the winning triangle where it passes the voxel, packs a record.

struct ResolveParams {
    // First slot of the batch.
    first_slot: u32,
    // Voxels of the batch.
    voxel_count: u32,
    // Invocations per row of the dispatch.
    row: u32,
}

@group(0) @binding(1) var<uniform> params: ResolveParams;
// Complemented keys by cell of the batch.
@group(2) @binding(0) var<storage, read> in_keys: array<u32>;
// Brick cell by slot.
@group(2) @binding(1) var<storage, read> in_bricks: array<u32>;
// By record of the batch: cell of the batch, then the factor of its emission as f32 bits (0 = as it is).
@group(2) @binding(2) var<storage, read> in_list: array<vec2u>;
// Per cell of the batch a bit: surfaces meet in it at an angle.
@group(2) @binding(3) var<storage, read> in_bends: array<u32>;

@compute @workgroup_size(64)
fn resolve(@builtin(global_invocation_id) id: vec3u) {
    let record = id.x + params.row * id.y;
    if (record >= params.voxel_count) {
        return;
    }
    let entry = in_list[record];
    let brick = in_bricks[params.first_slot + entry.x / GRID_BRICK_CELLS];
    let cell = grid_cell(brick, entry.x % GRID_BRICK_CELLS);
    let triangle = ~in_keys[entry.x] & 0xffffffu;
    let area = grid.voxel_size * grid.voxel_size;
    let point = voxel_point(triangle, cell);
    var s = material_surface(mesh_material(triangle), point, area);
    s.emission *= select(bitcast<f32>(entry.y), 1.0, entry.y == 0u);
    s.normal = select(s.normal, point.face_normal, grid.contours != 0u);
    // Of the normal as it will be read back.
    let normal = surface_normal_unpack(surface_normal_pack(s.normal));
    let offset = dot(normal, (point.position - voxel_center(cell)) / grid.voxel_size);
    let bound = 127.0 * SURFACE_CONTOUR_STEP;
    let is_bent = ((in_bends[entry.x >> 5u] >> (entry.x & 31u)) & 1u) != 0u;
    s.contour = select(clamp(offset, -bound, bound), f32(SURFACE_CREASE_CODE) * SURFACE_CONTOUR_STEP, is_bent);
    let p = vec3u(grid.low + cell);
    record_store(record, surface_pack_voxel(s, surface_hash(p.x + surface_hash(p.y + surface_hash(p.z)))));
}
