//! SVGF: light averaged over time where a pixel can be followed, then a wavelet guided by how noisy it still is.
//!
//! Source: Schied et al. 2017, "Spatiotemporal Variance-Guided Filtering: Real-Time Reconstruction for Path-Traced
//! Global Illumination". The voxel paper has no such stage; this is one to compare its blur with.
//!
//! In: light at trace size ([`RadianceImage`]) and the whole G-buffer. Out: the same light, less noisy. Per lobe, with
//! C the colour, l its luminance, N the frames a pixel has been followed, x positions (m), z depth:
//!
//! ```text
//! mix        C, mu = (E[l], E[l^2]) and N as in [`crate::temporal`], where the tests of a pixel's history are told
//! variance   V = max(0, mu_2 - mu_1^2) max(1/N, a / (2 - a)), a = alpha_color; the difference blurred by a Gauss over 3x3
//!            pixels; with N < 4, of moments averaged over 7x7 pixels by w_z w_n, times 4/N
//! level i    taps q = p + 2^i (a, b), a and b in -2..2 trace rows, h = 1/16, 1/4, 3/8, 1/4, 1/16
//!            k_q = h w_z w_n / sum h w_z w_n
//!            C_p <- sum k_q mix(C_p, C_q, w_l)        V_p <- the same weights, squared, on V
//!            w_z = exp(-d(p, q) / sigma_z)   distance from p's plane, rows (see `edge`)
//!            w_n = max(0, n_p . n_q)^sigma_n
//!            w_l = exp(-|l_p - l_q| / (sigma_l sqrt((V_p + V_q) / 2) + e))
//! ```
//!
//! The first level's colour is the next frame's C'. What is left alone, the weight w_r of the specular lobe and what
//! counts as a valid 0 are told in [`crate::edge`]. A pixel without light of its own and without history is filled from its
//! neighbours and never gives. The mean hit distance in a is filtered by k alone over what has one. Sums, moments and
//! variances are f32, colours between passes half floats. e is rounding: 2^-8 of the brighter luminance, and the smallest
//! half floats.
//!
//! **Light is kept.** The source leaves out of the sum what differs from the pixel, and with it most of the light that few
//! samples have in few pixels (4 % of a Cornell box at one sample). Here a pixel keeps its own value for what it does not
//! take, and w_l is the same seen from either side: what one pixel gives, another gets.
//!
//! Departs from its source: w_z takes the distance from the pixel's plane instead of the depth's screen gradient, which
//! is wrong at silhouettes and doubtful where a triangle is a few pixels wide; w_l as told above; V is that of the mean over
//! frames, not of one of them: sigma_l then counts deviations of what is filtered, and the rim of a patch of sunlight, which
//! comes and goes in the pixels beside it as the camera moves, is not washed out; the variance is blurred
//! once instead of before each level; footprints are square on the display
//! ([`FrameInfo::columns_per_row`]); two lobes instead of direct and indirect light; no temporal antialiasing here, it
//! wraps an upsampler. Glossy reflections are followed by the motion of their surface, as in the source.

pub mod filter;
pub mod reference;
mod settings;

use filter::Filter;
pub use settings::Settings;

use crate::lobes;
use crate::temporal::{Input, Needs, Temporal};
use crate::{Denoiser, Guides};
use frame::info::FrameInfo;
use frame::{GBuffer, Gpu, GpuError, Knob, RadianceImage, Recorder, Room, Texture, Uniform, gpu_struct};
use wgpu::TextureFormat;

gpu_struct! {
    /// See `svgf.inc.wgsl`.
    pub struct SvgfParams {
        /// Pixels to the first tap along x and y.
        pub first_tap: [i32; 2],
        /// Pixels to the second tap along x and y.
        pub second_tap: [i32; 2],
        /// Standard deviations.
        pub sigma_luminance: f32,
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
        /// 1 or 2.
        pub reach: i32,
        /// Least share of one frame's variance that the mean over frames has.
        pub least_variance: f32,
        /// Of the centre, the first and the second tap.
        pub kernel: [f32; 3],
        /// To 64 bytes.
        pub _end: u32,
    }
}

/// Bits of two f32.
const VARIANCE: TextureFormat = TextureFormat::Rg32Uint;

/// Spatiotemporal variance-guided filtering.
pub struct Svgf {
    settings: Settings,
    temporal: Temporal,
    filter: Filter,
    /// Diffuse and specular light after the first level.
    history: [Texture; 2],
}

impl Svgf {
    /// Compiles its kernels.
    ///
    /// # Errors
    /// A kernel was refused.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        Ok(Self {
            settings: Settings::default(),
            temporal: Temporal::new(gpu, "svgf", Needs::default())?,
            filter: Filter::new(gpu, "svgf")?,
            history: lobes::pair(gpu, Room::History, "Svgf::history", [1, 1], false)?,
        })
    }
}

impl Denoiser for Svgf {
    fn name(&self) -> &'static str {
        "svgf"
    }

    fn knobs(&mut self) -> Vec<Knob<'_>> {
        self.settings.knobs()
    }

    fn guides(&self) -> Guides {
        Guides::ALL
    }

    fn history_bytes(&self) -> u64 {
        self.temporal.bytes() + self.history.iter().map(Texture::bytes).sum::<u64>()
    }

    fn energy_bound(&self) -> f32 {
        ENERGY_BOUND
    }

    fn resize(&mut self, gpu: &Gpu, size: [u32; 2], specular: bool) -> Result<(), GpuError> {
        self.temporal.resize(gpu, size)?;
        self.filter.resize(gpu, size, specular)?;
        self.history = lobes::pair(gpu, Room::History, "Svgf::history", size, specular)?;
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
        let settings = self.settings.effective();
        let history = self.history.each_ref();
        self.temporal.pack(recorder, &input, settings.roughness_min);
        self.temporal.accumulate(recorder, &input, &settings.temporal, history, None, self.filter.input());
        recorder.output("denoise/svgf/frames", self.temporal.frames());
        let light = self.filter.record(recorder, &input, &settings, &self.temporal, history);
        let clean = lobes::clean(recorder, "svgf", noisy, light);
        self.temporal.turn();
        clean
    }
}

/// Rounding of half floats in six passes.
pub(crate) const ENERGY_BOUND: f32 = 0.005;

#[cfg(test)]
mod tests;
