// Copies the triangles to their places, and carries each one's box towards the root until it changes nothing.

// Per material 1 where light may pass straight through.
@group(2) @binding(0) var<storage, read> in_sheets: array<u32>;
@group(2) @binding(1) var<storage, read> in_parents: array<u32>;
@group(3) @binding(0) var<storage, read_write> elements: array<vec4u>;
// Six words per node, all of them maxima, from 0 up: of ~lbvh_ordered(low) and lbvh_ordered(high).
@group(3) @binding(1) var<storage, read_write> boxes: array<atomic<u32>>;

// Karras' trees are no deeper: mod.rs.
const BOUNDS_MOST_DEPTH = 64u;

// Whether the word was below `value`. Who wrote what is there carries it on, so that whoever adds nothing may stop.
fn bounds_raise(at: u32, value: u32) -> bool {
    if (atomicLoad(&boxes[at]) >= value) {
        return false;
    }
    return atomicMax(&boxes[at], value) < value;
}

@compute @workgroup_size(256)
fn bounds(@builtin(global_invocation_id) id: vec3u) {
    if (id.x >= params.triangle_count) {
        return;
    }
    let at = lbvh_triangle_at(id.x);
    let number = elements[at].w;
    let v = mesh_triangle(number);
    var a = mesh_position(v.x);
    var b = mesh_position(v.y);
    var c = mesh_position(v.z);
    let is_usable = lbvh_is_usable(a) && lbvh_is_usable(b) && lbvh_is_usable(c);
    if (!is_usable) {
        a = vec3f(LBVH_NOWHERE);
        b = a;
        c = a;
    }
    elements[at] = vec4u(bitcast<vec3u>(a), number);
    elements[at + 1u] = vec4u(bitcast<vec3u>(b), in_sheets[mesh_material(number)]);
    elements[at + 2u] = vec4u(bitcast<vec3u>(c), 0u);
    if (!is_usable || params.node_count == 0u) {
        return;
    }
    let low = ~lbvh_ordered(min(a, min(b, c)));
    let high = lbvh_ordered(max(a, max(b, c)));
    var node = in_parents[params.node_count + id.x];
    for (var step = 0u; step < BOUNDS_MOST_DEPTH && node != LBVH_NO_PARENT; step += 1u) {
        let words = 6u * node;
        let x = bounds_raise(words, low.x) | bounds_raise(words + 3u, high.x);
        let y = bounds_raise(words + 1u, low.y) | bounds_raise(words + 4u, high.y);
        let z = bounds_raise(words + 2u, low.z) | bounds_raise(words + 5u, high.z);
        if (!(x || y || z)) {
            break;
        }
        node = in_parents[node];
    }
}
