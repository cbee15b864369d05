// The four trace pixels around a display pixel, mixed by distance alone.

@group(3) @binding(0) var out_color: texture_storage_2d<rgba16float, write>;

@compute @workgroup_size(8, 8)
fn bilinear(@builtin(global_invocation_id) id: vec3u) {
    let pixel = id.xy;
    if (any(pixel >= frame.display_size)) {
        return;
    }
    let wanted = search_pixel(pixel);
    let place = search_place(pixel);
    let low = vec2i(floor(place));
    let part = place - floor(place);
    var lobes = MixLobes(MIX_NOTHING, MIX_NOTHING);
    for (var k = 0; k < 4; k++) {
        let corner = vec2i(k & 1, k >> 1u);
        let weights = select(vec2f(1.0) - part, part, corner == vec2i(1));
        lobes = mix_tap(lobes, search_tap(wanted, low + corner), weights.x * weights.y);
    }
    let own = modulate_trace_pixel(pixel);
    var diffuse = select(vec3f(0.0), mix_mean(lobes.diffuse), wanted.needs_diffuse);
    var specular = select(vec3f(0.0), mix_specular(lobes.specular, wanted.surface), wanted.needs_specular);
    diffuse = select(diffuse, textureLoad(light_diffuse, own, 0).rgb, wanted.is_same_size);
    let has_specular = search_params.has_specular == 1u;
    specular = select(specular, textureLoad(light_specular, own, 0).rgb, wanted.is_same_size && has_specular);
    textureStore(out_color, pixel, modulate_pixel(pixel, diffuse, specular, search_params.direct_lobes));
}
