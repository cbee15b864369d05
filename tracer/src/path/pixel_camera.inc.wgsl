// Where the light of a pixel's path is summed up, with what the path's own camera ray saw: nothing of it rounded.
struct Pixel {
    // As in pixel.inc.wgsl.
    diffuse: vec4f,
    specular: vec4f,
    samples: u32,
    // m along the camera ray; 0 = it left the scene.
    distance: f32,
    // Thin 1, the back side is seen 2.
    flags: u32,
    f90: f32,
    // What the camera ray itself found: emission, or the sky.
    direct: vec3f,
    f0: f32,
    point: vec3f,
    transmission: f32,
    wo: vec3f,
    metalness: f32,
    face: vec3f,
    handedness: f32,
    normal: vec3f,
    roughness_t: f32,
    tangent: vec3f,
    roughness_b: f32,
    base: vec3f,
    absorption: vec3f,
    // As in pixel.inc.wgsl; not used.
    aside: vec3f,
}
