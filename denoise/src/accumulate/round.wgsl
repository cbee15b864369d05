// Both lobes' means, as the light that travels has them.

@group(2) @binding(0) var in_diffuse: texture_2d<f32>;
@group(2) @binding(1) var in_specular: texture_2d<f32>;
@group(3) @binding(0) var out_diffuse: texture_storage_2d<rgba16float, write>;
@group(3) @binding(1) var out_specular: texture_storage_2d<rgba16float, write>;

@compute @workgroup_size(8, 8)
fn round_lobes(@builtin(global_invocation_id) id: vec3u) {
    let p = vec2i(id.xy);
    if (all(p < vec2i(textureDimensions(out_diffuse)))) {
        textureStore(out_diffuse, p, half_rounded(textureLoad(in_diffuse, p, 0)));
    }
    if (all(p < vec2i(textureDimensions(out_specular)))) {
        textureStore(out_specular, p, half_rounded(textureLoad(in_specular, p, 0)));
    }
}
