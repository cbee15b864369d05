//! The paper's specular lobe, as its author published it later: the mirrored or bent direction, its tip moved along tangent
//! and bitangent by as much as a tenth of their roughness.
//!
//! In: v, unit, in the tangent frame. Out: a direction and its density, in 1/sr. With the middle c and the moved tip p
//! (`p.z = c.z`, p uniform in a parallelogram of area `A = 0.04 r_t r_b`): `l = p / |p|`, `pdf = |p|^3 / (A |p.z|)`, the
//! solid angle of a patch of the plane `z = c.z`. The author published no density; this is the one of his samples.
//!
//! The lobe's value is what makes each of its samples weigh what a facet facing +z reflects: `f cos = F pdf`. It loses
//! nothing and is not reciprocal. A direction without roughness gets 0.01, so that the parallelogram has an area.

use super::facets::refracted_cosine;
use super::reference::{Brdf, LEAST_COSINE, NO_SAMPLE, Sample, eta, is_delta, is_straight, passed, to_world};
use crate::surface::Surface;
use glam::{DVec2, DVec3};

const SPREAD: f64 = 0.1;
const LEAST: f64 = 0.01;

fn middle(s: &Surface, v: DVec3, is_through: bool, inside: bool) -> DVec3 {
    if !is_through {
        return DVec3::new(-v.x, -v.y, v.z);
    }
    let eta = eta(s, inside);
    (-eta * v.truncate()).extend(-refracted_cosine(v.z, eta).unwrap_or(0.0))
}

/// Half the sides of the parallelogram.
fn half(s: &Surface) -> DVec2 {
    SPREAD * s.roughness.as_dvec2().max(DVec2::splat(LEAST))
}

fn density(tip: DVec3, half: DVec2) -> f64 {
    tip.length().powi(3) / (tip.z.abs() * 4.0 * half.x * half.y)
}

pub(super) fn sample(brdf: &Brdf<'_>, s: &Surface, v: DVec3, u: DVec3, inside: bool) -> Sample {
    let facet = brdf.facet(s, v.z, inside);
    let is_through = u.z >= facet.reflect_probability;
    let chosen = if is_through { 1.0 - facet.reflect_probability } else { facet.reflect_probability };
    let branch = chosen.max(1e-20);
    if is_through && is_straight(s) {
        return passed(s, -v, facet.transmitted / branch, branch);
    }
    let is_delta = is_delta(s);
    let mut tip = middle(s, v, is_through, inside);
    let half = half(s);
    if !is_delta {
        tip += (half * (2.0 * u.truncate() - 1.0)).extend(0.0);
    }
    if tip.z.abs() < LEAST_COSINE {
        return NO_SAMPLE;
    }
    let squeeze = if is_through { eta(s, inside).powi(2) } else { 1.0 };
    let light = if is_through { facet.transmitted } else { facet.reflected };
    Sample {
        wi: to_world(s, tip.normalize()),
        weight: light * squeeze / branch,
        pdf: if is_delta { 0.0 } else { branch * density(tip, half) },
        branch,
        delta: is_delta,
        transmitted: is_through,
        valid: true,
    }
}

/// The lobe's value, and the density of its samples.
pub(super) fn eval(brdf: &Brdf<'_>, s: &Surface, v: DVec3, l: DVec3, inside: bool) -> (DVec3, f64) {
    let is_through = l.z < 0.0;
    let middle = middle(s, v, is_through, inside);
    let tip = l * (middle.z / l.z);
    let half = half(s);
    if middle.z.abs() < LEAST_COSINE || (tip - middle).truncate().abs().cmpgt(half).any() {
        return (DVec3::ZERO, 0.0);
    }
    let facet = brdf.facet(s, v.z, inside);
    let density = density(tip, half);
    let (light, chosen) = if is_through {
        (facet.transmitted * eta(s, inside).powi(2), 1.0 - facet.reflect_probability)
    } else {
        (facet.reflected, facet.reflect_probability)
    };
    (light * (density / l.z.abs()), chosen * density)
}
