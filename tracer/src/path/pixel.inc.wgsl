// Where the light of a pixel's paths is summed up.
struct Pixel {
    // rgb = sum of demodulated radiance, a = sum of first lengths, m.
    diffuse: vec4f,
    specular: vec4f,
    // Kept aside: what was found for the voxel that the pixel's path renews; then how noisy the pixel is, and how many more
    // samples it gets.
    aside: vec3f,
    // Paths that started in the diffuse lobe in the low half, in the specular one in the high half.
    samples: u32,
}
