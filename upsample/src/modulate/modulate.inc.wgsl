// Light meets the surface it fell on, at display size. Formula and departures: mod.rs beside this file.
// After frame, surface, brdf with its table, and sky.

@group(2) @binding(0) var display_surface: texture_2d<u32>;
@group(2) @binding(1) var display_distance: texture_2d<f32>;
@group(2) @binding(2) var direct_diffuse: texture_2d<f32>;
@group(2) @binding(3) var direct_specular: texture_2d<f32>;
@group(2) @binding(4) var light_diffuse: texture_2d<f32>;
@group(2) @binding(5) var light_specular: texture_2d<f32>;

// The trace pixel under the centre of a display pixel, in integers.
fn modulate_trace_pixel(pixel: vec2u) -> vec2u {
    return (2u * pixel + 1u) * frame.trace_size / (2u * frame.display_size);
}

fn modulate_view_direction(pixel: vec2u) -> vec3f {
    return frame_view_direction(vec2f(pixel) + vec2f(0.5), frame.display_size);
}

// Light found elsewhere, at display size. direct_lobes: how many lobes of direct_* hold something, 0 to 2. No branches: one
// that a uniform alone decides has Mesa's software driver build the kernel anew for each dispatch.
fn modulate_direct_light(pixel: vec2u, direct_lobes: u32) -> BrdfModulators {
    return BrdfModulators(
        select(vec3f(0.0), textureLoad(direct_diffuse, pixel, 0).rgb, direct_lobes > 0u),
        select(vec3f(0.0), textureLoad(direct_specular, pixel, 0).rgb, direct_lobes > 1u),
    );
}

// The same, on the surface it fell on.
fn modulate_direct(pixel: vec2u, direct_lobes: u32) -> vec3f {
    let direct = modulate_direct_light(pixel, direct_lobes);
    let surface = surface_unpack_gbuffer(textureLoad(display_surface, pixel, 0));
    let m = brdf_modulators(surface, dot(surface.normal, -modulate_view_direction(pixel)));
    return m.diffuse * direct.diffuse + m.specular * direct.specular;
}

// The picture's value from demodulated light.
fn modulate_pixel(pixel: vec2u, diffuse: vec3f, specular: vec3f, direct_lobes: u32) -> vec4f {
    let direction = modulate_view_direction(pixel);
    if (!(textureLoad(display_distance, pixel, 0).r > 0.0)) {
        return half_rounded(vec4f(sky_radiance(direction), 1.0));
    }
    let direct = modulate_direct_light(pixel, direct_lobes);
    let surface = surface_unpack_gbuffer(textureLoad(display_surface, pixel, 0));
    let m = brdf_modulators(surface, dot(surface.normal, -direction));
    let color =
        m.diffuse * (diffuse + direct.diffuse) + m.specular * (specular + direct.specular) + surface.emission;
    return half_rounded(vec4f(color, 1.0));
}
