// A surface in 16 bytes, voxel and G-buffer texel alike. Bits, units and ranges: mod.rs beside this file.

struct Surface {
  normal: vec3f,
  tangent: vec3f,
  handedness: f32,   // +-1: bitangent = cross(normal, tangent) * handedness
  base: vec3f,       // base colour, linear, 0..1
  metalness: f32,
  emission: vec3f,   // radiance times the scene's radiance_scale
  absorption: vec3f, // 1/m, of the solid behind the surface
  roughness: vec2f,  // perceptual, along tangent and bitangent
  f0: f32,           // dielectric reflectance at normal incidence, 0 = no dielectric specular lobe
  f90: f32,          // the same at grazing incidence
  transmission: f32,
  coverage: f32,     // 1 = solid
  contour: f32,      // voxels only: signed offset of the plane from the cell's centre, in voxels
  two_sided: bool,
  thin: bool,
};

const SURFACE_SELECT_NONE = 0u;
const SURFACE_SELECT_METAL = 1u;
const SURFACE_SELECT_TRANSMISSION = 2u;
const SURFACE_SELECT_COVERAGE = 3u;

const SURFACE_NORMAL_STEPS = 2047;       // 12 + 12 bits
const SURFACE_FACE_NORMAL_STEPS = 32767; // 16 + 16 bits
const SURFACE_TANGENT_STEPS = 128.0;     // codes in one turn
const SURFACE_CONTOUR_STEP = 0.0068191762; // sqrt(3) / 2 over 127 codes
const SURFACE_CREASE_CODE = -128; // the contour of a cell whose surface bends
const SURFACE_TURN = 6.28318530717958647692;

// PCG (Jarzynski and Olano 2020, "Hash Functions for GPU Rendering").
fn surface_hash(x: u32) -> u32 {
  let state = x * 747796405u + 2891336453u;
  let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
  return (word >> 22u) ^ word;
}

// 24 bits of a hash in [0, 1).
fn surface_uniform(x: u32) -> f32 {
  return f32(surface_hash(x) >> 8u) * (1.0 / 16777216.0);
}

// Into 0..1; NaN becomes 0.
fn surface_unit(x: f32) -> f32 {
  return select(0.0, min(x, 1.0), x > 0.0);
}

fn surface_byte(x: f32) -> u32 {
  return u32(floor(surface_unit(x) * 255.0 + 0.5));
}

// ---- directions ----

// Octahedral grid point nearest to n on a grid of +-steps. Points on the square's outer border come in
// equal pairs; of each the one that `pack(unpack(code))` gives is taken. A vector without a direction gives +z.
fn surface_oct_pack(n: vec3f, steps: i32) -> vec2i {
  let length_1 = abs(n.x) + abs(n.y) + abs(n.z);
  if (!(length_1 > 1e-30 && length_1 < 1e30)) {
    return vec2i(0);
  }
  var p = n.xy / length_1;
  if (n.z < 0.0) {
    p = (1.0 - abs(p.yx)) * select(vec2f(-1.0), vec2f(1.0), p >= vec2f(0.0));
  }
  var code = vec2i(floor(p * f32(steps) + 0.5));
  if (abs(code.x) == steps) { code.y = abs(code.y); }
  if (abs(code.y) == steps) { code.x = abs(code.x); }
  return code;
}

// The direction before it is normalised: integers, so its signs are the same on every device.
fn surface_oct_unpack(code: vec2i, steps: i32) -> vec3i {
  let z = steps - abs(code.x) - abs(code.y);
  if (z >= 0) {
    return vec3i(code, z);
  }
  let folded = (steps - abs(code.yx)) * select(vec2i(-1), vec2i(1), code >= vec2i(0));
  return vec3i(folded, z);
}

fn surface_normal_integers(code: u32) -> vec3i {
  let p = vec2i(i32(code << 20u) >> 20u, i32(code << 8u) >> 20u);
  return surface_oct_unpack(p, SURFACE_NORMAL_STEPS);
}

fn surface_normal_pack(n: vec3f) -> u32 {
  let code = surface_oct_pack(n, SURFACE_NORMAL_STEPS);
  return (u32(code.x) & 0xfffu) | ((u32(code.y) & 0xfffu) << 12u);
}

// Reads the low 24 bits.
fn surface_normal_unpack(code: u32) -> vec3f {
  return normalize(vec3f(surface_normal_integers(code)));
}

fn surface_face_normal_pack(n: vec3f) -> u32 {
  let code = surface_oct_pack(n, SURFACE_FACE_NORMAL_STEPS);
  return (u32(code.x) & 0xffffu) | (u32(code.y) << 16u);
}

fn surface_face_normal_unpack(code: u32) -> vec3f {
  let p = vec2i(i32(code << 16u) >> 16u, i32(code) >> 16u);
  return normalize(vec3f(surface_oct_unpack(p, SURFACE_FACE_NORMAL_STEPS)));
}

// The tangent at angle 0 and at a quarter turn about a coded normal (Duff et al. 2017). The hemisphere
// comes from the integer: rounded floats disagree about the sign of z along the whole equator.
struct SurfaceBasis {
  first: vec3f,
  second: vec3f,
};

fn surface_basis(normal_code: u32) -> SurfaceBasis {
  let integers = surface_normal_integers(normal_code);
  let n = normalize(vec3f(integers));
  let s = select(-1.0, 1.0, integers.z >= 0);
  let a = -1.0 / (s + n.z);
  let b = n.x * n.y * a;
  return SurfaceBasis(
    vec3f(1.0 + s * n.x * n.x * a, s * b, -s * n.x),
    vec3f(b, s + n.y * n.y * a, -n.y),
  );
}

// Angle in the low 7 bits, handedness in the 8th. A tangent without a direction across the normal gives angle 0.
fn surface_tangent_pack(normal_code: u32, tangent: vec3f, handedness: f32) -> u32 {
  let basis = surface_basis(normal_code);
  let x = dot(tangent, basis.first);
  let y = dot(tangent, basis.second);
  let length_2 = x * x + y * y;
  var angle = 0u;
  if (length_2 > 1e-12 && length_2 < 1e30) {
    // A turn is added before rounding, so that the float is positive.
    let turns = atan2(y, x) / SURFACE_TURN + 1.0;
    angle = u32(floor(turns * SURFACE_TANGENT_STEPS + 0.5)) & 127u;
  }
  return angle | select(0u, 128u, handedness < 0.0);
}

// From word 0.
fn surface_tangent_unpack(word: u32) -> vec3f {
  let basis = surface_basis(word);
  let angle = f32((word >> 24u) & 127u) * (SURFACE_TURN / SURFACE_TANGENT_STEPS);
  return cos(angle) * basis.first + sin(angle) * basis.second;
}

// ---- colours ----

fn surface_linear_from_srgb(x: f32) -> f32 {
  return select(pow((max(x, 0.0) + 0.055) / 1.055, 2.4), x / 12.92, x <= 0.04045);
}

fn surface_srgb_from_linear(x: f32) -> f32 {
  return select(1.055 * pow(max(x, 0.0031308), 1.0 / 2.4) - 0.055, x * 12.92, x <= 0.0031308);
}

// One of the two neighbouring codes, the upper one with a probability linear in the decoded value.
fn surface_srgb8_pack(linear: f32, u: f32) -> u32 {
  let x = surface_unit(linear);
  var code = u32(clamp(255.0 * surface_srgb_from_linear(x), 0.0, 254.0));
  // The two powers do not invert each other to the last bit.
  if (code > 0u && x < surface_srgb8_unpack(code)) {
    code -= 1u;
  } else if (code < 254u && x >= surface_srgb8_unpack(code + 1u)) {
    code += 1u;
  }
  let below = surface_srgb8_unpack(code);
  let above = surface_srgb8_unpack(code + 1u);
  return code + select(0u, 1u, u < (x - below) / (above - below));
}

fn surface_srgb8_unpack(code: u32) -> f32 {
  return surface_linear_from_srgb(f32(code & 0xffu) / 255.0);
}

fn surface_base_pack(base: vec3f, hash: u32) -> u32 {
  // One number for all channels: grey stays grey.
  let u = surface_uniform(hash);
  return surface_srgb8_pack(base.r, u) | (surface_srgb8_pack(base.g, u) << 8u) | (surface_srgb8_pack(base.b, u) << 16u);
}

fn surface_base_unpack(word: u32) -> vec3f {
  return vec3f(surface_srgb8_unpack(word), surface_srgb8_unpack(word >> 8u), surface_srgb8_unpack(word >> 16u));
}

// Shared exponent of 5 bits above three mantissas of 9 (EXT_texture_shared_exponent). Saturates; NaN becomes 0.
fn surface_rgb9e5_pack(colour: vec3f) -> u32 {
  let c = select(vec3f(0.0), min(colour, vec3f(65408.0)), colour > vec3f(0.0));
  let largest = max(c.r, max(c.g, c.b));
  // The biased exponent of a float is its floor of log2 plus 127; shared exponents start at 2^-16.
  var exponent = max(i32(bitcast<u32>(largest) >> 23u) - 127, -16) + 16;
  if (floor(largest * surface_exp2(24 - exponent) + 0.5) >= 512.0) {
    exponent += 1;
  }
  let mantissas = vec3u(floor(c * surface_exp2(24 - exponent) + 0.5));
  return mantissas.r | (mantissas.g << 9u) | (mantissas.b << 18u) | (u32(exponent) << 27u);
}

fn surface_rgb9e5_unpack(code: u32) -> vec3f {
  let mantissas = vec3f(vec3u(code, code >> 9u, code >> 18u) & vec3u(511u));
  return mantissas * surface_exp2(i32(code >> 27u) - 24);
}

// Exact, for -126..127.
fn surface_exp2(exponent: i32) -> f32 {
  return bitcast<f32>(u32(exponent + 127) << 23u);
}

// ---- the record ----

// Select in the low 2 bits, amount in the next 4: of metal, transmission and holes, what is strongest.
fn surface_amount_pack(metalness: f32, transmission: f32, coverage: f32, hash: u32) -> u32 {
  let metal = surface_unit(metalness);
  let clear = surface_unit(transmission);
  let hole = 1.0 - surface_unit(coverage);
  var which = SURFACE_SELECT_METAL;
  var share = metal;
  if (clear > share) {
    which = SURFACE_SELECT_TRANSMISSION;
    share = clear;
  }
  if (hole > share) {
    which = SURFACE_SELECT_COVERAGE;
    share = hole;
  }
  let scaled = share * 15.0;
  let code = floor(scaled);
  let amount = u32(code) + select(0u, 1u, surface_uniform(hash) < scaled - code);
  return select(which | (amount << 2u), SURFACE_SELECT_NONE, amount == 0u);
}

fn surface_pack(s: Surface, metalness: f32, byte: u32, hash: u32) -> vec4u {
  let normal_code = surface_normal_pack(s.normal);
  let tangent_code = surface_tangent_pack(normal_code, s.tangent, s.handedness);
  let amount = surface_amount_pack(metalness, s.transmission, s.coverage, hash ^ 0x9e3779b9u);
  let transmissive = (amount & 3u) == SURFACE_SELECT_TRANSMISSION;
  var light = surface_rgb9e5_pack(s.emission);
  // A solid that shines cannot also hold its absorption: it becomes a thin sheet, which has none.
  let thin = s.thin || (transmissive && light != 0u);
  if (transmissive && !thin) {
    light = surface_rgb9e5_pack(s.absorption);
  }
  let lobe = surface_byte(s.roughness.x)
    | (surface_byte(s.roughness.y) << 8u)
    | (surface_byte(sqrt(surface_unit(s.f0))) << 16u)
    | (amount << 24u)
    | select(0u, 1u << 30u, s.two_sided)
    | select(0u, 1u << 31u, thin);
  return vec4u(normal_code | (tangent_code << 24u), surface_base_pack(s.base, hash) | (byte << 24u), light, lobe);
}

fn surface_pack_voxel(s: Surface, hash: u32) -> vec4u {
  let steps = select(0.0, s.contour / SURFACE_CONTOUR_STEP, abs(s.contour) < 2.0);
  let byte = u32(i32(clamp(floor(steps + 0.5), -128.0, 127.0))) & 0xffu;
  return surface_pack(s, s.metalness, byte, hash);
}

fn surface_pack_gbuffer(s: Surface, hash: u32) -> vec4u {
  return surface_pack(s, 0.0, surface_byte(s.metalness), hash);
}

fn surface_unpack(v: vec4u) -> Surface {
  var s: Surface;
  s.normal = surface_normal_unpack(v.x);
  s.tangent = surface_tangent_unpack(v.x);
  s.handedness = select(1.0, -1.0, (v.x >> 31u) == 1u);
  s.base = surface_base_unpack(v.y);
  s.roughness = vec2f(vec2u(v.w, v.w >> 8u) & vec2u(0xffu)) / 255.0;
  let root = f32((v.w >> 16u) & 0xffu) / 255.0;
  s.f0 = root * root;
  s.f90 = min(s.f0 / 0.02, 1.0);
  s.two_sided = ((v.w >> 30u) & 1u) == 1u;
  s.thin = (v.w >> 31u) == 1u;

  let which = (v.w >> 24u) & 3u;
  let amount = f32((v.w >> 26u) & 15u) / 15.0;
  let transmissive = which == SURFACE_SELECT_TRANSMISSION;
  s.metalness = select(0.0, amount, which == SURFACE_SELECT_METAL);
  s.transmission = select(0.0, amount, transmissive);
  s.coverage = 1.0 - select(0.0, amount, which == SURFACE_SELECT_COVERAGE);
  let light = surface_rgb9e5_unpack(v.z);
  let solid = transmissive && !s.thin;
  s.emission = select(light, vec3f(0.0), solid);
  s.absorption = select(vec3f(0.0), light, solid);
  return s;
}

fn surface_unpack_voxel(v: vec4u) -> Surface {
  var s = surface_unpack(v);
  s.contour = f32(i32(v.y) >> 24u) * SURFACE_CONTOUR_STEP;
  return s;
}

fn surface_unpack_gbuffer(v: vec4u) -> Surface {
  var s = surface_unpack(v);
  s.metalness = f32(v.y >> 24u) / 255.0;
  return s;
}
