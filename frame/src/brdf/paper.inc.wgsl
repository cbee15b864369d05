// The paper's specular lobe, after brdf.inc.wgsl. See paper.rs.

// The lobe stands in for the facets'.
override brdf_paper_lobe = false;

const BRDF_PAPER_SPREAD = 0.1; // half the lobe's width for roughness 1
const BRDF_PAPER_LEAST = 0.01; // roughness across a lobe that has one in the other direction alone

// Where the lobe's middle is: mirrored, or bent.
fn brdf_paper_middle(s: Surface, v: vec3f, is_through: bool, inside: bool) -> vec3f {
  if (!is_through) {
    return vec3f(-v.xy, v.z);
  }
  let eta = brdf_eta(s, inside);
  return vec3f(-eta * v.xy, -max(brdf_refracted_cosine(v.z, eta), 0.0));
}

// Half the sides of the parallelogram that the middle's tip is moved in.
fn brdf_paper_half(s: Surface) -> vec2f {
  return BRDF_PAPER_SPREAD * max(s.roughness, vec2f(BRDF_PAPER_LEAST));
}

fn brdf_sample_paper(s: Surface, v: vec3f, u: vec3f, inside: bool) -> BrdfSample {
  let facet = brdf_facet(s, v.z, inside);
  let is_through = u.z >= facet.reflect_probability;
  let branch = max(select(facet.reflect_probability, 1.0 - facet.reflect_probability, is_through), 1e-20);
  var light = select(facet.reflected, facet.transmitted, is_through) / branch;
  if (is_through && brdf_is_straight(s)) {
    return brdf_passed(s, -v, light, branch);
  }
  let is_delta = brdf_is_delta(s);
  var tip = brdf_paper_middle(s, v, is_through, inside);
  let half = brdf_paper_half(s);
  if (!is_delta) {
    tip = vec3f(tip.xy + half * (2.0 * u.xy - 1.0), tip.z);
  }
  if (abs(tip.z) < BRDF_LEAST_COSINE) {
    return brdf_no_sample();
  }
  let span = length(tip);
  if (is_through) {
    let eta = brdf_eta(s, inside);
    light *= eta * eta;
  }
  let pdf = branch * span * span * span / (abs(tip.z) * 4.0 * half.x * half.y);
  return BrdfSample(brdf_to_world(s, tip / span), light, select(pdf, 0.0, is_delta), branch, is_delta, is_through, true);
}

fn brdf_eval_paper(s: Surface, v: vec3f, l: vec3f, inside: bool) -> BrdfValue {
  var value = BrdfValue(vec3f(0.0), 0.0, vec3f(0.0), 0.0, 0.0);
  let is_through = l.z < 0.0;
  let middle = brdf_paper_middle(s, v, is_through, inside);
  let tip = l * (middle.z / l.z);
  let half = brdf_paper_half(s);
  if (abs(middle.z) < BRDF_LEAST_COSINE || any(abs(tip.xy - middle.xy) > half)) {
    return value;
  }
  let facet = brdf_facet(s, v.z, inside);
  let span = length(tip);
  let density = span * span * span / (abs(tip.z) * 4.0 * half.x * half.y);
  let eta = brdf_eta(s, inside);
  value.specular = select(facet.reflected, facet.transmitted * (eta * eta), is_through) * (density / abs(l.z));
  value.pdf_specular = select(facet.reflect_probability, 1.0 - facet.reflect_probability, is_through) * density;
  return value;
}
