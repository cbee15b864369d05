// One frame as every shader sees it. Directions are world space, lengths metres.
struct Frame {
    clip_from_world: mat4x4f,
    previous_clip_from_world: mat4x4f,
    eye: vec3f,
    frame_index: u32,
    // Half the picture's width and height at distance 1 along `forward`.
    right: vec3f,
    seed: u32,
    up: vec3f,
    radiance_scale: f32,
    forward: vec3f,
    // Length of the scene's diagonal.
    diagonal: f32,
    trace_size: vec2u,
    display_size: vec2u,
    // In trace pixels, x right, y down.
    jitter: vec2f,
    previous_jitter: vec2f,
    time: f32,
    dt: f32,
    restart: u32,
    // 1: somebody else lights first hits with the sun.
    sun_elsewhere: u32,
}

@group(0) @binding(0) var<uniform> frame: Frame;

// Unit direction from the eye through a point of a picture of this size; pixel centres lie at +0.5.
fn frame_view_direction(point: vec2f, size: vec2u) -> vec3f {
    let ndc = vec2f(2.0, -2.0) * (point / vec2f(size)) + vec2f(-1.0, 1.0);
    return normalize(frame.forward + ndc.x * frame.right + ndc.y * frame.up);
}
