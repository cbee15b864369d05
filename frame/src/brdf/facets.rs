//! What a facet does, and how facets lie: Fresnel and GGX, as in `brdf.inc.wgsl`, in f64.

use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};

// ---- Fresnel ----

pub(super) fn f90(f0: f64) -> f64 {
    (f0 / 0.02).min(1.0)
}

pub(super) fn schlick(f0: DVec3, f90: f64, cosine: f64) -> DVec3 {
    f0 + (f90 - f0) * (1.0 - cosine).clamp(0.0, 1.0).powi(5)
}

pub(super) fn ior(f0: f64) -> f64 {
    let root = f0.sqrt().min(0.99);
    (1.0 + root) / (1.0 - root)
}

/// None at total reflection; `eta` is the index before the surface over the one behind it.
pub(super) fn refracted_cosine(cosine: f64, eta: f64) -> Option<f64> {
    let squared = 1.0 - eta * eta * (1.0 - cosine * cosine);
    (squared > 0.0).then(|| squared.sqrt())
}

pub(super) fn fresnel(cosine: f64, eta: f64) -> f64 {
    let Some(refracted) = refracted_cosine(cosine, eta) else { return 1.0 };
    let s = (eta * cosine - refracted) / (eta * cosine + refracted);
    let p = (cosine - eta * refracted) / (cosine + eta * refracted);
    (0.5 * (s * s + p * p)).min(1.0)
}

/// Schlick's for both sides: from the denser one it takes the cosine beyond the surface.
pub(super) fn fresnel_schlick(cosine: f64, eta: f64) -> f64 {
    let Some(refracted) = refracted_cosine(cosine, eta) else { return 1.0 };
    let f0 = ((eta - 1.0) / (eta + 1.0)).powi(2);
    f0 + (1.0 - f0) * grazing(if eta > 1.0 { refracted } else { cosine })
}

/// Schlick's of a surface that reflects nothing straight on.
pub(super) fn grazing(cosine: f64) -> f64 {
    (1.0 - cosine).clamp(0.0, 1.0).powi(5)
}

// ---- GGX ----

pub(super) fn ggx(h: DVec3, alpha: DVec2) -> f64 {
    let x = h.truncate() / alpha;
    let e = x.length_squared() + h.z * h.z;
    1.0 / (PI * alpha.x * alpha.y * e * e)
}

pub(super) fn lambda(v: DVec3, alpha: DVec2) -> f64 {
    let x = alpha * v.truncate() / v.z;
    0.5 * ((1.0 + x.length_squared()).sqrt() - 1.0)
}

pub(super) fn shadowing(v: DVec3, l: DVec3, alpha: DVec2) -> f64 {
    let masked = 1.0 + lambda(v, alpha);
    masked / (masked + lambda(l, alpha))
}

pub(super) fn visible(v: DVec3, h: DVec3, alpha: DVec2) -> f64 {
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

/// Solid angle of facet normals over that of refracted directions.
pub(super) fn refraction_jacobian(cosine: f64, refracted: f64, eta: f64) -> f64 {
    refracted / (eta * cosine - refracted).powi(2).max(1e-12)
}
