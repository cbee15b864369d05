// A ray through an LBVH, after ../ray.inc.wgsl. A node is four elements: the left child's low corner and the left
// child, its high corner and the right child, the right child's low corner, its high corner (w unused in both).

// A child: its triangles' number from this bit on and the first one's place below, or a node.
const LBVH_COUNT_BIT = 29u;
const LBVH_MOST_IN_LEAF = 4u;
const LBVH_DONE = 0xffffffffu;

// One entry ends the walk; each node on the way down leaves at most one more, and no way is longer than 62 (mod.rs).
const LBVH_STACK = 64u;

struct LbvhWalk {
    // The child to look at next.
    at: u32,
    depth: u32,
    stack: array<u32, LBVH_STACK>,
}

fn lbvh_start() -> LbvhWalk {
    var walk: LbvhWalk;
    // Up to four triangles have no node above them.
    walk.at = select(0u, bvh_params.triangle_count << LBVH_COUNT_BIT, bvh_params.node_count == 0u);
    if (bvh_params.triangle_count == 0u) {
        walk.at = LBVH_DONE;
    }
    walk.stack[0] = LBVH_DONE;
    walk.depth = 1u;
    return walk;
}

fn lbvh_pop(walk: ptr<function, LbvhWalk>) {
    (*walk).depth -= 1u;
    (*walk).at = (*walk).stack[(*walk).depth];
}

// From a node to its nearer child, the other one for later; to what was left for later where the ray meets neither.
fn lbvh_descend(ray: BvhRay, t_max: f32, walk: ptr<function, LbvhWalk>) {
    let at = 4u * (*walk).at;
    let a = bvh[at];
    let b = bvh[at + 1u];
    let left = bvh_slab(ray, bitcast<vec3f>(a.xyz), bitcast<vec3f>(b.xyz), t_max);
    let right = bvh_slab(ray, bitcast<vec3f>(bvh[at + 2u].xyz), bitcast<vec3f>(bvh[at + 3u].xyz), t_max);
    let is_left = left.x <= left.y;
    let is_right = right.x <= right.y;
    let left_first = is_left && (!is_right || left.x <= right.x);
    (*walk).stack[(*walk).depth] = select(a.w, b.w, left_first);
    (*walk).depth += select(0u, 1u, is_left && is_right);
    (*walk).at = select(b.w, a.w, left_first);
    if (!is_left && !is_right) {
        lbvh_pop(walk);
    }
}

// The nearest triangle within t_max m, but `skip`; `direction` is unit.
fn bvh_closest(origin: vec3f, direction: vec3f, t_max: f32, skip: u32) -> BvhHit {
    let ray = bvh_ray(origin, direction, skip);
    var hit = BvhHit(BVH_NONE, t_max, vec2f(0.0), 0u, false);
    var walk = lbvh_start();
    while (walk.at != LBVH_DONE && hit.visits < BVH_MOST_VISITS) {
        hit.visits += 1u;
        let count = walk.at >> LBVH_COUNT_BIT;
        if (count == 0u) {
            lbvh_descend(ray, hit.distance, &walk);
        } else {
            let first = walk.at & ((1u << LBVH_COUNT_BIT) - 1u);
            for (var i = 0u; i < LBVH_MOST_IN_LEAF; i += 1u) {
                if (i < count) {
                    bvh_triangle(ray, first + i, &hit);
                }
            }
            lbvh_pop(&walk);
        }
    }
    hit.cut = walk.at != LBVH_DONE;
    return hit;
}

// What lies within t_max m: BVH_FREE, BVH_BLOCKED or BVH_SHEETS. A ray that is cut off says what it found until then.
fn bvh_blocked(origin: vec3f, direction: vec3f, t_max: f32, skip: u32) -> u32 {
    let ray = bvh_ray(origin, direction, skip);
    var found = BVH_FREE;
    var walk = lbvh_start();
    for (var visits = 0u; visits < BVH_MOST_VISITS && walk.at != LBVH_DONE; visits += 1u) {
        let count = walk.at >> LBVH_COUNT_BIT;
        if (count == 0u) {
            lbvh_descend(ray, t_max, &walk);
        } else {
            let first = walk.at & ((1u << LBVH_COUNT_BIT) - 1u);
            for (var i = 0u; i < LBVH_MOST_IN_LEAF; i += 1u) {
                if (i < count) {
                    var hit = BvhHit(BVH_NONE, t_max, vec2f(0.0), 0u, false);
                    bvh_triangle(ray, first + i, &hit);
                    if (hit.triangle != BVH_NONE && found != BVH_BLOCKED) {
                        found = select(BVH_BLOCKED, BVH_SHEETS, bvh_is_sheet(first + i));
                    }
                }
            }
            lbvh_pop(&walk);
            if (found == BVH_BLOCKED) {
                break;
            }
        }
    }
    return found;
}
