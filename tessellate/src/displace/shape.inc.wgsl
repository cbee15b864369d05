// Displaced points and the frames that fit them, after points.inc.wgsl and displace.inc.wgsl. Formulas: mod.rs.

// Steeper slopes are brought down to this one, so that no normal turns over.
const SHAPE_STEEPEST = 8.0;

// How much of a crease a point lies on, by the length of its direction: 1 where faces around it have one normal, more at
// hard edges.
fn shape_crease(direction: vec3f) -> f32 {
    return smoothstep(1.02, 1.15, length(direction));
}

fn shape_height_limited(height: f32, lowest: f32, highest: f32) -> f32 {
    return clamp(height, min(lowest, 0.0), max(highest, 0.0));
}

// What one side of an edge says about a point of it: its height, and 1 if it has one.
fn shape_side_height(corner: u32, start_class: u32, factor: u32, along: f32) -> vec2f {
    let triangle = corner >> 2u;
    if (subdivide_patch(triangle).kind != SUBDIVIDE_SHAPED) {
        return vec2f(0.0);
    }
    let map = displace_map(triangle);
    let first = displace_place(map, subdivide_corner_vertex(corner));
    let last = displace_place(map, subdivide_corner_vertex(subdivide_next(corner)));
    let t = select(1.0 - along, along, subdivide_corner_class(corner) == start_class);
    let level = height_level(map, length((last - first) * vec2f(map.size)) / f32(factor));
    return vec2f(height_at(map, level, first + t * (last - first)), 1.0);
}

fn shape_is_flat(corner: u32) -> bool {
    let kind = subdivide_patch(corner >> 2u).kind;
    return kind == SUBDIVIDE_FLAT || kind == SUBDIVIDE_UNTOUCHED;
}

// A point of an edge, from what both sides know alike: `along` runs as the edge's record does.
fn shape_edge(edge: SubdivideEdge, along: f32) -> vec3f {
    let start_class = subdivide_corner_class(edge.side.x);
    let a = subdivide_class_load(start_class);
    let b = subdivide_class_load(subdivide_corner_class(subdivide_next(edge.side.x)));
    var sum = vec2f(0.0);
    var is_pinned = false;
    for (var i = 0u; i < 2u; i += 1u) {
        let corner = edge.side[i];
        if (corner != SUBDIVIDE_NONE) {
            sum += shape_side_height(corner, start_class, edge.factor, along);
            is_pinned = is_pinned || shape_is_flat(corner);
        }
    }
    let direction = a.along + along * (b.along - a.along);
    let even = mix(a.height, b.height, along);
    var height = even;
    if (sum.y > 0.0) {
        height = mix(sum.x / sum.y, even, shape_crease(direction));
    }
    height = select(height, 0.0, is_pinned);
    height = shape_height_limited(height, max(a.lowest, b.lowest), min(a.highest, b.highest));
    return a.position + along * (b.position - a.position) + params.relief * height * direction;
}

fn shape_inside(triangle: u32, piece: SubdividePatch, rows: u32, weights: vec2f) -> vec3f {
    let v = mesh_triangle(triangle);
    let position = mesh_interpolate(mesh_position(v.x), mesh_position(v.y), mesh_position(v.z), weights);
    if (piece.kind == SUBDIVIDE_FLAT) {
        return position;
    }
    let a = subdivide_class_load(piece.classes.x);
    let b = subdivide_class_load(piece.classes.y);
    let c = subdivide_class_load(piece.classes.z);
    let even = a.height + weights.x * (b.height - a.height) + weights.y * (c.height - a.height);
    var height = even;
    if (piece.kind == SUBDIVIDE_SHAPED) {
        let map = displace_map(triangle);
        let places = displace_places(map, triangle);
        let place = places.a + weights.x * places.ab + weights.y * places.ac;
        height = height_at(map, displace_level(map, places, rows), place);
    }
    height = shape_height_limited(
        height,
        max(a.lowest, max(b.lowest, c.lowest)),
        min(a.highest, min(b.highest, c.highest)),
    );
    // Out of the face by the height; within it, as hard edges ask for, evenly, so that nothing folds over.
    let sum = mesh_interpolate(mesh_normal(v.x), mesh_normal(v.y), mesh_normal(v.z), weights);
    let n = sum / max(length(sum), 1e-6);
    let direction = mesh_interpolate(a.along, b.along, c.along, weights);
    let out = dot(direction, n) * n;
    return position + params.relief * (height * out + even * (direction - out));
}

struct ShapeFrame {
    normal: vec3f,
    // w: handedness.
    tangent: vec4f,
}

// The part of a vector across a unit normal, unit length; any perpendicular where there is none.
fn shape_across(v: vec3f, normal: vec3f) -> vec3f {
    let across = v - dot(v, normal) * normal;
    let across_length = length(across);
    let axis = select(vec3f(1.0, 0.0, 0.0), vec3f(0.0, 1.0, 0.0), abs(normal.x) > 0.7);
    return select(normalize(cross(axis, normal)), across / max(across_length, 1e-12), across_length > 1e-9);
}

// `v`, across the unit vector `before`, turned as `before` is turned into `after`.
fn shape_turned(v: vec3f, before: vec3f, after: vec3f) -> vec3f {
    return v - dot(after, v) / (1.0 + dot(before, after)) * (before + after);
}

fn shape_frame(triangle: u32, piece: SubdividePatch, rows: u32, weights: vec2f) -> ShapeFrame {
    let point = mesh_point(triangle, weights);
    let n = point.normal;
    let base = ShapeFrame(n, vec4f(shape_across(point.tangent.xyz, n), point.tangent.w));
    if (piece.kind != SUBDIVIDE_SHAPED || piece.keeps_frame) {
        return base;
    }
    let map = displace_map(triangle);
    let places = displace_places(map, triangle);
    let place = places.a + weights.x * places.ab + weights.y * places.ac;
    let level = displace_level(map, places, rows);

    // Coordinates of about 1 over the triangle: neither products nor quotients leave the range of floats.
    let unit = max(max(abs(places.ab.x), abs(places.ab.y)), max(abs(places.ac.x), abs(places.ac.y)));
    let ab = places.ab / unit;
    let ac = places.ac / unit;
    let det = ab.x * ac.y - ab.y * ac.x;
    let v = mesh_triangle(triangle);
    let corner = mesh_position(v.x);
    let edge_b = mesh_position(v.y) - corner;
    let edge_c = mesh_position(v.z) - corner;
    let face = select(point.face_normal, -point.face_normal, dot(point.face_normal, n) < 0.0);
    let p_u = shape_turned((edge_b * ac.y - edge_c * ab.y) / det, face, n);
    let p_v = shape_turned((edge_c * ab.x - edge_b * ac.x) / det, face, n);
    let normal_a = mesh_normal(v.x);
    let normal_b = mesh_normal(v.y) - normal_a;
    let normal_c = mesh_normal(v.z) - normal_a;
    let sum_length = max(length(normal_a + weights.x * normal_b + weights.y * normal_c), 1e-3);
    let sum_u = (normal_b * ac.y - normal_c * ab.y) / det;
    let sum_v = (normal_c * ab.x - normal_b * ac.x) / det;
    let n_u = (sum_u - dot(n, sum_u) * n) / sum_length;
    let n_v = (sum_v - dot(n, sum_v) * n) / sum_length;

    // The surface moved by the height alone; where curvature would fold it over, as if it were flat.
    let area = dot(n, cross(p_u, p_v));
    let height = params.relief * height_at(map, level, place);
    var t_u = p_u + height * n_u;
    var t_v = p_v + height * n_v;
    let is_folded = dot(n, cross(t_u, t_v)) * sign(area) < 0.1 * abs(area);
    t_u = select(t_u, p_u, is_folded);
    t_v = select(t_v, p_v, is_folded);
    // Its slope, and no steeper than allowed.
    let moved_area = dot(n, cross(t_u, t_v));
    var slopes = unit * height_slopes(map, level, place);
    let gradient = (slopes.x * cross(t_v, n) + slopes.y * cross(n, t_u)) / select(moved_area, 1.0, moved_area == 0.0);
    slopes *= min(1.0, SHAPE_STEEPEST / max(length(gradient), 1e-9));
    let s_u = t_u + slopes.x * n;
    let s_v = t_v + slopes.y * n;
    let up = cross(s_u, s_v) * sign(moved_area);
    let up_length = length(up);
    if (!(up_length > 1e-30)) {
        return base;
    }
    let normal = up / up_length;
    // The tangent keeps its coordinates along u and v.
    let tangent = base.tangent.xyz;
    let along_u = dot(cross(tangent, p_v), n) / select(area, 1.0, area == 0.0);
    let along_v = dot(cross(p_u, tangent), n) / select(area, 1.0, area == 0.0);
    return ShapeFrame(normal, vec4f(shape_across(along_u * s_u + along_v * s_v, normal), base.tangent.w));
}
