//! How a [`Surface`](crate::surface::Surface) scatters light: modulators, samples and values of its two lobes.
//!
//! Paper: the specular lobe uses both roughnesses "along the tangent and bitangent"; what a first hit multiplies is
//! left out of the traced light and put back after upsampling.
//!
//! In: a surface, unit vectors `wo` and `wi` *away* from it in world space, uniform numbers in [0, 1). Out: `f` in
//! 1/sr, densities in 1/sr, weights `f cos / pdf`. With m metalness, T transmission:
//!
//! - `M_d = base (1 - m)(1 - T)`, `f_d = M_d / pi C`, sampled by the cosine. `C = (1 - R(wo)) (1 - R(wi)) / (1 - mean R)`,
//!   R the dielectric's directional reflectance: what the surface does not reflect gets in and out again (Kulla and Conty
//!   2017), so that white plastic is white.
//! - `f_s` is everything else. A facet with normal h reflects
//!   `m Schlick(base, 1) + (1 - m)(1 - T) Schlick(F0, min(1, F0 / 0.02)) + (1 - m) T F` and transmits
//!   `(1 - m) T (1 - F) base`, F exact with total reflection, and `2F / (1 + F)` for a thin sheet. The index of
//!   refraction is `(1 + sqrt F0) / (1 - sqrt F0)`.
//! - Facets are GGX with `alpha = roughness^2` along tangent and bitangent and height-correlated masking
//!   `G2 = 1 / (1 + Lambda_i + Lambda_o)`, sampled among those that `wo` sees (Dupuy and Benyoub 2023). Below
//!   alpha 1e-3 in both directions the surface is a mirror: samples are `delta`, values 0.
//! - What opaque facets keep from each other is put back as a lobe of its own, sampled by the cosine ([`energy`]). What
//!   clear ones keep from each other passes: straight through a sheet, by the cosine into and out of a solid. It is a
//!   share of the samples and no part of `f_s`: light samples do not look there, and reflection stays reciprocal.
//! - Whether a facet's sample reflects or transmits is drawn by luminance (`u.z` below `branch` reflects), for clear
//!   glass exactly by F. For smooth glass `weight * branch` is that branch's own share: with `u.z` = 0 and `u.z` just
//!   below 1 both branches are had from one path.
//! - Into a solid the ray bends, and radiance is multiplied by `(eta_before / eta_behind)^2`; the factor cancels where
//!   the path leaves again. Through a thin sheet, or where F0 is 0, it goes straight on, a delta whatever the
//!   roughness.
//! - `M_s = max(E_s + (1 - m) T base (1 - E_s), 2^-10)`, E_s with what is put back, from [`BrdfTable`].
//!
//! The caller turns the normal to `wo`'s side (two-sided surfaces, solids from inside). There is no light where `wo`
//! is below the shading normal's horizon, nor reflected below it, nor transmitted above it: samples are then not
//! `valid`, values 0.
//!
//! Departs from the paper: GGX instead of its lobe, which narrows to a twentieth of the hemisphere at roughness 1, and
//! exact Fresnel instead of Schlick's where light is transmitted. Both are there as [`Rules`], as are those of the shared
//! reference images: masking as a product, `f_d = M_d / pi (1 - F_d(h))`, and nothing put back.

mod energy;
mod facets;
mod paper;
mod reference;
mod rules;
#[cfg(test)]
mod tests;

pub use energy::BrdfTable;
pub use reference::{Brdf, Modulators, Sample, Value, has_specular, is_delta, modulators};
pub use rules::{Fresnel, Lobe, Rules};

/// The shader's half, after [`crate::surface::WGSL`]: every struct named `Brdf*` and function named `brdf_*`.
pub const WGSL: &str = concat!(
    include_str!("brdf.inc.wgsl"),
    include_str!("energy/energy.inc.wgsl"),
    include_str!("paper.inc.wgsl")
);
