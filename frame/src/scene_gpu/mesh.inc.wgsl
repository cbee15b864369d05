// Triangles as every stage reads them, after surface.inc.wgsl. Words of a vertex: mesh.rs beside this file.

override mesh_stride_words: u32 = 7u;
override mesh_uv1_word: u32 = 0u;   // 0 = no second texture coordinates
override mesh_color_word: u32 = 0u; // 0 = no vertex colours

@group(1) @binding(0) var<storage, read> mesh_vertices: array<u32>;
@group(1) @binding(1) var<storage, read> mesh_triangles: array<vec4u>; // v0, v1, v2, material | object << 16
@group(1) @binding(20) var<storage, read> mesh_previous: array<f32>;   // 3 per vertex

// World space, m.
fn mesh_position(vertex: u32) -> vec3f {
  let at = vertex * mesh_stride_words;
  return bitcast<vec3f>(vec3u(mesh_vertices[at], mesh_vertices[at + 1u], mesh_vertices[at + 2u]));
}

// Where the vertex was one frame ago, m.
fn mesh_previous_position(vertex: u32) -> vec3f {
  let at = 3u * vertex;
  return vec3f(mesh_previous[at], mesh_previous[at + 1u], mesh_previous[at + 2u]);
}

fn mesh_normal(vertex: u32) -> vec3f {
  return surface_face_normal_unpack(mesh_vertices[vertex * mesh_stride_words + 3u]);
}

// w is the handedness: bitangent = cross(normal, tangent) * w.
fn mesh_tangent(vertex: u32) -> vec4f {
  return mesh_tangent_unpack(mesh_vertices[vertex * mesh_stride_words + 4u]);
}

fn mesh_uv0(vertex: u32) -> vec2f {
  let at = vertex * mesh_stride_words + 5u;
  return bitcast<vec2f>(vec2u(mesh_vertices[at], mesh_vertices[at + 1u]));
}

fn mesh_uv1(vertex: u32) -> vec2f {
  if (mesh_uv1_word == 0u) {
    return vec2f(0.0);
  }
  let at = vertex * mesh_stride_words + mesh_uv1_word;
  return bitcast<vec2f>(vec2u(mesh_vertices[at], mesh_vertices[at + 1u]));
}

// Linear RGBA that multiplies the base colour.
fn mesh_color(vertex: u32) -> vec4f {
  if (mesh_color_word == 0u) {
    return vec4f(1.0);
  }
  let at = vertex * mesh_stride_words + mesh_color_word;
  return vec4f(unpack2x16unorm(mesh_vertices[at]), unpack2x16unorm(mesh_vertices[at + 1u]));
}

fn mesh_triangle(triangle: u32) -> vec3u {
  return mesh_triangles[triangle].xyz;
}

fn mesh_material(triangle: u32) -> u32 {
  return mesh_triangles[triangle].w & 0xffffu;
}

fn mesh_object(triangle: u32) -> u32 {
  return mesh_triangles[triangle].w >> 16u;
}

// Word 4 of a vertex: a direction as in word 3, whose lowest bit says instead whether the handedness is -1.
fn mesh_tangent_pack(tangent: vec4f) -> u32 {
  return (surface_face_normal_pack(tangent.xyz) & ~1u) | select(0u, 1u, tangent.w < 0.0);
}

fn mesh_tangent_unpack(word: u32) -> vec4f {
  return vec4f(surface_face_normal_unpack(word & ~1u), select(1.0, -1.0, (word & 1u) == 1u));
}

// A point of a triangle, interpolated.
struct MeshPoint {
  position: vec3f,    // m
  face_normal: vec3f, // unit, on the front side
  normal: vec3f,      // unit
  tangent: vec4f,     // as interpolated: neither unit nor perpendicular to the normal
  uv0: vec2f,
  uv1: vec2f,
  uv_density: vec2f,  // area in uv0 and in uv1 per area of the triangle, 1/m^2
  color: vec4f,
};

fn mesh_interpolate(a: vec3f, b: vec3f, c: vec3f, weights: vec2f) -> vec3f {
  return a + weights.x * (b - a) + weights.y * (c - a);
}

fn mesh_uv_area(ab: vec2f, ac: vec2f) -> f32 {
  return abs(ab.x * ac.y - ab.y * ac.x);
}

// `weights` are those of the second and third corner.
fn mesh_point(triangle: u32, weights: vec2f) -> MeshPoint {
  let v = mesh_triangle(triangle);
  var point: MeshPoint;

  let a = mesh_position(v.x);
  let ab = mesh_position(v.y) - a;
  let ac = mesh_position(v.z) - a;
  point.position = a + weights.x * ab + weights.y * ac;
  // Scaled first: the square of a small triangle's area would be lost.
  let largest = max(max(max(abs(ab.x), abs(ab.y)), abs(ab.z)), max(max(abs(ac.x), abs(ac.y)), abs(ac.z)));
  let scale = 1.0 / max(largest, 1e-9);
  let cross_scaled = cross(ab * scale, ac * scale);
  let doubled_area = length(cross_scaled);
  point.normal = mesh_interpolate(mesh_normal(v.x), mesh_normal(v.y), mesh_normal(v.z), weights);
  let normal_length = length(point.normal);
  point.face_normal = select(point.normal, cross_scaled / max(doubled_area, 1e-12), doubled_area > 1e-12);
  point.normal = select(point.face_normal, point.normal / max(normal_length, 1e-6), normal_length > 1e-6);

  let tangent = mesh_tangent(v.x);
  let tangent_b = mesh_tangent(v.y);
  let tangent_c = mesh_tangent(v.z);
  point.tangent = vec4f(mesh_interpolate(tangent.xyz, tangent_b.xyz, tangent_c.xyz, weights), tangent.w);

  let uv0 = mesh_uv0(v.x);
  let uv0_ab = mesh_uv0(v.y) - uv0;
  let uv0_ac = mesh_uv0(v.z) - uv0;
  point.uv0 = uv0 + weights.x * uv0_ab + weights.y * uv0_ac;
  let uv1 = mesh_uv1(v.x);
  let uv1_ab = mesh_uv1(v.y) - uv1;
  let uv1_ac = mesh_uv1(v.z) - uv1;
  point.uv1 = uv1 + weights.x * uv1_ab + weights.y * uv1_ac;
  // The same scale twice, so that neither a square nor a quotient leaves the range of floats.
  let area = max(doubled_area, 1e-12);
  point.uv_density = vec2f(
    mesh_uv_area(uv0_ab * scale, uv0_ac * scale),
    mesh_uv_area(uv1_ab * scale, uv1_ac * scale),
  ) / area;

  let color = mesh_color(v.x);
  point.color = color + weights.x * (mesh_color(v.y) - color) + weights.y * (mesh_color(v.z) - color);
  return point;
}
