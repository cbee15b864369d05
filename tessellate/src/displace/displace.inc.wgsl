// Height maps on triangles, after subdivide.inc.wgsl and height.

fn displace_place(map: HeightMap, vertex: u32) -> vec2f {
    return height_place(map, select(mesh_uv0(vertex), mesh_uv1(vertex), height_uv_set(map) == 1u));
}

fn displace_map(triangle: u32) -> HeightMap {
    return height_map(mesh_material(triangle));
}

// Places of a triangle's corners in its map.
struct DisplacePlaces {
    a: vec2f,
    ab: vec2f,
    ac: vec2f,
}

fn displace_places(map: HeightMap, triangle: u32) -> DisplacePlaces {
    let v = mesh_triangle(triangle);
    let a = displace_place(map, v.x);
    return DisplacePlaces(a, displace_place(map, v.y) - a, displace_place(map, v.z) - a);
}

// The mip for a triangle of which each side is cut in `rows`: by the root of its sides' mean square.
fn displace_level(map: HeightMap, places: DisplacePlaces, rows: u32) -> u32 {
    let ab = places.ab * vec2f(map.size);
    let ac = places.ac * vec2f(map.size);
    let bc = ac - ab;
    return height_level(map, sqrt((dot(ab, ab) + dot(ac, ac) + dot(bc, bc)) / 3.0) / f32(rows));
}
