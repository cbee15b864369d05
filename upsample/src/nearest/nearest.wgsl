// The light of the trace pixel under the centre of the display pixel.

struct NearestParams {
    has_specular: u32,
    direct_lobes: u32,
}

@group(0) @binding(1) var<uniform> params: NearestParams;
@group(3) @binding(0) var out_color: texture_storage_2d<rgba16float, write>;

@compute @workgroup_size(8, 8)
fn nearest(@builtin(global_invocation_id) id: vec3u) {
    let pixel = id.xy;
    if (any(pixel >= frame.display_size)) {
        return;
    }
    let q = modulate_trace_pixel(pixel);
    let diffuse = textureLoad(light_diffuse, q, 0).rgb;
    let specular = select(vec3f(0.0), textureLoad(light_specular, q, 0).rgb, params.has_specular == 1u);
    textureStore(out_color, pixel, modulate_pixel(pixel, diffuse, specular, params.direct_lobes));
}
