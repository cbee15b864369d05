// Thin voxels: one cell per covered column. Rules and formulas: mod.rs beside this file.

struct RasterCorner {
    @builtin(position) position: vec4f,
    @location(0) @interpolate(flat) triangle: u32,
    // 0..2, the axis columns run along.
    @location(1) @interpolate(flat) axis: u32,
    // Column and depth of the first corner, cells.
    @location(2) @interpolate(flat) base: vec3f,
    // Cells of depth per column; distance from the plane per cell of depth.
    @location(3) @interpolate(flat) slope: vec3f,
    // Depth of the nearest and the farthest corner, cells.
    @location(4) @interpolate(flat) range: vec2f,
}

@vertex
fn raster_vertex(@builtin(vertex_index) index: u32) -> RasterCorner {
    let triangle = index / (3u * params.axes);
    let vertices = mesh_triangle(triangle);
    let a = raster_corner(vertices.x);
    let b = raster_corner(vertices.y);
    let c = raster_corner(vertices.z);
    let n = cross(b - a, c - a);
    let size = abs(n);
    var out: RasterCorner;
    out.triangle = triangle;
    out.axis = 2u;
    if (params.axes == 3u) {
        out.axis = index / 3u % 3u;
    } else if (size.x * RASTER_PREFERENCE >= max(size.y, size.z)) {
        out.axis = 0u;
    } else if (size.y * RASTER_PREFERENCE >= size.z) {
        out.axis = 1u;
    }
    let normal = raster_turn(n, out.axis);
    // Nothing to draw: the other kernel's, no area, or corners that are no numbers.
    if (raster_has_holes(triangle) != raster_holes || normal.z == 0.0
        || !raster_is_finite(a) || !raster_is_finite(b) || !raster_is_finite(c)) {
        out.position = vec4f(0.0, 0.0, 0.5, 1.0);
        return out;
    }
    let behind = vec3f(0.0, 0.0, select(RASTER_TIE, -RASTER_TIE, normal.z > 0.0));
    let corners = array<vec3f, 3>(
        raster_turn(a, out.axis) + behind,
        raster_turn(b, out.axis) + behind,
        raster_turn(c, out.axis) + behind,
    );
    out.base = corners[0];
    out.slope = vec3f(-normal.xy / normal.z, abs(normal.z) / length(normal));
    out.range = vec2f(
        min(corners[0].z, min(corners[1].z, corners[2].z)),
        max(corners[0].z, max(corners[1].z, corners[2].z)),
    );
    // One pixel per column, rows downwards.
    let side = f32(max(grid.cells.x, max(grid.cells.y, grid.cells.z)));
    let at = corners[index % 3u].xy * (2.0 / side);
    out.position = vec4f(at.x - 1.0, 1.0 - at.y, 0.5, 1.0);
    return out;
}

// Of what a fragment finds.
fn raster_cell_count(in: RasterCorner) -> u32 {
    return 1u;
}

fn raster_cell(in: RasterCorner, index: u32) -> RasterCell {
    let column = floor(in.position.xy);
    let depth = clamp(in.base.z + dot(in.slope.xy, column + 0.5 - in.base.xy), in.range.x, in.range.y);
    let layer = floor(depth);
    let cell = raster_turn_back(vec3i(vec3f(column, layer)), in.axis);
    let inside = all(cell >= vec3i(0)) && all(cell < grid.cells);
    // Distance of the plane from the cell's centre, 0..1/2.
    let miss = in.slope.z * abs(depth - layer - 0.5);
    return RasterCell(inside, cell, min(u32(128.0 * miss), 63u));
}
