// Writes both children's boxes into each node (Aila and Laine 2009): low corners with the children, high corners.

@group(2) @binding(0) var<storage, read> in_boxes: array<u32>; // as in bounds.wgsl
@group(3) @binding(0) var<storage, read_write> elements: array<vec4u>;

struct NodesBox {
    low: vec3f,
    high: vec3f,
}

// Nothing is inside it, and it takes in whatever is added.
fn nodes_empty() -> NodesBox {
    return NodesBox(vec3f(LBVH_NOWHERE), vec3f(-LBVH_NOWHERE));
}

fn nodes_box(node: u32) -> NodesBox {
    let at = 6u * node;
    if (in_boxes[at] == 0u) {
        return nodes_empty();
    }
    let low = vec3u(in_boxes[at], in_boxes[at + 1u], in_boxes[at + 2u]);
    let high = vec3u(in_boxes[at + 3u], in_boxes[at + 4u], in_boxes[at + 5u]);
    return NodesBox(lbvh_unordered(~low), lbvh_unordered(high));
}

fn nodes_leaf_box(first: u32, count: u32) -> NodesBox {
    var whole = nodes_empty();
    for (var i = 0u; i < LBVH_MOST_IN_LEAF; i += 1u) {
        let at = lbvh_triangle_at(first + min(i, count - 1u));
        let a = bitcast<vec3f>(elements[at].xyz);
        let b = bitcast<vec3f>(elements[at + 1u].xyz);
        let c = bitcast<vec3f>(elements[at + 2u].xyz);
        if (lbvh_is_usable(a)) {
            whole.low = min(whole.low, min(a, min(b, c)));
            whole.high = max(whole.high, max(a, max(b, c)));
        }
    }
    return whole;
}

// An empty box becomes the point that no ray reaches.
fn nodes_child_box(child: u32, margin: f32) -> NodesBox {
    let count = child >> LBVH_COUNT_BIT;
    var whole: NodesBox;
    if (count == 0u) {
        whole = nodes_box(child);
    } else {
        whole = nodes_leaf_box(child & ((1u << LBVH_COUNT_BIT) - 1u), count);
    }
    if (whole.low.x > whole.high.x) {
        return NodesBox(vec3f(LBVH_NOWHERE), vec3f(LBVH_NOWHERE));
    }
    return NodesBox(whole.low - margin, whole.high + margin);
}

@compute @workgroup_size(256)
fn nodes(@builtin(global_invocation_id) id: vec3u) {
    if (id.x >= params.node_count) {
        return;
    }
    let whole = nodes_box(0u);
    let reach = max(abs(whole.low), abs(whole.high));
    let margin = params.margin * max(reach.x, max(reach.y, reach.z));
    let at = 4u * id.x;
    let left_child = elements[at].w;
    let right_child = elements[at + 1u].w;
    let left = nodes_child_box(left_child, margin);
    let right = nodes_child_box(right_child, margin);
    elements[at] = vec4u(bitcast<vec3u>(left.low), left_child);
    elements[at + 1u] = vec4u(bitcast<vec3u>(left.high), right_child);
    elements[at + 2u] = vec4u(bitcast<vec3u>(right.low), 0u);
    elements[at + 3u] = vec4u(bitcast<vec3u>(right.high), 0u);
}
