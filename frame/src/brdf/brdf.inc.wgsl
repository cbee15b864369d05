// How a surface scatters light, after surface.inc.wgsl. Formulas, units and departures: mod.rs beside this file.
// wo and wi are unit vectors away from the surface, in world space; v and l are the same in the tangent frame.

const BRDF_PI = 3.14159265358979323846;

// G2 is the product of both G1 instead of Smith's height-correlated form.
override brdf_separable = false;
// What rough facets keep from each other is put back, and the diffuse lobe gets what the other lets through.
override brdf_compensated = true;
// Of clear surfaces by Schlick instead of exact.
override brdf_schlick_glass = false;

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
  lambert: f32,      // the same over its albedo
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

// Schlick's for both sides: from the denser one it takes the cosine beyond the surface.
fn brdf_fresnel_schlick(cosine: f32, eta: f32) -> f32 {
  let refracted = brdf_refracted_cosine(cosine, eta);
  let root = (eta - 1.0) / (eta + 1.0);
  let outer = select(cosine, refracted, eta > 1.0);
  return select(brdf_schlick(vec3f(root * root), vec3f(1.0), outer).x, 1.0, refracted < 0.0);
}

// Schlick's of a surface that reflects nothing straight on.
fn brdf_grazing(cosine: f32) -> f32 {
  let m = clamp(1.0 - cosine, 0.0, 1.0);
  return m * m * m * m * m;
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
  // Of what is reflected, what clear material adds: it passes where other facets are in the way.
  clear: vec3f,
};

fn brdf_facet(s: Surface, cosine: f32, inside: bool) -> BrdfFacet {
  let dielectric = 1.0 - s.metalness;
  var f = s.metalness * brdf_schlick(s.base, vec3f(1.0), cosine)
    + dielectric * (1.0 - s.transmission) * brdf_schlick(vec3f(s.f0), vec3f(s.f90), cosine);
  var t = vec3f(0.0);
  var passing = vec3f(0.0);
  if (s.transmission > 0.0) {
    var clear = 0.0;
    if (s.f0 > 0.0) {
      let eta = brdf_eta(s, inside && !s.thin);
      clear = select(brdf_fresnel(cosine, eta), brdf_fresnel_schlick(cosine, eta), brdf_schlick_glass);
    }
    if (s.thin) {
      // Both faces and all reflections between them.
      clear = 2.0 * clear / (1.0 + clear);
    }
    f += vec3f(dielectric * s.transmission * clear);
    t = s.base * (dielectric * s.transmission * (1.0 - clear));
    passing = s.base * (dielectric * s.transmission * clear);
  }
  let reflected = brdf_luminance(f);
  let sum = reflected + brdf_luminance(t);
  return BrdfFacet(f, t, select(1.0, reflected / max(sum, 1e-20), sum > 1e-20), passing);
}

// ---- modulators ----

// Directional reflectance of all that reflects, with Schlick's Fresnel and what is put back; midway between tangent and
// bitangent, for tracer and upsampler know the cosine alone.
fn brdf_reflectance(s: Surface, mu: f32) -> vec3f {
  let f0 = mix(vec3f(s.f0), s.base, s.metalness);
  let f90 = vec3f(mix(s.f90, 1.0, s.metalness));
  let z = clamp(mu, BRDF_LEAST_COSINE, 1.0);
  if (brdf_is_delta(s)) {
    return f0 + (f90 - f0) * brdf_grazing(z);
  }
  let alpha = brdf_alpha(s);
  let energy = brdf_energy(vec3f(vec2f(sqrt(0.5 * (1.0 - z * z))), z), alpha);
  let kept = brdf_kept_colour(f0, f90, brdf_energy_mean(alpha).x);
  return f0 * (energy.x - energy.y) + f90 * energy.y + kept * (1.0 - energy.x);
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

// f_d over its albedo, times pi; `energy` is that towards wi.
fn brdf_lambert(s: Surface, wo: vec3f, wi: vec3f, energy: vec2f) -> f32 {
  if (brdf_compensated && !brdf_paper_lobe) {
    return brdf_coupling(s, energy);
  }
  let h = normalize(wo + wi);
  return 1.0 - brdf_schlick(vec3f(s.f0), vec3f(s.f90), dot(wi, h)).x;
}

// E and B towards l, where what is put back asks for them.
fn brdf_energy_towards(s: Surface, l: vec3f) -> vec2f {
  if (!brdf_compensated || brdf_paper_lobe || l.z <= 0.0 || !brdf_has_specular(s)) {
    return vec2f(1.0, 0.0);
  }
  return brdf_energy_of(s, l);
}

// By the cosine about +z.
fn brdf_cosine(u: vec2f) -> vec3f {
  let radius = sqrt(u.x);
  let phi = 2.0 * BRDF_PI * u.y;
  return vec3f(radius * cos(phi), radius * sin(phi), sqrt(max(1.0 - u.x, 0.0)));
}

fn brdf_sample_diffuse(s: Surface, wo: vec3f, u: vec2f) -> BrdfSample {
  var result = brdf_no_sample();
  let l = brdf_cosine(u);
  if (dot(s.normal, wo) < BRDF_LEAST_COSINE || l.z < BRDF_LEAST_COSINE) {
    return result;
  }
  result.wi = brdf_to_world(s, l);
  result.weight = brdf_diffuse_albedo(s) * brdf_lambert(s, wo, result.wi, brdf_energy_towards(s, l));
  result.pdf = l.z / BRDF_PI;
  result.valid = true;
  return result;
}

fn brdf_sample_specular(s: Surface, wo: vec3f, u: vec3f, inside: bool) -> BrdfSample {
  let v = brdf_to_local(s, wo);
  if (v.z < BRDF_LEAST_COSINE || !brdf_has_specular(s)) {
    return brdf_no_sample();
  }
  if (brdf_paper_lobe) {
    return brdf_sample_paper(s, v, u, inside);
  }
  let is_delta = brdf_is_delta(s);
  let alpha = brdf_alpha(s);
  var back = BrdfPutBack(vec3f(0.0), 0.0);
  if (brdf_compensated && !is_delta) {
    back = brdf_put_back(s);
  }
  let is_put_back = u.z >= 1.0 - back.probability;
  let choice = min(u.z / max(1.0 - back.probability, 1e-6), 0.99999994);
  var h = vec3f(0.0, 0.0, 1.0);
  if (!is_delta) {
    h = brdf_sample_normal(v, alpha, u.xy);
  }
  let cosine = min(dot(v, h), 1.0);
  if (cosine < BRDF_LEAST_COSINE && !is_put_back) {
    return brdf_no_sample();
  }
  let facet = brdf_facet(s, cosine, inside);
  let is_through = choice >= facet.reflect_probability && !is_put_back;
  let chosen = max(select(facet.reflect_probability, 1.0 - facet.reflect_probability, is_through), 1e-20);
  let branch = chosen * (1.0 - back.probability);
  let straight = brdf_is_straight(s);
  let eta = brdf_eta(s, inside);
  let refracted = max(brdf_refracted_cosine(cosine, eta), 0.0);
  var l = 2.0 * cosine * h - v;
  if (is_put_back) {
    l = brdf_cosine(u.xy);
  } else if (is_through) {
    if (straight) {
      return brdf_passed(s, -v, facet.transmitted / branch, branch);
    }
    l = (eta * cosine - refracted) * h - eta * v;
  }
  let is_below = select(l.z, -l.z, is_through) < BRDF_LEAST_COSINE;
  // What clear facets keep from each other passes on: as its own share of the draw, so that nothing is lost.
  if (brdf_compensated && !is_delta && !is_put_back && s.transmission > 0.0) {
    let rest = select(choice, choice - facet.reflect_probability, is_through) / chosen;
    if (is_below || rest >= brdf_shadowing(v, l, alpha)) {
      let kept = select(facet.clear, facet.transmitted, is_through) / branch;
      if (straight) {
        return brdf_passed(s, -v, kept, branch);
      }
      let below = brdf_cosine(u.yx);
      return brdf_passed(s, vec3f(below.xy, -max(below.z, BRDF_LEAST_COSINE)), kept * (eta * eta), branch);
    }
  }
  if (is_below) {
    return brdf_no_sample();
  }
  if (!is_through && !is_delta) {
    // Any of the reflecting parts may have drawn it: weighted by the density of all.
    let value = brdf_lobe(s, v, l, inside, back, brdf_energy_towards(s, l));
    let weight = value.specular * (l.z / max(value.pdf_specular, 1e-30));
    return BrdfSample(brdf_to_world(s, l), weight, value.pdf_specular, 1.0, false, false, value.pdf_specular > 0.0);
  }
  var light = select(facet.reflected, facet.transmitted, is_through) / branch;
  var pdf = 0.0;
  if (is_through) {
    light *= eta * eta; // radiance is squeezed with the solid angle
  }
  if (!is_delta) {
    let shadowing = brdf_shadowing(v, l, alpha);
    pdf = branch * brdf_visible(v, h, alpha) * cosine * brdf_refraction_jacobian(cosine, refracted, eta);
    light *= select(shadowing, 1.0, brdf_compensated);
    pdf *= select(1.0, shadowing, brdf_compensated);
  }
  return BrdfSample(brdf_to_world(s, l), light, pdf, branch, is_delta, is_through, true);
}

// A direction that light samples do not look along.
fn brdf_passed(s: Surface, l: vec3f, weight: vec3f, branch: f32) -> BrdfSample {
  return BrdfSample(brdf_to_world(s, l), weight, 0.0, branch, true, true, true);
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
  var value = BrdfValue(vec3f(0.0), 0.0, vec3f(0.0), 0.0, 0.0);
  let v = brdf_to_local(s, wo);
  let l = brdf_to_local(s, wi);
  if (v.z < BRDF_LEAST_COSINE || abs(l.z) < BRDF_LEAST_COSINE) {
    return value;
  }
  let is_reflection = l.z > 0.0;
  let energy = brdf_energy_towards(s, l);
  if (is_reflection) {
    value.lambert = brdf_lambert(s, wo, wi, energy) / BRDF_PI;
    value.diffuse = brdf_diffuse_albedo(s) * value.lambert;
    value.pdf_diffuse = l.z / BRDF_PI;
  }
  if (brdf_is_delta(s) || !brdf_has_specular(s) || (!is_reflection && (s.transmission == 0.0 || brdf_is_straight(s)))) {
    return value;
  }

  if (brdf_paper_lobe) {
    let lobe = brdf_eval_paper(s, v, l, inside);
    value.specular = lobe.specular;
    value.pdf_specular = lobe.pdf_specular;
    return value;
  }
  var back = BrdfPutBack(vec3f(0.0), 0.0);
  if (brdf_compensated) {
    back = brdf_put_back(s);
  }
  let lobe = brdf_lobe(s, v, l, inside, back, energy);
  value.specular = lobe.specular;
  value.pdf_specular = lobe.pdf_specular;
  return value;
}

// The specular lobe of a surface that is no mirror, reflected or refracted, with what is put back; `energy` is that
// towards l.
fn brdf_lobe(s: Surface, v: vec3f, l: vec3f, inside: bool, back: BrdfPutBack, energy: vec2f) -> BrdfValue {
  var value = BrdfValue(vec3f(0.0), 0.0, vec3f(0.0), 0.0, 0.0);
  let is_reflection = l.z > 0.0;
  let alpha = brdf_alpha(s);
  if (is_reflection && back.probability > 0.0) {
    value.specular = back.value * max(1.0 - energy.x, 0.0);
    value.pdf_specular = back.probability * l.z / BRDF_PI;
  }
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
  let shadowing = brdf_shadowing(v, l, alpha);
  value.specular += light * (density * shadowing / abs(l.z));
  let drawn = select(1.0, shadowing, brdf_compensated && s.transmission > 0.0);
  value.pdf_specular += (1.0 - back.probability) * branch * density * drawn;
  return value;
}
