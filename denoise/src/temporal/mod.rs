//! Finds pixels in the last frame and mixes their light with what was found: the part that all filters over time share.
//!
//! Source: the reprojection tests of Schied et al. 2017 ("Spatiotemporal Variance-Guided Filtering"), with planes instead
//! of depths.
//!
//! In: this frame's light and G-buffer, the last frame's packed edges ([`crate::edge`]) and what it left. Out: light as half
//! floats, moments and counts as below. Per lobe, with C the colour, l its luminance, N the frames a pixel has been
//! followed, x positions (m), z depth:
//!
//! ```text
//! taps: the four around p - motion, bilinear; where their weights sum below 0.01, the nine around it, alike
//! a tap counts if its object is p's, |g . (x_tap - x_p')| <= history_plane z_p', n_tap . n_p >= history_normal
//! of the four, where they lie on two sides of an edge of light, those that are like this frame's count (below)
//! N <- min((1 - haste) N' + 1, history_max), 1 where nothing counts
//! C <- mix(C', C_now, a),            a = 1 - (1 - haste) (1 - max(1/N, alpha_color))
//! mu <- mix(mu', (l, l^2), b),       b = 1 - (1 - haste) (1 - max(1/N, alpha_moments))
//! ```
//!
//! - x_p' is where the pixel was, relative to the last frame's eye: along the ray that the motion tells, at the depth it
//!   has if it stands still.
//! - Edges of light: bilinear taps drag the rim of a patch of sunlight along, and the blur grows with every frame of
//!   motion. With s the root of the taps' mean variance and l a tap's luminance, taps whose l lie more than s to 2 s apart
//!   (a smooth step) are weighted by `exp(-(|l - l_now| - least) / s)`; the sum of their weights stays. Noise, which the
//!   wavelet has smoothed by then, keeps taps closer than that: choosing by it would darken them. Ours.
//! - Jitter: history is looked up as if there were none, so that a still picture is averaged in place; its positions are
//!   those of the jittered rays.
//! - `haste` (0..1) is what somebody else says is out of date ([`crate::asvgf`]); 0 for all others.
//! - A pixel without light of its own in this frame keeps its history and grows no older. What does not take
//!   ([`crate::edge`]) passes by.
//! - N is kept per lobe, and 0 where the lobe has neither light nor history. Moments and sums are f32.

pub mod reference;

use crate::edge::{self, EdgePacker, EdgeParams};
use crate::lobes;
use frame::info::{Frame, FrameInfo};
use frame::{
    Bind, GBuffer, Gpu, GpuError, Kernel, Knob, RadianceImage, Recorder, Room, Texture, Uniform, gpu_struct,
};
use glam::Vec3;
use wgpu::BindingResource::TextureView as View;
use wgpu::TextureFormat;

/// Functions `temporal_…` that find a pixel in the last frame; after [`edge::WGSL`].
pub const WGSL: &str = include_str!("temporal.inc.wgsl");

/// Of the moments: diffuse in xy, specular in zw.
pub const MOMENTS: TextureFormat = TextureFormat::Rgba32Float;
/// Of the counts: diffuse in the low half, specular in the high one.
pub const FRAMES: TextureFormat = TextureFormat::R32Uint;

gpu_struct! {
    /// See `temporal.inc.wgsl`.
    pub struct TemporalParams {
        /// Unit.
        pub previous_forward: [f32; 3],
        /// Least share of a new frame.
        pub alpha_color: f32,
        /// Half the picture's width at distance 1.
        pub previous_right: [f32; 3],
        /// Least share of a new frame.
        pub alpha_moments: f32,
        /// Half the picture's height at distance 1.
        pub previous_up: [f32; 3],
        /// Relative to depth.
        pub plane_tolerance: f32,
        /// This frame's eye minus the last one's, metres.
        pub eye_offset: [f32; 3],
        /// Cosine.
        pub normal_min: f32,
        /// 0 or 1.
        pub keeps_history: u32,
        /// Frames.
        pub history_max: f32,
        /// To 80 bytes.
        pub _pad: [u32; 2],
    }
}

/// What is followed, and how long it is remembered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Least share of a new frame in the colour.
    pub alpha_color: f32,
    /// Least share of a new frame in the moments.
    pub alpha_moments: f32,
    /// Frames that a pixel remembers having.
    pub history_max: u32,
    /// How far from the expected plane history may lie, relative to depth.
    pub history_plane: f32,
    /// Least cosine between the shading normals of a pixel and its history.
    pub history_normal: f32,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            alpha_color: 0.2,
            alpha_moments: 0.2,
            history_max: 255,
            history_plane: 0.01,
            history_normal: 0.9,
        }
    }
}

impl Settings {
    /// The two by which history is told from what merely lies there.
    pub fn surface_knobs<'a>(plane: &'a mut f32, normal: &'a mut f32) -> [Knob<'a>; 2] {
        [
            Knob::float(
                "history_plane",
                plane,
                0.0..=1.0,
                "",
                "how far from the pixel's plane its history may lie, relative to depth; higher leaves trails behind edges, \
                 lower forgets what moves towards the viewer. The paper gives none: one hundredth",
            ),
            Knob::float(
                "history_normal",
                normal,
                -1.0..=1.0,
                "",
                "least cosine between the shading normals of a pixel and its history; higher forgets bumps at every motion, \
                 lower drags light around corners. The paper gives none: 0.9, 26 degrees",
            ),
        ]
    }

    /// For one frame.
    pub fn params(&self, frame: &FrameInfo) -> TemporalParams {
        let before = FrameInfo { camera: frame.previous_camera.clone(), ..frame.clone() }.uniform();
        TemporalParams {
            previous_forward: before.forward,
            alpha_color: self.alpha_color,
            previous_right: before.right,
            alpha_moments: self.alpha_moments,
            previous_up: before.up,
            plane_tolerance: self.history_plane,
            eye_offset: (frame.camera.eye - Vec3::from(before.eye)).into(),
            normal_min: self.history_normal,
            keeps_history: u32::from(!frame.restart),
            history_max: self.history_max as f32,
            _pad: [0; 2],
        }
    }
}

/// One frame's input, as every denoiser gets it.
#[derive(Clone, Copy)]
pub struct Input<'a> {
    /// Camera, sizes.
    pub frame: &'a FrameInfo,
    /// `frame` for shaders.
    pub uniform: &'a Uniform,
    /// What is seen.
    pub guides: &'a GBuffer,
    /// Its light.
    pub noisy: &'a RadianceImage,
}

/// What somebody who mixes frames needs besides.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Needs {
    /// A share of history to forget is handed in.
    pub haste: bool,
    /// Means of more than 32 frames: light is kept as `rgba32float`, not `rgba16float`.
    pub precise: bool,
}

/// Mixes each frame with the last.
pub struct Temporal {
    pass: String,
    packer: EdgePacker,
    kernel: Kernel,
    /// Of this frame and the last, by `now`.
    edges: [Texture; 2],
    moments: [Texture; 2],
    frames: [Texture; 2],
    now: usize,
    /// The same of the counts, which somebody else may rewrite within a frame.
    frames_now: usize,
}

impl Temporal {
    /// Compiles its kernels; passes are called `denoise/NAME/edge` and `…/accumulate`.
    ///
    /// # Errors
    /// A kernel was refused.
    pub fn new(gpu: &Gpu, name: &str, needs: Needs) -> Result<Self, GpuError> {
        let pass = format!("denoise/{name}/accumulate");
        let (format, kept_as) = match needs.precise {
            true => (TextureFormat::Rgba32Float, include_str!("float.inc.wgsl")),
            false => (RadianceImage::FORMAT, include_str!("half.inc.wgsl")),
        };
        let bindings = [
            Bind::uniform::<Frame>(0, 0, "frame"),
            Bind::uniform::<TemporalParams>(0, 1, "params"),
            Bind::texture_uint(2, 0, "in_edge"),
            Bind::texture_uint(2, 1, "in_motion_id"),
            Bind::texture_uint(2, 2, "in_edge_before"),
            Bind::texture(2, 3, "in_diffuse"),
            Bind::texture(2, 4, "in_specular"),
            Bind::texture(2, 5, "in_diffuse_before"),
            Bind::texture(2, 6, "in_specular_before"),
            Bind::texture(2, 7, "in_moments_before"),
            Bind::texture_uint(2, 8, "in_frames_before"),
            Bind::texture_uint(2, 9, "in_haste"),
            Bind::storage_texture(3, 0, "out_diffuse", format),
            Bind::storage_texture(3, 1, "out_specular", format),
            Bind::storage_texture(3, 2, "out_moments", MOMENTS),
            Bind::storage_texture(3, 3, "out_frames", FRAMES),
        ];
        let kernel = lobes::kernel(
            gpu,
            &pass,
            "temporal_accumulate_frame",
            &[WGSL, kept_as, include_str!("accumulate.wgsl")],
            &bindings,
            &[("has_haste", f64::from(needs.haste))],
        )?;
        let [edges, moments, frames] = Self::pictures(gpu, [1, 1])?;
        let packer = EdgePacker::new(gpu, &format!("denoise/{name}/edge"))?;
        Ok(Self { pass, packer, kernel, edges, moments, frames, now: 0, frames_now: 0 })
    }

    fn pictures(gpu: &Gpu, size: [u32; 2]) -> Result<[[Texture; 2]; 3], GpuError> {
        let two = |label, format| -> Result<[Texture; 2], GpuError> {
            let picture = || lobes::picture(gpu, Room::History, label, size, format);
            Ok([picture()?, picture()?])
        };
        Ok([
            two("Temporal::edges", edge::FORMAT)?,
            two("Temporal::moments", MOMENTS)?,
            two("Temporal::frames", FRAMES)?,
        ])
    }

    /// Allocates what it keeps.
    ///
    /// # Errors
    /// Too large, or out of memory.
    pub fn resize(&mut self, gpu: &Gpu, size: [u32; 2]) -> Result<(), GpuError> {
        [self.edges, self.moments, self.frames] = Self::pictures(gpu, size)?;
        Ok(())
    }

    /// Bytes kept from frame to frame.
    pub fn bytes(&self) -> u64 {
        [&self.edges, &self.moments, &self.frames].into_iter().flatten().map(Texture::bytes).sum()
    }

    /// Packs this frame's edges.
    pub fn pack(&self, recorder: &mut Recorder<'_>, input: &Input<'_>, roughness_min: f32) {
        let params = EdgeParams::new(roughness_min, input.noisy.specular.is_some(), true);
        self.packer.pack(recorder, input.uniform, &params, input.guides, input.noisy, self.edge());
    }

    /// Mixes this frame, whose edges are packed, with `before` into `output`.
    pub fn accumulate(
        &self,
        recorder: &mut Recorder<'_>,
        input: &Input<'_>,
        settings: &Settings,
        before: [&Texture; 2],
        haste: Option<&Texture>,
        output: [&Texture; 2],
    ) {
        let params = recorder.uniform(&settings.params(input.frame));
        let light = lobes::of(input.noisy);
        recorder.compute(
            &self.pass,
            &self.kernel,
            &[
                input.uniform.binding(),
                params.binding(),
                View(self.edge().view()),
                View(input.guides.motion_id.view()),
                View(self.edge_before().view()),
                View(light[0].view()),
                View(light[1].view()),
                View(before[0].view()),
                View(before[1].view()),
                View(self.moments_before().view()),
                View(self.frames_before().view()),
                // Where there is none, nothing reads what stands in for it.
                View(haste.unwrap_or(self.edge()).view()),
                View(output[0].view()),
                View(output[1].view()),
                View(self.moments().view()),
                View(self.frames().view()),
            ],
            lobes::workgroups(input.noisy.size()),
        );
    }

    /// This frame's packed edges.
    pub fn edge(&self) -> &Texture {
        &self.edges[self.now]
    }

    /// The last frame's.
    pub fn edge_before(&self) -> &Texture {
        &self.edges[1 - self.now]
    }

    /// This frame's moments.
    pub fn moments(&self) -> &Texture {
        &self.moments[self.now]
    }

    /// This frame's counts.
    pub fn frames(&self) -> &Texture {
        &self.frames[self.frames_now]
    }

    /// The last frame's moments.
    pub fn moments_before(&self) -> &Texture {
        &self.moments[1 - self.now]
    }

    /// The last frame's counts.
    pub fn frames_before(&self) -> &Texture {
        &self.frames[1 - self.frames_now]
    }

    /// Ends the frame: what it wrote is the next one's past.
    pub fn turn(&mut self) {
        self.now = 1 - self.now;
        self.swap_frames();
    }

    /// Counts that a later pass wrote over the last frame's are this frame's from now on.
    pub fn swap_frames(&mut self) {
        self.frames_now = 1 - self.frames_now;
    }
}
