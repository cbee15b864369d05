// Light is kept as half floats: enough for means of up to 32 frames.

@group(3) @binding(0) var out_diffuse: texture_storage_2d<rgba16float, write>;
@group(3) @binding(1) var out_specular: texture_storage_2d<rgba16float, write>;

fn temporal_stored(light: vec4f) -> vec4f {
    return half_rounded(light);
}
