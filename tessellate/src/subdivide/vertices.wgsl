// The vertices of patches, with everything a vertex has.

@group(2) @binding(0) var<storage, read> topology: array<u32>;
@group(2) @binding(1) var<storage, read> classes: array<f32>;
@group(2) @binding(2) var<storage, read> in_before: array<u32>;
@group(2) @binding(3) var<storage, read> in_blocks: array<u32>;
@group(3) @binding(0) var<storage, read_write> out_vertices: array<u32>;

fn places_before(triangle: u32) -> u32 {
    return in_before[triangle] + in_blocks[triangle / SCAN_BLOCK];
}

fn vertices_put2(at: u32, value: vec2f) {
    let words = bitcast<vec2u>(value);
    out_vertices[at] = words.x;
    out_vertices[at + 1u] = words.y;
}

@compute @workgroup_size(256)
fn vertices(@builtin(global_invocation_id) id: vec3u) {
    if (id.x >= params.count) {
        return;
    }
    let element = params.first + id.x;
    let triangle = places_owner(element);
    let piece = subdivide_patch(triangle);
    let rows = subdivide_most(subdivide_factors(piece));
    let place = subdivide_grid_place(element - places_before(triangle));
    let point = subdivide_point(triangle, piece, rows, place);
    let shading = shape_frame(triangle, piece, rows, point.weights);

    let at = (params.vertex_base + element) * mesh_stride_words;
    let position = bitcast<vec3u>(point.position);
    out_vertices[at] = position.x;
    out_vertices[at + 1u] = position.y;
    out_vertices[at + 2u] = position.z;
    out_vertices[at + 3u] = surface_face_normal_pack(shading.normal);
    out_vertices[at + 4u] = mesh_tangent_pack(shading.tangent);
    let v = mesh_triangle(triangle);
    let w = vec3f(1.0 - point.weights.x - point.weights.y, point.weights);
    vertices_put2(at + 5u, w.x * mesh_uv0(v.x) + w.y * mesh_uv0(v.y) + w.z * mesh_uv0(v.z));
    if (mesh_uv1_word != 0u) {
        vertices_put2(at + mesh_uv1_word, w.x * mesh_uv1(v.x) + w.y * mesh_uv1(v.y) + w.z * mesh_uv1(v.z));
    }
    if (mesh_color_word != 0u) {
        let color = w.x * mesh_color(v.x) + w.y * mesh_color(v.y) + w.z * mesh_color(v.z);
        out_vertices[at + mesh_color_word] = pack2x16unorm(color.rg);
        out_vertices[at + mesh_color_word + 1u] = pack2x16unorm(color.ba);
    }
}
