// Rays through a compressed wide BVH. See mod.rs; after ray.inc.wgsl. CWBVH_STACK is declared before.
//
// A node is five elements of `bvh`, its eight slots hold a node, one to three triangles, or nothing:
//   0  xyz the corner of its box with the least coordinates, m; w the exponents of a step in x, y and z, and in the
//      highest byte which slots hold nodes
//   1  x its first node, y its first triangle, zw a byte per slot: 0 nothing; 32 + 24 + slot a node; otherwise the
//      place of its first triangle behind y, 0 to 23, plus 32, 96 or 224 for one, two or three of them
//   2, 3, 4  x, y and z of the slots' boxes in steps, a byte each: xy low ends, zw high ends

struct CwbvhWalk {
    // Slot ^ octant is higher the earlier the ray meets a slot.
    octant: u32,
    visits: u32,
    // Nodes yet to visit, all children of one: x its first, y in the high byte one bit per slot by slot ^ octant, in
    // the low byte which slots hold nodes.
    nodes: vec2u,
    // Triangles to test: x the first of the node last visited, y one bit for each after it.
    triangles: vec2u,
    // What is left of the nodes further up.
    stack: array<vec2u, CWBVH_STACK>,
    height: u32,
}

// Where a ray meets four planes along one axis. The product is exact, so that drivers that fuse it with the sum get the
// same plane.
fn cwbvh_planes(steps: u32, low: f32, step: f32, origin: f32, inverse: f32) -> vec4f {
    return (low + vec4f(unpack4xU8(steps)) * step - origin) * inverse;
}

// Bits of those of four slots that the ray meets: of a node by its order in the high byte, of triangles by their place.
fn cwbvh_met(slots: u32, octant: u32, enter: vec4f, leave: vec4f) -> u32 {
    let slot = unpack4xU8(slots);
    // Only of a node are both bits of 24 set.
    let is_node = ((slot & (slot << vec4u(1u))) >> vec4u(4u)) & vec4u(1u);
    let place = (slot ^ (is_node * octant)) & vec4u(31u);
    let bits = select(vec4u(0u), (slot >> vec4u(5u)) << place, enter <= leave);
    return bits.x | bits.y | bits.z | bits.w;
}

fn cwbvh_visit(walk: ptr<function, CwbvhWalk>, ray: BvhRay, index: u32, t_max: f32) {
    let at = 5u * index;
    let head = bvh[at];
    let slots = bvh[at + 1u];
    let x = bvh[at + 2u];
    let y = bvh[at + 3u];
    let z = bvh[at + 4u];
    let low = bitcast<vec3f>(head.xyz);
    let exponent = vec3u(head.w, head.w >> 8u, head.w >> 16u) & vec3u(255u);
    let step = bitcast<vec3f>(exponent << vec3u(23u));
    // The ends that the ray meets first, and those it meets last.
    let back = ray.inverse < vec3f(0.0);
    let near_x = select(x.xy, x.zw, back.x);
    let near_y = select(y.xy, y.zw, back.y);
    let near_z = select(z.xy, z.zw, back.z);
    let far_x = select(x.zw, x.xy, back.x);
    let far_y = select(y.zw, y.xy, back.y);
    let far_z = select(z.zw, z.xy, back.z);
    var met = 0u;
    for (var four = 0u; four < 2u; four += 1u) {
        let enter_x = cwbvh_planes(near_x[four], low.x, step.x, ray.origin.x, ray.inverse.x);
        let enter_y = cwbvh_planes(near_y[four], low.y, step.y, ray.origin.y, ray.inverse.y);
        let enter_z = cwbvh_planes(near_z[four], low.z, step.z, ray.origin.z, ray.inverse.z);
        let leave_x = cwbvh_planes(far_x[four], low.x, step.x, ray.origin.x, ray.inverse.x);
        let leave_y = cwbvh_planes(far_y[four], low.y, step.y, ray.origin.y, ray.inverse.y);
        let leave_z = cwbvh_planes(far_z[four], low.z, step.z, ray.origin.z, ray.inverse.z);
        let enter = max(max(enter_x, enter_y), max(enter_z, vec4f(0.0))) * BVH_NEARER;
        let leave = min(min(leave_x, leave_y), min(leave_z, vec4f(t_max)));
        met |= cwbvh_met(slots[2u + four], (*walk).octant, enter, leave);
    }
    (*walk).nodes = vec2u(slots.x, (met & 0xff000000u) | (head.w >> 24u));
    (*walk).triangles = vec2u(slots.y, met & 0xffffffu);
}

fn cwbvh_walk(ray: BvhRay) -> CwbvhWalk {
    var walk: CwbvhWalk;
    walk.octant = dot(select(vec3u(4u, 2u, 1u), vec3u(0u), ray.inverse < vec3f(0.0)), vec3u(1u));
    // The root, as if it were a node's only child.
    walk.nodes = vec2u(0u, select(0u, 0x80000000u, bvh_params.node_count > 0u));
    return walk;
}

// Visits the next node that the ray meets within t_max. False when there is none, or when it would be one too many.
fn cwbvh_step(walk: ptr<function, CwbvhWalk>, ray: BvhRay, t_max: f32) -> bool {
    if ((*walk).nodes.y < 0x1000000u) {
        if ((*walk).height == 0u) {
            return false;
        }
        (*walk).height -= 1u;
        (*walk).nodes = (*walk).stack[(*walk).height];
    }
    if ((*walk).visits == BVH_MOST_VISITS) {
        return false;
    }
    (*walk).visits += 1u;
    let nodes = (*walk).nodes;
    let first = firstLeadingBit(nodes.y);
    let rest = nodes.y & ~(1u << first);
    // One entry per level at most: those of a deeper level are gone before.
    if (rest >= 0x1000000u) {
        (*walk).stack[(*walk).height] = vec2u(nodes.x, rest);
        (*walk).height += 1u;
    }
    let slot = (first - 24u) ^ (*walk).octant;
    cwbvh_visit(walk, ray, nodes.x + countOneBits(nodes.y & ~(0xffffffffu << slot)), t_max);
    return true;
}

// Takes one of the triangles to test, by its place.
fn cwbvh_next_triangle(walk: ptr<function, CwbvhWalk>) -> u32 {
    let bit = firstLeadingBit((*walk).triangles.y);
    (*walk).triangles.y &= ~(1u << bit);
    return (*walk).triangles.x + bit;
}

fn bvh_closest(origin: vec3f, direction: vec3f, t_max: f32, skip: u32) -> BvhHit {
    let ray = bvh_ray(origin, direction, skip);
    var walk = cwbvh_walk(ray);
    var hit = BvhHit(BVH_NONE, t_max, vec2f(0.0), 0u, false);
    while (cwbvh_step(&walk, ray, hit.distance)) {
        while (walk.triangles.y != 0u) {
            bvh_triangle(ray, cwbvh_next_triangle(&walk), &hit);
        }
    }
    hit.visits = walk.visits;
    // Whatever is left was cut off, be it by a driver that ends loops.
    hit.cut = (walk.nodes.y & 0xff000000u) + walk.triangles.y + walk.height != 0u;
    return hit;
}

fn bvh_blocked(origin: vec3f, direction: vec3f, t_max: f32, skip: u32) -> u32 {
    let ray = bvh_ray(origin, direction, skip);
    var walk = cwbvh_walk(ray);
    var found = BVH_FREE;
    while (found != BVH_BLOCKED && cwbvh_step(&walk, ray, t_max)) {
        while (found != BVH_BLOCKED && walk.triangles.y != 0u) {
            let place = cwbvh_next_triangle(&walk);
            var hit = BvhHit(BVH_NONE, t_max, vec2f(0.0), 0u, false);
            bvh_triangle(ray, place, &hit);
            if (hit.triangle != BVH_NONE) {
                found = select(BVH_BLOCKED, BVH_SHEETS, bvh_is_sheet(place));
            }
        }
    }
    return found;
}
