// One ray per invocation through both functions.

struct TestRay {
    origin: vec3f,
    t_max: f32,
    direction: vec3f,
    skip: u32,
}

struct TestHit {
    triangle: u32,
    distance: f32,
    weights: vec2f,
    visits: u32,
    cut: u32,
    blocked: u32,
    _pad: u32,
}

@group(2) @binding(0) var<storage, read> in_rays: array<TestRay>;
@group(3) @binding(0) var<storage, read_write> out_hits: array<TestHit>;

@compute @workgroup_size(64)
fn trace_rays(@builtin(global_invocation_id) id: vec3u) {
    if (id.x >= arrayLength(&in_rays)) {
        return;
    }
    let r = in_rays[id.x];
    let hit = bvh_closest(r.origin, r.direction, r.t_max, r.skip);
    let blocked = bvh_blocked(r.origin, r.direction, r.t_max, r.skip);
    out_hits[id.x] = TestHit(hit.triangle, hit.distance, hit.weights, hit.visits, u32(hit.cut), blocked, 0u);
}
