// A ray among triangles: what every search structure shares, so that they meet the same triangle to the bit. See mod.rs.

struct BvhParams {
    // Element of `bvh` at which the triangles begin, three elements each.
    triangles_at: u32,
    triangle_count: u32,
    // Elements before the triangles that are nodes.
    node_count: u32,
    _pad: u32,
}

// Nodes as the structure lays them out, then triangles in the order of its leaves, three elements each:
// corner 0 and the triangle's number; corner 1 and 1 where light may pass straight through (a mask, a blend, a thin
// pane); corner 2 and 0. World, m.
@group(1) @binding(21) var<storage, read> bvh: array<vec4u>;
@group(1) @binding(22) var<uniform> bvh_params: BvhParams;

const BVH_NONE = 0xffffffffu;
// Most nodes that a ray visits; what is cut off is counted.
const BVH_MOST_VISITS = 4096u;
// Components of a direction are kept away from 0 by this, so that no quotient leaves the range of floats.
const BVH_LEAST = 1e-20;

// 1 - 2^-21: where a box is entered and where it is left are off by three roundings each, a share of the distance that no
// growth of the box covers when it is far away.
const BVH_NEARER = 0.99999952;

// Answers of bvh_blocked: nothing lies on the ray; something that lets no light through; only what may let it through.
const BVH_FREE = 0u;
const BVH_BLOCKED = 1u;
const BVH_SHEETS = 2u;

struct BvhHit {
    // BVH_NONE: nothing was met.
    triangle: u32,
    // m along the unit direction; the search's limit where nothing was met.
    distance: f32,
    // Of the second and third corner.
    weights: vec2f,
    // Nodes looked at.
    visits: u32,
    cut: bool,
}

struct BvhRay {
    origin: vec3f,
    // 1 / direction, never infinite.
    inverse: vec3f,
    // Axis of the direction's largest component: 0 x, 1 y, 2 z.
    axis: u32,
    // Shear that turns the direction into the axis; z scales it to length 1.
    shear: vec3f,
    // A triangle that is never met: the one the ray leaves. BVH_NONE = all are.
    skip: u32,
}

// The vector turned so that the ray's axis comes last; which way round does not matter, triangles have two sides.
fn bvh_turned(v: vec3f, axis: u32) -> vec3f {
    return select(select(v, v.zxy, axis == 1u), v.yzx, axis == 0u);
}

fn bvh_ray(origin: vec3f, direction: vec3f, skip: u32) -> BvhRay {
    let a = abs(direction);
    let axis = select(select(2u, 1u, a.y > a.z), 0u, a.x >= a.y && a.x > a.z);
    let d = bvh_turned(direction, axis);
    let kept = select(direction, select(vec3f(-BVH_LEAST), vec3f(BVH_LEAST), direction >= vec3f(0.0)), a < vec3f(BVH_LEAST));
    return BvhRay(origin, 1.0 / kept, axis, vec3f(d.xy, 1.0) / d.z, skip);
}

// Where the ray is inside a box: x enters, y leaves; it meets the box if x <= y. Boxes are made a little larger than
// their triangles by whoever builds them (mod.rs), which covers the rounding here.
fn bvh_slab(ray: BvhRay, low: vec3f, high: vec3f, t_max: f32) -> vec2f {
    let a = (low - ray.origin) * ray.inverse;
    let b = (high - ray.origin) * ray.inverse;
    let enter = min(a, b);
    let leave = max(a, b);
    let first = max(max(enter.x, enter.y), max(enter.z, 0.0)) * BVH_NEARER;
    return vec2f(first, min(min(leave.x, leave.y), min(leave.z, t_max)));
}

// Twice the signed area of the origin and an edge: the same bits but for the sign whichever way round the edge is
// walked, even where a driver fuses a product with the difference. Triangles that share it leave no gap. An edge
// without length has none: fused, it would have that of a rounding, and a triangle shrunk to a point would be met.
fn bvh_edge(a: vec2f, b: vec2f) -> f32 {
    let swapped = a.x > b.x || (a.x == b.x && a.y > b.y);
    let p = select(a, b, swapped);
    let q = select(b, a, swapped);
    let area = p.x * q.y - p.y * q.x;
    return select(select(area, -area, swapped), 0.0, all(a == b));
}

// Meets one triangle, by its place among the triangles; keeps the nearer of it and what is there, of equally distant
// ones the lower number. Woop, Benthin and Wald 2013, "Watertight Ray/Triangle Intersection".
fn bvh_triangle(ray: BvhRay, place: u32, hit: ptr<function, BvhHit>) {
    let at = bvh_params.triangles_at + 3u * place;
    let first = bvh[at];
    let number = first.w;
    let a = bvh_turned(bitcast<vec3f>(first.xyz) - ray.origin, ray.axis);
    let b = bvh_turned(bitcast<vec3f>(bvh[at + 1u].xyz) - ray.origin, ray.axis);
    let c = bvh_turned(bitcast<vec3f>(bvh[at + 2u].xyz) - ray.origin, ray.axis);
    let a2 = a.xy - ray.shear.xy * a.z;
    let b2 = b.xy - ray.shear.xy * b.z;
    let c2 = c.xy - ray.shear.xy * c.z;
    let u = bvh_edge(c2, b2);
    let v = bvh_edge(a2, c2);
    let w = bvh_edge(b2, a2);
    let det = u + v + w;
    let inside = (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
    // Seen from its edge, a triangle can pass the test by rounding alone, metres beside the ray: its box cannot. No shared
    // edge is lost by that, for what lies on it is in both boxes.
    let around = all(min(a2, min(b2, c2)) <= vec2f(0.0)) && all(max(a2, max(b2, c2)) >= vec2f(0.0));
    // A degenerate triangle, or one seen from its edge, has no area to meet.
    if (!inside || !around || det == 0.0 || number == ray.skip) {
        return;
    }
    let distance = ray.shear.z * (u * a.z + v * b.z + w * c.z) / det;
    if (distance > 0.0 && (distance < (*hit).distance || (distance == (*hit).distance && number < (*hit).triangle))) {
        (*hit).triangle = number;
        (*hit).distance = distance;
        (*hit).weights = vec2f(v, w) / det;
    }
}

// Whether light may pass straight through a triangle, by its place.
fn bvh_is_sheet(place: u32) -> bool {
    return bvh[bvh_params.triangles_at + 3u * place + 1u].w != 0u;
}
