//! A recurrent blur: what was blurred is next frame's history, so that a few taps a frame become a wide kernel.
//!
//! Source: in the manner of ReBLUR (Zhdan 2021, "ReBLUR: A Hierarchical Recurrent Denoiser", and NRD 4.14's settings); the
//! voxel paper has no such stage.
//!
//! In: light at trace size ([`RadianceImage`]) with its hit distances, and the whole G-buffer. Out: the same light, less
//! noisy. Per lobe, with N the frames a pixel has been followed, h the mean hit distance (m), z depth, R roughness:
//!
//! ```text
//! accumulate  slow: light, share 1/N, N <= history_max; fast: moments of luminance, share 1/N, N <= fast_frames
//!             (as in [`crate::temporal`])
//! recover     N < fix_frames: mean over 5x5 pixels, fix_stride / (1 + N) rows apart, each worth its own N
//!             over 3x3 pixels: apart = |slow - fast|, error = standard error of fast; what lies beyond lag_sigma errors is
//!             lag: the light is scaled towards fast by that share, N shrinks by it
//! blur        twice, the first is kept: eight taps in opposite pairs on a disc of radius r rows that turns from frame to
//!             frame, weights exp(-2 |o|^2) w_n w_z (see `edge`)
//! diffuse     r = max(radius / sqrt(N) * mix(1/4, 1, min(h / (hit_far + hit_far_growth z), 1)), radius_min)
//! specular    r = min(R^2 h / (h + z) * height / (2 |up|), max(radius / sqrt(N), radius_min)), and only like roughness
//! ```
//!
//! No weight looks at the light, and taps lie opposite each other: on a plane what one pixel gives another gets, and a
//! firefly keeps its light. Constant light stays constant to the bit. Sums are f32, pictures between passes half floats.
//!
//! Departs from its source: no blur before accumulation (so that history is looked up in what was not blurred yet); no clamp
//! of fireflies, which loses their light; the fast history is luminance alone and is tested, not clamped to; reflections are
//! followed by the motion of their surface; no temporal stabilisation.

pub mod reference;
mod settings;

pub use settings::Settings;

use crate::lobes;
use crate::temporal::{FRAMES, Input, Needs, Temporal};
use crate::{Denoiser, Guides, Need};
use frame::info::{Frame, FrameInfo};
use frame::{
    Bind, GBuffer, Gpu, GpuError, Kernel, Knob, RadianceImage, Recorder, Room, Texture, Uniform, gpu_struct,
};
use wgpu::BindingResource::TextureView as View;

gpu_struct! {
    /// See `recurrent.inc.wgsl`.
    pub struct RecurrentParams {
        /// Cosine and sine.
        pub turn: [f32; 2],
        /// Rows.
        pub radius: f32,
        /// Rows.
        pub radius_min: f32,
        /// Metres, metres per metre.
        pub hit_far: [f32; 2],
        /// Power of the cosine.
        pub sigma_normal: f32,
        /// Rows.
        pub sigma_depth: f32,
        /// Relative.
        pub roughness_fraction: f32,
        /// Pixels along a row per row.
        pub columns_per_row: f32,
        /// Frames.
        pub fix_frames: f32,
        /// Rows.
        pub fix_stride: f32,
        /// Standard errors.
        pub lag_sigma: f32,
        /// Frames.
        pub fast_frames: f32,
    }
}

/// The recurrent blur.
pub struct Recurrent {
    settings: Settings,
    temporal: Temporal,
    recover_kernel: Kernel,
    blur_kernel: Kernel,
    /// Light after the first blur.
    history: [Texture; 2],
    accumulated: [Texture; 2],
    recovered: [Texture; 2],
}

fn pictures(gpu: &Gpu, size: [u32; 2], has_specular: bool) -> Result<[[Texture; 2]; 3], GpuError> {
    let pair = |room, label| lobes::pair(gpu, room, label, size, has_specular);
    Ok([
        pair(Room::History, "Recurrent::history")?,
        pair(Room::Radiance, "Recurrent::accumulated")?,
        pair(Room::Radiance, "Recurrent::recovered")?,
    ])
}

impl Recurrent {
    /// Compiles its kernels.
    ///
    /// # Errors
    /// A kernel was refused.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let shared = include_str!("recurrent.inc.wgsl");
        let blur_bindings = [
            Bind::uniform::<Frame>(0, 0, "frame"),
            Bind::uniform::<RecurrentParams>(0, 1, "params"),
            Bind::texture_uint(2, 0, "in_edge"),
            Bind::texture(2, 1, "in_diffuse"),
            Bind::texture(2, 2, "in_specular"),
            Bind::texture_uint(2, 3, "in_frames"),
            Bind::storage_texture(3, 0, "out_diffuse", RadianceImage::FORMAT),
            Bind::storage_texture(3, 1, "out_specular", RadianceImage::FORMAT),
        ];
        let recover_bindings = [
            &blur_bindings[..],
            &[Bind::texture(2, 4, "in_moments"), Bind::storage_texture(3, 2, "out_frames", FRAMES)],
        ]
        .concat();
        let kernel = |entry: &str, source: &str, bindings: &[Bind]| {
            lobes::kernel(gpu, &format!("denoise/recurrent/{entry}"), entry, &[shared, source], bindings, &[])
        };
        let [history, accumulated, recovered] = pictures(gpu, [1, 1], false)?;
        Ok(Self {
            settings: Settings::default(),
            temporal: Temporal::new(gpu, "recurrent", Needs::default())?,
            recover_kernel: kernel("recover", include_str!("recover.wgsl"), &recover_bindings)?,
            blur_kernel: kernel("blur", include_str!("blur.wgsl"), &blur_bindings)?,
            history,
            accumulated,
            recovered,
        })
    }

    fn blur(
        &self,
        recorder: &mut Recorder<'_>,
        input: &Input<'_>,
        turn: u32,
        from: &[Texture; 2],
        to: &[Texture; 2],
    ) {
        let params = recorder.uniform(&self.settings.params(input.frame, turn));
        recorder.compute(
            &format!("denoise/recurrent/blur{turn}"),
            &self.blur_kernel,
            &[
                input.uniform.binding(),
                params.binding(),
                View(self.temporal.edge().view()),
                View(from[0].view()),
                View(from[1].view()),
                View(self.temporal.frames().view()),
                View(to[0].view()),
                View(to[1].view()),
            ],
            lobes::workgroups(input.noisy.size()),
        );
    }

    fn recover(&self, recorder: &mut Recorder<'_>, input: &Input<'_>) {
        let params = recorder.uniform(&self.settings.params(input.frame, 0));
        recorder.compute(
            "denoise/recurrent/recover",
            &self.recover_kernel,
            &[
                input.uniform.binding(),
                params.binding(),
                View(self.temporal.edge().view()),
                View(self.accumulated[0].view()),
                View(self.accumulated[1].view()),
                View(self.temporal.frames().view()),
                View(self.recovered[0].view()),
                View(self.recovered[1].view()),
                View(self.temporal.moments().view()),
                View(self.temporal.frames_before().view()),
            ],
            lobes::workgroups(input.noisy.size()),
        );
    }
}

impl Denoiser for Recurrent {
    fn name(&self) -> &'static str {
        "recurrent"
    }

    fn knobs(&mut self) -> Vec<Knob<'_>> {
        self.settings.knobs()
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
        self.temporal.bytes() + self.history.iter().map(Texture::bytes).sum::<u64>()
    }

    fn energy_bound(&self) -> f32 {
        // Rounding of half floats in four passes, and of radii to pixels where hit distances differ.
        0.005
    }

    fn resize(&mut self, gpu: &Gpu, size: [u32; 2], specular: bool) -> Result<(), GpuError> {
        self.temporal.resize(gpu, size)?;
        [self.history, self.accumulated, self.recovered] = pictures(gpu, size, specular)?;
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
        self.temporal.pack(recorder, &input, self.settings.roughness_min);
        let (before, accumulated) = (self.history.each_ref(), self.accumulated.each_ref());
        let memory = self.settings.memory();
        self.temporal.accumulate(recorder, &input, &memory, before, None, accumulated);
        self.recover(recorder, &input);
        self.temporal.swap_frames();
        recorder.output("denoise/recurrent/frames", self.temporal.frames());
        self.blur(recorder, &input, 0, &self.recovered, &self.history);
        self.blur(recorder, &input, 1, &self.history, &self.accumulated);
        let clean = lobes::clean(recorder, "recurrent", noisy, accumulated);
        self.temporal.turn();
        clean
    }
}

#[cfg(test)]
mod tests;
