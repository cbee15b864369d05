// The triangles of patches.

@group(2) @binding(0) var<storage, read> topology: array<u32>;
@group(2) @binding(1) var<storage, read> in_before: array<u32>;
@group(2) @binding(2) var<storage, read> in_blocks: array<u32>;
@group(2) @binding(3) var<storage, read> in_vertex_before: array<u32>;
@group(2) @binding(4) var<storage, read> in_vertex_blocks: array<u32>;
@group(3) @binding(0) var<storage, read_write> out_triangles: array<vec4u>;

fn places_before(triangle: u32) -> u32 {
    return in_before[triangle] + in_blocks[triangle / SCAN_BLOCK];
}

// Three grid points, as row and column.
struct TrianglesCorners {
    a: vec2u,
    b: vec2u,
    c: vec2u,
}

// The triangle that points to row 0, below grid point (row, column), and the one that points away from it, right of it.
fn triangles_up(row: u32, column: u32) -> TrianglesCorners {
    return TrianglesCorners(vec2u(row, column), vec2u(row + 1u, column), vec2u(row + 1u, column + 1u));
}

fn triangles_down(row: u32, column: u32) -> TrianglesCorners {
    return TrianglesCorners(vec2u(row, column), vec2u(row + 1u, column + 1u), vec2u(row, column + 1u));
}

// Whether an edge's first and last of `rows` steps lead anywhere, and not back to the corner.
fn triangles_first_lives(factor: u32, rows: u32) -> bool {
    return subdivide_snap(1u, factor, rows) > 0u;
}

fn triangles_last_lives(factor: u32, rows: u32) -> bool {
    return subdivide_snap(rows - 1u, factor, rows) < factor;
}

// The step of `rows` that leads from point `local` of an edge's `factor` to the next: the last that snaps to it.
fn triangles_step(local: u32, factor: u32, rows: u32) -> u32 {
    // snap(step) <= local  <=>  2 step factor + rows < 2 rows (local + 1)
    return (rows * (2u * local + 1u) - 1u) / (2u * factor);
}

// The triangle at step `step` of side 0, 1 or 2.
fn triangles_at_side(side: u32, step: u32, rows: u32) -> TrianglesCorners {
    if (side == 0u) {
        return triangles_up(step, 0u);
    }
    if (side == 1u) {
        return triangles_up(rows - 1u, step);
    }
    return triangles_up(rows - 1u - step, rows - 1u - step);
}

// Number `index` of a patch's triangles. A grid's triangles but those of which two corners snapped to the same point, in
// four kinds: away from the border; pointing away from row 0 next to a corner; along one edge; at a corner.
fn triangles_corners(index: u32, factors: vec3u, rows: u32) -> TrianglesCorners {
    if (rows == 1u) {
        return triangles_up(0u, 0u);
    }
    var left = index;
    if (rows == 2u) {
        if (left == 0u) {
            return triangles_down(1u, 0u);
        }
        left -= 1u;
    } else {
        // Pointing to row 0, not at the border.
        let ups = (rows - 3u) * (rows - 2u) / 2u;
        if (left < ups) {
            let place = subdivide_grid_place(left);
            return triangles_up(place.x + 2u, place.y + 1u);
        }
        left -= ups;
        // Pointing away, but for the three next to corners, whose numbers are 0, the last row's first and its last.
        let downs = rows * (rows - 1u) / 2u;
        if (left < downs - 3u) {
            let place = subdivide_grid_place(left + 1u + select(0u, 1u, left + 1u >= downs - (rows - 1u)));
            return triangles_down(place.x + 1u, place.y);
        }
        left -= downs - 3u;
        for (var corner = 0u; corner < 3u; corner += 1u) {
            let is_dead =
                !triangles_last_lives(factors[(corner + 2u) % 3u], rows) && !triangles_first_lives(factors[corner], rows);
            if (!is_dead) {
                if (left == 0u) {
                    let row = select(rows - 1u, 1u, corner == 0u);
                    return triangles_down(row, select(0u, rows - 2u, corner == 2u));
                }
                left -= 1u;
            }
        }
    }
    for (var side = 0u; side < 3u; side += 1u) {
        let factor = factors[side];
        let first = select(0u, 1u, triangles_first_lives(factor, rows));
        let last = select(0u, 1u, triangles_last_lives(factor, rows));
        // Steps that live, but for those at the corners.
        let live = factor - min(factor, first + last);
        if (left < live) {
            return triangles_at_side(side, triangles_step(left + first, factor, rows), rows);
        }
        left -= live;
    }
    for (var corner = 0u; corner < 3u; corner += 1u) {
        let lives =
            triangles_last_lives(factors[(corner + 2u) % 3u], rows) && triangles_first_lives(factors[corner], rows);
        if (lives) {
            if (left == 0u) {
                return triangles_at_side(corner, 0u, rows);
            }
            left -= 1u;
        }
    }
    return triangles_up(0u, 0u);
}

@compute @workgroup_size(256)
fn triangles(@builtin(global_invocation_id) id: vec3u) {
    if (id.x >= params.count) {
        return;
    }
    let element = params.first + id.x;
    let triangle = places_owner(element);
    let piece = subdivide_patch(triangle);
    let source = mesh_triangles[triangle];
    if (piece.kind == SUBDIVIDE_UNTOUCHED) {
        out_triangles[element] = source;
        return;
    }
    let factors = subdivide_factors(piece);
    let rows = subdivide_most(factors);
    let corners = triangles_corners(element - places_before(triangle), factors, rows);
    let first = params.vertex_base + in_vertex_before[triangle] + in_vertex_blocks[triangle / SCAN_BLOCK];
    out_triangles[element] = vec4u(
        first + subdivide_grid_index(corners.a.x, corners.a.y),
        first + subdivide_grid_index(corners.b.x, corners.b.y),
        first + subdivide_grid_index(corners.c.x, corners.c.y),
        source.w,
    );
}
