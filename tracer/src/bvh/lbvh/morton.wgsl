// A Morton code per triangle, of its centroid: 10 bits per axis, cubic cells.

@group(3) @binding(0) var<storage, read_write> out_pairs: array<vec2u>; // code, triangle

// Moves bit i of 10 to bit 3 i.
fn morton_spread(v: u32) -> u32 {
    var x = v;
    x = (x | (x << 16u)) & 0x030000ffu;
    x = (x | (x << 8u)) & 0x0300f00fu;
    x = (x | (x << 4u)) & 0x030c30c3u;
    return (x | (x << 2u)) & 0x09249249u;
}

@compute @workgroup_size(256)
fn morton(@builtin(global_invocation_id) id: vec3u) {
    if (id.x >= params.triangle_count) {
        return;
    }
    let v = mesh_triangle(id.x);
    let a = mesh_position(v.x);
    let b = mesh_position(v.y);
    let c = mesh_position(v.z);
    // The last code of all: triangles that no ray meets stay together.
    var code = 0x3fffffffu;
    if (lbvh_is_usable(a) && lbvh_is_usable(b) && lbvh_is_usable(c)) {
        let centroid = (a + b + c) * (1.0 / 3.0);
        let cell = vec3u(clamp((centroid - params.low) * params.cells_per_m, vec3f(0.0), vec3f(1023.0)));
        code = morton_spread(cell.x) | (morton_spread(cell.y) << 1u) | (morton_spread(cell.z) << 2u);
    }
    out_pairs[id.x] = vec2u(code, id.x);
}
