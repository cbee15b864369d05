// Light meets the surface it fell on, at display size. Formula and departures: mod.rs beside this file.
// After frame, surface, brdf with its table, and sky.

@group(2) @binding(0) var display_surface: texture_2d<u32>;
@group(2) @binding(1) var display_distance: texture_2d<f32>;
@group(2) @binding(2) var direct_diffuse: texture_2d<f32>;
@group(2) @binding(3) var direct_specular: texture_2d<f32>;
@group(2) @binding(4) var light_diffuse: texture_2d<f32>;
@group(2) @binding(5) var light_specular: texture_2d<f32>;

// The nearest half float, since stores may cut the rest off; not finite becomes 0. The exponent's bits cannot be folded
// away as a comparison may be.
fn modulate_stored(color: vec3f) -> vec4f {
    let bits = bitcast<vec3u>(color);
    let is_finite = (bits & vec3u(0x7f800000u)) != vec3u(0x7f800000u);
    let nearest = (bits + vec3u(0xfffu) + ((bits >> vec3u(13u)) & vec3u(1u))) & vec3u(0xffffe000u);
    let stored = bitcast<vec3f>(select(vec3u(0u), nearest, is_finite));
    return vec4f(min(stored, vec3f(65504.0)), 1.0);
}

// The trace pixel under the centre of a display pixel, in integers.
fn modulate_trace_pixel(pixel: vec2u) -> vec2u {
    return (2u * pixel + 1u) * frame.trace_size / (2u * frame.display_size);
}

fn modulate_view_direction(pixel: vec2u) -> vec3f {
    return frame_view_direction(vec2f(pixel) + vec2f(0.5), frame.display_size);
}

// The picture's value from demodulated light. direct_lobes: how many lobes of direct_* hold something, 0 to 2.
fn modulate_pixel(pixel: vec2u, diffuse: vec3f, specular: vec3f, direct_lobes: u32) -> vec4f {
    let direction = modulate_view_direction(pixel);
    if (!(textureLoad(display_distance, pixel, 0).r > 0.0)) {
        return modulate_stored(sky_radiance(direction));
    }
    var lobes = BrdfModulators(diffuse, specular);
    if (direct_lobes > 0u) {
        lobes.diffuse += textureLoad(direct_diffuse, pixel, 0).rgb;
    }
    if (direct_lobes > 1u) {
        lobes.specular += textureLoad(direct_specular, pixel, 0).rgb;
    }
    let surface = surface_unpack_gbuffer(textureLoad(display_surface, pixel, 0));
    let m = brdf_modulators(surface, dot(surface.normal, -direction));
    return modulate_stored(m.diffuse * lobes.diffuse + m.specular * lobes.specular + surface.emission);
}
