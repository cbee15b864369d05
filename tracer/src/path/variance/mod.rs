//! Samples by estimated variance: half of a frame's paths are even, the other half goes where the light is noisy.
//!
//! Paper: none; it gives rough pixels more ("Fragments with higher roughness will trace more samples").
//!
//! In: the sums of each pixel's first samples, whole and half way. Out: how many more samples each pixel gets, in its sums'
//! `aside`.
//!
//! Formula: with D the difference of a pixel's two halves (luminance of both lobes, demodulated, as filters see it), its
//! neighbours estimate its noise: `sigma = sqrt(mean D^2)` over the 7x7 pixels around it, itself left out. So the number of
//! a pixel's samples does not depend on what they found, and its mean stays unbiased. With m the mean of sigma over the
//! pixels that see something, `w = min(sigma, 2 m) + 0.7 m`, and a pixel gets `rest w / mean w` samples, rounded up or down
//! by chance: at most 2.7 / 0.7 < 4 times as many as on average, and on average exactly as many as there are.
//!
//! Worst case: 49 iterations, and one 64th of the number of workgroups.

use super::kernels::Workshop;
use crate::path::PathParams;
use frame::{Bind, Buffer, Gpu, GpuError, Kernel, Recorder, Room, Uniform};

/// The kernels' text.
pub(super) const WGSL: &str = include_str!("variance.wgsl");
/// Most samples of a pixel over the mean, of the second half.
const MOST: u32 = 4;
/// Sums of weights and of pixels: the two means, then one per workgroup.
pub(super) const SUMS: Bind = Bind::storage(1, 35, "variance_sums");
const SUM_BYTES: u64 = 8;
const MEANS: u64 = 2;

/// How a frame of `spp` samples is divided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Division {
    /// Even samples of every pixel: an even number, two halves.
    pub(super) even: u32,
    /// Mean number of the others.
    pub(super) rest: u32,
}

impl Division {
    pub(super) fn of(spp: u32) -> Self {
        // Of a single sample nothing is known.
        let even = if spp < 2 { spp } else { (spp / 4 * 2).max(2) };
        Self { even, rest: spp - even }
    }

    /// Most samples of a pixel.
    pub(super) fn most(self) -> u32 {
        self.even + MOST * self.rest
    }
}

/// Kernels and sums of one trace size.
pub(super) struct Variance {
    note: Kernel,
    square: Kernel,
    spread: Kernel,
    /// Sums and their means, of sigma and of w.
    means: [[Kernel; 2]; 2],
    plan: Kernel,
    sums: Buffer,
}

impl Variance {
    pub(super) fn new(gpu: &Gpu, workshop: &Workshop<'_>, size: [u32; 2]) -> Result<Self, GpuError> {
        let of_pixels = |entry| workshop.variance(entry, [true, false], false);
        let mean = |of_weights| {
            let sum = workshop.variance("variance_sum", [true, true], of_weights)?;
            Ok::<_, GpuError>([sum, workshop.variance("variance_mean", [false, true], of_weights)?])
        };
        let groups = u64::from(size[0].div_ceil(8)) * u64::from(size[1].div_ceil(8));
        let usage = wgpu::BufferUsages::STORAGE;
        Ok(Self {
            note: of_pixels("variance_note")?,
            square: of_pixels("variance_square")?,
            spread: of_pixels("variance_spread")?,
            means: [mean(false)?, mean(true)?],
            plan: workshop.variance("variance_plan", [true, true], true)?,
            sums: gpu.buffer(Room::Radiance, "Variance::sums", SUM_BYTES * (MEANS + groups), usage)?,
        })
    }

    /// After sample number `sample`, if it is the last of a half of the even ones.
    pub(super) fn record(
        &self,
        recorder: &mut Recorder<'_>,
        pass: &str,
        [uniform, params]: [&Uniform; 2],
        pixels: &Buffer,
        of_sample: &PathParams,
        groups: [u32; 3],
    ) {
        let resources =
            [uniform.binding(), params.binding(), pixels.as_entire_binding(), self.sums.as_entire_binding()];
        let [of_pixels, of_sums] = [&resources[..3], &resources[3..]];
        let mut run = |kernel: &Kernel, resources: &[wgpu::BindingResource<'_>], groups| {
            recorder.compute(&format!("{pass}/variance"), kernel, resources, groups);
        };
        if 2 * (of_sample.sample + 1) == of_sample.even {
            run(&self.note, of_pixels, groups);
        }
        if of_sample.sample + 1 == of_sample.even {
            run(&self.square, of_pixels, groups);
            run(&self.spread, of_pixels, groups);
            for [sum, mean] in &self.means {
                run(sum, &resources, groups);
                run(mean, of_sums, [1, 1, 1]);
            }
            run(&self.plan, &resources, groups);
        }
    }
}
