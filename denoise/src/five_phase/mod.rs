//! The paper's denoiser: five blurs along rows and columns, each for a bracket of roughness "and above".
//!
//! Paper: "denoised through a two-pass, five-phase blur process".
//!
//! In: light at trace size ([`RadianceImage`]); of the G-buffer the shading normal, the two roughnesses and what tells
//! which lobes there are (`surface`), and metres along the ray (`distance`). Out: the same light, less noisy. With
//! world position x (m), normal n, distance d, overall roughness R of the lobe, for each phase k and axis e:
//!
//! ```text
//! g   = floor(d_p / growth_step)
//! K   = round((k[k] + min(k_growth g, k_growth_max)) * scale_e)     pixels
//! rho = rho[k] + min(rho_growth g, rho_growth_max)                  metres
//! out = sum_j w_j L(p + j e) / sum_j w_j,  j = -K..K,  if R_p >= tau[k]; else L(p)
//! w_j = [R_q >= tau[k]] [|x_q - x_p| <= rho] [valid q] max(0, n_p . n_q) falloff(j)
//! ```
//!
//! - **Lobes**: the diffuse one has R = 1, the specular one the rougher of the surface's two; one pass does both. Mirrors
//!   and clear glass lie below `tau0` and keep their reflections, bit for bit. So does the sky, and a lobe that the
//!   surface lacks.
//! - **Pixels are not square**: `scale` is 1 along a column and [`FrameInfo::columns_per_row`] along a row, and the half
//!   width is rounded to the nearest pixel after growth, so that 1, 2, 3, 4, 6 become 1, 2, 2, 3, 5 at 0.75.
//! - **Valid** is what was hit, traced, valid ([`crate::light`]) and has the lobe. A traced pixel whose lobe happened to draw no sample
//!   is a valid 0 (see the crate's page). What is not valid but has the lobe is filled from its neighbours; it never
//!   gives. The mean hit distance in a is filtered by the same weights over the taps that have one.
//! - The centre's own weight is 1, so the sum of weights is at least 1 wherever the centre is valid, and constant light
//!   stays constant to the bit. Sums are f32, the pictures between passes half floats.
//!
//! What a tap asks about a pixel is packed once per frame into 16 bytes by `guide.wgsl`: position relative to the eye,
//! and a word with the normal's 24 bits, one bit per phase that the specular lobe takes part in, and one each for
//! "specular gives", "diffuse takes", "diffuse gives".
//!
//! Pixels whose light is not valid are counted as `denoise_invalid`. Two pictures are used in turn, so only the last
//! pass's are there to be looked at.
//!
//! Departs from the paper: two lobes instead of one; the rest of what it leaves open is a knob (`settings.rs`).

pub mod reference;
mod settings;

pub use settings::{Axis, FALLOFFS, ORDERS, PHASES, Settings};

use crate::lobes::{self, Turns};
use crate::{Denoiser, Guides, Need};
use frame::info::{Frame, FrameInfo};
use frame::{
    Bind, Buffer, GBuffer, Gpu, GpuError, Kernel, Knob, RadianceImage, Recorder, Room, Texture, Uniform,
    gpu_struct,
};
use wgpu::BindingResource::TextureView as View;
use wgpu::TextureFormat;

gpu_struct! {
    /// See `guide.wgsl`.
    pub struct GuideParams {
        /// Least roughness code of phases 0 to 3.
        pub thresholds: [u32; 4],
        /// Least roughness code of phase 4.
        pub last_threshold: u32,
        /// 0: one lobe only.
        pub has_specular: u32,
        /// To 16 bytes.
        pub _pad: [u32; 2],
    }
}

gpu_struct! {
    /// See `five_phase.wgsl`.
    pub struct PhaseParams {
        /// One pixel along the axis.
        pub step: [i32; 2],
        /// 0..4.
        pub phase: u32,
        /// Pixels along the axis per trace row.
        pub radius_scale: f32,
        /// Trace rows.
        pub kernel_radius: f32,
        /// Trace rows per growth step.
        pub radius_growth: f32,
        /// Trace rows.
        pub radius_growth_max: f32,
        /// Metres.
        pub radial_cutoff: f32,
        /// Metres per growth step.
        pub cutoff_growth: f32,
        /// Metres.
        pub cutoff_growth_max: f32,
        /// Metres.
        pub growth_step: f32,
        /// 0: box.
        pub is_triangular: u32,
        /// 1: taps must be of the bracket.
        pub same_bracket: u32,
        /// 1: beyond the border lies the mirror image.
        pub is_mirrored: u32,
        /// 1: the cut-off is of distances from the viewer.
        pub by_depth: u32,
        /// To 8 bytes, the alignment of `step`.
        pub _pad: u32,
    }
}

const GUIDE: TextureFormat = TextureFormat::Rgba32Uint;

/// The paper's denoiser.
pub struct FivePhase {
    settings: Settings,
    guide_kernel: Kernel,
    /// Without and with a specular lobe.
    phase_kernels: [Kernel; 2],
    invalid: Buffer,
    guide: Texture,
    turns: Turns,
}

impl FivePhase {
    /// Compiles its kernels.
    ///
    /// # Errors
    /// A kernel was refused.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let guide_kernel = lobes::kernel(
            gpu,
            "denoise/five_phase/guide",
            "guide_pack",
            &[include_str!("guide.wgsl")],
            &[
                Bind::uniform::<Frame>(0, 0, "frame"),
                Bind::uniform::<GuideParams>(0, 1, "params"),
                Bind::texture_uint(2, 0, "in_surface"),
                Bind::texture(2, 1, "in_distance"),
                Bind::texture(2, 2, "in_diffuse"),
                Bind::texture(2, 3, "in_specular"),
                Bind::texture_uint(2, 4, "in_samples"),
                Bind::storage_texture(3, 0, "out_guide", GUIDE),
                Bind::storage(3, 1, "out_invalid"),
            ],
            &[],
        )?;
        let phase_kernel = |has_specular: bool| {
            lobes::kernel(
                gpu,
                "denoise/five_phase",
                "filter_phase",
                &[include_str!("five_phase.wgsl")],
                &[
                    Bind::uniform::<PhaseParams>(0, 1, "params"),
                    Bind::texture_uint(2, 0, "in_guide"),
                    Bind::texture(2, 1, "in_diffuse"),
                    Bind::texture(2, 2, "in_specular"),
                    Bind::storage_texture(3, 0, "out_diffuse", RadianceImage::FORMAT),
                    Bind::storage_texture(3, 1, "out_specular", RadianceImage::FORMAT),
                ],
                &[("has_specular", f64::from(has_specular))],
            )
        };
        Ok(Self {
            settings: Settings::default(),
            guide_kernel,
            phase_kernels: [phase_kernel(false)?, phase_kernel(true)?],
            invalid: gpu.storage(Room::Radiance, "FivePhase::invalid", &[0u32; 2])?,
            guide: lobes::picture(gpu, Room::Radiance, "FivePhase::guide", [1, 1], GUIDE)?,
            turns: Turns::new(gpu, "FivePhase::lobes", [1, 1], false)?,
        })
    }
}

impl Denoiser for FivePhase {
    fn name(&self) -> &'static str {
        "five_phase"
    }

    fn knobs(&mut self) -> Vec<Knob<'_>> {
        self.settings.knobs()
    }

    fn guides(&self) -> Guides {
        Guides { surface: Need::Required, distance: Need::Required, ..Guides::default() }
    }

    fn history_bytes(&self) -> u64 {
        0
    }

    fn energy_bound(&self) -> f32 {
        // Without a mirror beyond the border, what lies next to it counts up to twice; where half widths grow, a pixel at
        // the step may give to more than it takes from.
        if self.settings.effective().border == 1 { 0.25 } else { 1.0 }
    }

    fn resize(&mut self, gpu: &Gpu, size: [u32; 2], specular: bool) -> Result<(), GpuError> {
        self.guide = lobes::picture(gpu, Room::Radiance, "FivePhase::guide", size, GUIDE)?;
        self.turns = Turns::new(gpu, "FivePhase::lobes", size, specular)?;
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
        let workgroups = lobes::workgroups(noisy.size());
        let (input, has_specular) = (lobes::of(noisy), noisy.specular.is_some());
        let settings = self.settings.effective();

        recorder.clear(&self.invalid);
        let params = recorder.uniform(&settings.guide_params(has_specular));
        recorder.compute(
            "denoise/five_phase/guide",
            &self.guide_kernel,
            &[
                uniform.binding(),
                params.binding(),
                View(guides.surface.view()),
                View(guides.distance.view()),
                View(input[0].view()),
                View(input[1].view()),
                View(noisy.samples.view()),
                View(self.guide.view()),
                self.invalid.as_entire_binding(),
            ],
            workgroups,
        );
        recorder.counter("denoise_invalid", &self.invalid, 0);

        let schedule = settings.schedule();
        let light = self.turns.chain(input, 0, schedule.len(), |turn, from, to| {
            let (phase, axis) = schedule[turn];
            let params = recorder.uniform(&settings.phase_params(phase, axis, frame));
            recorder.compute(
                &format!("denoise/five_phase/phase{phase}/{}", axis.name()),
                &self.phase_kernels[usize::from(has_specular)],
                &[
                    params.binding(),
                    View(self.guide.view()),
                    View(from[0].view()),
                    View(from[1].view()),
                    View(to[0].view()),
                    View(to[1].view()),
                ],
                workgroups,
            );
        });
        lobes::clean(recorder, "five_phase", noisy, light)
    }
}

#[cfg(test)]
mod tests;
