// A segment of the paths that renew voxels. See mod.rs; after segment.inc.wgsl.

@compute @workgroup_size(8, 8)
fn path_feed_segment(@builtin(workgroup_id) group: vec3u, @builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) local: u32) {
    params = params_of[group.z];
    path_is_feeding = true;
    if (all(id.xy < vec2u(frame.trace_size.x, params.rows))) {
        let index = path_index(id.xy);
        var path = paths[index];
        for (var segment = 0u; segment < params.segments && path.feed != 0u && (path.state & PATH_ALIVE) != 0u; segment += 1u) {
            pixels[index].aside += segment_advance(&path, id.xy);
        }
        paths[index] = path;
    }
    path_count(local);
    path_count_feed(local);
}
