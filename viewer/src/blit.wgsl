// The whole window as one triangle; each pixel loads the picture's texel it falls on.

struct Blit {
    window: vec2f,
    picture: vec2f,
    exposure: f32,
}

@group(0) @binding(1) var<uniform> params: Blit;
@group(2) @binding(0) var in_picture: texture_2d<f32>;

// 1: the target stores what it is given; 0: it applies the sRGB curve itself.
override blit_encode: u32 = 1u;

@vertex
fn blit_corner(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    let corner = vec2f(f32(index & 1u), f32(index >> 1u)) * 4.0 - 1.0;
    return vec4f(corner, 0.0, 1.0);
}

fn blit_srgb_from_linear(linear: vec3f) -> vec3f {
    return select(1.055 * pow(linear, vec3f(1.0 / 2.4)) - 0.055, 12.92 * linear, linear <= vec3f(0.0031308));
}

@fragment
fn blit_texel(@builtin(position) at: vec4f) -> @location(0) vec4f {
    // As large as fits, centred, its aspect kept; black bars beside it.
    let zoom = min(params.window.x / params.picture.x, params.window.y / params.picture.y);
    let texel = vec2i(floor((at.xy - 0.5 * params.window) / zoom + 0.5 * params.picture));
    if any(texel < vec2i(0)) || any(texel >= vec2i(params.picture)) {
        return vec4f(0.0, 0.0, 0.0, 1.0);
    }
    let linear = clamp(textureLoad(in_picture, texel, 0).rgb * params.exposure, vec3f(0.0), vec3f(1.0));
    return vec4f(select(linear, blit_srgb_from_linear(linear), blit_encode == 1u), 1.0);
}
