// Random numbers without state: a hash of (pixel, sample, block, seed). Needs the frame uniform. See mod.rs.

// Jarzynski and Olano 2020, "Hash Functions for GPU Rendering".
fn noise_pcg4d(input: vec4u) -> vec4u {
    var v = input * 1664525u + 1013904223u;
    v.x += v.y * v.w; v.y += v.z * v.x; v.z += v.x * v.y; v.w += v.y * v.z;
    v ^= v >> vec4u(16u);
    v.x += v.y * v.w; v.y += v.z * v.x; v.z += v.x * v.y; v.w += v.y * v.z;
    return v;
}

// Four independent numbers in [0, 1) with 24 bits each.
fn noise_at(pixel: vec2u, sample: u32, block: u32) -> vec4f {
    let key = vec4u(pixel.x | (pixel.y << 16u), sample, block, frame.seed);
    return vec4f(noise_pcg4d(key) >> vec4u(8u)) * (1.0 / 16777216.0);
}

// The first two numbers of a pixel's sample: R2 (Roberts 2018) over the samples, rotated per pixel. The golden ratio's
// plane relatives are kept as 32-bit integers, so that the sequence stays exact for any number of samples.
fn noise_stratified(pixel: vec2u, sample: u32) -> vec2f {
    let rotation = noise_pcg4d(vec4u(pixel.x | (pixel.y << 16u), 0xffffffffu, 0u, frame.seed)).xy;
    let turned = rotation + sample * vec2u(3242174889u, 2447445414u);
    return vec2f(turned >> vec2u(8u)) * (1.0 / 16777216.0);
}
