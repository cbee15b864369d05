// Outward search for the nearest trace pixel that faces as the display pixel does. Rules: mod.rs of search.

@group(3) @binding(0) var out_color: texture_storage_2d<rgba16float, write>;
@group(3) @binding(1) var<storage, read_write> out_fallbacks: atomic<u32>;

@compute @workgroup_size(8, 8)
fn best_candidate(@builtin(global_invocation_id) id: vec3u) {
    let pixel = id.xy;
    if (any(pixel >= frame.display_size)) {
        return;
    }
    let wanted = search_pixel(pixel);
    let found = search_outward(wanted, modulate_trace_pixel(pixel), wanted.needs_diffuse, wanted.needs_specular);
    if ((wanted.needs_diffuse && !found.diffuse.is_accepted) || (wanted.needs_specular && !found.specular.is_accepted)) {
        atomicAdd(&out_fallbacks, 1u);
    }

    // A lobe that the surface lacks gets no light from elsewhere.
    var light = BrdfModulators(vec3f(0.0), vec3f(0.0));
    if (wanted.needs_diffuse || wanted.is_same_size) {
        light.diffuse = textureLoad(light_diffuse, found.diffuse.pixel, 0).rgb;
    }
    if (wanted.needs_specular || (wanted.is_same_size && search_params.has_specular == 1u)) {
        light.specular = textureLoad(light_specular, found.specular.pixel, 0).rgb;
    }
    textureStore(out_color, pixel, modulate_pixel(pixel, light.diffuse, light.specular, search_params.direct_lobes));
}
