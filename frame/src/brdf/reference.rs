//! The CPU half: the same functions as `brdf.inc.wgsl`, in the same order, in f64.

use super::BrdfTable;
use crate::surface::Surface;
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};

pub(super) const DELTA_ALPHA: f64 = 1e-3;
const LEAST_MODULATOR: f64 = 1.0 / 1024.0;
const LEAST_COSINE: f64 = 1e-6;

/// What a first hit multiplies the light of each lobe by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Modulators {
    /// `M_d`: base colour times the share that is neither metal nor clear.
    pub diffuse: DVec3,
    /// `M_s`, at least 2^-10.
    pub specular: DVec3,
}

/// A direction drawn from a lobe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Where light comes from: unit, away from the surface, world space.
    pub wi: DVec3,
    /// `f cos / pdf`, not divided by a modulator.
    pub weight: DVec3,
    /// 1/sr; 0 when `delta`.
    pub pdf: f64,
    /// Probability with which reflection or transmission was chosen; part of `weight` and `pdf`.
    pub branch: f64,
    /// The only direction of its kind: light samples cannot hit it.
    pub delta: bool,
    /// On the other side of the surface.
    pub transmitted: bool,
    /// False where the path ends.
    pub valid: bool,
}

/// What both lobes do with light from a given direction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Value {
    /// `f_d`, 1/sr, without the cosine.
    pub diffuse: DVec3,
    /// `f_s`, 1/sr, without the cosine and without deltas.
    pub specular: DVec3,
    /// Density of [`sample_diffuse`], 1/sr.
    pub pdf_diffuse: f64,
    /// Density of [`sample_specular`], 1/sr.
    pub pdf_specular: f64,
}

fn luminance(c: DVec3) -> f64 {
    c.dot(DVec3::new(0.2126, 0.7152, 0.0722))
}

// ---- Fresnel ----

fn f90(f0: f64) -> f64 {
    (f0 / 0.02).min(1.0)
}

fn schlick(f0: DVec3, f90: f64, cosine: f64) -> DVec3 {
    f0 + (f90 - f0) * (1.0 - cosine).clamp(0.0, 1.0).powi(5)
}

pub(super) fn ior(f0: f64) -> f64 {
    let root = f0.sqrt().min(0.99);
    (1.0 + root) / (1.0 - root)
}

/// None at total reflection; `eta` is the index before the surface over the one behind it.
fn refracted_cosine(cosine: f64, eta: f64) -> Option<f64> {
    let squared = 1.0 - eta * eta * (1.0 - cosine * cosine);
    (squared > 0.0).then(|| squared.sqrt())
}

pub(super) fn fresnel(cosine: f64, eta: f64) -> f64 {
    let Some(refracted) = refracted_cosine(cosine, eta) else { return 1.0 };
    let s = (eta * cosine - refracted) / (eta * cosine + refracted);
    let p = (cosine - eta * refracted) / (cosine + eta * refracted);
    (0.5 * (s * s + p * p)).min(1.0)
}

// ---- the surface as the lobes see it ----

/// False for a pure Lambert surface.
pub fn has_specular(s: &Surface) -> bool {
    s.f0 > 0.0 || s.metalness > 0.0 || s.transmission > 0.0
}

fn alpha_unclamped(s: &Surface) -> DVec2 {
    s.roughness.as_dvec2() * s.roughness.as_dvec2()
}

fn alpha(s: &Surface) -> DVec2 {
    alpha_unclamped(s).max(DVec2::splat(DELTA_ALPHA))
}

/// Whether its specular lobe is a mirror: narrower than alpha 1e-3.
pub fn is_delta(s: &Surface) -> bool {
    alpha_unclamped(s).max_element() < DELTA_ALPHA
}

fn is_straight(s: &Surface) -> bool {
    s.thin || s.f0 == 0.0
}

fn eta(s: &Surface, inside: bool) -> f64 {
    let ior = ior(f64::from(s.f0));
    if inside { ior } else { 1.0 / ior }
}

fn diffuse_albedo(s: &Surface) -> DVec3 {
    s.base.as_dvec3() * (1.0 - f64::from(s.metalness)) * (1.0 - f64::from(s.transmission))
}

struct Facet {
    reflected: DVec3,
    transmitted: DVec3,
    reflect_probability: f64,
}

fn facet(s: &Surface, cosine: f64, inside: bool) -> Facet {
    let (base, f0) = (s.base.as_dvec3(), f64::from(s.f0));
    let (metalness, transmission) = (f64::from(s.metalness), f64::from(s.transmission));
    let dielectric = 1.0 - metalness;
    let mut reflected = metalness * schlick(base, 1.0, cosine)
        + dielectric * (1.0 - transmission) * schlick(DVec3::splat(f0), f90(f0), cosine);
    let mut transmitted = DVec3::ZERO;
    if transmission > 0.0 {
        let mut clear = if f0 > 0.0 { fresnel(cosine, eta(s, inside && !s.thin)) } else { 0.0 };
        if s.thin {
            clear = 2.0 * clear / (1.0 + clear);
        }
        reflected += dielectric * transmission * clear;
        transmitted = base * (dielectric * transmission * (1.0 - clear));
    }
    let sum = luminance(reflected) + luminance(transmitted);
    let reflect_probability = if sum > 1e-20 { luminance(reflected) / sum } else { 1.0 };
    Facet { reflected, transmitted, reflect_probability }
}

// ---- modulators ----

/// Directional reflectance of all that reflects, with Schlick's Fresnel.
fn reflectance(s: &Surface, mu: f64, table: &BrdfTable) -> DVec3 {
    let [a, b] = table.lookup(mu, alpha_unclamped(s));
    let (f0, metalness) = (f64::from(s.f0), f64::from(s.metalness));
    let edge = f90(f0) + (1.0 - f90(f0)) * metalness;
    DVec3::splat(f0).lerp(s.base.as_dvec3(), metalness) * a + edge * b
}

/// `M_d` and `M_s` of a surface seen under the cosine `mu`.
pub fn modulators(s: &Surface, mu: f64, table: &BrdfTable) -> Modulators {
    let mut specular = DVec3::ZERO;
    if has_specular(s) {
        let e = reflectance(s, mu, table);
        let clear = (1.0 - f64::from(s.metalness)) * f64::from(s.transmission);
        specular = e + clear * s.base.as_dvec3() * (1.0 - e);
    }
    Modulators { diffuse: diffuse_albedo(s), specular: specular.max(DVec3::splat(LEAST_MODULATOR)) }
}

// ---- GGX ----

fn frame(s: &Surface) -> [DVec3; 3] {
    let (n, t) = (s.normal.as_dvec3(), s.tangent.as_dvec3());
    [t, n.cross(t) * f64::from(s.handedness), n]
}

fn to_local(s: &Surface, w: DVec3) -> DVec3 {
    let [t, b, n] = frame(s);
    DVec3::new(w.dot(t), w.dot(b), w.dot(n))
}

fn to_world(s: &Surface, l: DVec3) -> DVec3 {
    let [t, b, n] = frame(s);
    (l.x * t + l.y * b + l.z * n).normalize()
}

pub(super) fn ggx(h: DVec3, alpha: DVec2) -> f64 {
    let x = h.truncate() / alpha;
    let e = x.length_squared() + h.z * h.z;
    1.0 / (PI * alpha.x * alpha.y * e * e)
}

fn lambda(v: DVec3, alpha: DVec2) -> f64 {
    let x = alpha * v.truncate() / v.z;
    0.5 * ((1.0 + x.length_squared()).sqrt() - 1.0)
}

pub(super) fn shadowing(v: DVec3, l: DVec3, alpha: DVec2) -> f64 {
    let masked = 1.0 + lambda(v, alpha);
    masked / (masked + lambda(l, alpha))
}

fn visible(v: DVec3, h: DVec3, alpha: DVec2) -> f64 {
    ggx(h, alpha) / ((1.0 + lambda(v, alpha)) * v.z)
}

pub(super) fn sample_normal(v: DVec3, alpha: DVec2, u: DVec2) -> DVec3 {
    let w = (alpha * v.truncate()).extend(v.z).normalize();
    let (sin, cos) = (TAU * u.x).sin_cos();
    let z = (1.0 - u.y) * (1.0 + w.z) - w.z;
    let radius = (1.0 - z * z).clamp(0.0, 1.0).sqrt();
    let h = DVec3::new(radius * cos, radius * sin, z) + w;
    (alpha * h.truncate()).extend(h.z.max(1e-7)).normalize()
}

// ---- sampling ----

const NO_SAMPLE: Sample = Sample {
    wi: DVec3::Z,
    weight: DVec3::ZERO,
    pdf: 0.0,
    branch: 1.0,
    delta: false,
    transmitted: false,
    valid: false,
};

fn diffuse(s: &Surface, wo: DVec3, wi: DVec3) -> DVec3 {
    let h = (wo + wi).normalize();
    let f0 = f64::from(s.f0);
    diffuse_albedo(s) * (1.0 - schlick(DVec3::splat(f0), f90(f0), wi.dot(h)))
}

/// Draws a direction by the cosine about the normal.
pub fn sample_diffuse(s: &Surface, wo: DVec3, u: DVec2) -> Sample {
    let radius = u.x.sqrt();
    let (sin, cos) = (TAU * u.y).sin_cos();
    let l = DVec3::new(radius * cos, radius * sin, (1.0 - u.x).max(0.0).sqrt());
    if s.normal.as_dvec3().dot(wo) < LEAST_COSINE || l.z < LEAST_COSINE {
        return NO_SAMPLE;
    }
    let wi = to_world(s, l);
    Sample { wi, weight: diffuse(s, wo, wi), pdf: l.z / PI, valid: true, ..NO_SAMPLE }
}

/// Draws a reflected or transmitted direction. `inside`: `wo` lies in the solid that the surface closes off.
pub fn sample_specular(s: &Surface, wo: DVec3, u: DVec3, inside: bool) -> Sample {
    let v = to_local(s, wo);
    if v.z < LEAST_COSINE || !has_specular(s) {
        return NO_SAMPLE;
    }
    let is_delta = is_delta(s);
    let alpha = alpha(s);
    let h = if is_delta { DVec3::Z } else { sample_normal(v, alpha, u.truncate()) };
    let cosine = v.dot(h).min(1.0);
    if cosine < LEAST_COSINE {
        return NO_SAMPLE;
    }
    let facet = facet(s, cosine, inside);
    let transmitted = u.z >= facet.reflect_probability;
    let mut l = 2.0 * cosine * h - v;
    let mut light = facet.reflected;
    let mut branch = facet.reflect_probability;
    let mut jacobian = 1.0 / (4.0 * cosine);
    if transmitted {
        light = facet.transmitted;
        branch = 1.0 - facet.reflect_probability;
        if is_straight(s) {
            let weight = light / branch;
            return Sample { wi: -wo, weight, pdf: 0.0, branch, delta: true, transmitted, valid: true };
        }
        let eta = eta(s, inside);
        let refracted = refracted_cosine(cosine, eta).unwrap_or(0.0);
        l = (eta * cosine - refracted) * h - eta * v;
        light *= eta * eta;
        jacobian = refraction_jacobian(cosine, refracted, eta);
    }
    if (if transmitted { -l.z } else { l.z }) < LEAST_COSINE {
        return NO_SAMPLE;
    }
    let mut weight = light / branch.max(1e-20);
    let mut pdf = 0.0;
    if !is_delta {
        weight *= shadowing(v, l, alpha);
        pdf = branch * visible(v, h, alpha) * cosine * jacobian;
    }
    Sample { wi: to_world(s, l), weight, pdf, branch, delta: is_delta, transmitted, valid: true }
}

fn refraction_jacobian(cosine: f64, refracted: f64, eta: f64) -> f64 {
    refracted / (eta * cosine - refracted).powi(2).max(1e-12)
}

// ---- evaluation ----

/// Both lobes as seen from outside a solid.
pub fn eval(s: &Surface, wo: DVec3, wi: DVec3) -> Value {
    eval_side(s, wo, wi, false)
}

/// Both lobes; `inside` as for [`sample_specular`].
pub fn eval_side(s: &Surface, wo: DVec3, wi: DVec3, inside: bool) -> Value {
    let mut value = Value::default();
    let (v, l) = (to_local(s, wo), to_local(s, wi));
    if v.z < LEAST_COSINE || l.z.abs() < LEAST_COSINE {
        return value;
    }
    let is_reflection = l.z > 0.0;
    if is_reflection {
        value.diffuse = diffuse(s, wo, wi) / PI;
        value.pdf_diffuse = l.z / PI;
    }
    let is_shut = !is_reflection && (s.transmission == 0.0 || is_straight(s));
    if is_delta(s) || !has_specular(s) || is_shut {
        return value;
    }

    let alpha = alpha(s);
    let eta = eta(s, inside);
    let mut h = v + l;
    if !is_reflection {
        h = eta * v + l;
        if h.z < 0.0 {
            h = -h;
        }
    }
    if h.length_squared() < 1e-14 {
        return value;
    }
    let h = h.normalize();
    let cosine = v.dot(h).min(1.0);
    let light_cosine = if is_reflection { l.dot(h) } else { -l.dot(h) };
    if cosine < LEAST_COSINE || light_cosine < LEAST_COSINE {
        return value;
    }
    let facet = facet(s, cosine, inside);
    let mut light = facet.reflected;
    let mut branch = facet.reflect_probability;
    let mut jacobian = 1.0 / (4.0 * cosine);
    if !is_reflection {
        light = facet.transmitted * (eta * eta);
        branch = 1.0 - facet.reflect_probability;
        jacobian = refraction_jacobian(cosine, light_cosine, eta);
    }
    let density = visible(v, h, alpha) * cosine * jacobian;
    value.specular = light * (density * shadowing(v, l, alpha) / l.z.abs());
    value.pdf_specular = branch * density;
    value
}
