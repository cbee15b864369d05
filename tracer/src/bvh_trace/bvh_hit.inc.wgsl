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
    // World, m, from the corners: closer to the triangle than the ray's own arithmetic.
    position: vec3f,
    // x names the triangle, for a ray that leaves it.
    own: vec2u,
    // Never: a triangle that is left is not met.
    again: bool,
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

fn hit_blocked(origin: vec3f, direction: vec3f, distance: f32, own: vec2u) -> u32 {
    return bvh_blocked(origin, direction, distance, own.x);
}

// Where a path starts at a surface whose point came from a distance.
fn hit_start(point: vec3f, face: vec3f, side: vec3f) -> vec3f {
    return point + hit_off(point) * side;
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
