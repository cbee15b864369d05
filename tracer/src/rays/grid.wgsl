// Rays through the voxel grid, one per invocation, after voxel::TRACE_WGSL.

@compute @workgroup_size(64)
fn rays_closest(@builtin(global_invocation_id) id: vec3u) {
    if (id.x < arrayLength(&in_rays)) {
        let ray = in_rays[id.x];
        let hit = grid_trace(ray.origin, ray.direction, ray.t_max, ray.origin, GRID_BEHIND);
        let primitive = select(0xffffffffu, hit.record, hit.hit);
        out_met[id.x] = Met(primitive, hit.distance, vec2f(0.0), hit.iterations, u32(hit.cut));
    }
}
