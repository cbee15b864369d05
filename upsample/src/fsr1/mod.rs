//! Upscales the finished picture of trace size by its edges alone, and sharpens it: light is modulated before, not after.
//!
//! Paper: nothing; the comparison that the field asks for. Source: AMD FidelityFX Super Resolution 1.0, the published
//! description of EASU (edge-adaptive spatial upsampling) and RCAS (robust contrast-adaptive sharpening), written anew.
//!
//! In: light and G-buffer at trace size. Out: the picture at display size. Steps:
//!
//! 1. `fsr1/color`: the picture at trace size ([`crate::nearest`] at equal sizes), with its own surfaces.
//! 2. `fsr1/easu`: per display pixel twelve trace pixels, weighed by a Lanczos-like kernel that is turned along the edge
//!    found in their luma and stretched along it, then clamped to the range of the nearest four.
//! 3. `fsr1/rcas`: centre minus a share of its four neighbours, at most the largest that stays between 0 and 1.
//!
//! Both work on `c / (s + max(c))`, s the scene's `radiance_scale`, because they expect colours from 0 to 1. Display pixels
//! that hit nothing show the sky at their own direction, and direct light of display size is modulated there. At equal
//! sizes the picture is that of `fsr1/color` to the bit.
//!
//! Departs from the contract's one place of modulation, as FSR must: textures have trace resolution.

mod kernels;
pub mod reference;

use crate::nearest::Nearest;
use crate::{Upsampler, modulate};
use frame::info::FrameInfo;
use frame::scene_gpu::GpuScene;
use frame::{ColorImage, GBuffer, Gpu, GpuError, Knob, RadianceImage, Recorder, Uniform, gpu_struct};
use kernels::Kernels;

gpu_struct! {
    /// See `rcas.wgsl`.
    pub struct RcasParams {
        /// 0..1: share of the largest sharpening.
        pub strength: f32,
        /// Lobes of direct light.
        pub direct_lobes: u32,
    }
}

const WORKGROUP: [u32; 3] = [8, 8, 1];

/// EASU and RCAS.
pub struct Fsr1 {
    /// Stops by which the sharpening is less than the largest.
    softness: f32,
    color: Nearest,
    kernels: Kernels,
    upscaled: ColorImage,
    picture: ColorImage,
}

impl Fsr1 {
    /// Compiles its kernels.
    ///
    /// # Errors
    /// A kernel was refused.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        Ok(Self {
            softness: 0.2,
            color: Nearest::new(gpu)?,
            kernels: Kernels::new(gpu)?,
            upscaled: ColorImage::new(gpu, [1, 1])?,
            picture: ColorImage::new(gpu, [1, 1])?,
        })
    }
}

impl Upsampler for Fsr1 {
    fn name(&self) -> &'static str {
        "fsr1"
    }

    fn knobs(&mut self) -> Vec<Knob<'_>> {
        vec![Knob::float(
            "softness",
            &mut self.softness,
            0.0..=8.0,
            "",
            "stops by which the sharpening is less than the largest that clips nothing; higher is softer and shows \
             less noise. 0.2 as FSR 1 has it",
        )]
    }

    fn history_bytes(&self) -> u64 {
        0
    }

    fn resize(
        &mut self,
        gpu: &Gpu,
        trace_size: [u32; 2],
        display_size: [u32; 2],
        specular: bool,
    ) -> Result<(), GpuError> {
        self.color.resize(gpu, trace_size, trace_size, specular)?;
        self.upscaled = ColorImage::new(gpu, display_size)?;
        self.picture = ColorImage::new(gpu, display_size)?;
        Ok(())
    }

    fn upsample(
        &mut self,
        recorder: &mut Recorder<'_>,
        frame: &FrameInfo,
        uniform: &Uniform,
        scene: &GpuScene,
        trace: &GBuffer,
        light: &RadianceImage,
        display: &GBuffer,
        direct: Option<&RadianceImage>,
    ) -> ColorImage {
        use wgpu::BindingResource::TextureView as View;
        if frame.trace_size == frame.display_size {
            return self.color.upsample(recorder, frame, uniform, scene, trace, light, display, direct);
        }
        // The same view, counted in trace pixels.
        let mut small = frame.uniform();
        small.display_size = frame.trace_size;
        let small = recorder.uniform(&small);
        let color = self.color.upsample(recorder, frame, &small, scene, trace, light, trace, None);

        let [width, height] = self.picture.size();
        let workgroups = [width.div_ceil(WORKGROUP[0]), height.div_ceil(WORKGROUP[1]), 1];
        let views = [&color.texture, &self.upscaled.texture].map(|texture| View(texture.view()));
        let [from, into] = views;
        recorder.compute(
            "upsample/fsr1/easu",
            &self.kernels.easu,
            &[uniform.binding(), from, into.clone()],
            workgroups,
        );
        recorder.output("upsample/fsr1/easu", &self.upscaled.texture);

        let params = recorder.uniform(&RcasParams {
            strength: (-self.softness).exp2(),
            direct_lobes: modulate::lobe_count(direct),
        });
        let [frame_binding, sky, table, surface, distance, direct_diffuse, direct_specular, ..] =
            modulate::resources(uniform, scene, light, display, direct);
        let resources = [
            frame_binding,
            sky,
            table,
            surface,
            distance,
            direct_diffuse,
            direct_specular,
            params.binding(),
            into,
            View(self.picture.texture.view()),
        ];
        recorder.compute("upsample/fsr1/rcas", &self.kernels.rcas, &resources, workgroups);
        recorder.output("upsample/fsr1/rcas", &self.picture.texture);
        self.picture.clone()
    }
}

#[cfg(test)]
mod tests;
