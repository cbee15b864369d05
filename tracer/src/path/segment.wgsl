// Every living path advances by some segments. See mod.rs; after segment.inc.wgsl.

@compute @workgroup_size(8, 8)
fn path_segment(@builtin(workgroup_id) group: vec3u, @builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) local: u32) {
    params = params_of[group.z];
    if (all(id.xy < vec2u(frame.trace_size.x, params.rows))) {
        let index = path_index(id.xy);
        let pixel = id.xy + vec2u(0u, params.first_row);
        var path = paths[index];
        for (var segment = 0u; segment < params.segments && (path.state & PATH_ALIVE) != 0u; segment += 1u) {
            let first = (path.state & PATH_FIRST) != 0u;
            let found = segment_advance(&path, pixel);
            let length = select(0.0, min(path.first_distance, frame.diagonal), first);
            path.state &= ~PATH_FIRST;
            if ((path.state & PATH_SPECULAR) != 0u) {
                pixels[index].specular += vec4f(found, length);
            } else {
                pixels[index].diffuse += vec4f(found, length);
            }
        }
        paths[index] = path;
        if ((path.state & PATH_ALIVE) != 0u) {
            atomicStore(&counters[PATH_ANY_ALIVE], 1u);
        }
    }
    path_count(local);
}
