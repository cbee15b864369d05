// The first two numbers of a pixel's sample, after noise.inc.wgsl. See mod.rs.

// 64 x 64 texels of two blue-noise masks, 16 bits each, four texels to an element.
@group(0) @binding(2) var<uniform> noise_mask: array<vec4u, 1024>;

// R2 (Roberts 2018) over the samples, turned by each pixel's place in the masks. The golden ratio's plane relatives are
// kept as 32-bit integers, so that the sequence stays exact for any number of samples.
fn noise_stratified(pixel: vec2u, sample: u32) -> vec2f {
    if (noise_kind != NOISE_R2_BLUE) {
        return noise_at(pixel, sample, 0u).xy;
    }
    let seed = noise_pcg4d(vec4u(pixel.x | (pixel.y << 16u), 0xffffffffu, 0u, frame.seed));
    let moved = noise_pcg4d(vec4u(0u, 0xffffffffu, 1u, frame.seed)).xy;
    let texel = (pixel + moved) & vec2u(63u);
    let at = 64u * texel.y + texel.x;
    let ranks = noise_mask[at >> 2u][at & 3u];
    // The mask's 16 bits, and below them those that a mask of 4,096 ranks does not have.
    let turn = vec2u(ranks << 16u, ranks & 0xffff0000u) | (seed.xy >> vec2u(12u));
    let turned = turn + sample * vec2u(3242174889u, 2447445414u);
    return vec2f(turned >> vec2u(8u)) * (1.0 / 16777216.0);
}
