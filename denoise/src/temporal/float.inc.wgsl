// Light is kept as f32: a mean of more than 32 frames would no longer move as half floats.

@group(3) @binding(0) var out_diffuse: texture_storage_2d<rgba32float, write>;
@group(3) @binding(1) var out_specular: texture_storage_2d<rgba32float, write>;

fn temporal_stored(light: vec4f) -> vec4f {
    return light;
}
