// Whether a triangle and a cube overlap; after mesh, grid and the constants RASTER_*. Formulas: mod.rs beside this file.

// Error of a product and of the sum it goes into: 2^-22.
const SAT_ROUNDING = 2.384186e-7;

struct SatTriangle {
    // Corners in cells from the grid's low corner, moved to the grain.
    a: vec3f,
    b: vec3f,
    c: vec3f,
    // By which edges are multiplied, so that the longest side along an axis is 1 to 2.
    scale: f32,
    // Of the edges so scaled.
    normal: vec3f,
    // By how much rounding may be off in it: a sliver's normal is what is left of products that cancel.
    doubt: vec3f,
    // 0..2, the axis the normal is longest on.
    axis: u32,
    // By how much an overlap may be missed and still count, cells.
    slack: f32,
    // Whether it has an area and its corners are numbers.
    is_there: bool,
}

// Columns and depth of a point for an axis: (y, z, x), (z, x, y) or (x, y, z).
fn sat_turn(p: vec3f, axis: u32) -> vec3f {
    return select(select(p, p.zxy, axis == 1u), p.yzx, axis == 0u);
}

fn sat_turn_back(p: vec3i, axis: u32) -> vec3i {
    return select(select(p, p.yzx, axis == 1u), p.zxy, axis == 0u);
}

fn sat_corner(vertex: u32) -> vec3f {
    return grid_moved(mesh_position(vertex), RASTER_GRAIN);
}

// Beyond this, cells, products of coordinates would leave the range of floats; so are corners that are no numbers.
fn sat_is_near(p: vec3f) -> bool {
    return all((bitcast<vec3u>(p) & vec3u(0x7fffffffu)) < vec3u(bitcast<u32>(1e18)));
}

fn sat_largest(p: vec3f) -> f32 {
    return max(p.x, max(p.y, p.z));
}

// thin: the plane is moved behind the face, so that one on the boundary between two layers of cells is in one of them.
fn sat_triangle(triangle: u32, is_thin: bool) -> SatTriangle {
    let v = mesh_triangle(triangle);
    var t: SatTriangle;
    t.a = sat_corner(v.x);
    t.b = sat_corner(v.y);
    t.c = sat_corner(v.z);
    let is_near = sat_is_near(t.a) && sat_is_near(t.b) && sat_is_near(t.c);
    if (!is_near) {
        return t;
    }
    let ab = t.b - t.a;
    let ac = t.c - t.a;
    let longest = sat_largest(max(max(abs(ab), abs(ac)), abs(t.c - t.b)));
    // A power of two, so that what is collinear stays so.
    t.scale = bitcast<f32>(0x7f000000u - (bitcast<u32>(max(longest, 1e-9)) & 0x7f800000u));
    let p = ab * t.scale;
    let q = ac * t.scale;
    t.normal = cross(p, q);
    t.doubt = SAT_ROUNDING * (abs(p.yzx * q.zxy) + abs(p.zxy * q.yzx) + abs(t.normal));
    let size = abs(t.normal);
    t.axis = 2u;
    if (size.x * RASTER_PREFERENCE >= max(size.y, size.z)) {
        t.axis = 0u;
    } else if (size.y * RASTER_PREFERENCE >= size.z) {
        t.axis = 1u;
    }
    let largest = sat_largest(size);
    t.is_there = largest > 0.0;
    t.slack = select(1.0 / 4096.0, 0.0, is_thin);
    let along = select(vec3f(0.0), vec3f(1.0), vec3<bool>(t.axis == 0u, t.axis == 1u, t.axis == 2u));
    let behind = select(0.0, RASTER_TIE, is_thin) * -sign(t.normal) * along;
    t.a += behind;
    t.b += behind;
    t.c += behind;
    return t;
}

// Edges in one projection, per edge: coordinates of the corner it begins at and of the edge; the triangle's orientation.
fn sat_projection(x: vec3f, y: vec3f, ex: vec3f, ey: vec3f, up: f32, half: f32, slack: f32, is_thin: bool) -> bool {
    let inside = select(-1.0, 1.0, up >= 0.0) * (ey * x - ex * y);
    let most = max(abs(ex), abs(ey));
    let reach = half * select(abs(ex) + abs(ey), most, is_thin);
    let rounding = select(SAT_ROUNDING, 0.0, is_thin) * (abs(ey * x) + abs(ex * y));
    return all(inside + reach + slack * most + rounding >= vec3f(0.0));
}

// Whether the triangle meets a cube of half a side around a centre, cells; thin: its 6-separating core.
fn sat_overlaps(t: SatTriangle, center: vec3f, half: f32, slack: f32, is_thin: bool) -> bool {
    let a = t.a - center;
    let b = t.b - center;
    let c = t.c - center;
    let low = min(a, min(b, c));
    let high = max(a, max(b, c));
    // Boxes that only touch do not overlap; the conservative test's are larger.
    if (any(low >= vec3f(half + slack)) || any(high <= vec3f(-half - slack))) {
        return false;
    }
    let n = abs(t.normal);
    let most = sat_largest(n);
    let reach = half * select(n.x + n.y + n.z, most, is_thin);
    let rounding = select(dot(t.doubt, abs(a)), 0.0, is_thin);
    if (abs(dot(t.normal, a)) > reach + slack * most + rounding) {
        return false;
    }
    let x = vec3f(a.x, b.x, c.x);
    let y = vec3f(a.y, b.y, c.y);
    let z = vec3f(a.z, b.z, c.z);
    let ex = t.scale * (x.yzx - x);
    let ey = t.scale * (y.yzx - y);
    let ez = t.scale * (z.yzx - z);
    return sat_projection(x, y, ex, ey, t.normal.z, half, slack, is_thin)
        && sat_projection(y, z, ey, ez, t.normal.x, half, slack, is_thin)
        && sat_projection(z, x, ez, ex, t.normal.y, half, slack, is_thin);
}

// Depths along the triangle's axis at which cubes in a column around (u, v) may meet its plane: least and largest centre.
fn sat_depths(t: SatTriangle, column: vec2f, half: f32, slack: f32, is_thin: bool) -> vec2f {
    let n = sat_turn(t.normal, t.axis);
    let a = sat_turn(t.a, t.axis);
    let depth = a.z - dot(n.xy / n.z, column - a.xy);
    let s = abs(n);
    let doubt = sat_turn(t.doubt, t.axis);
    let rounding = dot(doubt, abs(vec3f(column, depth) - a)) / s.z;
    let reach = half * select((s.x + s.y + s.z) / s.z, 1.0, is_thin) + slack + rounding;
    return depth + vec2f(-reach, reach);
}
