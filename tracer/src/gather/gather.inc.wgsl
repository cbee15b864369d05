// What both halves of the gather share, after frame, surface, brdf, mesh and material.

struct GatherParams {
  size: vec2u,     // pixels of this image
  area_scale: f32, // 1: textures are seen through the pixel's footprint, 0: at mip 0
  bend: u32,       // 1: normals that a map turned away from the viewer are bent back
};

@group(0) @binding(1) var<uniform> params: GatherParams;

// m^2 of a plane facing `face_normal` at `distance` m along -wo that one pixel covers.
fn gather_footprint(wo: vec3f, distance: f32, face_normal: vec3f) -> f32 {
  let pixels = f32(params.size.x * params.size.y);
  let at_1 = 4.0 * length(frame.right) * length(frame.up) / pixels;
  let off_axis = -dot(wo, frame.forward);
  let solid_angle = at_1 * off_axis * off_axis * off_axis;
  return params.area_scale * solid_angle * distance * distance / max(abs(dot(face_normal, wo)), 1e-3);
}

fn gather_hash(pixel: vec2u) -> u32 {
  return surface_hash(pixel.x + surface_hash(pixel.y + surface_hash(frame.seed)));
}
