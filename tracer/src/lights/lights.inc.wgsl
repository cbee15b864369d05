// Light that is no surface, sampled for a shadow ray. See mod.rs; `Light` comes from the scene's snippet.

struct LightSample {
    // Unit, towards the light.
    wi: vec3f,
    // m; the scene's diagonal and more for lights at infinity.
    distance: f32,
    // On a plane facing `wi`, already divided by the probability of this choice.
    irradiance: vec3f,
    // Of this choice, 1/sr; LIGHT_CERTAIN for light that no path finds by chance.
    pdf: f32,
    // The emitter that is looked at, as the structure names it; LIGHT_NO_EMITTER for what is no surface.
    emitter: vec2u,
}

const LIGHT_CERTAIN = 1e12;
const LIGHT_NO_EMITTER = vec2u(0xffffffffu);

// u.x picks among the lights `first` to `end` - 1, the rest of it and u.y a point of the sun's disc.
fn light_sample(first: u32, end: u32, point: vec3f, u: vec2f) -> LightSample {
    let count = end - first;
    let scaled = u.x * f32(count);
    let index = min(u32(scaled), count - 1u);
    let light = light_at(first + index);
    let chosen = light.intensity * f32(count);
    if (light.kind == LIGHT_SUN || light.kind == LIGHT_DIRECTIONAL) {
        // Uniform over the disc: even in the cosine of the angle from its centre.
        let cosine = 1.0 - (1.0 - light.cos_inner) * u.y;
        let radius = sqrt(max(1.0 - cosine * cosine, 0.0));
        let phi = 6.2831853 * (scaled - f32(index));
        let axis = -light.direction;
        let side = normalize(cross(axis, select(vec3f(1.0, 0.0, 0.0), vec3f(0.0, 1.0, 0.0), abs(axis.x) > 0.7)));
        let wi = normalize(axis * cosine + radius * (cos(phi) * side + sin(phi) * cross(axis, side)));
        return LightSample(wi, 4.0 * frame.diagonal, chosen, LIGHT_CERTAIN, LIGHT_NO_EMITTER);
    }
    let to_light = light.position - point;
    let distance_2 = max(dot(to_light, to_light), 1e-12);
    let distance = sqrt(distance_2);
    let wi = to_light / distance;
    var irradiance = chosen / distance_2;
    // KHR_lights_punctual: a window that reaches 0 at the range, and a smooth edge of the cone.
    let reach = distance / light.range;
    let reach_2 = min(reach * reach, 1.0);
    irradiance *= 1.0 - reach_2 * reach_2;
    if (light.kind == LIGHT_SPOT) {
        let width = max(light.cos_inner - light.cos_outer, 1e-4);
        let edge = clamp((dot(-wi, light.direction) - light.cos_outer) / width, 0.0, 1.0);
        irradiance *= edge * edge;
    }
    return LightSample(wi, distance, irradiance, LIGHT_CERTAIN, LIGHT_NO_EMITTER);
}
