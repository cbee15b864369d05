//! Returns the light as it came, and mends what is no light.
//!
//! Paper: nothing; this is the street without a filter, against which filters are measured. It is also the folder to copy
//! for a new one.
//!
//! In: light at trace size ([`RadianceImage`]); nothing of the G-buffer. Out: the same, bit for bit where it is valid
//! ([`crate::light`]), the mean of the valid pixels next to it where it is not. Those are counted as `denoise_invalid`.
//!
//! Departs from the paper: it has no such stage.

pub mod reference;

use crate::lobes;
use crate::{Denoiser, Guides};
use frame::info::FrameInfo;
use frame::{
    Bind, Buffer, GBuffer, Gpu, GpuError, Kernel, Knob, RadianceImage, Recorder, Room, Texture, Uniform,
};
use wgpu::BindingResource::TextureView as View;

/// The denoiser that does nothing.
pub struct Identity {
    kernel: Kernel,
    invalid: Buffer,
    output: [Texture; 2],
}

impl Identity {
    /// Compiles its kernel.
    ///
    /// # Errors
    /// It was refused.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let bindings = [
            Bind::texture(2, 0, "in_diffuse"),
            Bind::texture(2, 1, "in_specular"),
            Bind::storage_texture(3, 0, "out_diffuse", RadianceImage::FORMAT),
            Bind::storage_texture(3, 1, "out_specular", RadianceImage::FORMAT),
            Bind::storage(3, 2, "out_invalid"),
        ];
        let (name, sources) = ("denoise/identity/mend", [include_str!("identity.wgsl")]);
        Ok(Self {
            kernel: lobes::kernel(gpu, name, "identity", &sources, &bindings, &[])?,
            invalid: gpu.storage(Room::Radiance, "Identity::invalid", &[0u32; 2])?,
            output: lobes::pair(gpu, Room::Radiance, "Identity::output", [1, 1], false)?,
        })
    }
}

impl Denoiser for Identity {
    fn name(&self) -> &'static str {
        "identity"
    }

    fn knobs(&mut self) -> Vec<Knob<'_>> {
        Vec::new()
    }

    fn guides(&self) -> Guides {
        Guides::default()
    }

    fn history_bytes(&self) -> u64 {
        0
    }

    fn energy_bound(&self) -> f32 {
        0.0
    }

    fn resize(&mut self, gpu: &Gpu, size: [u32; 2], specular: bool) -> Result<(), GpuError> {
        self.output = lobes::pair(gpu, Room::Radiance, "Identity::output", size, specular)?;
        Ok(())
    }

    fn denoise(
        &mut self,
        recorder: &mut Recorder<'_>,
        _frame: &FrameInfo,
        _uniform: &Uniform,
        _guides: &GBuffer,
        noisy: &RadianceImage,
    ) -> RadianceImage {
        let (input, output) = (lobes::of(noisy), self.output.each_ref());
        recorder.clear(&self.invalid);
        recorder.compute(
            "denoise/identity/mend",
            &self.kernel,
            &[
                View(input[0].view()),
                View(input[1].view()),
                View(output[0].view()),
                View(output[1].view()),
                self.invalid.as_entire_binding(),
            ],
            lobes::workgroups(noisy.size()),
        );
        recorder.counter("denoise_invalid", &self.invalid, 0);
        lobes::clean(recorder, "identity", noisy, output)
    }
}

#[cfg(test)]
mod tests;
