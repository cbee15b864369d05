// What the corners at one place have in common: one height, and one direction that moves every face around by as much.

// More triangles around one point are not looked at.
const CLASS_MOST = 4096u;
// The longest direction, for the sharpest corner that is still followed: 120 degrees between normals.
const CLASS_LONGEST = 2.0;
// How far towards a centre of curvature a point may go.
const CLASS_CURVED = 0.9;

fn class_angle(corner: u32) -> f32 {
    let here = mesh_position(subdivide_corner_vertex(corner));
    let next = subdivide_next(corner);
    let a = mesh_position(subdivide_corner_vertex(next)) - here;
    let b = mesh_position(subdivide_corner_vertex(subdivide_next(next))) - here;
    let lengths = length(a) * length(b);
    return select(0.0, acos(clamp(dot(a, b) / max(lengths, 1e-30), -1.0, 1.0)), lengths > 1e-30);
}

// 1/m along the triangle's side from this corner, positive where it bulges.
fn class_curvature(corner: u32) -> f32 {
    let from_vertex = subdivide_corner_vertex(corner);
    let to_vertex = subdivide_corner_vertex(subdivide_next(corner));
    let side = mesh_position(to_vertex) - mesh_position(from_vertex);
    return dot(mesh_normal(to_vertex) - mesh_normal(from_vertex), side) / max(dot(side, side), 1e-20);
}

fn shape_class(class_index: u32) -> SubdivideClass {
    let list = subdivide_class(class_index);
    let count = min(list.y, CLASS_MOST);
    var normals = vec3f(0.0);
    var angles = 0.0;
    var heights_sum = 0.0;
    var heights_count = 0.0;
    var is_pinned = false;
    var bulge = 1e-9;
    var hollow = 1e-9;
    for (var i = 0u; i < count; i += 1u) {
        let corner = topology[list.x + i];
        let triangle = corner >> 2u;
        let piece = subdivide_patch(triangle);
        let vertex = subdivide_corner_vertex(corner);
        let angle = class_angle(corner);
        normals += angle * mesh_normal(vertex);
        angles += angle;
        let curvature = class_curvature(corner);
        bulge = max(bulge, curvature);
        hollow = max(hollow, -curvature);
        if (piece.kind == SUBDIVIDE_SHAPED) {
            let map = displace_map(triangle);
            let rows = subdivide_most(subdivide_factors(piece));
            let level = displace_level(map, displace_places(map, triangle), rows);
            heights_sum += height_at(map, level, displace_place(map, vertex));
            heights_count += 1.0;
        }
        is_pinned = is_pinned || piece.kind == SUBDIVIDE_FLAT || piece.kind == SUBDIVIDE_UNTOUCHED;
    }
    var joined: SubdivideClass;
    joined.position = mesh_position(subdivide_corner_vertex(topology[list.x]));
    joined.lowest = -CLASS_CURVED / bulge;
    joined.highest = CLASS_CURVED / hollow;
    let mean = heights_sum / max(heights_count, 1.0);
    joined.height = select(clamp(mean, joined.lowest, joined.highest), 0.0, is_pinned);

    let normals_length = length(normals);
    let middle = normals / max(normals_length, 1e-9);
    var cosines = 0.0;
    for (var i = 0u; i < count; i += 1u) {
        let corner = topology[list.x + i];
        cosines += class_angle(corner) * dot(middle, mesh_normal(subdivide_corner_vertex(corner)));
    }
    // Normals that face each other have no direction in common.
    let reach = min(angles / max(cosines, 1e-9), CLASS_LONGEST);
    joined.along = select(vec3f(0.0), reach * middle, normals_length > 1e-6 * angles && cosines > 0.0);
    return joined;
}
