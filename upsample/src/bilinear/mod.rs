//! Mixes the light of the four trace pixels around the display pixel by distance alone.
//!
//! Paper: nothing; the least that does not look blocky, against which others are measured.
//!
//! In: light and G-buffer at trace size, G-buffer at display size. Out: the picture at display size, through
//! [`crate::modulate`]. With `x = (p + 1/2) trace_size / display_size - 1/2 - jitter` the place of display pixel p among the
//! centres of trace pixels: weights `(1 - |x - q|)` per axis, over those of the four that count for the lobe
//! ([`crate::search`]), divided by their sum; none at all gives no light. Neither normals nor distances are looked at, so
//! light leaks over edges.
//!
//! Light of a mirror or of clear glass (roughness 0) is copied from the heaviest of the four: mixed pictures would be
//! double ones. At equal sizes a pixel takes its own light.
//!
//! Departs from the paper: the paper searches (see [`crate::best_candidate`]).

pub mod reference;

use crate::{Upsampler, modulate, search};
use frame::info::FrameInfo;
use frame::scene_gpu::GpuScene;
use frame::{
    Bind, ColorImage, GBuffer, Gpu, GpuError, Kernel, KernelDesc, Knob, RadianceImage, Recorder, Uniform,
};

const WORKGROUP: [u32; 3] = [8, 8, 1];
const NAME: &str = "upsample/bilinear";

/// The mean of four.
pub struct Bilinear {
    kernel: Kernel,
    picture: ColorImage,
}

impl Bilinear {
    /// Compiles its kernel.
    ///
    /// # Errors
    /// The kernel was refused.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let own = [Bind::storage_texture(3, 0, "out_color", ColorImage::FORMAT)];
        let kernel = Kernel::new(
            gpu,
            &KernelDesc {
                name: NAME,
                sources: &search::sources(&[search::MIX_WGSL, include_str!("bilinear.wgsl")]),
                entry: "bilinear",
                workgroup: WORKGROUP,
                bindings: &search::binds(&own),
                constants: &[],
            },
        )?;
        Ok(Self { kernel, picture: ColorImage::new(gpu, [1, 1])? })
    }
}

impl Upsampler for Bilinear {
    fn name(&self) -> &'static str {
        "bilinear"
    }

    fn knobs(&mut self) -> Vec<Knob<'_>> {
        Vec::new()
    }

    fn history_bytes(&self) -> u64 {
        0
    }

    fn resize(
        &mut self,
        gpu: &Gpu,
        _trace_size: [u32; 2],
        display_size: [u32; 2],
        _specular: bool,
    ) -> Result<(), GpuError> {
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
        let params = recorder.uniform(&search::Settings::default().params(frame, light, direct));
        let mut resources = modulate::resources(uniform, scene, light, display, direct).to_vec();
        resources.extend(search::resources(&params, trace, light));
        resources.push(View(self.picture.texture.view()));
        let [width, height] = self.picture.size();
        let workgroups = [width.div_ceil(WORKGROUP[0]), height.div_ceil(WORKGROUP[1]), 1];
        recorder.compute(NAME, &self.kernel, &resources, workgroups);
        recorder.output(NAME, &self.picture.texture);
        self.picture.clone()
    }
}

#[cfg(test)]
mod tests;
