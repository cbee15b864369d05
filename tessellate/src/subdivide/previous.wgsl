// Where the vertices of patches lie in the mesh of another moment: positions alone.

@group(2) @binding(0) var<storage, read> topology: array<u32>;
@group(2) @binding(1) var<storage, read> classes: array<f32>;
@group(2) @binding(2) var<storage, read> in_before: array<u32>;
@group(2) @binding(3) var<storage, read> in_blocks: array<u32>;
@group(3) @binding(0) var<storage, read_write> out_previous: array<f32>;

fn places_before(triangle: u32) -> u32 {
    return in_before[triangle] + in_blocks[triangle / SCAN_BLOCK];
}

@compute @workgroup_size(256)
fn previous(@builtin(global_invocation_id) id: vec3u) {
    if (id.x >= params.count) {
        return;
    }
    let element = params.first + id.x;
    let triangle = places_owner(element);
    let piece = subdivide_patch(triangle);
    let rows = subdivide_most(subdivide_factors(piece));
    let place = subdivide_grid_place(element - places_before(triangle));
    let position = subdivide_point(triangle, piece, rows, place).position;
    let at = 3u * (params.vertex_base + element);
    out_previous[at] = position.x;
    out_previous[at + 1u] = position.y;
    out_previous[at + 2u] = position.z;
}
