// How a surface scatters light, after surface.inc.wgsl. Formulas, units and departures: mod.rs beside this file.
// wo and wi are unit vectors away from the surface, in world space; v and l are the same in the tangent frame.

const BRDF_PI = 3.14159265358979323846;
const BRDF_TABLE_SIZE = 32u;

// Rows of (A, B) as pairs of half floats, four to an element.
@group(1) @binding(14) var<uniform> brdf_table: array<vec4u, 256>;

// G2 is the product of both G1 instead of Smith's height-correlated form.
override brdf_separable = false;

const BRDF_DELTA_ALPHA = 1e-3;          // a lobe narrower than this is a mirror
const BRDF_LEAST_MODULATOR = 0.0009765625; // 2^-10
const BRDF_LEAST_COSINE = 1e-6;         // directions closer to the horizon count as below it

struct BrdfModulators {
  diffuse: vec3f,
  specular: vec3f,
};

struct BrdfSample {
  wi: vec3f,
  weight: vec3f, // f cos / pdf, not divided by a modulator
  pdf: f32,      // 1/sr; 0 when delta
  branch: f32,   // probability with which u.z chose reflection or transmission; part of weight and pdf
  delta: bool,
  transmitted: bool,
  valid: bool,   // false: the path ends here
};

struct BrdfValue {
  diffuse: vec3f,    // 1/sr, without the cosine
  specular: vec3f,
  pdf_diffuse: f32,  // 1/sr, of brdf_sample_diffuse
  pdf_specular: f32, // 1/sr, of brdf_sample_specular
};

fn brdf_luminance(c: vec3f) -> f32 {
  return dot(c, vec3f(0.2126, 0.7152, 0.0722));
}

// ---- Fresnel ----

fn brdf_schlick(f0: vec3f, f90: vec3f, cosine: f32) -> vec3f {
  let m = clamp(1.0 - cosine, 0.0, 1.0);
  let m2 = m * m;
  return f0 + (f90 - f0) * (m2 * m2 * m);
}

// Index of refraction behind the surface over the one before it.
fn brdf_ior(f0: f32) -> f32 {
  let root = min(sqrt(f0), 0.99);
  return (1.0 + root) / (1.0 - root);
}

// Refracted cosine for eta = n_before / n_behind; negative at total reflection.
fn brdf_refracted_cosine(cosine: f32, eta: f32) -> f32 {
  let squared = 1.0 - eta * eta * (1.0 - cosine * cosine);
  return select(-1.0, sqrt(max(squared, 0.0)), squared > 0.0);
}

// Exact, unpolarised.
fn brdf_fresnel(cosine: f32, eta: f32) -> f32 {
  let refracted = brdf_refracted_cosine(cosine, eta);
  if (refracted < 0.0) {
    return 1.0;
  }
  let s = (eta * cosine - refracted) / (eta * cosine + refracted);
  let p = (cosine - eta * refracted) / (cosine + eta * refracted);
  return min(0.5 * (s * s + p * p), 1.0);
}

// ---- the surface as the lobes see it ----

fn brdf_has_specular(s: Surface) -> bool {
  return s.f0 > 0.0 || s.metalness > 0.0 || s.transmission > 0.0;
}

fn brdf_alpha(s: Surface) -> vec2f {
  return max(s.roughness * s.roughness, vec2f(BRDF_DELTA_ALPHA));
}

fn brdf_is_delta(s: Surface) -> bool {
  let rougher = max(s.roughness.x, s.roughness.y);
  return rougher * rougher < BRDF_DELTA_ALPHA;
}

// What passes is not bent: a sheet, or no change of index.
fn brdf_is_straight(s: Surface) -> bool {
  return s.thin || s.f0 == 0.0;
}

fn brdf_eta(s: Surface, inside: bool) -> f32 {
  let ior = brdf_ior(s.f0);
  return select(1.0 / ior, ior, inside);
}

// M_d before Fresnel.
fn brdf_diffuse_albedo(s: Surface) -> vec3f {
  return s.base * ((1.0 - s.metalness) * (1.0 - s.transmission));
}

// What a facet met at this cosine does with light.
struct BrdfFacet {
  reflected: vec3f,
  transmitted: vec3f,
  reflect_probability: f32,
};

fn brdf_facet(s: Surface, cosine: f32, inside: bool) -> BrdfFacet {
  let dielectric = 1.0 - s.metalness;
  var f = s.metalness * brdf_schlick(s.base, vec3f(1.0), cosine)
    + dielectric * (1.0 - s.transmission) * brdf_schlick(vec3f(s.f0), vec3f(s.f90), cosine);
  var t = vec3f(0.0);
  if (s.transmission > 0.0) {
    var clear = 0.0;
    if (s.f0 > 0.0) {
      clear = brdf_fresnel(cosine, brdf_eta(s, inside && !s.thin));
    }
    if (s.thin) {
      // Both faces and all reflections between them.
      clear = 2.0 * clear / (1.0 + clear);
    }
    f += vec3f(dielectric * s.transmission * clear);
    t = s.base * (dielectric * s.transmission * (1.0 - clear));
  }
  let reflected = brdf_luminance(f);
  let sum = reflected + brdf_luminance(t);
  return BrdfFacet(f, t, select(1.0, reflected / max(sum, 1e-20), sum > 1e-20));
}

// ---- modulators ----

// A and B of E_s = F0 A + F90 B: x is sqrt(mu), y the square root of the two alphas' root mean square.
fn brdf_table_texel(x: u32, y: u32) -> vec2f {
  let i = y * BRDF_TABLE_SIZE + x;
  return unpack2x16float(brdf_table[i >> 2u][i & 3u]);
}

fn brdf_table_lookup(mu: f32, alpha_t: f32, alpha_b: f32) -> vec2f {
  let last = f32(BRDF_TABLE_SIZE - 1u);
  let alpha = sqrt(0.5 * (alpha_t * alpha_t + alpha_b * alpha_b));
  let p = sqrt(clamp(vec2f(mu, alpha), vec2f(0.0), vec2f(1.0))) * last;
  let low = min(floor(p), vec2f(last - 1.0));
  let w = p - low;
  let i = vec2u(low);
  let row_0 = mix(brdf_table_texel(i.x, i.y), brdf_table_texel(i.x + 1u, i.y), w.x);
  let row_1 = mix(brdf_table_texel(i.x, i.y + 1u), brdf_table_texel(i.x + 1u, i.y + 1u), w.x);
  return mix(row_0, row_1, w.y);
}

// Directional reflectance of all that reflects, with Schlick's Fresnel.
fn brdf_reflectance(s: Surface, mu: f32) -> vec3f {
  let alpha = s.roughness * s.roughness;
  let scale = brdf_table_lookup(mu, alpha.x, alpha.y);
  let f0 = mix(vec3f(s.f0), s.base, s.metalness);
  let f90 = mix(s.f90, 1.0, s.metalness);
  return f0 * scale.x + vec3f(f90 * scale.y);
}

fn brdf_modulators(s: Surface, mu: f32) -> BrdfModulators {
  var specular = vec3f(0.0);
  if (brdf_has_specular(s)) {
    let e = brdf_reflectance(s, mu);
    specular = e + (1.0 - s.metalness) * s.transmission * s.base * (1.0 - e);
  }
  return BrdfModulators(brdf_diffuse_albedo(s), max(specular, vec3f(BRDF_LEAST_MODULATOR)));
}

// ---- GGX ----

fn brdf_to_local(s: Surface, w: vec3f) -> vec3f {
  let bitangent = cross(s.normal, s.tangent) * s.handedness;
  return vec3f(dot(w, s.tangent), dot(w, bitangent), dot(w, s.normal));
}

fn brdf_to_world(s: Surface, l: vec3f) -> vec3f {
  let bitangent = cross(s.normal, s.tangent) * s.handedness;
  return normalize(l.x * s.tangent + l.y * bitangent + l.z * s.normal);
}

fn brdf_ggx(h: vec3f, alpha: vec2f) -> f32 {
  let x = h.xy / alpha;
  let e = dot(x, x) + h.z * h.z;
  return 1.0 / (BRDF_PI * alpha.x * alpha.y * e * e);
}

fn brdf_lambda(v: vec3f, alpha: vec2f) -> f32 {
  let x = alpha * v.xy / v.z;
  return 0.5 * (sqrt(1.0 + dot(x, x)) - 1.0);
}

// G2 / G1.
fn brdf_shadowing(v: vec3f, l: vec3f, alpha: vec2f) -> f32 {
  let masked = 1.0 + brdf_lambda(v, alpha);
  let shadowed = brdf_lambda(l, alpha);
  return select(masked / (masked + shadowed), 1.0 / (1.0 + shadowed), brdf_separable);
}

// Density of the normals that v sees, over v.h: D G1 / v.z, 1/sr.
fn brdf_visible(v: vec3f, h: vec3f, alpha: vec2f) -> f32 {
  return brdf_ggx(h, alpha) / ((1.0 + brdf_lambda(v, alpha)) * v.z);
}

// A normal that v sees, by spherical caps (Dupuy and Benyoub 2023).
fn brdf_sample_normal(v: vec3f, alpha: vec2f, u: vec2f) -> vec3f {
  let w = normalize(vec3f(alpha * v.xy, v.z));
  let phi = 2.0 * BRDF_PI * u.x;
  let z = (1.0 - u.y) * (1.0 + w.z) - w.z;
  let radius = sqrt(clamp(1.0 - z * z, 0.0, 1.0));
  let h = vec3f(radius * cos(phi), radius * sin(phi), z) + w;
  return normalize(vec3f(alpha * h.xy, max(h.z, 1e-7)));
}

// ---- sampling ----

fn brdf_no_sample() -> BrdfSample {
  return BrdfSample(vec3f(0.0, 0.0, 1.0), vec3f(0.0), 0.0, 1.0, false, false, false);
}

fn brdf_diffuse(s: Surface, wo: vec3f, wi: vec3f) -> vec3f {
  let h = normalize(wo + wi);
  let f = brdf_schlick(vec3f(s.f0), vec3f(s.f90), dot(wi, h));
  return brdf_diffuse_albedo(s) * (1.0 - f);
}

fn brdf_sample_diffuse(s: Surface, wo: vec3f, u: vec2f) -> BrdfSample {
  var result = brdf_no_sample();
  let radius = sqrt(u.x);
  let phi = 2.0 * BRDF_PI * u.y;
  let l = vec3f(radius * cos(phi), radius * sin(phi), sqrt(max(1.0 - u.x, 0.0)));
  if (dot(s.normal, wo) < BRDF_LEAST_COSINE || l.z < BRDF_LEAST_COSINE) {
    return result;
  }
  result.wi = brdf_to_world(s, l);
  result.weight = brdf_diffuse(s, wo, result.wi);
  result.pdf = l.z / BRDF_PI;
  result.valid = true;
  return result;
}

fn brdf_sample_specular(s: Surface, wo: vec3f, u: vec3f, inside: bool) -> BrdfSample {
  var result = brdf_no_sample();
  let v = brdf_to_local(s, wo);
  if (v.z < BRDF_LEAST_COSINE || !brdf_has_specular(s)) {
    return result;
  }
  let is_delta = brdf_is_delta(s);
  let alpha = brdf_alpha(s);
  var h = vec3f(0.0, 0.0, 1.0);
  if (!is_delta) {
    h = brdf_sample_normal(v, alpha, u.xy);
  }
  let cosine = min(dot(v, h), 1.0);
  if (cosine < BRDF_LEAST_COSINE) {
    return result;
  }
  let facet = brdf_facet(s, cosine, inside);
  result.delta = is_delta;
  result.transmitted = u.z >= facet.reflect_probability;

  var l = 2.0 * cosine * h - v;
  var light = facet.reflected;
  result.branch = facet.reflect_probability;
  var jacobian = 1.0 / (4.0 * cosine);
  if (result.transmitted) {
    light = facet.transmitted;
    result.branch = 1.0 - facet.reflect_probability;
    if (brdf_is_straight(s)) {
      result.wi = -wo;
      result.weight = light / result.branch;
      result.delta = true;
      result.valid = true;
      return result;
    }
    let eta = brdf_eta(s, inside);
    let refracted = max(brdf_refracted_cosine(cosine, eta), 0.0);
    l = (eta * cosine - refracted) * h - eta * v;
    light *= eta * eta; // radiance is squeezed with the solid angle
    jacobian = brdf_refraction_jacobian(cosine, refracted, eta);
  }
  if (select(l.z, -l.z, result.transmitted) < BRDF_LEAST_COSINE) {
    return result;
  }
  result.wi = brdf_to_world(s, l);
  result.weight = light / max(result.branch, 1e-20);
  if (!is_delta) {
    result.weight *= brdf_shadowing(v, l, alpha);
    result.pdf = result.branch * brdf_visible(v, h, alpha) * cosine * jacobian;
  }
  result.valid = true;
  return result;
}

// Solid angle of facet normals over that of refracted directions, for both cosines positive.
fn brdf_refraction_jacobian(cosine: f32, refracted: f32, eta: f32) -> f32 {
  let d = eta * cosine - refracted;
  return refracted / max(d * d, 1e-12);
}

// ---- evaluation ----

// As seen from outside a solid.
fn brdf_eval(s: Surface, wo: vec3f, wi: vec3f) -> BrdfValue {
  return brdf_eval_side(s, wo, wi, false);
}

fn brdf_eval_side(s: Surface, wo: vec3f, wi: vec3f, inside: bool) -> BrdfValue {
  var value = BrdfValue(vec3f(0.0), vec3f(0.0), 0.0, 0.0);
  let v = brdf_to_local(s, wo);
  let l = brdf_to_local(s, wi);
  if (v.z < BRDF_LEAST_COSINE || abs(l.z) < BRDF_LEAST_COSINE) {
    return value;
  }
  let is_reflection = l.z > 0.0;
  if (is_reflection) {
    value.diffuse = brdf_diffuse(s, wo, wi) / BRDF_PI;
    value.pdf_diffuse = l.z / BRDF_PI;
  }
  if (brdf_is_delta(s) || !brdf_has_specular(s) || (!is_reflection && (s.transmission == 0.0 || brdf_is_straight(s)))) {
    return value;
  }

  let alpha = brdf_alpha(s);
  let eta = brdf_eta(s, inside);
  var h = v + l;
  if (!is_reflection) {
    h = eta * v + l;
    h *= select(1.0, -1.0, h.z < 0.0);
  }
  let length_2 = dot(h, h);
  if (length_2 < 1e-14) {
    return value;
  }
  h *= inverseSqrt(length_2);
  let cosine = min(dot(v, h), 1.0);
  let light_cosine = select(-dot(l, h), dot(l, h), is_reflection);
  if (cosine < BRDF_LEAST_COSINE || light_cosine < BRDF_LEAST_COSINE) {
    return value;
  }
  let facet = brdf_facet(s, cosine, inside);
  var light = facet.reflected;
  var branch = facet.reflect_probability;
  var jacobian = 1.0 / (4.0 * cosine);
  if (!is_reflection) {
    light = facet.transmitted * (eta * eta);
    branch = 1.0 - facet.reflect_probability;
    jacobian = brdf_refraction_jacobian(cosine, light_cosine, eta);
  }
  let density = brdf_visible(v, h, alpha) * cosine * jacobian;
  value.specular = light * (density * brdf_shadowing(v, l, alpha) / abs(l.z));
  value.pdf_specular = branch * density;
  return value;
}
