// Rays through a BVH, one per invocation, after its snippets.

@compute @workgroup_size(64)
fn rays_closest(@builtin(global_invocation_id) id: vec3u) {
    if (id.x < arrayLength(&in_rays)) {
        let ray = in_rays[id.x];
        let hit = bvh_closest(ray.origin, ray.direction, ray.t_max, ray.skip);
        out_met[id.x] = Met(hit.triangle, hit.distance, hit.weights, hit.visits, u32(hit.cut));
    }
}

@compute @workgroup_size(64)
fn rays_blocked(@builtin(global_invocation_id) id: vec3u) {
    if (id.x < arrayLength(&in_rays)) {
        let ray = in_rays[id.x];
        out_blocked[id.x] = bvh_blocked(ray.origin, ray.direction, ray.t_max, ray.skip);
    }
}
