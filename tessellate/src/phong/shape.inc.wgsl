// Points pulled towards the tangent planes of the corners, after points.inc.wgsl. Formula: mod.rs beside this file.

// A point on the tangent plane of a vertex.
fn shape_projected(point: vec3f, vertex: u32) -> vec3f {
    let normal = mesh_normal(vertex);
    return point - dot(point - mesh_position(vertex), normal) * normal;
}

// A point of an edge: the mean of what its sides make of it, which at a crease have their own normals.
fn shape_edge(edge: SubdivideEdge, along: f32) -> vec3f {
    let start_class = subdivide_corner_class(edge.side.x);
    let a = subdivide_class_load(start_class).position;
    let b = subdivide_class_load(subdivide_corner_class(subdivide_next(edge.side.x))).position;
    let point = a + along * (b - a);
    var sum = vec3f(0.0);
    var count = 0.0;
    for (var i = 0u; i < 2u; i += 1u) {
        let corner = edge.side[i];
        if (corner != SUBDIVIDE_NONE) {
            let first = shape_projected(point, subdivide_corner_vertex(corner));
            let last = shape_projected(point, subdivide_corner_vertex(subdivide_next(corner)));
            let t = select(1.0 - along, along, subdivide_corner_class(corner) == start_class);
            sum += first + t * (last - first);
            count += 1.0;
        }
    }
    return point + params.relief * (sum / max(count, 1.0) - point);
}

fn shape_inside(triangle: u32, piece: SubdividePatch, rows: u32, weights: vec2f) -> vec3f {
    let v = mesh_triangle(triangle);
    let point = mesh_interpolate(mesh_position(v.x), mesh_position(v.y), mesh_position(v.z), weights);
    let pulled = mesh_interpolate(
        shape_projected(point, v.x),
        shape_projected(point, v.y),
        shape_projected(point, v.z),
        weights,
    );
    return select(point + params.relief * (pulled - point), point, piece.kind == SUBDIVIDE_FLAT);
}

struct ShapeFrame {
    normal: vec3f,
    // w: handedness.
    tangent: vec4f,
}

// The normals that made the shape are its normals (Boubekeur and Alexa keep them too).
fn shape_frame(triangle: u32, piece: SubdividePatch, rows: u32, weights: vec2f) -> ShapeFrame {
    let point = mesh_point(triangle, weights);
    let across = point.tangent.xyz - dot(point.tangent.xyz, point.normal) * point.normal;
    let across_length = length(across);
    let n = point.normal;
    let axis = select(vec3f(1.0, 0.0, 0.0), vec3f(0.0, 1.0, 0.0), abs(n.x) > 0.7);
    let tangent = select(normalize(cross(axis, n)), across / max(across_length, 1e-12), across_length > 1e-9);
    return ShapeFrame(n, vec4f(tangent, point.tangent.w));
}
