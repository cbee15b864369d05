// One invocation per voxel of an emitter: how brightly its record shines.

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
// Luminance of what each emitter's voxel stores; 0 where another surface won the cell.
@group(3) @binding(1) var<storage, read_write> out_luminances: array<f32>;

@compute @workgroup_size(64)
fn glowing(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + params.row * id.y;
    if (index >= params.count) {
        return;
    }
    let cell = vec3i(in_voxels[index].xyz);
    var luminance = 0.0;
    if (grid_occupied(cell)) {
        luminance = dot(surface_unpack_voxel(record_words(grid_record(cell))).emission, vec3f(0.2126, 0.7152, 0.0722));
    }
    out_luminances[index] = luminance;
}
