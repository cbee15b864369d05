// One invocation per voxel of an emitter: hands the factor of its emission to the record's list.

struct EmittersParams {
    count: u32,
    // Invocations per row of the dispatch.
    row: u32,
    // Records of the batch.
    first_record: u32,
    record_count: u32,
}

@group(0) @binding(1) var<uniform> params: EmittersParams;
// Cell, factor as f32 bits.
@group(2) @binding(0) var<storage, read> in_voxels: array<vec4u>;
@group(3) @binding(0) var<storage, read_write> out_list: array<vec2u>;

@compute @workgroup_size(64)
fn emitters(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + params.row * id.y;
    if (index >= params.count) {
        return;
    }
    let voxel = in_voxels[index];
    let cell = vec3i(voxel.xyz);
    if (!grid_occupied(cell)) {
        return;
    }
    // Bricks of later batches have no masks yet, those of earlier ones hold smaller numbers.
    let record = grid_record(cell) - params.first_record;
    if (record < params.record_count) {
        out_list[record].y = voxel.w;
    }
}
