// What a pixel sees, from the G-buffer. See mod.rs.

@group(2) @binding(0) var in_surface: texture_2d<u32>;
@group(2) @binding(1) var in_distance: texture_2d<f32>;
@group(2) @binding(2) var in_face_normal: texture_2d<u32>;
@group(2) @binding(3) var in_motion_id: texture_2d<u32>;

struct First {
    // Its normal faces the viewer.
    surface: Surface,
    // World, m.
    point: vec3f,
    // Unit, towards the viewer: nothing is reflected below it.
    face: vec3f,
    // Unit, towards the viewer.
    wo: vec3f,
    // The back side is seen.
    is_back: bool,
}

fn first_is_hit(index: u32, pixel: vec2u) -> bool {
    return textureLoad(in_distance, pixel, 0).x > 0.0;
}

fn first_load(index: u32, pixel: vec2u) -> First {
    var first: First;
    first.surface = path_surface(surface_unpack_gbuffer(textureLoad(in_surface, pixel, 0)));
    first.face = surface_face_normal_unpack(textureLoad(in_face_normal, pixel, 0).x);
    first.is_back = (textureLoad(in_motion_id, pixel, 0).y & 0x80000000u) != 0u;
    first.wo = -frame_view_direction(vec2f(pixel) + 0.5 + frame.jitter, frame.trace_size);
    first.point = frame.eye - textureLoad(in_distance, pixel, 0).x * first.wo;
    return first;
}
