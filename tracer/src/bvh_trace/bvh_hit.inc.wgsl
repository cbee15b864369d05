// What a ray meets among triangles, for the path kernels. Needs mesh, material, bvh::RAY_WGSL and a structure's walk.

// Normal maps that face away from the ray are bent back.
override bvh_bend = true;
// What is reflected must lie above the interpolated normal instead of the triangle's: the shared references' rule.
override bvh_smooth_horizon = false;

struct Hit {
    found: bool,
    // m along the ray.
    distance: f32,
    // Nothing rounded; its normal is on the front side.
    surface: Surface,
    // Met from the front side.
    front: bool,
    // Unit, towards the ray: nothing is reflected below it.
    face: vec3f,
    // The triangle's, towards the ray.
    flat_face: vec3f,
    // Front side of the triangle.
    triangle_face: vec3f,
    // Mean luminance of its emission.
    glow: f32,
    // World, m, from the corners: closer to the triangle than the ray's own arithmetic.
    position: vec3f,
    // x names the triangle, for a ray that leaves it.
    own: vec2u,
}

// Off a triangle by this share of the largest coordinate around: rounding of a position is 2^-23 of it, that of one
// made from a distance a few times more.
const HIT_OFF = 1.9073486e-6;

fn hit_off(point: vec3f) -> f32 {
    let a = abs(point);
    return HIT_OFF * max(max(a.x, max(a.y, a.z)), frame.diagonal);
}

fn hit_trace(origin: vec3f, direction: vec3f, distance: f32, own: vec2u) -> Hit {
    let met = bvh_closest(origin, direction, distance, own.x);
    atomicAdd(&tally[TALLY_ITERATIONS], met.visits);
    if (met.cut) {
        atomicAdd(&tally[TALLY_CUT], 1u);
    }
    var hit: Hit;
    hit.found = met.triangle != BVH_NONE;
    if (hit.found) {
        let point = mesh_point(met.triangle, met.weights);
        hit.distance = met.distance;
        hit.position = point.position;
        hit.own = vec2u(met.triangle, 0u);
        hit.triangle_face = point.face_normal;
        hit.glow = materials[mesh_material(met.triangle)].glow;
        let judge = select(point.face_normal, point.normal, bvh_smooth_horizon);
        hit.front = dot(judge, direction) < 0.0;
        hit.face = select(-judge, judge, hit.front);
        hit.flat_face = select(point.face_normal, -point.face_normal, dot(point.face_normal, direction) > 0.0);
        let material = mesh_material(met.triangle);
        var surface = material_surface(material, point, 0.0);
        if (path_coverage) {
            surface.coverage = material_opacity(material, point, 0.0);
        }
        hit.surface = path_surface(surface);
        if (bvh_bend) {
            let side = select(-1.0, 1.0, hit.front);
            hit.surface.normal = side * material_bend(side * hit.surface.normal, -direction);
        }
    }
    return hit;
}

// A point of an emitting triangle, seen from `from`: its radiance, and the density but for the sum of all weights.
fn hit_emitter(emitter: vec2u, from_point: vec3f, own: vec2u, u: vec3f) -> LightSample {
    let triangle = emitter.x;
    let root = sqrt(u.x);
    let point = mesh_point(triangle, vec2f(root * (1.0 - u.y), root * u.y));
    let away = point.position - from_point;
    let distance_2 = max(dot(away, away), 1e-20);
    let distance = sqrt(distance_2);
    let wi = away / distance;
    let cosine = -dot(point.face_normal, wi);
    if (cosine <= 1e-6 || triangle == own.x) {
        return LightSample(wi, 0.0, vec3f(0.0), 0.0, emitter);
    }
    let material = mesh_material(triangle);
    let pdf = materials[material].glow * distance_2 / cosine;
    // Ends before the triangle itself.
    let reach = distance - max(2.0 * hit_off(point.position), 1.5e-5 * distance);
    var emission = material_emission(material, point);
    if (path_coverage) {
        emission *= material_opacity(material, point, 0.0);
    }
    return LightSample(wi, reach, emission, pdf, emitter);
}

fn hit_is_emitter(hit: Hit, emitter: vec2u) -> bool {
    return hit.own.x == emitter.x;
}

// The density with which hit_emitter chooses what a ray from `from` met.
fn hit_emitter_pdf(hit: Hit, from_point: vec3f, direction: vec3f, distance: f32) -> f32 {
    return hit.glow * distance * distance / max(-dot(hit.triangle_face, direction), 1e-6);
}

fn hit_blocked(origin: vec3f, direction: vec3f, distance: f32, own: vec2u) -> u32 {
    return bvh_blocked(origin, direction, distance, own.x);
}

// Where a path starts at a surface whose point came from a distance.
fn hit_start(point: vec3f, face: vec3f, side: vec3f, wo: vec3f) -> vec3f {
    return point + hit_off(point) * side;
}

// What it leaves: no triangle whose number is known.
fn hit_starts_from(point: vec3f, side: vec3f, wo: vec3f) -> vec2u {
    return PATH_NO_OWN;
}

// What a path leaves that goes on from a hit.
fn hit_leaves(hit: Hit, direction: vec3f) -> vec2u {
    return hit.own;
}

// Where it starts after scattering at a triangle.
fn hit_leave(point: vec3f, hit: Hit, direction: vec3f) -> vec3f {
    let out = select(-1.0, 1.0, dot(direction, hit.flat_face) > 0.0);
    return hit.position + (out * hit_off(hit.position)) * hit.flat_face;
}

// Where it goes on after passing one.
fn hit_pass(point: vec3f, hit: Hit, direction: vec3f) -> vec3f {
    return hit.position - hit_off(hit.position) * hit.flat_face;
}
