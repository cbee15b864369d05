// Where the points of patches lie, after subdivide.inc.wgsl and a shape (shape_edge, shape_inside).

fn subdivide_class_load(class_index: u32) -> SubdivideClass {
    let at = 12u * class_index;
    return SubdivideClass(
        vec3f(classes[at], classes[at + 1u], classes[at + 2u]),
        classes[at + 3u],
        vec3f(classes[at + 4u], classes[at + 5u], classes[at + 6u]),
        classes[at + 7u],
        classes[at + 8u],
    );
}

// A point of a patch: whether it is one of the corners, on an edge, or inside, and where on this triangle.
struct SubdividePoint {
    position: vec3f,
    // Of the second and third corner.
    weights: vec2f,
}

fn subdivide_corner_point(triangle: u32, piece: SubdividePatch, corner: u32) -> SubdividePoint {
    let weights = select(vec2f(0.0), vec2f(1.0), vec2u(corner) == vec2u(1u, 2u));
    let class_index = piece.classes[corner];
    if (class_index == SUBDIVIDE_NONE) {
        return SubdividePoint(mesh_position(mesh_triangle(triangle)[corner]), weights);
    }
    let joined = subdivide_class_load(class_index);
    return SubdividePoint(joined.position + params.relief * joined.height * joined.along, weights);
}

// One call each for corners and for edges, whatever the side: copies that a compiler makes for each call might round
// differently, and the two triangles of an edge would no longer meet.
fn subdivide_point(triangle: u32, piece: SubdividePatch, rows: u32, place: vec2u) -> SubdividePoint {
    let row = place.x;
    let column = place.y;
    let weights = vec2f(f32(row - column), f32(column)) / f32(rows);
    if (column > 0u && column < row && row < rows) {
        return SubdividePoint(shape_inside(triangle, piece, rows, weights), weights);
    }
    var side = 0u;
    var step = row;
    if (column > 0u) {
        side = select(1u, 2u, column == row && column < rows);
        step = select(column, rows - row, side == 2u);
    }
    let edge = piece.edges[side];
    let factor = subdivide_edge_factor(edge);
    let local = subdivide_snap(step, factor, rows);
    if (local == 0u || local == factor) {
        return subdivide_corner_point(triangle, piece, select(side, (side + 1u) % 3u, local == factor));
    }
    // Only edges with a record have points between their ends.
    let record = subdivide_edge(edge);
    let is_forward = subdivide_corner_class(record.side.x) == piece.classes[side];
    let along = f32(select(factor - local, local, is_forward)) / f32(factor);
    // Corner `side` has 1 - t, the next one t.
    let t = f32(local) / f32(factor);
    var own = vec2f(t, 0.0);
    if (side == 1u) {
        own = vec2f(1.0 - t, t);
    } else if (side == 2u) {
        own = vec2f(0.0, 1.0 - t);
    }
    return SubdividePoint(shape_edge(record, along), own);
}
