// Patches and what joins them, after frame, surface, mesh and params. Rules: mod.rs beside this file; words: topology.rs.
// A `topology` is what the pass binds.

const SUBDIVIDE_NONE = 0xffffffffu;
const SUBDIVIDE_UNTOUCHED = 0u;
const SUBDIVIDE_FLAT = 1u;
const SUBDIVIDE_NEUTRAL = 2u;
const SUBDIVIDE_SHAPED = 3u;
const SUBDIVIDE_DROPPED = 4u;
const SUBDIVIDE_MOST = 64u;

struct SubdividePatch {
    edges: vec3u,
    classes: vec3u,
    kind: u32,
    // The normal map holds the relief: the vertex frame stays as it was.
    keeps_frame: bool,
}

fn subdivide_patch(triangle: u32) -> SubdividePatch {
    let at = 8u * triangle;
    return SubdividePatch(
        vec3u(topology[at], topology[at + 1u], topology[at + 2u]),
        vec3u(topology[at + 3u], topology[at + 4u], topology[at + 5u]),
        topology[at + 6u] & 7u,
        (topology[at + 6u] & 8u) != 0u,
    );
}

struct SubdivideEdge {
    // Triangle and corner it starts at; the second may be missing. It runs as the first side does.
    side: vec2u,
    factor: u32,
    is_shaped: bool,
}

fn subdivide_edge_at(edge: u32) -> u32 {
    return 8u * params.triangle_count + 4u * edge;
}

fn subdivide_edge(edge: u32) -> SubdivideEdge {
    let at = subdivide_edge_at(edge);
    return SubdivideEdge(vec2u(topology[at], topology[at + 1u]), topology[at + 2u], topology[at + 3u] != 0u);
}

// Class of a corner: triangle * 4 + 0..2.
fn subdivide_corner_class(corner: u32) -> u32 {
    return topology[8u * (corner >> 2u) + 3u + (corner & 3u)];
}

// The corner after it.
fn subdivide_next(corner: u32) -> u32 {
    return select(corner + 1u, corner - 2u, (corner & 3u) == 2u);
}

fn subdivide_corner_vertex(corner: u32) -> u32 {
    return mesh_triangle(corner >> 2u)[corner & 3u];
}

// First word of a class's list of corners, and how many there are.
fn subdivide_class(class_index: u32) -> vec2u {
    let at = subdivide_edge_at(params.edge_count) + 2u * class_index;
    return vec2u(topology[at], topology[at + 1u]);
}

fn subdivide_edge_factor(edge: u32) -> u32 {
    if (edge == SUBDIVIDE_NONE) {
        return 1u;
    }
    return topology[subdivide_edge_at(edge) + 2u];
}

fn subdivide_factors(piece: SubdividePatch) -> vec3u {
    return vec3u(
        subdivide_edge_factor(piece.edges.x),
        subdivide_edge_factor(piece.edges.y),
        subdivide_edge_factor(piece.edges.z),
    );
}

fn subdivide_most(factors: vec3u) -> u32 {
    return max(factors.x, max(factors.y, factors.z));
}

// Vertices and triangles of a patch. A grid of F rows whose border has as many points as the edges want: by Euler's
// formula F^2 - 3 F + sum of factors triangles.
fn subdivide_counts(piece: SubdividePatch) -> vec2u {
    if (piece.kind == SUBDIVIDE_DROPPED) {
        return vec2u(0u);
    }
    if (piece.kind == SUBDIVIDE_UNTOUCHED) {
        return vec2u(0u, 1u);
    }
    let factors = subdivide_factors(piece);
    let rows = subdivide_most(factors);
    return vec2u((rows + 1u) * (rows + 2u) / 2u, rows * rows + factors.x + factors.y + factors.z - 3u * rows);
}

// ---- the grid: row 0 is corner 0, row F runs from corner 1 to corner 2 ----

fn subdivide_grid_index(row: u32, column: u32) -> u32 {
    return row * (row + 1u) / 2u + column;
}

// Row and column of a number in the order of rows that grow by one.
fn subdivide_grid_place(index: u32) -> vec2u {
    var row = u32((sqrt(8.0 * f32(index) + 1.0) - 1.0) * 0.5);
    // The root may be off by one.
    if (row * (row + 1u) / 2u > index) {
        row -= 1u;
    } else if ((row + 1u) * (row + 2u) / 2u <= index) {
        row += 1u;
    }
    return vec2u(row, index - row * (row + 1u) / 2u);
}

// The point of an edge's own `factor` points that stands for point `step` of `rows`.
fn subdivide_snap(step: u32, factor: u32, rows: u32) -> u32 {
    return (2u * step * factor + rows) / (2u * rows);
}

// ---- what the corners at one place have in common ----

struct SubdivideClass {
    // Metres, before displacement.
    position: vec3f,
    // Of the displacement along `along`, metres.
    height: f32,
    // As long as it takes for every face around to move by 1.
    along: vec3f,
    // Heights between which nothing folds over, metres.
    lowest: f32,
    highest: f32,
}
