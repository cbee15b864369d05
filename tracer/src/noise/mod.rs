//! Gives every decision of every path its own random number, without state.
//!
//! Paper: "A 512x512 random texture covers the space skewed along the z-axis" (section 2).
//!
//! In: pixel, index of the sample over all frames, block (one per bounce and purpose), the frame's seed. Out: numbers in
//! [0, 1) on a grid of 2^-24.
//!
//! Generators ([`Noise`]), x a pixel, n the sample, b the block:
//!
//! - `paper`: texel `(p.xy + (1 / rho, 1 / rho^2) p.z) 512 / diagonal` of a 512x512 white texture, p the vertex in the
//!   world, shifted by a hash of (n, b). One texel covers 1/512 of the scene's diagonal.
//! - `r2_blue`: `pcg4d(x, n, b, seed)`; but the first direction is `fract(mask(x) + n (1 / rho, 1 / rho^2))` (R2,
//!   rho = 1.32471796), mask two tiles of 64x64 blue noise.
//! - `sobol`: two points per block of Sobol's first two dimensions, their order and digits scrambled by a hash of
//!   (x, b) (Owen 1995; Burley 2020; without loops).
//! - `reference`: XXH32 of (x, n, b), for images that others are measured against.
//!
//! Departs from the paper by default: its texture gives neighbouring pixels one number where a texel covers them
//! (`docs/light.md` has what that costs). R2 is applied to the first direction alone: turned copies of one sequence in
//! later dimensions would be correlated with it, and a pixel of many samples would converge to a wrong value.

use frame::{Bind, Buffer, Gpu, GpuError, Room};

/// Functions `noise_at` and what it needs.
pub const WGSL: &str = include_str!("noise.inc.wgsl");
/// Function `noise_stratified`, after [`WGSL`]; binds [`MASK_BIND`].
pub const STRATIFIED_WGSL: &str = include_str!("stratified.inc.wgsl");
/// The blue-noise masks.
pub const MASK_BIND: Bind = Bind::uniform_array(0, 2, "noise_mask");

/// Texels along a side of the masks.
const MASK_SIDE: usize = 64;
/// Ranks of both masks per texel, 16 bits each, of 4,096 places by void and cluster (Ulichney 1993); made by a test.
const MASK: &[u8; 4 * MASK_SIDE * MASK_SIDE] = include_bytes!("mask.bin");

/// Where random numbers come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u32)]
pub enum Noise {
    /// The paper's texture.
    Paper,
    /// A hash; the first direction R2 turned by blue noise.
    #[default]
    R2Blue,
    /// Owen-scrambled Sobol pairs.
    Sobol,
    /// Another hash, for references.
    Reference,
}

impl Noise {
    /// Those that a knob chooses from.
    pub const NAMES: [&'static str; 3] = ["paper", "r2_blue", "sobol"];

    /// By place among [`Noise::NAMES`].
    pub(crate) fn of_knob(index: u32) -> Self {
        match index {
            0 => Self::Paper,
            1 => Self::R2Blue,
            _ => Self::Sobol,
        }
    }
}

/// The resource of [`MASK_BIND`].
pub(crate) fn upload_mask(gpu: &Gpu) -> Result<Buffer, GpuError> {
    let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
    let buffer = gpu.buffer(Room::Scene, "noise::mask", MASK.len() as u64, usage)?;
    gpu.queue.write_buffer(&buffer, 0, MASK);
    Ok(buffer)
}

/// The shader's hash.
pub fn pcg4d(input: [u32; 4]) -> [u32; 4] {
    let mut v = input.map(|x| x.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
    let round = |v: &mut [u32; 4]| {
        v[0] = v[0].wrapping_add(v[1].wrapping_mul(v[3]));
        v[1] = v[1].wrapping_add(v[2].wrapping_mul(v[0]));
        v[2] = v[2].wrapping_add(v[0].wrapping_mul(v[1]));
        v[3] = v[3].wrapping_add(v[1].wrapping_mul(v[2]));
    };
    round(&mut v);
    v = v.map(|x| x ^ (x >> 16));
    round(&mut v);
    v
}

/// Four independent numbers in [0, 1): `r2_blue`'s.
pub fn at(pixel: [u32; 2], sample: u32, block: u32, seed: u32) -> [f32; 4] {
    pcg4d([pixel[0] | (pixel[1] << 16), sample, block, seed]).map(unit)
}

/// The first two numbers of a pixel's sample, `r2_blue`'s.
pub fn stratified(pixel: [u32; 2], sample: u32, seed: u32) -> [f32; 2] {
    let below = pcg4d([pixel[0] | (pixel[1] << 16), u32::MAX, 0, seed]);
    let moved = pcg4d([0, u32::MAX, 1, seed]);
    let [x, y] = [0, 1].map(|axis| pixel[axis].wrapping_add(moved[axis]) as usize % MASK_SIDE);
    let at = 4 * (y * MASK_SIDE + x);
    // 2^32 / rho and 2^32 / rho^2.
    [(0, 3_242_174_889), (1, 2_447_445_414)].map(|(channel, step): (usize, u32)| {
        let rank = u16::from_le_bytes([MASK[at + 2 * channel], MASK[at + 2 * channel + 1]]);
        let turn = (u32::from(rank) << 16) | (below[channel] >> 12);
        unit(turn.wrapping_add(sample.wrapping_mul(step)))
    })
}

fn unit(bits: u32) -> f32 {
    (bits >> 8) as f32 * (1.0 / 16_777_216.0)
}

#[cfg(test)]
mod tests;
