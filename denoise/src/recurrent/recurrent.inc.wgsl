// What recovering and blurring share: parameters and counts. After edge.

struct RecurrentParams {
    // Cosine and sine of the disc's angle in this frame.
    turn: vec2f,
    // Rows: of a kernel whose history is one frame long; of one that is long.
    radius: f32,
    radius_min: f32,
    // Metres, and metres per metre of depth: what counts as a far hit.
    hit_far: vec2f,
    // Power of the cosine; rows.
    sigma_normal: f32,
    sigma_depth: f32,
    // Relative difference of roughness.
    roughness_fraction: f32,
    // Pixels along a row per row.
    columns_per_row: f32,
    // Frames below which neighbours help, and how far they lie after one frame, rows.
    fix_frames: f32,
    fix_stride: f32,
    // Standard errors; frames that the fast history spans.
    lag_sigma: f32,
    fast_frames: f32,
}

@group(0) @binding(1) var<uniform> params: RecurrentParams;
@group(2) @binding(0) var in_edge: texture_2d<u32>;
@group(2) @binding(1) var in_diffuse: texture_2d<f32>;
@group(2) @binding(2) var in_specular: texture_2d<f32>;
@group(2) @binding(3) var in_frames: texture_2d<u32>;
@group(3) @binding(0) var out_diffuse: texture_storage_2d<rgba16float, write>;
@group(3) @binding(1) var out_specular: texture_storage_2d<rgba16float, write>;

// Diffuse, specular.
fn recurrent_frames(p: vec2i) -> vec2f {
    let packed = textureLoad(in_frames, p, 0).r;
    return vec2f(f32(packed & 0xffffu), f32(packed >> 16u));
}

// Of a tap, for both lobes; 0 where it has no light.
fn recurrent_weights(centre: EdgeCentre, q: vec2i, size: vec2i) -> vec2f {
    let tap = textureLoad(in_edge, q, 0);
    let weight = exp(-edge_fall(centre, tap, q, size, params.sigma_normal, params.sigma_depth));
    let lobes = vec2f(weight, weight * edge_roughness_weight(centre.texel, tap, params.roughness_fraction));
    return select(vec2f(0.0), lobes, recurrent_frames(q) > vec2f(0.0));
}

// To the nearest pixel, alike on either side of the centre.
fn recurrent_pixels(rows: vec2f) -> vec2i {
    let pixels = rows * vec2f(params.columns_per_row, 1.0);
    return vec2i(sign(pixels) * floor(abs(pixels) + vec2f(0.5)));
}
