// Children and parents from the sorted codes, one inner node per invocation (Karras 2012, section 4), and the order
// of the triangles.

@group(2) @binding(0) var<storage, read> in_pairs: array<vec2u>;
@group(3) @binding(0) var<storage, read_write> out_elements: array<vec4u>;
// Of the nodes, then of the triangles.
@group(3) @binding(1) var<storage, read_write> out_parents: array<u32>;

// Leading bits that two codes share, -1 outside; equal codes are told apart by their places.
fn link_shared(i: i32, j: i32) -> i32 {
    if (j < 0 || j >= i32(params.triangle_count)) {
        return -1;
    }
    let apart = in_pairs[i].x ^ in_pairs[j].x;
    return i32(select(countLeadingZeros(apart), 32u + countLeadingZeros(u32(i ^ j)), apart == 0u));
}

// A child over `count` triangles from a place on; `split` names its node if it is one.
fn link_child(first: u32, count: u32, split: u32) -> u32 {
    return select(split, first | (count << LBVH_COUNT_BIT), count <= LBVH_MOST_IN_LEAF);
}

@compute @workgroup_size(256)
fn link(@builtin(global_invocation_id) id: vec3u) {
    if (id.x < params.triangle_count) {
        out_elements[lbvh_triangle_at(id.x)] = vec4u(0u, 0u, 0u, in_pairs[id.x].y);
    }
    if (id.x >= params.node_count) {
        return;
    }
    let i = i32(id.x);
    let way = select(-1, 1, link_shared(i, i + 1) > link_shared(i, i - 1));
    // The node's triangles share more with the one it is named after than the neighbour beyond does.
    let outside = link_shared(i, i - way);
    var most = 2;
    while (link_shared(i, i + most * way) > outside) { // at most 32 times: beyond the last triangle nothing is shared
        most *= 2;
    }
    var length = 0;
    for (var step = most / 2; step >= 1; step /= 2) {
        if (link_shared(i, i + (length + step) * way) > outside) {
            length += step;
        }
    }
    let other = i + length * way;
    let inside = link_shared(i, other);
    var split_length = 0;
    var step = length;
    while (step > 1) {
        step = (step + 1) / 2;
        if (link_shared(i, i + (split_length + step) * way) > inside) {
            split_length += step;
        }
    }
    // The last triangle of the first child.
    let split = u32(i + split_length * way + min(way, 0));
    let first = u32(min(i, other));
    let last = u32(max(i, other));

    let at = 4u * id.x;
    out_elements[at].w = link_child(first, split - first + 1u, split);
    out_elements[at + 1u].w = link_child(split + 1u, last - split, split + 1u);
    out_parents[select(split, params.node_count + split, first == split)] = id.x;
    out_parents[select(split + 1u, params.node_count + split + 1u, last == split + 1u)] = id.x;
    if (id.x == 0u) {
        out_parents[0] = LBVH_NO_PARENT;
    }
}
