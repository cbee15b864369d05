// Copies both lobes, and mends what is not valid.

@group(2) @binding(0) var in_diffuse: texture_2d<f32>;
@group(2) @binding(1) var in_specular: texture_2d<f32>;
@group(3) @binding(0) var out_diffuse: texture_storage_2d<rgba16float, write>;
@group(3) @binding(1) var out_specular: texture_storage_2d<rgba16float, write>;
@group(3) @binding(2) var<storage, read_write> out_invalid: atomic<u32>;

@compute @workgroup_size(8, 8)
fn identity(@builtin(global_invocation_id) id: vec3u) {
    let size = vec2i(textureDimensions(out_diffuse));
    let p = vec2i(id.xy);
    if (any(p >= size)) {
        return;
    }
    let is_valid = light_is_valid(textureLoad(in_diffuse, p, 0)) && light_is_valid(textureLoad(in_specular, p, 0));
    if (!is_valid) {
        atomicAdd(&out_invalid, 1u);
    }
    textureStore(out_diffuse, p, light_mended(in_diffuse, p));
    // Without a specular lobe the texture is a single texel that nobody reads.
    if (all(p < vec2i(textureDimensions(out_specular)))) {
        textureStore(out_specular, p, light_mended(in_specular, p));
    }
}
