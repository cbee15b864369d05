//! The CPU half: the same functions as `brdf.inc.wgsl`, in the same order, in f64.

use super::energy::{self, PutBack};
use super::facets::{
    f90, fresnel, fresnel_schlick, grazing, ior, lambda, refracted_cosine, refraction_jacobian,
    sample_normal, schlick, shadowing, visible,
};
use super::{BrdfTable, Fresnel, Lobe, Rules, paper};
use crate::surface::Surface;
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};

pub(super) const DELTA_ALPHA: f64 = 1e-3;
const LEAST_MODULATOR: f64 = 1.0 / 1024.0;
pub(super) const LEAST_COSINE: f64 = 1e-6;
const BELOW_ONE: f64 = 0.999_999_94;

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
    /// Density of [`Brdf::sample_diffuse`], 1/sr.
    pub pdf_diffuse: f64,
    /// Density of [`Brdf::sample_specular`], 1/sr.
    pub pdf_specular: f64,
}

/// The lobes of surfaces under some rules.
#[derive(Clone, Copy, Debug)]
pub struct Brdf<'a> {
    /// Of the specular lobe's energy.
    pub table: &'a BrdfTable,
    /// Whose rules.
    pub rules: Rules,
}

pub(super) fn luminance(c: DVec3) -> f64 {
    c.dot(DVec3::new(0.2126, 0.7152, 0.0722))
}

// ---- the surface as the lobes see it ----

/// False for a pure Lambert surface.
pub fn has_specular(s: &Surface) -> bool {
    s.f0 > 0.0 || s.metalness > 0.0 || s.transmission > 0.0
}

fn alpha_unclamped(s: &Surface) -> DVec2 {
    s.roughness.as_dvec2() * s.roughness.as_dvec2()
}

pub(super) fn alpha(s: &Surface) -> DVec2 {
    alpha_unclamped(s).max(DVec2::splat(DELTA_ALPHA))
}

/// Whether its specular lobe is a mirror: narrower than alpha 1e-3.
pub fn is_delta(s: &Surface) -> bool {
    alpha_unclamped(s).max_element() < DELTA_ALPHA
}

pub(super) fn is_straight(s: &Surface) -> bool {
    s.thin || s.f0 == 0.0
}

pub(super) fn eta(s: &Surface, inside: bool) -> f64 {
    let ior = ior(f64::from(s.f0));
    if inside { ior } else { 1.0 / ior }
}

fn diffuse_albedo(s: &Surface) -> DVec3 {
    s.base.as_dvec3() * (1.0 - f64::from(s.metalness)) * (1.0 - f64::from(s.transmission))
}

pub(super) struct Facet {
    pub(super) reflected: DVec3,
    pub(super) transmitted: DVec3,
    pub(super) reflect_probability: f64,
    /// Of what is reflected, what clear material adds.
    clear: DVec3,
}

// ---- modulators ----

/// Directional reflectance of all that reflects, midway between tangent and bitangent.
fn reflectance(s: &Surface, mu: f64, table: &BrdfTable) -> DVec3 {
    let metalness = f64::from(s.metalness);
    let f0 = DVec3::splat(f64::from(s.f0)).lerp(s.base.as_dvec3(), metalness);
    let f90 = f90(f64::from(s.f0)) + (1.0 - f90(f64::from(s.f0))) * metalness;
    let z = mu.clamp(LEAST_COSINE, 1.0);
    if is_delta(s) {
        return f0 + (f90 - f0) * grazing(z);
    }
    let across = (0.5 * (1.0 - z * z)).sqrt();
    let [e, b] = table.energy(DVec3::new(across, across, z), alpha(s));
    let [mean, _] = table.energy_mean(alpha(s));
    f0 * (e - b) + f90 * b + energy::kept_colour(f0, f90, mean) * (1.0 - e)
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

// ---- directions ----

fn frame(s: &Surface) -> [DVec3; 3] {
    let (n, t) = (s.normal.as_dvec3(), s.tangent.as_dvec3());
    [t, n.cross(t) * f64::from(s.handedness), n]
}

pub(super) fn to_local(s: &Surface, w: DVec3) -> DVec3 {
    let [t, b, n] = frame(s);
    DVec3::new(w.dot(t), w.dot(b), w.dot(n))
}

pub(super) fn to_world(s: &Surface, l: DVec3) -> DVec3 {
    let [t, b, n] = frame(s);
    (l.x * t + l.y * b + l.z * n).normalize()
}

// ---- sampling ----

pub(super) const NO_SAMPLE: Sample = Sample {
    wi: DVec3::Z,
    weight: DVec3::ZERO,
    pdf: 0.0,
    branch: 1.0,
    delta: false,
    transmitted: false,
    valid: false,
};

/// A direction that light samples do not look along.
pub(super) fn passed(s: &Surface, l: DVec3, weight: DVec3, branch: f64) -> Sample {
    Sample { wi: to_world(s, l), weight, pdf: 0.0, branch, delta: true, transmitted: true, valid: true }
}

/// By the cosine about +z.
fn cosine_about_z(u: DVec2) -> DVec3 {
    let radius = u.x.sqrt();
    let (sin, cos) = (TAU * u.y).sin_cos();
    DVec3::new(radius * cos, radius * sin, (1.0 - u.x).max(0.0).sqrt())
}

impl<'a> Brdf<'a> {
    /// The default rules.
    pub fn new(table: &'a BrdfTable) -> Self {
        Self { table, rules: Rules::default() }
    }

    pub(super) fn facet(&self, s: &Surface, cosine: f64, inside: bool) -> Facet {
        let (base, f0) = (s.base.as_dvec3(), f64::from(s.f0));
        let (metalness, transmission) = (f64::from(s.metalness), f64::from(s.transmission));
        let dielectric = 1.0 - metalness;
        let mut reflected = metalness * schlick(base, 1.0, cosine)
            + dielectric * (1.0 - transmission) * schlick(DVec3::splat(f0), f90(f0), cosine);
        let (mut transmitted, mut passing) = (DVec3::ZERO, DVec3::ZERO);
        if transmission > 0.0 {
            let eta = eta(s, inside && !s.thin);
            let mut clear = match self.rules.fresnel {
                _ if f0 <= 0.0 => 0.0,
                Fresnel::Exact => fresnel(cosine, eta),
                Fresnel::Schlick => fresnel_schlick(cosine, eta),
            };
            if s.thin {
                clear = 2.0 * clear / (1.0 + clear);
            }
            reflected += dielectric * transmission * clear;
            transmitted = base * (dielectric * transmission * (1.0 - clear));
            passing = base * (dielectric * transmission * clear);
        }
        let sum = luminance(reflected) + luminance(transmitted);
        let reflect_probability = if sum > 1e-20 { luminance(reflected) / sum } else { 1.0 };
        Facet { reflected, transmitted, reflect_probability, clear: passing }
    }

    fn shadowing(&self, v: DVec3, l: DVec3, alpha: DVec2) -> f64 {
        if self.rules.lossy { 1.0 / (1.0 + lambda(l, alpha)) } else { shadowing(v, l, alpha) }
    }

    fn diffuse(&self, s: &Surface, wo: DVec3, wi: DVec3) -> DVec3 {
        if !self.rules.lossy && self.rules.lobe == Lobe::Ggx {
            return diffuse_albedo(s) * energy::coupling(self.table, s, to_local(s, wo), to_local(s, wi));
        }
        let h = (wo + wi).normalize();
        let f0 = f64::from(s.f0);
        diffuse_albedo(s) * (1.0 - schlick(DVec3::splat(f0), f90(f0), wi.dot(h)))
    }

    /// Draws a direction by the cosine about the normal.
    pub fn sample_diffuse(&self, s: &Surface, wo: DVec3, u: DVec2) -> Sample {
        let l = cosine_about_z(u);
        if s.normal.as_dvec3().dot(wo) < LEAST_COSINE || l.z < LEAST_COSINE {
            return NO_SAMPLE;
        }
        let wi = to_world(s, l);
        Sample { wi, weight: self.diffuse(s, wo, wi), pdf: l.z / PI, valid: true, ..NO_SAMPLE }
    }

    /// Draws a reflected or transmitted direction. `inside`: `wo` lies in the solid that the surface closes off.
    pub fn sample_specular(&self, s: &Surface, wo: DVec3, u: DVec3, inside: bool) -> Sample {
        let v = to_local(s, wo);
        if v.z < LEAST_COSINE || !has_specular(s) {
            return NO_SAMPLE;
        }
        if self.rules.lobe == Lobe::Paper {
            return paper::sample(self, s, v, u, inside);
        }
        let is_delta = is_delta(s);
        let alpha = alpha(s);
        let mut back = PutBack::default();
        let mut choice = u.z;
        if !self.rules.lossy && !is_delta {
            back = energy::put_back(self.table, s, v);
            if u.z >= 1.0 - back.probability {
                return self.reflected(s, v, cosine_about_z(u.truncate()), inside, back);
            }
            choice = (u.z / (1.0 - back.probability)).min(BELOW_ONE);
        }
        let h = if is_delta { DVec3::Z } else { sample_normal(v, alpha, u.truncate()) };
        let cosine = v.dot(h).min(1.0);
        if cosine < LEAST_COSINE {
            return NO_SAMPLE;
        }
        let facet = self.facet(s, cosine, inside);
        let is_through = choice >= facet.reflect_probability;
        let probability = facet.reflect_probability;
        let chosen = if is_through { 1.0 - probability } else { probability }.max(1e-20);
        let branch = chosen * (1.0 - back.probability);
        let eta = eta(s, inside);
        let refracted = refracted_cosine(cosine, eta).unwrap_or(0.0);
        let mut l = 2.0 * cosine * h - v;
        if is_through {
            if is_straight(s) {
                return passed(s, -v, facet.transmitted / branch, branch);
            }
            l = (eta * cosine - refracted) * h - eta * v;
        }
        let is_below = (if is_through { -l.z } else { l.z }) < LEAST_COSINE;
        if !self.rules.lossy && !is_delta && s.transmission > 0.0 {
            let rest = if is_through { choice - probability } else { choice } / chosen;
            if is_below || rest >= self.shadowing(v, l, alpha) {
                let kept = if is_through { facet.transmitted } else { facet.clear } / branch;
                if is_straight(s) {
                    return passed(s, -v, kept, branch);
                }
                let below = cosine_about_z(DVec2::new(u.y, u.x));
                let l = DVec3::new(below.x, below.y, -below.z.max(LEAST_COSINE));
                return passed(s, l, kept * (eta * eta), branch);
            }
        }
        if is_below {
            return NO_SAMPLE;
        }
        if !is_through && !is_delta {
            return self.reflected(s, v, l, inside, back);
        }
        let mut weight = if is_through { facet.transmitted * (eta * eta) } else { facet.reflected } / branch;
        let mut pdf = 0.0;
        if !is_delta {
            let shadowing = self.shadowing(v, l, alpha);
            let jacobian = refraction_jacobian(cosine, refracted, eta);
            pdf = branch * visible(v, h, alpha) * cosine * jacobian;
            if self.rules.lossy {
                weight *= shadowing;
            } else {
                pdf *= shadowing;
            }
        }
        let wi = to_world(s, l);
        Sample { wi, weight, pdf, branch, delta: is_delta, transmitted: is_through, valid: true }
    }

    /// A direction that any of the reflecting parts may have drawn, weighted by the density of all.
    fn reflected(&self, s: &Surface, v: DVec3, l: DVec3, inside: bool, back: PutBack) -> Sample {
        if l.z < LEAST_COSINE {
            return NO_SAMPLE;
        }
        let (value, pdf) = self.lobe(s, v, l, inside, back);
        if pdf <= 0.0 {
            return NO_SAMPLE;
        }
        Sample { wi: to_world(s, l), weight: value * (l.z / pdf), pdf, valid: true, ..NO_SAMPLE }
    }

    // ---- evaluation ----

    /// Both lobes as seen from outside a solid.
    pub fn eval(&self, s: &Surface, wo: DVec3, wi: DVec3) -> Value {
        self.eval_side(s, wo, wi, false)
    }

    /// Both lobes; `inside` as for [`Brdf::sample_specular`].
    pub fn eval_side(&self, s: &Surface, wo: DVec3, wi: DVec3, inside: bool) -> Value {
        let mut value = Value::default();
        let (v, l) = (to_local(s, wo), to_local(s, wi));
        if v.z < LEAST_COSINE || l.z.abs() < LEAST_COSINE {
            return value;
        }
        let is_reflection = l.z > 0.0;
        if is_reflection {
            value.diffuse = self.diffuse(s, wo, wi) / PI;
            value.pdf_diffuse = l.z / PI;
        }
        let is_shut = !is_reflection && (s.transmission == 0.0 || is_straight(s));
        if is_delta(s) || !has_specular(s) || is_shut {
            return value;
        }
        (value.specular, value.pdf_specular) = if self.rules.lobe == Lobe::Paper {
            paper::eval(self, s, v, l, inside)
        } else {
            let back = if self.rules.lossy { PutBack::default() } else { energy::put_back(self.table, s, v) };
            self.lobe(s, v, l, inside, back)
        };
        value
    }

    /// The specular lobe of a surface that is no mirror, reflected or refracted, with what is put back; and its density.
    fn lobe(&self, s: &Surface, v: DVec3, l: DVec3, inside: bool, back: PutBack) -> (DVec3, f64) {
        let is_reflection = l.z > 0.0;
        let (alpha, eta) = (alpha(s), eta(s, inside));
        let mut value = DVec3::ZERO;
        let mut pdf = 0.0;
        if is_reflection && back.probability > 0.0 {
            value = back.value * (1.0 - self.table.energy(l, alpha)[0]).max(0.0);
            pdf = back.probability * l.z / PI;
        }
        let mut h = v + l;
        if !is_reflection {
            h = eta * v + l;
            if h.z < 0.0 {
                h = -h;
            }
        }
        if h.length_squared() < 1e-14 {
            return (value, pdf);
        }
        let h = h.normalize();
        let cosine = v.dot(h).min(1.0);
        let light_cosine = if is_reflection { l.dot(h) } else { -l.dot(h) };
        if cosine < LEAST_COSINE || light_cosine < LEAST_COSINE {
            return (value, pdf);
        }
        let facet = self.facet(s, cosine, inside);
        let mut light = facet.reflected;
        let mut branch = facet.reflect_probability;
        let mut jacobian = 1.0 / (4.0 * cosine);
        if !is_reflection {
            light = facet.transmitted * (eta * eta);
            branch = 1.0 - facet.reflect_probability;
            jacobian = refraction_jacobian(cosine, light_cosine, eta);
        }
        let density = visible(v, h, alpha) * cosine * jacobian;
        let shadowing = self.shadowing(v, l, alpha);
        let drawn = if !self.rules.lossy && s.transmission > 0.0 { shadowing } else { 1.0 };
        value += light * (density * shadowing / l.z.abs());
        pdf += (1.0 - back.probability) * branch * density * drawn;
        (value, pdf)
    }
}
