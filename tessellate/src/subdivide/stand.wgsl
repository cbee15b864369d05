// What stands still was where it is.

@group(2) @binding(0) var<storage, read> in_vertices: array<u32>;
@group(3) @binding(0) var<storage, read_write> out_previous: array<u32>;

@compute @workgroup_size(256)
fn stand(@builtin(global_invocation_id) id: vec3u) {
    if (id.x >= params.count) {
        return;
    }
    let vertex = params.vertex_base + params.first + id.x;
    for (var i = 0u; i < 3u; i += 1u) {
        out_previous[3u * vertex + i] = in_vertices[vertex * mesh_stride_words + i];
    }
}
