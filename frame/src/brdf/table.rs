//! What the specular lobe reflects in all, tabulated once at start-up.
//!
//! In: nothing. Out: 32 x 32 texels `(A, B)` so that the lobe's directional reflectance is `E = F0 A + F90 B`
//! (Karis 2013). Column x is `sqrt(mu)` and row y `sqrt(alpha)`, both 0 to 1 from the first texel's centre to the
//! last's: E moves fastest towards grazing angles and smooth surfaces. `A = mean((1 - c) G2/G1)` and
//! `B = mean(c G2/G1)`, `c = (1 - wo.h)^5`, over the facets that wo sees.
//!
//! Two alphas enter as their root mean square, which is off by at most 0.035 where the geometric mean is off by 0.4
//! (alphas 0.05 and 1, seen straight on).
//!
//! Shaders read it from a uniform: its 4 KiB fit there, and the path kernels' textures stay few.

use super::reference::{sample_normal, shadowing};
use crate::{Buffer, Gpu, GpuError, Room};
use glam::{DVec2, DVec3};
use half::f16;

/// Texels along either side; the shader's `BRDF_TABLE_SIZE`.
const SIZE: usize = 32;
/// Points of the Fibonacci lattice that integrates one texel: each has a cap height of its own, because the light lost
/// below the horizon sits in the last few of a hundred.
const LATTICE: [usize; 2] = [377, 233];

/// The table, in the precision the shader sees.
#[derive(Clone, Debug)]
pub struct BrdfTable {
    texels: Vec<[f16; 2]>,
}

impl Default for BrdfTable {
    fn default() -> Self {
        Self::new()
    }
}

impl BrdfTable {
    /// Texels along either side.
    pub const SIZE: u32 = SIZE as u32;

    /// Integrates all texels; the same bits every time.
    pub fn new() -> Self {
        let parameter = |i: usize| (i as f64 / (SIZE - 1) as f64).powi(2);
        let texel = |i: usize| integrate(parameter(i % SIZE), parameter(i / SIZE)).map(f16::from_f64);
        Self { texels: (0..SIZE * SIZE).map(texel).collect() }
    }

    /// As the uniform `brdf_table` of [`super::WGSL`].
    ///
    /// # Errors
    /// Out of memory.
    pub fn upload(&self, gpu: &Gpu) -> Result<Buffer, GpuError> {
        let bytes: &[u8] = bytemuck::cast_slice(&self.texels);
        let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        let buffer = gpu.buffer(Room::Scene, "BrdfTable", bytes.len() as u64, usage)?;
        gpu.queue.write_buffer(&buffer, 0, bytes);
        Ok(buffer)
    }

    /// `(A, B)` at the cosine `mu` to the viewer; bilinear, as `brdf_table_lookup`.
    pub fn lookup(&self, mu: f64, alpha: DVec2) -> [f64; 2] {
        let last = (SIZE - 1) as f64;
        let rms = (0.5 * alpha.length_squared()).sqrt();
        let p = DVec2::new(mu, rms).clamp(DVec2::ZERO, DVec2::ONE).map(f64::sqrt) * last;
        let low = p.floor().min(DVec2::splat(last - 1.0));
        let w = p - low;
        let first = low.y as usize * SIZE + low.x as usize;
        [0, 1].map(|channel| {
            let at = |offset: usize| self.texels[first + offset][channel].to_f64();
            let row = |offset: usize| at(offset) + (at(offset + 1) - at(offset)) * w.x;
            row(0) + (row(SIZE) - row(0)) * w.y
        })
    }
}

fn integrate(mu: f64, alpha: f64) -> [f64; 2] {
    // A facet seen exactly edge-on, or without width, is a limit of the formulas and not a value of them.
    let (mu, alpha) = (mu.max(1e-4), DVec2::splat(alpha.max(1e-4)));
    let v = DVec3::new((1.0 - mu * mu).sqrt(), 0.0, mu);
    let count = LATTICE[0] as f64;
    let mut sum = [0.0; 2];
    for i in 0..LATTICE[0] {
        // v lies in the plane y = 0, so half a turn stands for the whole.
        let turn = 0.5 * ((i * LATTICE[1] % LATTICE[0]) as f64 + 0.5) / count;
        let h = sample_normal(v, alpha, DVec2::new(turn, (i as f64 + 0.5) / count));
        let cosine = v.dot(h);
        let l = 2.0 * cosine * h - v;
        if l.z > 0.0 {
            let weight = shadowing(v, l, alpha);
            let grazing = (1.0 - cosine).max(0.0).powi(5);
            sum[0] += weight * (1.0 - grazing);
            sum[1] += weight * grazing;
        }
    }
    sum.map(|s| s / count)
}
