// Counts triangles of which a part is outside the grid. After surface, mesh and grid.inc.wgsl.

struct ClipParams {
    first_triangle: u32,
    count: u32,
    // Invocations per row of the dispatch.
    row: u32,
}

@group(0) @binding(1) var<uniform> params: ClipParams;
@group(3) @binding(0) var<storage, read_write> out_clipped: atomic<u32>;

fn clip_is_inside(vertex: u32) -> bool {
    let p = (mesh_position(vertex) - grid.origin) / grid.voxel_size;
    return all(p >= vec3f(0.0)) && all(p <= vec3f(grid.cells));
}

@compute @workgroup_size(64)
fn clip_count(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + params.row * id.y;
    if (index >= params.count) {
        return;
    }
    let v = mesh_triangle(params.first_triangle + index);
    if (!(clip_is_inside(v.x) && clip_is_inside(v.y) && clip_is_inside(v.z))) {
        atomicAdd(&out_clipped, 1u);
    }
}
