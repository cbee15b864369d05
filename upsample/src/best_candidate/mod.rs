//! The paper's upsampler: takes the light of the nearest trace pixel that faces as the display pixel does.
//!
//! Paper: "an outward search from the center fragment to find the best candidate".
//!
//! In: light and G-buffer at trace size, G-buffer at display size. Out: the picture at display size, through
//! [`crate::modulate`]. The search is [`crate::search`]'s. Pixels that had to do with less than an accepted candidate are
//! counted as `upsample_fallbacks`. A lobe that the pixel's surface lacks is not searched and gets no light. Light is
//! copied from one pixel, never mixed: mirrors keep their picture. At equal sizes a pixel takes its own light.
//!
//! Departs from the paper: the plane test, because with normals alone light leaks between parallel walls behind each
//! other (`plane_test=off` is the paper's reading); two lobes; nothing else. The paper gives no number for "highly
//! similar", nor a radius: knobs.

pub mod reference;

pub use crate::search::Settings;

use crate::{Upsampler, modulate, search};
use frame::info::FrameInfo;
use frame::scene_gpu::GpuScene;
use frame::{
    Bind, Buffer, ColorImage, GBuffer, Gpu, GpuError, Kernel, KernelDesc, Knob, RadianceImage, Recorder,
    Room, Uniform,
};

const WORKGROUP: [u32; 3] = [8, 8, 1];
const NAME: &str = "upsample/best_candidate";

/// The paper's upsampler.
pub struct BestCandidate {
    settings: Settings,
    kernel: Kernel,
    fallbacks: Buffer,
    picture: ColorImage,
}

impl BestCandidate {
    /// Compiles its kernel.
    ///
    /// # Errors
    /// The kernel was refused.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let own = [
            Bind::storage_texture(3, 0, "out_color", ColorImage::FORMAT),
            Bind::storage(3, 1, "out_fallbacks"),
        ];
        let kernel = Kernel::new(
            gpu,
            &KernelDesc {
                name: NAME,
                sources: &search::sources(&[include_str!("best_candidate.wgsl")]),
                entry: "best_candidate",
                workgroup: WORKGROUP,
                bindings: &search::binds(&own),
                constants: &[],
            },
        )?;
        Ok(Self {
            settings: Settings::default(),
            kernel,
            fallbacks: gpu.storage(Room::Radiance, "BestCandidate::fallbacks", &[0u32; 2])?,
            picture: ColorImage::new(gpu, [1, 1])?,
        })
    }
}

impl Upsampler for BestCandidate {
    fn name(&self) -> &'static str {
        "best_candidate"
    }

    fn knobs(&mut self) -> Vec<Knob<'_>> {
        self.settings.knobs()
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
        recorder.clear(&self.fallbacks);
        let params = recorder.uniform(&self.settings.params(frame, light, direct));
        let mut resources = modulate::resources(uniform, scene, light, display, direct).to_vec();
        resources.extend(search::resources(&params, trace, light));
        resources.extend([View(self.picture.texture.view()), self.fallbacks.as_entire_binding()]);
        let [width, height] = self.picture.size();
        let workgroups = [width.div_ceil(WORKGROUP[0]), height.div_ceil(WORKGROUP[1]), 1];
        recorder.compute(NAME, &self.kernel, &resources, workgroups);
        recorder.output(NAME, &self.picture.texture);
        recorder.counter("upsample_fallbacks", &self.fallbacks, 0);
        self.picture.clone()
    }
}

#[cfg(test)]
mod tests;
