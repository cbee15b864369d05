// The four trace pixels around a display pixel that lie on its surface.

@group(3) @binding(0) var out_color: texture_storage_2d<rgba16float, write>;
// Two numbers of 64 bits: fallbacks, searches.
@group(3) @binding(1) var<storage, read_write> out_counts: array<atomic<u32>, 4>;

@compute @workgroup_size(8, 8)
fn joint_bilateral(@builtin(global_invocation_id) id: vec3u) {
    let pixel = id.xy;
    if (any(pixel >= frame.display_size)) {
        return;
    }
    let light = joint_light(pixel, search_pixel(pixel));
    if (light.fell_back) {
        atomicAdd(&out_counts[0], 1u);
    }
    if (light.searched) {
        atomicAdd(&out_counts[2], 1u);
    }
    textureStore(out_color, pixel, modulate_pixel(pixel, light.diffuse, light.specular, search_params.direct_lobes));
}
