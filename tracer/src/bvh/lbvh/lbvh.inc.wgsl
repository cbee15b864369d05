// What the kernels that build an LBVH share. See mod.rs.

struct LbvhParams {
    // Corner of the Morton grid, m.
    low: vec3f,
    triangle_count: u32,
    // Inner nodes; 0 where all triangles fit one leaf.
    node_count: u32,
    // Blocks of the sort.
    block_count: u32,
    // Lowest bit of the digit that is sorted by.
    shift: u32,
    // Morton cells per metre.
    cells_per_m: f32,
    // How much boxes grow on each side, per metre of the largest coordinate.
    margin: f32,
}

@group(0) @binding(0) var<uniform> params: LbvhParams;

// A child: up to 4 triangles (their number from this bit on, the first one's place below it), or a node.
const LBVH_COUNT_BIT = 29u;
const LBVH_MOST_IN_LEAF = 4u;
const LBVH_NO_PARENT = 0xffffffffu;
// m, FARTHEST_M of ../mod.rs.
const LBVH_FARTHEST = 1e12;
// m. Triangles with a coordinate that is not a number up to LBVH_FARTHEST shrink to a point here: no box takes them in,
// and no ray meets them. Slab distances of the point are still floats: bvh_ray keeps inverses below 1e20.
const LBVH_NOWHERE = 1e18;

// Element of the triangle at a place.
fn lbvh_triangle_at(place: u32) -> u32 {
    return 4u * params.node_count + 3u * place;
}

// Compares bits: what is no number does not compare as a float.
fn lbvh_is_usable(v: vec3f) -> bool {
    return all((bitcast<vec3u>(v) & vec3u(0x7fffffffu)) <= vec3u(bitcast<u32>(LBVH_FARTHEST)));
}

// Whole numbers in the order of the floats; that of any number is above 0.
fn lbvh_ordered(x: vec3f) -> vec3u {
    let bits = bitcast<vec3u>(x);
    return select(bits | vec3u(0x80000000u), ~bits, bits >= vec3u(0x80000000u));
}

fn lbvh_unordered(code: vec3u) -> vec3f {
    return bitcast<vec3f>(select(~code, code & vec3u(0x7fffffffu), code >= vec3u(0x80000000u)));
}
