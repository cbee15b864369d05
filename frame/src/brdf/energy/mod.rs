//! How much light a rough lobe reflects in all, and what its facets keep from each other.
//!
//! In: a unit vector v from the surface in its tangent frame, and both alphas. Out, for facets that reflect everything and
//! for those that reflect `(1 - cosine)^5` of it: the share of light from v that leaves the surface after one reflection,
//! `E` and `B`, and their means over the hemisphere by the cosine. With Schlick's Fresnel a lobe's directional
//! reflectance is `F0 (E - B) + F90 B` (Karis 2013); what is put back is Kulla and Conty's (2017) lobe
//! `F_ms (1 - E(wo)) (1 - E(wi)) / (pi (1 - mean E))`, `F_ms = F^2 mean E / (1 - F (1 - mean E))`, F the mean Fresnel.
//!
//! The table has 16 roughnesses along each axis (linear, from the least rough lobe to 1; one of two mirror images), 28
//! heights and 3 azimuths of v. Height and azimuth are those of v in the space where the facets' distribution is a
//! half ball, `w = normalize(alpha v.xy, v.z)`: there E hardly changes with the alphas, so that both are interpolated
//! linearly, w.z by `2/pi asin(sqrt(w.z))`. Along the azimuth the three values are a parabola in `cos 2 phi`. B is held as
//! two numbers that are smooth there too: the mean cosine between v and facet over `|alpha v.xy, v.z|`, and the spread j of
//! `B = E (1 + 5 j c)^(-1/j)`, c the mean cosine: exact without spread (j = -1/5), where B is `(1 - c)^5`.
//!
//! Measured between the nodes (`tests.rs`): E to 0.004; B to 0.005 for nine surfaces of ten, at worst 0.03, for hair-fine
//! scratches (alphas 0.001 and 1) seen within 5 degrees of the plane.
//!
//! The numbers come as a file made by the test `integrate`: exact at the nodes, then moved so that what lies between is
//! nearest to the integral. Shaders read them from a uniform (65,264 bytes of the 65,536 that all adapters have).

#[cfg(test)]
pub(super) mod integrate;

use super::facets::{f90, grazing};
use super::reference::{DELTA_ALPHA, alpha, is_delta, luminance};
use crate::surface::Surface;
use crate::{Buffer, Gpu, GpuError, Room};
use glam::{DVec2, DVec3};
use half::f16;
use std::f64::consts::{FRAC_PI_2, PI};

/// Roughnesses along either axis.
pub(super) const ROUGHNESSES: usize = 16;
/// Heights of v.
pub(super) const HEIGHTS: usize = 28;
/// Pairs of roughnesses, the smoother one first.
pub(super) const PAIRS: usize = ROUGHNESSES * (ROUGHNESSES + 1) / 2;
/// Roughnesses along either axis for which means are kept: three to a step, for E's own bends between nodes show in them.
const MEAN_ROUGHNESSES: usize = 3 * (ROUGHNESSES - 1) + 1;
const MEAN_PAIRS: usize = MEAN_ROUGHNESSES * (MEAN_ROUGHNESSES + 1) / 2;
/// Half floats of a node: E and m at `cos 2 phi` = -1, 0, 1, j at -1 and 1.
const NODE: usize = 8;
/// Half floats of the means of a pair: the fourth root of that of 1 - E, which may be tiny and would not be straight
/// between nodes, and that of B.
const MEAN: usize = 2;
/// Means come in fours, an element of the shader's.
const VALUES: usize = PAIRS * HEIGHTS * NODE + MEAN_PAIRS.next_multiple_of(4) * MEAN;

/// The table, in the precision the shader sees.
#[derive(Clone, Debug)]
pub struct BrdfTable {
    values: Vec<f16>,
}

impl Default for BrdfTable {
    fn default() -> Self {
        Self::new()
    }
}

/// Two neighbours of a place between nodes, and the share of the second.
#[derive(Clone, Copy)]
struct Between(usize, f64);

impl Between {
    /// `place` in 0..1 among `count` nodes.
    fn new(place: f64, count: usize) -> Self {
        let scaled = place.clamp(0.0, 1.0) * (count - 1) as f64;
        let low = (scaled as usize).min(count - 2);
        Self(low, scaled - low as f64)
    }

    fn both(self) -> [(usize, f64); 2] {
        [(self.0, 1.0 - self.1), (self.0 + 1, self.1)]
    }
}

/// Place of an alpha among the roughnesses.
fn place(alpha: f64) -> f64 {
    let least = DELTA_ALPHA.sqrt();
    (alpha.sqrt() - least) / (1.0 - least)
}

/// Of two roughnesses, and whether they come the other way round.
fn pair(first: usize, second: usize) -> (usize, bool) {
    let (low, high) = (first.min(second), first.max(second));
    (high * (high + 1) / 2 + low, first > second)
}

/// A node's part in what lies between.
#[derive(Clone, Copy)]
struct Part {
    /// Its first value.
    at: usize,
    weight: f64,
    /// `cos 2 phi`, turned with the pair.
    double: f64,
}

impl Part {
    /// Of E, m and j.
    fn read(&self, value: impl Fn(usize) -> f64) -> [f64; 3] {
        let sum = |of: &[f64], first: usize| {
            let values = of.iter().enumerate().map(|(i, share)| share * value(self.at + first + i));
            self.weight * values.sum::<f64>()
        };
        let (parabola, line) = (self.parabola(), self.line());
        [sum(&parabola, 0), sum(&parabola, 3), sum(&line, 6)]
    }

    fn parabola(&self) -> [f64; 3] {
        let c = self.double;
        [0.5 * c * (c - 1.0), 1.0 - c * c, 0.5 * c * (c + 1.0)]
    }

    fn line(&self) -> [f64; 2] {
        [0.5 * (1.0 - self.double), 0.5 * (1.0 + self.double)]
    }
}

/// The nodes around a direction and a pair of alphas.
struct Around {
    parts: [Part; 8],
    /// Length of v where facets are a half ball.
    span: f64,
}

impl Around {
    fn new(v: DVec3, alpha: DVec2) -> Self {
        let stretched = (alpha * v.truncate()).extend(v.z);
        let w = stretched.normalize();
        let across = w.truncate().length_squared();
        let double = if across > 1e-12 { (w.x * w.x - w.y * w.y) / across } else { 0.0 };
        let height = Between::new(w.z.sqrt().min(1.0).asin() / FRAC_PI_2, HEIGHTS).both();
        let [along, other] = [alpha.x, alpha.y].map(|a| Between::new(place(a), ROUGHNESSES).both());
        let parts = std::array::from_fn(|i| {
            let ((first, x), (second, y), (row, z)) = (along[i & 1], other[i >> 1 & 1], height[i >> 2]);
            let (pair, is_turned) = pair(first, second);
            let double = if is_turned { -double } else { double };
            Part { at: (pair * HEIGHTS + row) * NODE, weight: x * y * z, double }
        });
        Self { parts, span: stretched.length() }
    }

    /// E and B of E, m and j.
    fn both(&self, [e, mean, spread]: [f64; 3]) -> [f64; 2] {
        let j = if spread.abs() < 1e-3 { 1e-3 } else { spread };
        [e, e * (1.0 + 5.0 * j * mean * self.span).max(1e-9).powf(-1.0 / j).min(1.0)]
    }
}

impl BrdfTable {
    /// Reads the file that the program carries.
    pub fn new() -> Self {
        let bytes: &[u8] = include_bytes!("table.bin");
        Self { values: bytes.chunks_exact(2).map(|b| f16::from_le_bytes([b[0], b[1]])).collect() }
    }

    /// As the uniform `brdf_table` of [`super::WGSL`].
    ///
    /// # Errors
    /// Out of memory.
    pub fn upload(&self, gpu: &Gpu) -> Result<Buffer, GpuError> {
        let bytes: &[u8] = bytemuck::cast_slice(&self.values);
        let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        let buffer = gpu.buffer(Room::Scene, "BrdfTable", bytes.len() as u64, usage)?;
        gpu.queue.write_buffer(&buffer, 0, bytes);
        Ok(buffer)
    }

    /// E and B for `v`, in the tangent frame and above the surface; as `brdf_energy`.
    pub fn energy(&self, v: DVec3, alpha: DVec2) -> [f64; 2] {
        let around = Around::new(v, alpha);
        let mut sum = [0.0; 3];
        for part in &around.parts {
            for (sum, found) in sum.iter_mut().zip(part.read(|i| self.values[i].to_f64())) {
                *sum += found;
            }
        }
        around.both(sum)
    }

    /// Means of E and B over the hemisphere, by the cosine; as `brdf_energy_mean`.
    pub fn energy_mean(&self, alpha: DVec2) -> [f64; 2] {
        let [along, other] = [alpha.x, alpha.y].map(|a| Between::new(place(a), MEAN_ROUGHNESSES).both());
        let mut sum = [0.0; 2];
        for ((first, x), (second, y)) in along.iter().flat_map(|a| other.iter().map(move |b| (*a, *b))) {
            let at = PAIRS * HEIGHTS * NODE + MEAN * pair(first, second).0;
            for (sum, value) in sum.iter_mut().zip(&self.values[at..]) {
                *sum += x * y * value.to_f64();
            }
        }
        [1.0 - sum[0].powi(4), sum[1]]
    }
}

/// Of light that facets with this Fresnel keep from each other, the share that leaves in the end.
pub(super) fn kept_colour(f0: DVec3, f90: f64, mean_energy: f64) -> DVec3 {
    let mean = f0 + (f90 - f0) / 21.0;
    mean * mean * mean_energy / (1.0 - mean * (1.0 - mean_energy)).max(DVec3::splat(1e-6))
}

/// A dielectric's.
fn kept_grey(s: &Surface, mean_energy: f64) -> f64 {
    let f0 = f64::from(s.f0);
    kept_colour(DVec3::splat(f0), f90(f0), mean_energy).x
}

/// Share of light from `v` that does not come back off a dielectric's surface.
fn entering(table: &BrdfTable, s: &Surface, v: DVec3, mean_energy: f64) -> f64 {
    let f0 = f64::from(s.f0);
    let [e, b] = if is_delta(s) { [1.0, grazing(v.z)] } else { table.energy(v, alpha(s)) };
    (1.0 - f0 * (e - b) - f90(f0) * b - kept_grey(s, mean_energy) * (1.0 - e)).max(0.0)
}

/// The diffuse lobe under a dielectric's surface over its albedo, times pi: light has to get in and out again.
pub(super) fn coupling(table: &BrdfTable, s: &Surface, v: DVec3, l: DVec3) -> f64 {
    let f0 = f64::from(s.f0);
    if f0 <= 0.0 {
        return 1.0;
    }
    let [e, b] = if is_delta(s) { [1.0, 1.0 / 21.0] } else { table.energy_mean(alpha(s)) };
    let reflected = f0 * (e - b) + f90(f0) * b + kept_grey(s, e) * (1.0 - e);
    entering(table, s, v, e) * entering(table, s, l, e) / (1.0 - reflected).max(1e-6)
}

/// What rough facets keep from each other, as a lobe of its own.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PutBack {
    /// Times `1 - E(wi)`: 1/sr.
    pub(super) value: DVec3,
    /// With which a sample goes there, by the cosine.
    pub(super) probability: f64,
}

pub(super) fn put_back(table: &BrdfTable, s: &Surface, v: DVec3) -> PutBack {
    let [mean, _] = table.energy_mean(alpha(s));
    let [e, b] = table.energy(v, alpha(s));
    let lost = (1.0 - e).max(0.0);
    let (f0, metalness) = (f64::from(s.f0), f64::from(s.metalness));
    let opaque = (1.0 - metalness) * (1.0 - f64::from(s.transmission));
    let kept = metalness * kept_colour(s.base.as_dvec3(), 1.0, mean) + opaque * kept_grey(s, mean);
    let once = luminance(metalness * s.base.as_dvec3() + opaque * f0) * (e - b)
        + (metalness + opaque * f90(f0)) * b
        + (1.0 - metalness) * f64::from(s.transmission);
    let again = luminance(kept) * lost;
    PutBack {
        value: kept * (lost / (PI * (1.0 - mean).max(1e-7))),
        probability: again / (again + once).max(1e-20),
    }
}
