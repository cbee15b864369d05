// A batch of rays through a search structure, one per invocation, after its snippets.

struct Ray {
    origin: vec3f,
    t_max: f32,
    direction: vec3f,
    skip: u32,
}

struct Met {
    triangle: u32,
    distance: f32,
    weights: vec2f,
    visits: u32,
    cut: u32,
}

@group(2) @binding(0) var<storage, read> in_rays: array<Ray>;
@group(3) @binding(0) var<storage, read_write> out_met: array<Met>;
@group(3) @binding(1) var<storage, read_write> out_blocked: array<u32>;

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
