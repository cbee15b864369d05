//! Denoisers: noisy light in, clean light out.
//!
//! | paper, section 2 | here |
//! | --- | --- |
//! | "denoised through a two-pass, five-phase blur process" | [`five_phase`] |
//! | - (Dammertz et al. 2010, for comparison) | [`atrous`] |
//! | - (Schied et al. 2017, for comparison) | [`svgf`] |
//! | - (Schied et al. 2018, for comparison) | [`asvgf`] |
//! | "Mara et al." (2017), named by the paper | [`mara`] |
//! | - (in the manner of ReBLUR, for comparison) | [`recurrent`] |
//! | - (the mean over time alone) | [`accumulate`] |
//! | the same street without a filter, to measure what one is worth | [`identity`] |
//!
//! **A new denoiser**: copy the folder `identity/`, rename it, and add one line to [`all`]. The folder's name is the
//! denoiser's name, on the command line too; `five_phase/` shows where shader, CPU twin and tests go. This page and
//! [`Denoiser`] are all it has to know.
//!
//! What comes in is demodulated light at trace size, [`frame::RadianceImage`]: rgb is radiance times the scene's
//! `radiance_scale`, a the mean length in metres of the lobe's first segments (0: the lobe has no sample here). What
//! goes out has the same size, unit and lobes. Two things are easily got wrong:
//!
//! - **Zeros count.** A path starts in one lobe, and what it brings is divided by the probability of that lobe and by
//!   *all* paths of the pixel. A traced pixel whose lobe drew no sample therefore holds 0 as its share of the mean:
//!   leaving it out of an average makes the picture too bright by one over the probability. Only where the *surface*
//!   lacks the lobe, where nothing was traced at all, or where the number is not finite, is there nothing to average.
//! - **Roughness belongs to the lobe.** The diffuse lobe is filtered as roughness 1, the specular one as the rougher of
//!   the surface's two; so mirrors and clear glass, whose light is a picture of something else, stay as they are.

pub mod accumulate;
pub mod asvgf;
pub mod atrous;
pub mod edge;
pub mod five_phase;
pub mod identity;
pub mod light;
pub mod lobes;
pub mod mara;
#[cfg(feature = "oidn")]
pub mod oidn;
pub mod recurrent;
pub mod svgf;
pub mod temporal;

use frame::info::FrameInfo;
use frame::{GBuffer, Gpu, GpuError, Knob, RadianceImage, Recorder, Uniform};

/// How much a denoiser wants a channel of the G-buffer. What it calls unused may hold anything, NaN included.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Need {
    /// Never read.
    #[default]
    Unused,
    /// Read where it is there; pictures of other renderers may come without.
    Optional,
    /// Nothing works without it.
    Required,
}

/// Which channels of the G-buffer a denoiser reads.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Guides {
    /// [`GBuffer::surface`].
    pub surface: Need,
    /// [`GBuffer::distance`].
    pub distance: Need,
    /// [`GBuffer::face_normal`].
    pub face_normal: Need,
    /// [`GBuffer::motion_id`].
    pub motion_id: Need,
}

/// Noisy light in, clean light out.
///
/// Promises, tested for every member of [`all`]: constant light stays constant; light that is not valid ([`light`]) is no
/// tap, is filled and counted as `denoise_invalid`; the rest keeps its sum within [`Denoiser::energy_bound`]; channels called
/// [`Need::Unused`] do not change one bit; the same frames give the same bits; after a frame that says `restart`, nothing of
/// earlier frames is left.
pub trait Denoiser {
    /// Its folder and its name in [`all`].
    fn name(&self) -> &'static str;

    /// Its settings, lent out.
    fn knobs(&mut self) -> Vec<Knob<'_>>;

    /// What it reads besides the light.
    fn guides(&self) -> Guides;

    /// Bytes kept from frame to frame.
    fn history_bytes(&self) -> u64;

    /// How far the sum of the light over a plane surface that fills the picture may differ from what came in, relative:
    /// in one frame without history, whatever is brightest where. At edges a pixel may take more than it gives, and over
    /// time history stands in for the frame; there the promise is of the mean.
    fn energy_bound(&self) -> f32;

    /// Allocates for pictures of this size, with or without a specular lobe; called before the first frame, and again
    /// when either changes.
    ///
    /// # Errors
    /// Too large, or out of memory.
    fn resize(&mut self, gpu: &Gpu, size: [u32; 2], specular: bool) -> Result<(), GpuError>;

    /// Records its passes, named `denoise/NAME/…`. `uniform` is `frame` for shaders; `guides` and `noisy` have the size
    /// of the last [`Denoiser::resize`]. The picture it returns is good until the next call.
    fn denoise(
        &mut self,
        recorder: &mut Recorder<'_>,
        frame: &FrameInfo,
        uniform: &Uniform,
        guides: &GBuffer,
        noisy: &RadianceImage,
    ) -> RadianceImage;
}

/// Makes a denoiser: compiles its kernels.
pub type Constructor = fn(&Gpu) -> Result<Box<dyn Denoiser>, GpuError>;

/// Every denoiser by name.
pub fn all() -> &'static [(&'static str, Constructor)] {
    &[
        ("identity", |gpu| Ok(Box::new(identity::Identity::new(gpu)?))),
        ("five_phase", |gpu| Ok(Box::new(five_phase::FivePhase::new(gpu)?))),
        ("atrous", |gpu| Ok(Box::new(atrous::Atrous::new(gpu)?))),
        ("svgf", |gpu| Ok(Box::new(svgf::Svgf::new(gpu)?))),
        ("asvgf", |gpu| Ok(Box::new(asvgf::Asvgf::new(gpu)?))),
        ("recurrent", |gpu| Ok(Box::new(recurrent::Recurrent::new(gpu)?))),
        ("mara", |gpu| Ok(Box::new(mara::Mara::new(gpu)?))),
        ("accumulate", |gpu| Ok(Box::new(accumulate::Accumulate::new(gpu)?))),
        #[cfg(feature = "oidn")]
        ("oidn", |gpu| Ok(Box::new(oidn::Oidn::new(gpu)?))),
    ]
}

#[cfg(test)]
mod fixture;
#[cfg(test)]
mod tests;
