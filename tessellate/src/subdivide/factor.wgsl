// Factor of each edge, from its two ends alone.

@group(2) @binding(0) var<storage, read_write> topology: array<u32>;

@compute @workgroup_size(256)
fn factor(@builtin(global_invocation_id) id: vec3u) {
    let edge = params.first + id.x;
    if (edge >= params.first + params.count) {
        return;
    }
    let record = subdivide_edge(edge);
    let a = mesh_position(subdivide_corner_vertex(record.side.x));
    let b = mesh_position(subdivide_corner_vertex(subdivide_next(record.side.x)));
    let middle = 0.5 * (a + b);
    let wanted = max(params.edge_length, params.edge_angle * distance(middle, frame.eye));
    let steps = ceil(distance(a, b) / wanted);
    let most = f32(SUBDIVIDE_MOST);
    topology[subdivide_edge_at(edge) + 2u] = select(1u, u32(clamp(steps, 1.0, most)), record.is_shaped);
}
