// Radiance from 0 to 1 and back, hues kept. After frame.

fn tone_mapped(color: vec3f) -> vec3f {
    let c = max(color, vec3f(0.0));
    return c / (frame.radiance_scale + max(c.r, max(c.g, c.b)));
}

fn tone_unmapped(mapped: vec3f) -> vec3f {
    let c = clamp(mapped, vec3f(0.0), vec3f(1.0));
    // Half floats end at 65504.
    return c * frame.radiance_scale / max(1.0 - max(c.r, max(c.g, c.b)), 1e-5);
}
