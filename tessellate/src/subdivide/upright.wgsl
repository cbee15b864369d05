// Vertex normals that lean over one of the triangles around them are turned back until they face all of them: slopes of a
// height map can be steeper, and change faster, than the patch that shows them. After the vertices.

@group(2) @binding(0) var<storage, read> topology: array<u32>;
@group(2) @binding(2) var<storage, read> in_before: array<u32>;
@group(2) @binding(3) var<storage, read> in_blocks: array<u32>;
// Positions are read; of each vertex its own normal and tangent are written.
@group(3) @binding(0) var<storage, read_write> out_vertices: array<u32>;

// Cosine to a triangle's normal that is leaning.
const UPRIGHT_LEAST = 0.01;
const UPRIGHT_ATTEMPTS = 32u;

fn places_before(triangle: u32) -> u32 {
    return in_before[triangle] + in_blocks[triangle / SCAN_BLOCK];
}

fn upright_position(vertex: u32) -> vec3f {
    let at = vertex * mesh_stride_words;
    return bitcast<vec3f>(vec3u(out_vertices[at], out_vertices[at + 1u], out_vertices[at + 2u]));
}

// Around grid point (row, column), in the order of corners; outside the patch where a coordinate is.
fn upright_neighbour(place: vec2u, index: u32) -> vec2u {
    switch (index % 6u) {
        case 0u: { return place - vec2u(1u, 1u); }
        case 1u: { return place - vec2u(1u, 0u); }
        case 2u: { return place + vec2u(0u, 1u); }
        case 3u: { return place + vec2u(1u, 1u); }
        case 4u: { return place + vec2u(1u, 0u); }
        default: { return place - vec2u(0u, 1u); }
    }
}

// Row and column of -1 have become the largest number.
fn upright_is_inside(place: vec2u, rows: u32) -> bool {
    return place.x <= rows && place.y <= place.x;
}

@compute @workgroup_size(256)
fn upright(@builtin(global_invocation_id) id: vec3u) {
    if (id.x >= params.count) {
        return;
    }
    let element = params.first + id.x;
    let triangle = places_owner(element);
    let piece = subdivide_patch(triangle);
    let factors = subdivide_factors(piece);
    let rows = subdivide_most(factors);
    let first = places_before(triangle);
    let place = subdivide_grid_place(element - first);
    let vertex = params.vertex_base + element;
    let here = upright_position(vertex);
    let at = vertex * mesh_stride_words;
    let normal = surface_face_normal_unpack(out_vertices[at + 3u]);
    let tangent = mesh_tangent_unpack(out_vertices[at + 4u]);

    // Unit normals of the triangles around, as far as they have an area.
    var faces: array<vec3f, 6>;
    for (var i = 0u; i < 6u; i += 1u) {
        faces[i] = vec3f(0.0);
        let a = upright_neighbour(place, i);
        let b = upright_neighbour(place, i + 1u);
        if (upright_is_inside(a, rows) && upright_is_inside(b, rows)) {
            let to_a = upright_position(params.vertex_base + first + subdivide_grid_index(a.x, a.y)) - here;
            let to_b = upright_position(params.vertex_base + first + subdivide_grid_index(b.x, b.y)) - here;
            let area = cross(to_b, to_a);
            let area_length = length(area);
            if (area_length > 1e-6 * length(to_a) * length(to_b) && area_length > 1e-20) {
                faces[i] = area / area_length;
            }
        }
    }
    // Files wind some triangles backwards.
    let w = vec2f(f32(place.x - place.y), f32(place.y)) / f32(rows);
    let point = mesh_point(triangle, w);
    let side = select(1.0, -1.0, dot(point.normal, point.face_normal) < 0.0);

    // Towards the triangle it leans over most, again and again (Kaczmarz's projections); the best of all tries stays.
    var chosen = normal;
    var best = -2.0;
    var offered = normal;
    for (var attempt = 0u; attempt < UPRIGHT_ATTEMPTS; attempt += 1u) {
        var least = 1.0;
        var towards = vec3f(0.0);
        for (var i = 0u; i < 6u; i += 1u) {
            let cosine = side * dot(offered, faces[i]);
            let is_least = any(faces[i] != vec3f(0.0)) && cosine < least;
            least = select(least, cosine, is_least);
            towards = select(towards, side * faces[i], is_least);
        }
        if (least > best) {
            chosen = offered;
            best = least;
        }
        if (best >= UPRIGHT_LEAST) {
            break;
        }
        // A little farther than needed, so that the last step arrives.
        let moved = offered + max(2.0 * UPRIGHT_LEAST - least, 0.0) * towards;
        let moved_length = length(moved);
        // Halfway, from the normal without relief: of a height field that one leans nowhere.
        let begins_anew = attempt == UPRIGHT_ATTEMPTS / 2u || moved_length < 1e-3;
        offered = select(moved / max(moved_length, 1e-6), point.normal, begins_anew);
    }
    let across = tangent.xyz - dot(tangent.xyz, chosen) * chosen;
    let across_length = length(across);
    let axis = select(vec3f(1.0, 0.0, 0.0), vec3f(0.0, 1.0, 0.0), abs(chosen.x) > 0.7);
    let squared = select(normalize(cross(axis, chosen)), across / max(across_length, 1e-6), across_length > 1e-6);
    if (any(chosen != normal)) {
        out_vertices[at + 3u] = surface_face_normal_pack(chosen);
        out_vertices[at + 4u] = mesh_tangent_pack(vec4f(squared, tangent.w));
    }
}
