// What a pixel sees, from the camera ray of this sample. See camera.rs.

struct First {
    // Its normal faces the viewer.
    surface: Surface,
    // World, m.
    point: vec3f,
    // Unit, towards the viewer: nothing is reflected below it.
    face: vec3f,
    // Unit, towards the viewer.
    wo: vec3f,
    // The back side is seen.
    is_back: bool,
}

const FIRST_THIN = 1u;
const FIRST_BACK = 2u;

fn first_is_hit(index: u32, pixel: vec2u) -> bool {
    return pixels[index].distance > 0.0;
}

fn first_load(index: u32, pixel: vec2u) -> First {
    let p = pixels[index];
    var first: First;
    first.surface.normal = p.normal;
    first.surface.tangent = p.tangent;
    first.surface.handedness = p.handedness;
    first.surface.base = p.base;
    first.surface.metalness = p.metalness;
    first.surface.absorption = p.absorption;
    first.surface.roughness = vec2f(p.roughness_t, p.roughness_b);
    first.surface.f0 = p.f0;
    first.surface.f90 = p.f90;
    first.surface.transmission = p.transmission;
    first.surface.coverage = 1.0;
    first.surface.thin = (p.flags & FIRST_THIN) != 0u;
    first.surface = path_surface(first.surface);
    first.point = p.point;
    first.face = p.face;
    first.wo = p.wo;
    first.is_back = (p.flags & FIRST_BACK) != 0u;
    return first;
}
