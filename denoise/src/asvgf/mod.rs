//! A-SVGF: SVGF that forgets where light has changed, as fast as it changed.
//!
//! Source: Schied, Peters and Dachsbacher 2018, "Gradient Estimation for Real-Time Adaptive Temporal Filtering". The voxel
//! paper has no such stage; this is one to compare its blur with.
//!
//! In: light at trace size ([`RadianceImage`]) and the whole G-buffer. Out: the same light, less noisy. Everything but the
//! first two passes, and every formula not given here, is [`crate::svgf`]'s. Per lobe, l the luminance of one frame's noisy
//! light, q where the last frame shows what p shows now (tested as in [`crate::temporal`], to the nearest pixel):
//!
//! ```text
//! gradient   over strata of 3x3 pixels: n, sum l_p, sum l'_q, sum (l_p - l'_q)^2
//! haste      over 5x5 strata, weighted by w_z w_n of their middles: means L, L', S
//!            delta = |L - L'|,  error = sqrt(S / n),   lambda = clamp((delta - lag_sigma error) / max(L, L'), 0, 1)
//! accumulate a history's share and its frames shrink by lambda
//! ```
//!
//! Departs from its source: that one shades a pixel of each stratum again with the last frame's random numbers, so that what
//! differs is change and nothing else. A denoiser that is handed pictures cannot ask a tracer for this; the samples here are
//! independent, their noise is told from change by its standard error, and change below it goes unseen.

pub mod reference;

use crate::svgf::{self, filter::Filter};
use crate::temporal::{self, Input, Needs, Temporal, TemporalParams};
use crate::{Denoiser, Guides, Need, lobes};
use frame::info::{Frame, FrameInfo};
use frame::{
    Bind, GBuffer, Gpu, GpuError, Kernel, Knob, RadianceImage, Recorder, Room, Texture, Uniform, gpu_struct,
};
use wgpu::BindingResource::TextureView as View;
use wgpu::TextureFormat;

gpu_struct! {
    /// See `haste.wgsl`.
    pub struct HasteParams {
        /// Power of the cosine.
        pub sigma_normal: f32,
        /// Rows.
        pub sigma_depth: f32,
        /// Standard errors.
        pub lag_sigma: f32,
        /// To 16 bytes.
        pub _pad: u32,
    }
}

/// Pixels of a stratum along each axis.
pub const STRATUM: u32 = 3;

/// Bits of two f32: luminance of both lobes, negative where there is none.
const LUMINANCE: TextureFormat = TextureFormat::Rg32Uint;
/// Bits of two f32.
const HASTE: TextureFormat = TextureFormat::Rg32Uint;
const STRATA: TextureFormat = TextureFormat::Rgba32Float;

/// SVGF with temporal gradients.
pub struct Asvgf {
    settings: svgf::Settings,
    lag_sigma: f32,
    temporal: Temporal,
    gradient_kernel: Kernel,
    haste_kernel: Kernel,
    filter: Filter,
    /// Diffuse and specular light after the first level.
    history: [Texture; 2],
    /// Of this frame and the last, by `now`.
    luminances: [Texture; 2],
    now: usize,
    strata: [Texture; 2],
    haste: Texture,
}

struct Pictures {
    history: [Texture; 2],
    luminances: [Texture; 2],
    strata: [Texture; 2],
    haste: Texture,
}

impl Pictures {
    fn new(gpu: &Gpu, size: [u32; 2], has_specular: bool) -> Result<Self, GpuError> {
        let luminance = || lobes::picture(gpu, Room::History, "Asvgf::luminance", size, LUMINANCE);
        let coarse = size.map(|n| n.div_ceil(STRATUM));
        let strata = || lobes::picture(gpu, Room::Radiance, "Asvgf::strata", coarse, STRATA);
        Ok(Self {
            history: lobes::pair(gpu, Room::History, "Asvgf::history", size, has_specular)?,
            luminances: [luminance()?, luminance()?],
            strata: [strata()?, strata()?],
            haste: lobes::picture(gpu, Room::Radiance, "Asvgf::haste", size, HASTE)?,
        })
    }
}

impl Asvgf {
    /// Compiles its kernels.
    ///
    /// # Errors
    /// A kernel was refused.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let frame = Bind::uniform::<Frame>(0, 0, "frame");
        let gradient_kernel = lobes::kernel(
            gpu,
            "denoise/asvgf/gradient",
            "gradient",
            &[temporal::WGSL, include_str!("gradient.wgsl")],
            &[
                frame,
                Bind::uniform::<TemporalParams>(0, 1, "params"),
                Bind::texture_uint(2, 0, "in_edge"),
                Bind::texture_uint(2, 1, "in_motion_id"),
                Bind::texture_uint(2, 2, "in_edge_before"),
                Bind::texture(2, 3, "in_diffuse"),
                Bind::texture(2, 4, "in_specular"),
                Bind::texture_uint(2, 5, "in_luminance_before"),
                Bind::storage_texture(3, 0, "out_diffuse_strata", STRATA),
                Bind::storage_texture(3, 1, "out_specular_strata", STRATA),
                Bind::storage_texture(3, 2, "out_luminance", LUMINANCE),
            ],
            &[],
        )?;
        let haste_kernel = lobes::kernel(
            gpu,
            "denoise/asvgf/haste",
            "haste",
            &[include_str!("haste.wgsl")],
            &[
                frame,
                Bind::uniform::<HasteParams>(0, 1, "params"),
                Bind::texture_uint(2, 0, "in_edge"),
                Bind::texture(2, 1, "in_diffuse_strata"),
                Bind::texture(2, 2, "in_specular_strata"),
                Bind::storage_texture(3, 0, "out_haste", HASTE),
            ],
            &[],
        )?;
        let Pictures { history, luminances, strata, haste } = Pictures::new(gpu, [1, 1], false)?;
        Ok(Self {
            settings: svgf::Settings::default(),
            lag_sigma: 3.0,
            temporal: Temporal::new(gpu, "asvgf", Needs { haste: true, ..Needs::default() })?,
            gradient_kernel,
            haste_kernel,
            filter: Filter::new(gpu, "asvgf")?,
            history,
            luminances,
            now: 0,
            strata,
            haste,
        })
    }

    /// For the pass of the same name.
    pub fn haste_params(&self, settings: &svgf::Settings) -> HasteParams {
        HasteParams {
            sigma_normal: settings.sigma_normal,
            sigma_depth: settings.sigma_depth,
            lag_sigma: self.lag_sigma,
            _pad: 0,
        }
    }

    fn record_haste(&self, recorder: &mut Recorder<'_>, input: &Input<'_>, settings: &svgf::Settings) {
        let params = recorder.uniform(&settings.temporal.params(input.frame));
        let light = lobes::of(input.noisy);
        recorder.compute(
            "denoise/asvgf/gradient",
            &self.gradient_kernel,
            &[
                input.uniform.binding(),
                params.binding(),
                View(self.temporal.edge().view()),
                View(input.guides.motion_id.view()),
                View(self.temporal.edge_before().view()),
                View(light[0].view()),
                View(light[1].view()),
                View(self.luminances[1 - self.now].view()),
                View(self.strata[0].view()),
                View(self.strata[1].view()),
                View(self.luminances[self.now].view()),
            ],
            lobes::workgroups(input.noisy.size().map(|n| n.div_ceil(STRATUM))),
        );
        let params = recorder.uniform(&self.haste_params(settings));
        recorder.compute(
            "denoise/asvgf/haste",
            &self.haste_kernel,
            &[
                input.uniform.binding(),
                params.binding(),
                View(self.temporal.edge().view()),
                View(self.strata[0].view()),
                View(self.strata[1].view()),
                View(self.haste.view()),
            ],
            lobes::workgroups(input.noisy.size()),
        );
        recorder.output("denoise/asvgf/haste", &self.haste);
    }
}

impl Denoiser for Asvgf {
    fn name(&self) -> &'static str {
        "asvgf"
    }

    fn knobs(&mut self) -> Vec<Knob<'_>> {
        let mut knobs = self.settings.knobs();
        knobs.push(Knob::float(
            "lag_sigma",
            &mut self.lag_sigma,
            0.0..=1000.0,
            "",
            "standard errors that light must have changed by; lower forgets for noise, higher lags. Ours: three, as each frame \
             asks again",
        ));
        knobs
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
        let pictures = self.history.iter().chain(&self.luminances);
        self.temporal.bytes() + pictures.map(Texture::bytes).sum::<u64>()
    }

    fn energy_bound(&self) -> f32 {
        svgf::ENERGY_BOUND
    }

    fn resize(&mut self, gpu: &Gpu, size: [u32; 2], specular: bool) -> Result<(), GpuError> {
        self.temporal.resize(gpu, size)?;
        self.filter.resize(gpu, size, specular)?;
        let Pictures { history, luminances, strata, haste } = Pictures::new(gpu, size, specular)?;
        (self.history, self.luminances, self.strata, self.haste) = (history, luminances, strata, haste);
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
        self.record_haste(recorder, &input, &settings);
        let haste = Some(&self.haste);
        self.temporal.accumulate(recorder, &input, &settings.temporal, history, haste, self.filter.input());
        recorder.output("denoise/asvgf/frames", self.temporal.frames());
        let light = self.filter.record(recorder, &input, &settings, &self.temporal, history);
        let clean = lobes::clean(recorder, "asvgf", noisy, light);
        self.temporal.turn();
        self.now = 1 - self.now;
        clean
    }
}

#[cfg(test)]
mod tests;
