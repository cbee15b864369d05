// Whether a triangle of a cell is another surface than the cell's winner; after resolve/point.inc.wgsl. Rules: bend.rs.

// Whether planes are met, which then must not be apart; elsewhere they only tell sides.
override bend_meets_planes: bool = false;

struct Bend {
    // Cosine of their normals below which it is, either side.
    flat: f32,
    // Cells from the winner's plane beyond which it is.
    apart: f32,
    // What moves is another surface than what stands still.
    first_moving: u32,
}

// Unit, of a triangle with corners in the world; cells are cubes.
fn bend_normal(a: vec3f, b: vec3f, c: vec3f) -> vec3f {
    let n = cross((b - a) / grid.voxel_size, (c - a) / grid.voxel_size);
    return n / max(length(n), 1e-30);
}

// `stored` is the winner's key, complemented; `own` the triangle's normal, unit.
fn bend_is(bend: Bend, stored: u32, triangle: u32, own: vec3f, cell: vec3i) -> bool {
    let key = ~stored;
    let winner = key & 0xffffffu;
    // What lets light through keeps its plane: a cube would be met once where glass is crossed twice.
    if (stored == 0u || (key >> 30u) == 2u || winner == triangle) {
        return false;
    }
    if ((winner >= bend.first_moving) != (triangle >= bend.first_moving)) {
        return true;
    }
    let won = mesh_triangle(winner);
    let a = mesh_position(won.x);
    let normal = bend_normal(a, mesh_position(won.y), mesh_position(won.z));
    if (abs(dot(normal, own)) <= bend.flat) {
        return true;
    }
    if (!bend_meets_planes) {
        return false;
    }
    let v = mesh_triangle(triangle);
    let b = mesh_position(v.x);
    let c = mesh_position(v.y);
    let d = mesh_position(v.z);
    // Where this triangle is nearest to the cell's centre, cells from the winner's plane.
    let center = voxel_center(cell);
    let size = grid.voxel_size;
    let weights = voxel_nearest((b - center) / size, (c - center) / size, (d - center) / size, vec3f(0.0));
    let nearest = b + weights.x * (c - b) + weights.y * (d - b);
    return abs(dot(normal, nearest - a)) / size >= bend.apart;
}
