// A G-buffer from the triangle that each pixel sees, after gather.inc.wgsl. See mod.rs beside this file.

@group(2) @binding(0) var in_triangle: texture_2d<u32>; // 0 = none
@group(3) @binding(0) var out_surface: texture_storage_2d<rgba32uint, write>;
@group(3) @binding(1) var out_distance: texture_storage_2d<r32float, write>;
@group(3) @binding(2) var out_face_normal: texture_storage_2d<r32uint, write>;
@group(3) @binding(3) var out_motion_id: texture_storage_2d<rg32uint, write>;

// Weights of the second and third corner where the ray meets the triangle. A rasteriser's grid may put a pixel into a
// triangle that its centre's ray just misses: then those of a point on its edge.
fn gather_weights(v: vec3u, direction: vec3f) -> vec2f {
  let a = mesh_position(v.x);
  let ab = mesh_position(v.y) - a;
  let ac = mesh_position(v.z) - a;
  let to_eye = frame.eye - a;
  let p = cross(direction, ac);
  let q = cross(to_eye, ab);
  let det = dot(ab, p);
  let weights = vec2f(dot(to_eye, p), dot(direction, q)) / select(1.0, det, abs(det) > 1e-30);
  let inside = clamp(weights, vec2f(0.0), vec2f(1.0));
  return inside / max(inside.x + inside.y, 1.0);
}

// Pixels of this image, without the jitter; far outside where the point is behind the eye.
fn gather_pixel(clip: vec4f, jitter: vec2f) -> vec2f {
  if (clip.w <= 0.0) {
    return vec2f(-1e9);
  }
  let size = vec2f(params.size);
  return (clip.xy / clip.w * vec2f(0.5, -0.5) + 0.5) * size + jitter * size / vec2f(frame.trace_size);
}

fn gather_motion(v: vec3u, weights: vec2f, position: vec3f) -> vec2f {
  let a = mesh_previous_position(v.x);
  let b = mesh_previous_position(v.y);
  let c = mesh_previous_position(v.z);
  let before = mesh_interpolate(a, b, c, weights);
  // Both through their matrix, so that what stands still does so to the last bit.
  let now_px = gather_pixel(frame.clip_from_world * vec4f(position, 1.0), frame.jitter);
  let before_px = gather_pixel(frame.previous_clip_from_world * vec4f(before, 1.0), frame.previous_jitter);
  return clamp(now_px - before_px, vec2f(-65504.0), vec2f(65504.0));
}

@compute @workgroup_size(8, 8)
fn gather(@builtin(global_invocation_id) id: vec3u) {
  let pixel = id.xy;
  if (any(pixel >= params.size)) {
    return;
  }
  let code = textureLoad(in_triangle, pixel, 0).x;
  if (code == 0u) {
    textureStore(out_surface, pixel, vec4u(0u));
    textureStore(out_distance, pixel, vec4f(0.0));
    textureStore(out_face_normal, pixel, vec4u(0u));
    textureStore(out_motion_id, pixel, vec4u(0u));
    return;
  }
  let triangle = code - 1u;
  let v = mesh_triangle(triangle);
  let size = vec2f(params.size);
  let sample_point = vec2f(pixel) + 0.5 + frame.jitter * size / vec2f(frame.trace_size);
  let weights = gather_weights(v, frame_view_direction(sample_point, params.size));

  let point = mesh_point(triangle, weights);
  let to_eye = frame.eye - point.position;
  let distance = length(to_eye);
  let wo = to_eye / max(distance, 1e-20);
  let is_back = dot(point.face_normal, wo) < 0.0;
  let face_normal = select(point.face_normal, -point.face_normal, is_back);

  var s = material_surface(mesh_material(triangle), point, gather_footprint(wo, distance, face_normal));
  s.coverage = 1.0;
  if (is_back) {
    s = material_turn(s);
  }
  if (params.bend == 1u) {
    s.normal = material_bend(s.normal, wo);
  }
  let motion = pack2x16float(gather_motion(v, weights, point.position));
  let object = (mesh_object(triangle) + 1u) | select(0u, 0x80000000u, is_back);
  textureStore(out_surface, pixel, surface_pack_gbuffer(s, gather_hash(pixel)));
  textureStore(out_distance, pixel, vec4f(distance));
  textureStore(out_face_normal, pixel, vec4u(surface_face_normal_pack(face_normal)));
  textureStore(out_motion_id, pixel, vec4u(motion, object, 0u, 0u));
}
