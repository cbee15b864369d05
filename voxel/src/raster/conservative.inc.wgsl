// Conservative voxels: every cell that a triangle passes. A quadrilateral around the triangle's columns is drawn, and each
// fragment tests the cells of its column (Schwarz and Seidel 2010). Rules and formulas: mod.rs beside this file.

struct RasterCorner {
    @builtin(position) position: vec4f,
    @location(0) @interpolate(flat) triangle: u32,
    // 0..2, the axis columns run along.
    @location(1) @interpolate(flat) axis: u32,
}

// Corners as columns and depth, in cells, and the normal they make.
struct RasterTriangle {
    a: vec3f,
    b: vec3f,
    c: vec3f,
    normal: vec3f,
}

fn raster_triangle(triangle: u32, axis: u32) -> RasterTriangle {
    let v = mesh_triangle(triangle);
    let a = raster_turn(raster_corner(v.x), axis);
    let b = raster_turn(raster_corner(v.y), axis);
    let c = raster_turn(raster_corner(v.z), axis);
    let n = cross(b - a, c - a);
    let behind = vec3f(0.0, 0.0, select(RASTER_TIE, -RASTER_TIE, n.z > 0.0));
    return RasterTriangle(a + behind, b + behind, c + behind, n);
}

@vertex
fn raster_vertex(@builtin(vertex_index) index: u32) -> RasterCorner {
    var out: RasterCorner;
    out.triangle = index / (6u * params.axes);
    let t = raster_triangle(out.triangle, 2u);
    let size = abs(t.normal);
    out.axis = 2u;
    if (size.x * RASTER_PREFERENCE >= max(size.y, size.z)) {
        out.axis = 0u;
    } else if (size.y * RASTER_PREFERENCE >= size.z) {
        out.axis = 1u;
    }
    // Nothing to draw: the other kernel's, no area, or corners that are no numbers.
    if (raster_has_holes(out.triangle) != raster_holes || max(size.x, max(size.y, size.z)) == 0.0
        || !raster_is_finite(t.a) || !raster_is_finite(t.b) || !raster_is_finite(t.c)) {
        out.position = vec4f(0.0, 0.0, 0.5, 1.0);
        return out;
    }
    let a = raster_turn(t.a, out.axis).xy;
    let b = raster_turn(t.b, out.axis).xy;
    let c = raster_turn(t.c, out.axis).xy;
    let side = f32(max(grid.cells.x, max(grid.cells.y, grid.cells.z)));
    let low = clamp(floor(min(a, min(b, c)) - RASTER_TIE), vec2f(0.0), vec2f(side));
    let high = clamp(floor(max(a, max(b, c)) + RASTER_TIE) + 1.0, vec2f(0.0), vec2f(side));
    // Two triangles: 0 1 2, 2 1 3.
    let k = index % 3u;
    let corner = select(k, select(select(3u, 1u, k == 1u), 2u, k == 0u), index % 6u > 2u);
    let at = select(low, high, vec2<bool>((corner & 1u) != 0u, (corner & 2u) != 0u)) * (2.0 / side);
    out.position = vec4f(at.x - 1.0, 1.0 - at.y, 0.5, 1.0);
    return out;
}

// Cells by which a triangle must enter a cell to pass it, less than RASTER_TIE: 2^-12.
const RASTER_TOUCH = 0.000244140625;

// Whether a triangle in the plane overlaps the unit square around p; `turn` is 1 where its corners go counter-clockwise.
// What only touches does not: a face on a boundary between cells belongs to one side.
fn raster_overlaps(a: vec2f, b: vec2f, c: vec2f, turn: f32, p: vec2f) -> bool {
    var corners = array<vec2f, 3>(a, b, c);
    for (var i = 0u; i < 3u; i += 1u) {
        let edge = corners[(i + 1u) % 3u] - corners[i];
        let inwards = turn * vec2f(-edge.y, edge.x);
        let reach = (0.5 - RASTER_TOUCH) * (abs(inwards.x) + abs(inwards.y));
        if (dot(inwards, p - corners[i]) + reach < 0.0) {
            return false;
        }
    }
    return true;
}

// Cells of a column that the triangle's plane may pass: its slopes are at most 1.
fn raster_cell_count(in: RasterCorner) -> u32 {
    return 3u;
}

fn raster_cell(in: RasterCorner, index: u32) -> RasterCell {
    let t = raster_triangle(in.triangle, in.axis);
    let a = t.a;
    let b = t.b;
    let c = t.c;
    let n = t.normal;
    let column = floor(in.position.xy) + 0.5;
    let slope = -n.xy / n.z;
    let depth = a.z + dot(slope, column - a.xy);
    let half = 0.5 * (abs(slope.x) + abs(slope.y));
    let low = max(depth - half, min(a.z, min(b.z, c.z)));
    let high = min(depth + half, max(a.z, max(b.z, c.z)));
    let layer = floor(low + RASTER_TOUCH) + f32(index);
    let p = vec3f(column, layer + 0.5);
    let cell = raster_turn_back(vec3i(vec3f(floor(in.position.xy), layer)), in.axis);
    let turns = select(vec3f(-1.0), vec3f(1.0), n >= vec3f(0.0));
    let inside = layer <= max(high - RASTER_TOUCH, low) && all(cell >= vec3i(0)) && all(cell < grid.cells)
        && raster_overlaps(a.xy, b.xy, c.xy, turns.z, p.xy)
        && raster_overlaps(a.yz, b.yz, c.yz, turns.x, p.yz)
        && raster_overlaps(a.zx, b.zx, c.zx, turns.y, p.zx);
    let weights = voxel_nearest(a - p, b - p, c - p, vec3f(0.0));
    let miss = length(a - p + weights.x * (b - a) + weights.y * (c - a));
    return RasterCell(inside, cell, min(u32(72.0 * miss), 63u));
}
