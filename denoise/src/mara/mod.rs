//! Matte and glossy light filtered apart: averaged over time, then cross-bilateral blurs along rows and columns.
//!
//! Source: Mara, McGuire, Bitterli and Jarosz 2017, "An Efficient Denoising Algorithm for Global Illumination", which the
//! voxel paper names. Its text leaves radii and weights to its supplement; the numbers here are ours.
//!
//! In: light at trace size ([`RadianceImage`]) and the whole G-buffer. Out: the same light, less noisy. Matte light is the
//! diffuse lobe, glossy light the specular one; neither knows a material. Per lobe:
//!
//! ```text
//! accumulate  C <- mix(C', C_now, max(1/N, share)), the lobe's own share (as in [`crate::temporal`])
//! blur        rounds i = 0, 1, ..: along rows, then along columns, taps j = -radius..radius, 4^i rows apart
//!             out = sum w C / sum w,   w = exp(-2 (j / (radius + 1))^2) w_n w_z      (see `edge`)
//! glossy      and w_r, the reflection's own width and roughness: the kernel of a mirror is the pixel
//! ```
//!
//! What is accumulated is kept before it is blurred, so that blurs do not add up over time. Weights do not look at the light;
//! taps beyond the border are mirrored. Constant light stays constant to the bit.
//!
//! Departs from its source: direct light is not apart (it comes with the paths' first hits); no median against fireflies,
//! which would lose their light.

pub mod reference;
mod settings;

pub use settings::Settings;

use crate::lobes::{self, Turns};
use crate::temporal::{Input, Needs, Temporal};
use crate::{Denoiser, Guides, Need};
use frame::info::{Frame, FrameInfo};
use frame::{
    Bind, GBuffer, Gpu, GpuError, Kernel, Knob, RadianceImage, Recorder, Room, Texture, Uniform, gpu_struct,
};
use wgpu::BindingResource::TextureView as View;

gpu_struct! {
    /// See `mara.wgsl`.
    pub struct MaraParams {
        /// Pixels from tap to tap.
        pub step: [i32; 2],
        /// Taps on either side.
        pub radius: i32,
        /// Power of the cosine.
        pub sigma_normal: f32,
        /// Rows.
        pub sigma_depth: f32,
        /// Share of the specular lobe's slope.
        pub lobe_spread: f32,
        /// Relative.
        pub roughness_fraction: f32,
        /// Trace rows per pixel along a row.
        pub rows_per_column: f32,
    }
}

/// The filter for matte and glossy light.
pub struct Mara {
    settings: Settings,
    temporal: Temporal,
    kernel: Kernel,
    /// Accumulated light of this frame and the last, by `now`.
    history: [[Texture; 2]; 2],
    now: usize,
    turns: Turns,
}

fn history(gpu: &Gpu, size: [u32; 2], has_specular: bool) -> Result<[[Texture; 2]; 2], GpuError> {
    let one = || lobes::pair(gpu, Room::History, "Mara::history", size, has_specular);
    Ok([one()?, one()?])
}

impl Mara {
    /// Compiles its kernels.
    ///
    /// # Errors
    /// A kernel was refused.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let kernel = lobes::kernel(
            gpu,
            "denoise/mara/blur",
            "mara",
            &[include_str!("mara.wgsl")],
            &[
                Bind::uniform::<Frame>(0, 0, "frame"),
                Bind::uniform::<MaraParams>(0, 1, "params"),
                Bind::texture_uint(2, 0, "in_edge"),
                Bind::texture(2, 1, "in_diffuse"),
                Bind::texture(2, 2, "in_specular"),
                Bind::texture_uint(2, 3, "in_frames"),
                Bind::storage_texture(3, 0, "out_diffuse", RadianceImage::FORMAT),
                Bind::storage_texture(3, 1, "out_specular", RadianceImage::FORMAT),
            ],
            &[],
        )?;
        Ok(Self {
            settings: Settings::default(),
            temporal: Temporal::new(gpu, "mara", Needs::default())?,
            kernel,
            history: history(gpu, [1, 1], false)?,
            now: 0,
            turns: Turns::new(gpu, "Mara::lobes", [1, 1], false)?,
        })
    }
}

impl Denoiser for Mara {
    fn name(&self) -> &'static str {
        "mara"
    }

    fn knobs(&mut self) -> Vec<Knob<'_>> {
        self.settings.knobs()
    }

    fn guides(&self) -> Guides {
        Guides {
            surface: Need::Required,
            distance: Need::Required,
            face_normal: Need::Required,
            motion_id: Need::Required,
        }
    }

    fn history_bytes(&self) -> u64 {
        self.temporal.bytes() + self.history.as_flattened().iter().map(Texture::bytes).sum::<u64>()
    }

    fn energy_bound(&self) -> f32 {
        // Rounding of half floats in five passes.
        0.005
    }

    fn resize(&mut self, gpu: &Gpu, size: [u32; 2], specular: bool) -> Result<(), GpuError> {
        self.temporal.resize(gpu, size)?;
        self.history = history(gpu, size, specular)?;
        self.turns = Turns::new(gpu, "Mara::lobes", size, specular)?;
        Ok(())
    }

    fn denoise(
        &mut self,
        recorder: &mut Recorder<'_>,
        frame: &FrameInfo,
        uniform: &Uniform,
        guides: &GBuffer,
        noisy: &RadianceImage,
    ) -> RadianceImage {
        let input = Input { frame, uniform, guides, noisy };
        let [mean, before] = [self.now, 1 - self.now].map(|index| self.history[index].each_ref());
        self.temporal.pack(recorder, &input, self.settings.roughness_min);
        self.temporal.accumulate(recorder, &input, &self.settings.temporal, before, None, mean);
        recorder.output("denoise/mara/frames", self.temporal.frames());
        let passes = 2 * self.settings.rounds as usize;
        let light = self.turns.chain(mean, 0, passes, |pass, from, to| {
            let params = recorder.uniform(&self.settings.params(pass as u32, frame.columns_per_row()));
            recorder.compute(
                &format!("denoise/mara/round{}/{}", pass / 2, ["horizontal", "vertical"][pass % 2]),
                &self.kernel,
                &[
                    uniform.binding(),
                    params.binding(),
                    View(self.temporal.edge().view()),
                    View(from[0].view()),
                    View(from[1].view()),
                    View(self.temporal.frames().view()),
                    View(to[0].view()),
                    View(to[1].view()),
                ],
                lobes::workgroups(noisy.size()),
            );
        });
        let clean = lobes::clean(recorder, "mara", noisy, light);
        self.temporal.turn();
        self.now = 1 - self.now;
        clean
    }
}

#[cfg(test)]
mod tests;
