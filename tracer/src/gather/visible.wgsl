// Which triangle each pixel sees, by rasterising, after gather.inc.wgsl. See mod.rs beside this file.

struct VisibleVertex {
  @builtin(position) position: vec4f,
  @location(0) weights: vec2f, // of the second and third corner
  @location(1) @interpolate(flat) triangle: u32,
};

fn visible_corner(index: u32) -> VisibleVertex {
  let triangle = index / 3u;
  let corner = index % 3u;
  let vertex = mesh_triangle(triangle)[corner];
  var out: VisibleVertex;
  out.position = frame.clip_from_world * vec4f(mesh_position(vertex), 1.0);
  out.weights = select(vec2f(0.0), vec2f(1.0), vec2u(corner) == vec2u(1u, 2u));
  out.triangle = triangle;
  return out;
}

// All triangles.
@vertex
fn visible_all(@builtin(vertex_index) index: u32) -> VisibleVertex {
  return visible_corner(index);
}

// Those without holes; the others shrink to a point.
@vertex
fn visible_solid(@builtin(vertex_index) index: u32) -> VisibleVertex {
  var out = visible_corner(index);
  out.position = select(out.position, vec4f(0.0, 0.0, 0.0, 1.0), material_is_cut(mesh_material(out.triangle)));
  return out;
}

// The others.
@vertex
fn visible_cut(@builtin(vertex_index) index: u32) -> VisibleVertex {
  var out = visible_corner(index);
  out.position = select(vec4f(0.0, 0.0, 0.0, 1.0), out.position, material_is_cut(mesh_material(out.triangle)));
  return out;
}

@fragment
fn visible_untested(in: VisibleVertex) -> @location(0) u32 {
  return in.triangle + 1u;
}

@fragment
fn visible_tested(in: VisibleVertex) -> @location(0) u32 {
  let point = mesh_point(in.triangle, in.weights);
  let to_eye = frame.eye - point.position;
  let distance = length(to_eye);
  let area = gather_footprint(to_eye / max(distance, 1e-20), distance, point.face_normal);
  // Another number for each triangle, so that two veils behind each other do not let the same pixels through.
  let random = surface_uniform(gather_hash(vec2u(in.position.xy)) ^ surface_hash(in.triangle));
  if (material_opacity(mesh_material(in.triangle), point, area) <= random) {
    discard;
  }
  return in.triangle + 1u;
}
