// Where a triangle passes a voxel; after surface, mesh and grid.

// Half a step of the 4 bits that hold a share: what covers less of a voxel is not stored.
const VOXEL_LEAST_COVERAGE = 0.0333333;

fn voxel_center(cell: vec3i) -> vec3f {
    return grid.lattice + grid.voxel_size * (vec3f(grid.low + cell) + 0.5);
}

// The point of a triangle that is nearest to p, as weights of its second and third corner (Ericson 2005, 5.1.5: by the
// region of the triangle's plane that p projects to).
fn voxel_nearest(a: vec3f, b: vec3f, c: vec3f, p: vec3f) -> vec2f {
    let ab = b - a;
    let ac = c - a;
    let d1 = dot(ab, p - a);
    let d2 = dot(ac, p - a);
    if (d1 <= 0.0 && d2 <= 0.0) {
        return vec2f(0.0);
    }
    let d3 = dot(ab, p - b);
    let d4 = dot(ac, p - b);
    if (d3 >= 0.0 && d4 <= d3) {
        return vec2f(1.0, 0.0);
    }
    let d5 = dot(ab, p - c);
    let d6 = dot(ac, p - c);
    if (d6 >= 0.0 && d5 <= d6) {
        return vec2f(0.0, 1.0);
    }
    let vc = d1 * d4 - d3 * d2;
    if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) {
        return vec2f(voxel_share(d1, d1 - d3), 0.0);
    }
    let vb = d5 * d2 - d1 * d6;
    if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) {
        return vec2f(0.0, voxel_share(d2, d2 - d6));
    }
    let va = d3 * d6 - d5 * d4;
    if (va <= 0.0 && d4 >= d3 && d5 >= d6) {
        let w = voxel_share(d4 - d3, (d4 - d3) + (d5 - d6));
        return vec2f(1.0 - w, w);
    }
    return vec2f(voxel_share(vb, va + vb + vc), voxel_share(vc, va + vb + vc));
}

// part / whole in 0..1; 0 where there is no whole.
fn voxel_share(part: f32, whole: f32) -> f32 {
    return select(0.0, clamp(part / max(whole, 1e-37), 0.0, 1.0), whole > 1e-37);
}

fn voxel_point(triangle: u32, cell: vec3i) -> MeshPoint {
    let v = mesh_triangle(triangle);
    // In voxels from the cell's centre, so that small triangles far from the origin keep their digits.
    let center = voxel_center(cell);
    let a = (mesh_position(v.x) - center) / grid.voxel_size;
    let b = (mesh_position(v.y) - center) / grid.voxel_size;
    let c = (mesh_position(v.z) - center) / grid.voxel_size;
    return mesh_point(triangle, voxel_nearest(a, b, c, vec3f(0.0)));
}
