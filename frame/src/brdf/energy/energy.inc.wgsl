// What a rough lobe reflects in all and what its facets keep from each other, after brdf.inc.wgsl. Table, units and
// formulas: mod.rs beside this file. v is unit, in the tangent frame, above the surface.

const BRDF_ROUGHNESSES = 16u;
const BRDF_HEIGHTS = 28u;
const BRDF_MEAN_ROUGHNESSES = 46u;
const BRDF_MEANS_AT = 3808u; // elements before the means
const BRDF_LEAST_ROUGHNESS = 0.031622777; // of alpha 1e-3

// A node is one element: E and m at three azimuths, j at two; behind all nodes the means of
// 1 - E (its fourth root) and B, four pairs to an element.
@group(1) @binding(14) var<uniform> brdf_table: array<vec4u, 4079>;

// Of two roughnesses, whichever comes first.
fn brdf_table_pair(first: u32, second: u32) -> u32 {
  let high = max(first, second);
  return high * (high + 1u) / 2u + min(first, second);
}

// Places of both alphas among the roughnesses: the lower neighbour, and the share of the upper one.
fn brdf_table_place(alpha: vec2f, count: u32) -> vec2f {
  let place = (sqrt(alpha) - BRDF_LEAST_ROUGHNESS) / (1.0 - BRDF_LEAST_ROUGHNESS);
  return clamp(place, vec2f(0.0), vec2f(1.0)) * f32(count - 1u);
}

// E, m and j of a pair of roughnesses, for a height's place and cos 2 phi.
fn brdf_table_node(first: u32, second: u32, row: f32, double: f32) -> vec3f {
  let c = select(double, -double, first > second);
  let low = min(u32(row), BRDF_HEIGHTS - 2u);
  let at = brdf_table_pair(first, second) * BRDF_HEIGHTS + low;
  let parabola = vec3f(0.5 * c * (c - 1.0), 1.0 - c * c, 0.5 * c * (c + 1.0));
  var found = array<vec3f, 2>();
  for (var i = 0u; i < 2u; i += 1u) {
    let node = brdf_table[at + i];
    let x = unpack2x16float(node.x);
    let y = unpack2x16float(node.y);
    let z = unpack2x16float(node.z);
    let w = unpack2x16float(node.w);
    found[i] = vec3f(
      dot(parabola, vec3f(x, y.x)), dot(parabola, vec3f(y.y, z)), mix(w.x, w.y, 0.5 * (c + 1.0)),
    );
  }
  return mix(found[0], found[1], row - f32(low));
}

// E and B: the share of light from v that leaves after one reflection, for facets that reflect all of it and for those
// that reflect (1 - cosine)^5.
fn brdf_energy(v: vec3f, alpha: vec2f) -> vec2f {
  let stretched = vec3f(alpha * v.xy, v.z);
  let span = length(stretched);
  let w = stretched / span;
  let across = dot(w.xy, w.xy);
  let double = select(0.0, (w.x * w.x - w.y * w.y) / max(across, 1e-12), across > 1e-12);
  let row = asin(min(sqrt(w.z), 1.0)) * (f32(BRDF_HEIGHTS - 1u) / (0.5 * BRDF_PI));
  let place = brdf_table_place(alpha, BRDF_ROUGHNESSES);
  let low = min(vec2u(place), vec2u(BRDF_ROUGHNESSES - 2u));
  let share = place - vec2f(low);
  let near = mix(brdf_table_node(low.x, low.y, row, double), brdf_table_node(low.x + 1u, low.y, row, double), share.x);
  let far = mix(brdf_table_node(low.x, low.y + 1u, row, double), brdf_table_node(low.x + 1u, low.y + 1u, row, double), share.x);
  let found = mix(near, far, share.y);
  let j = select(found.z, 1e-3, abs(found.z) < 1e-3);
  return vec2f(found.x, found.x * min(pow(max(1.0 + 5.0 * j * found.y * span, 1e-9), -1.0 / j), 1.0));
}

fn brdf_table_mean(first: u32, second: u32) -> vec2f {
  let pair = brdf_table_pair(first, second);
  return unpack2x16float(brdf_table[BRDF_MEANS_AT + (pair >> 2u)][pair & 3u]);
}

// Their means over the hemisphere, by the cosine.
fn brdf_energy_mean(alpha: vec2f) -> vec2f {
  let place = brdf_table_place(alpha, BRDF_MEAN_ROUGHNESSES);
  let low = min(vec2u(place), vec2u(BRDF_MEAN_ROUGHNESSES - 2u));
  let share = place - vec2f(low);
  let near = mix(brdf_table_mean(low.x, low.y), brdf_table_mean(low.x + 1u, low.y), share.x);
  let far = mix(brdf_table_mean(low.x, low.y + 1u), brdf_table_mean(low.x + 1u, low.y + 1u), share.x);
  let mean = mix(near, far, share.y);
  let squared = mean.x * mean.x;
  return vec2f(1.0 - squared * squared, mean.y);
}

// Of light that facets with this Fresnel keep from each other, the share that leaves in the end.
fn brdf_kept_colour(f0: vec3f, f90: vec3f, mean_energy: f32) -> vec3f {
  let mean = f0 + (f90 - f0) * (1.0 / 21.0);
  return mean * mean * mean_energy / max(1.0 - mean * (1.0 - mean_energy), vec3f(1e-6));
}

// What facets keep from each other of all that the opaque part of a surface reflects.
fn brdf_kept(s: Surface, mean_energy: f32) -> vec3f {
  return s.metalness * brdf_kept_colour(s.base, vec3f(1.0), mean_energy)
    + (1.0 - s.metalness) * (1.0 - s.transmission) * brdf_kept_colour(vec3f(s.f0), vec3f(s.f90), mean_energy);
}

// What the lobes need to know of the direction they are seen from: found once, by brdf_look, for all that is asked of a
// vertex. A look-up is long, and drivers put it wherever it is called.
struct BrdfSeen {
  energy: vec2f,
  mean: vec2f,
};
var<private> brdf_seen: BrdfSeen;

// E and B towards w, in the tangent frame; a mirror's are Fresnel's.
fn brdf_energy_of(s: Surface, w: vec3f) -> vec2f {
  if (brdf_is_delta(s)) {
    return vec2f(1.0, brdf_grazing(w.z));
  }
  return brdf_energy(vec3f(w.xy, max(w.z, BRDF_LEAST_COSINE)), brdf_alpha(s));
}

// Comes before brdf_sample_*, brdf_eval* and brdf_view with the same surface and wo.
fn brdf_look(s: Surface, wo: vec3f) {
  if (!brdf_compensated || brdf_paper_lobe || !brdf_has_specular(s)) {
    return;
  }
  brdf_seen.energy = brdf_energy_of(s, brdf_to_local(s, wo));
  brdf_seen.mean = vec2f(1.0, 1.0 / 21.0);
  if (!brdf_is_delta(s)) {
    brdf_seen.mean = brdf_energy_mean(brdf_alpha(s));
  }
}

// Share of light from a direction of this energy that does not come back off a dielectric's surface.
fn brdf_entering(s: Surface, energy: vec2f) -> f32 {
  let kept = brdf_kept_colour(vec3f(s.f0), vec3f(s.f90), brdf_seen.mean.x).x;
  return max(1.0 - s.f0 * (energy.x - energy.y) - s.f90 * energy.y - kept * (1.0 - energy.x), 0.0);
}

// The factor of the diffuse lobe that depends on where it is seen from.
fn brdf_view(s: Surface) -> f32 {
  if (!brdf_compensated || brdf_paper_lobe || s.f0 <= 0.0) {
    return 1.0;
  }
  return brdf_entering(s, brdf_seen.energy);
}

// The diffuse lobe under a dielectric's surface over its albedo, times pi, for light from a direction of this energy:
// light has to get in and out again.
fn brdf_coupling(s: Surface, energy: vec2f) -> f32 {
  if (s.f0 <= 0.0) {
    return 1.0;
  }
  return brdf_view(s) * brdf_entering(s, energy) / max(brdf_entering(s, brdf_seen.mean), 1e-6);
}

// ---- what rough facets keep from each other, put back as a lobe of its own (Kulla and Conty 2017) ----

struct BrdfPutBack {
  // Times 1 - E(wi): 1/sr.
  value: vec3f,
  // With which a sample goes there, by the cosine.
  probability: f32,
};

fn brdf_put_back(s: Surface) -> BrdfPutBack {
  let energy = brdf_seen.energy;
  let lost = max(1.0 - energy.x, 0.0);
  let kept = brdf_kept(s, brdf_seen.mean.x);
  let opaque = s.metalness * s.base + vec3f((1.0 - s.metalness) * (1.0 - s.transmission) * s.f0);
  let edge = s.metalness + (1.0 - s.metalness) * (1.0 - s.transmission) * s.f90;
  let once = brdf_luminance(opaque * (energy.x - energy.y)) + edge * energy.y + (1.0 - s.metalness) * s.transmission;
  let again = brdf_luminance(kept) * lost;
  return BrdfPutBack(kept * (lost / (BRDF_PI * max(1.0 - brdf_seen.mean.x, 1e-7))), again / max(again + once, 1e-20));
}
