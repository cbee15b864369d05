// Vertices and triangles of each patch.

@group(2) @binding(0) var<storage, read> topology: array<u32>;
@group(3) @binding(0) var<storage, read_write> out_vertex_counts: array<u32>;
@group(3) @binding(1) var<storage, read_write> out_triangle_counts: array<u32>;

@compute @workgroup_size(256)
fn count(@builtin(global_invocation_id) id: vec3u) {
    let triangle = id.x;
    if (triangle >= params.triangle_count) {
        return;
    }
    let counts = subdivide_counts(subdivide_patch(triangle));
    out_vertex_counts[triangle] = counts.x;
    out_triangle_counts[triangle] = counts.y;
}
