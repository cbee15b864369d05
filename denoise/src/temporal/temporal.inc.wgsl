// How a pixel is found in the last frame: parameters, where it is expected, and which taps are the same surface.
// After edge. Formula, units: mod.rs beside this file.

struct TemporalParams {
    // The last frame's view, as `frame` has this one's.
    previous_forward: vec3f,
    alpha_color: f32,
    previous_right: vec3f,
    alpha_moments: f32,
    previous_up: vec3f,
    // Distance from the expected plane, relative to depth.
    plane_tolerance: f32,
    // This frame's eye minus the last one's, metres.
    eye_offset: vec3f,
    // Cosine between shading normals.
    normal_min: f32,
    // 0 or 1, a factor: a branch on it would have Mesa's software driver build the kernel anew for each dispatch.
    keeps_history: u32,
    // Frames.
    history_max: f32,
}

@group(0) @binding(1) var<uniform> params: TemporalParams;
@group(2) @binding(0) var in_edge: texture_2d<u32>;
@group(2) @binding(1) var in_motion_id: texture_2d<u32>;
@group(2) @binding(2) var in_edge_before: texture_2d<u32>;

// What taps are tested against: the pixel's texel, and its position relative to the last frame's eye.
struct Expected {
    texel: vec4u,
    position: vec3f,
    depth: f32,
}

fn temporal_ray(point: vec2f, size: vec2i) -> vec3f {
    let ndc = vec2f(2.0, -2.0) * (point / vec2f(size)) + vec2f(-1.0, 1.0);
    return params.previous_forward + ndc.x * params.previous_right + ndc.y * params.previous_up;
}

// Pixels from where it was to where it is; `moves` is false where the numbers are none.
struct Motion {
    pixels: vec2f,
    is_known: bool,
}

fn temporal_motion(p: vec2i) -> Motion {
    let code = textureLoad(in_motion_id, p, 0).x;
    let is_known = (code & 0x7c00u) != 0x7c00u && (code & 0x7c000000u) != 0x7c000000u;
    return Motion(unpack2x16float(select(0u, code, is_known)), is_known);
}

// Exact for what stands still. What moves on its own is expected at the depth it would have at rest: it may come nearer
// by `plane_tolerance` a frame.
fn temporal_expected(texel: vec4u, p: vec2i, motion: vec2f, size: vec2i) -> Expected {
    let depth = dot(params.previous_forward, edge_position(texel, p, size) + params.eye_offset);
    let point = vec2f(p) + vec2f(0.5) + frame.jitter - motion;
    return Expected(texel, depth * temporal_ray(point, size), depth);
}

// Whether the last frame's pixel q, which lies inside, shows the same surface.
fn temporal_is_same(expected: Expected, q: vec2i, size: vec2i) -> bool {
    let tap = textureLoad(in_edge_before, q, 0);
    let depth = bitcast<f32>(tap.x);
    let position = depth * temporal_ray(vec2f(q) + vec2f(0.5) + frame.previous_jitter, size);
    let plane = abs(dot(edge_face_normal(expected.texel), position - expected.position));
    return depth > 0.0
        && ((tap.w ^ expected.texel.w) & EDGE_OBJECT_MASK) == 0u
        && plane <= params.plane_tolerance * expected.depth
        && dot(edge_normal(tap), edge_normal(expected.texel)) >= params.normal_min;
}
