//! Upsamplers: trace-size light in, display-size pictures out.
//!
//! | paper, section 2 | here |
//! | --- | --- |
//! | "an outward search from the center fragment to find the best candidate" | [`best_candidate`] |
//! | "its light amount is modulated with the center fragment's albedo" | [`modulate`], for every upsampler |
//! | the texel under the pixel, or the mean of four, to measure what the search is worth | [`nearest`], [`bilinear`] |
//! | ours: four pixels of the same surface; many jittered frames | [`joint_bilateral`], [`temporal`] |
//! | the field's: the finished picture made larger | [`fsr1`] |
//!
//! **A new upsampler**: copy the folder `nearest/`, rename it, and add one line to [`all`]. The folder's name is the
//! upsampler's name, on the command line too. It chooses or mixes light of the trace size; what it ends with goes
//! through [`modulate`], the only place where light meets colour and emission is added.
//!
//! Light that may be taken for a lobe is that of a trace pixel which hit something, was traced, and whose surface has the
//! lobe. A traced pixel whose lobe happened to draw no sample holds a valid 0: skipping it would make the picture too
//! bright by one over the lobe's probability. Light of mirrors is a picture of something else: copy it from one
//! pixel, do not mix several.

pub mod best_candidate;
pub mod bilinear;
pub mod fsr1;
pub mod joint_bilateral;
pub mod modulate;
pub mod nearest;
pub mod search;
pub mod temporal;

use frame::info::FrameInfo;
use frame::scene_gpu::GpuScene;
use frame::{ColorImage, GBuffer, Gpu, GpuError, Knob, RadianceImage, Recorder, Uniform};

/// Trace-size light in, display-size picture out.
///
/// Promises, tested for every member of [`all`]: where both sizes are equal, each pixel gets its own light; where
/// nothing was hit, the sky; the picture is finite and at most 65,504; the same frames give the same bits.
pub trait Upsampler {
    /// Its folder and its name in [`all`].
    fn name(&self) -> &'static str;

    /// Its settings, lent out.
    fn knobs(&mut self) -> Vec<Knob<'_>>;

    /// Bytes kept from frame to frame.
    fn history_bytes(&self) -> u64;

    /// Where in its pixel the trace-size gather should look, in trace pixels from the centre; asked before gather. The
    /// display-size gather is never jittered.
    fn jitter(&self, _frame_index: u32) -> [f32; 2] {
        [0.0; 2]
    }

    /// Allocates for pictures of these sizes, with or without a specular lobe; called before the first frame, and again
    /// when any of them changes.
    ///
    /// # Errors
    /// Too large, or out of memory.
    fn resize(
        &mut self,
        gpu: &Gpu,
        trace_size: [u32; 2],
        display_size: [u32; 2],
        specular: bool,
    ) -> Result<(), GpuError>;

    /// Records its passes, named `upsample/NAME…`. `trace` and `light` have the frame's trace size, `display` and
    /// `direct` its display size; `direct` is light found elsewhere (a sun's shadow map) under the same modulators.
    /// The picture it returns is good until the next call.
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
    ) -> ColorImage;
}

/// Makes an upsampler: compiles its kernels.
pub type Constructor = fn(&Gpu) -> Result<Box<dyn Upsampler>, GpuError>;

/// Every upsampler by name.
pub fn all() -> &'static [(&'static str, Constructor)] {
    &[
        ("nearest", |gpu| Ok(Box::new(nearest::Nearest::new(gpu)?))),
        ("bilinear", |gpu| Ok(Box::new(bilinear::Bilinear::new(gpu)?))),
        ("best_candidate", |gpu| Ok(Box::new(best_candidate::BestCandidate::new(gpu)?))),
        ("joint_bilateral", |gpu| Ok(Box::new(joint_bilateral::JointBilateral::new(gpu)?))),
        ("temporal", |gpu| Ok(Box::new(temporal::Temporal::new(gpu)?))),
        ("fsr1", |gpu| Ok(Box::new(fsr1::Fsr1::new(gpu)?))),
    ]
}

#[cfg(test)]
mod tests;
