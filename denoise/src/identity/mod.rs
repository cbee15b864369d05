//! Returns the light as it came.
//!
//! Paper: nothing; this is the street without a filter, against which filters are measured.
//!
//! In and out: the same textures; no pass, no memory, no setting.
//!
//! Departs from the paper: it has no such stage.

use crate::{Denoiser, Guides};
use frame::info::FrameInfo;
use frame::{GBuffer, Gpu, GpuError, Knob, RadianceImage, Recorder, Uniform};

/// The denoiser that does nothing.
pub struct Identity;

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

    fn resize(&mut self, _gpu: &Gpu, _size: [u32; 2], _specular: bool) -> Result<(), GpuError> {
        Ok(())
    }

    fn denoise(
        &mut self,
        _recorder: &mut Recorder<'_>,
        _frame: &FrameInfo,
        _uniform: &Uniform,
        _guides: &GBuffer,
        noisy: &RadianceImage,
    ) -> RadianceImage {
        noisy.clone()
    }
}
