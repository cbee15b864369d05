//! SVGF: light averaged over time where a pixel can be followed, then a wavelet guided by how noisy it still is.
//!
//! Source: Schied et al. 2017, "Spatiotemporal Variance-Guided Filtering: Real-Time Reconstruction for Path-Traced
//! Global Illumination". The voxel paper has no such stage; this is one to compare its blur with.
//!
//! In: light at trace size ([`RadianceImage`]) and the whole G-buffer. Out: the same light, less noisy. Per lobe, with
//! C the colour, l its luminance, N the frames a pixel has been followed, x positions (m), z depth:
//!
//! ```text
//! reproject  taps: the four around p - motion, bilinear; where their weights sum below 0.01, the nine around it, alike
//!            a tap counts if its object is p's, |g . (x_tap - x_p')| <= history_plane z_p', n_tap . n_p >= history_normal
//!            N <- min(mean N + 1, history_max), 1 where nothing counts
//!            a  = max(1/N, alpha_color);     C  <- (1 - a) C' + a C_now
//!            b  = max(1/N, alpha_moments);   mu <- (1 - b) mu' + b (l, l^2)
//! variance   V = max(0, mu_2 - mu_1^2); with N < 4, of moments averaged over 7x7 pixels by w_z w_n, times 4/N
//! level i    taps q = p + 2^i (a, b), a and b in -2..2 trace rows, h = 1/16, 1/4, 3/8, 1/4, 1/16
//!            C <- sum h w C / sum h w,       V <- sum (h w)^2 V / (sum h w)^2,       w = w_z w_n w_l
//!            w_z = exp(-d(p, q) / sigma_z)   distance from p's plane, rows (see `edge`)
//!            w_n = max(0, n_p . n_q)^sigma_n
//!            w_l = exp(-|l_p - l_q| / (sigma_l sqrt(g * V) + e)), g a Gauss over 3x3 pixels
//! ```
//!
//! The first level's colour is the next frame's C'. What is left alone, the weight w_r of the specular lobe and what
//! counts as a valid 0 are told in [`crate::edge`]. N and V are kept per lobe. A pixel without light of its own in this
//! frame keeps its history; without one it is filled from its neighbours and never gives. The mean hit distance in a is
//! mixed and filtered by the same weights over what has one. Sums and moments are f32, colours between passes half
//! floats.
//!
//! - x_p' is where the pixel was, relative to the last frame's eye: along the ray that the motion tells, at the depth it
//!   has if it stands still.
//! - e is rounding: 2^-8 of the brighter luminance, and the smallest half floats.
//! - Jitter: history is looked up as if there were none, so that a still picture is averaged in place; its positions are
//!   those of the jittered rays.
//! - The luminance weight loses light, as the source's does: it leaves out what is much brighter than the pixel, and the
//!   noise of few samples has its light in few pixels. Even noise loses none (see the tests); one sample a pixel of a
//!   Cornell box lost 4 % after eight frames, and nothing with `sigma_l` at 100.
//!
//! Departs from its source: w_z takes the distance from the pixel's plane instead of the depth's screen gradient, which
//! is wrong at silhouettes and doubtful where a triangle is a few pixels wide; footprints are square on the display
//! ([`FrameInfo::columns_per_row`]); two lobes instead of direct and indirect light; no temporal antialiasing here, it
//! wraps an upsampler. Glossy reflections are followed by the motion of their surface, as in the source.

mod kernels;
pub mod reference;
mod settings;

use kernels::Kernels;
pub use settings::Settings;

use crate::edge::{self, EdgePacker, EdgeParams};
use crate::{Denoiser, Guides, Need};
use frame::info::FrameInfo;
use frame::{GBuffer, Gpu, GpuError, Knob, RadianceImage, Recorder, Room, Texture, Uniform, gpu_struct};
use wgpu::BindingResource::TextureView as View;
use wgpu::{TextureFormat, TextureUsages};

gpu_struct! {
    /// See `reproject.wgsl`.
    pub struct ReprojectParams {
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
        /// To 48 bytes.
        pub _pad: [u32; 2],
    }
}

const MOMENTS: TextureFormat = TextureFormat::Rgba32Float;
const FRAMES: TextureFormat = TextureFormat::R32Uint;
/// Bits of two f32.
const VARIANCE: TextureFormat = TextureFormat::Rg32Uint;

/// Spatiotemporal variance-guided filtering.
pub struct Svgf {
    settings: Settings,
    packer: EdgePacker,
    kernels: Kernels,
    history: History,
    pictures: Pictures,
}

/// What one frame leaves to the next. Two of what is read and written in the same pass, used in turn.
struct History {
    edge: [Texture; 2],
    /// Diffuse in xy, specular in zw.
    moments: [Texture; 2],
    /// Diffuse in the low half, specular in the high one.
    frames: [Texture; 2],
    /// Diffuse and specular after the first level.
    lobes: [Texture; 2],
    /// Index of what the next frame writes.
    now: usize,
}

/// What is gone after a frame.
struct Pictures {
    /// Written in turn: diffuse and specular.
    lobes: [[Texture; 2]; 2],
    /// Written in turn: of both lobes.
    variances: [Texture; 2],
}

/// A binding cannot be left empty: without a specular lobe, one texel stands in.
fn sizes(size: [u32; 2], has_specular: bool) -> [[u32; 2]; 2] {
    [size, if has_specular { size } else { [1, 1] }]
}

fn picture(
    gpu: &Gpu,
    room: Room,
    label: &str,
    [width, height]: [u32; 2],
    format: TextureFormat,
) -> Result<Texture, GpuError> {
    let usage = TextureUsages::TEXTURE_BINDING | TextureUsages::STORAGE_BINDING | TextureUsages::COPY_SRC;
    gpu.texture(room, label, [width, height, 1], 1, format, usage)
}

impl History {
    fn new(gpu: &Gpu, size: [u32; 2], has_specular: bool) -> Result<Self, GpuError> {
        let [diffuse, specular] = sizes(size, has_specular);
        let edge = || edge::texture(gpu, Room::History, "Svgf::edge", size);
        let make = |label, size, format| picture(gpu, Room::History, label, size, format);
        let moments = || make("Svgf::moments", size, MOMENTS);
        let frames = || make("Svgf::frames", size, FRAMES);
        Ok(Self {
            edge: [edge()?, edge()?],
            moments: [moments()?, moments()?],
            frames: [frames()?, frames()?],
            lobes: [
                make("Svgf::diffuse_history", diffuse, RadianceImage::FORMAT)?,
                make("Svgf::specular_history", specular, RadianceImage::FORMAT)?,
            ],
            now: 0,
        })
    }

    fn bytes(&self) -> u64 {
        let pairs = [&self.edge, &self.moments, &self.frames, &self.lobes];
        pairs.into_iter().flatten().map(Texture::bytes).sum()
    }
}

impl Pictures {
    fn new(gpu: &Gpu, size: [u32; 2], has_specular: bool) -> Result<Self, GpuError> {
        let [diffuse, specular] = sizes(size, has_specular);
        let lobes = || -> Result<[Texture; 2], GpuError> {
            Ok([
                RadianceImage::lobe(gpu, "Svgf::diffuse", diffuse)?,
                RadianceImage::lobe(gpu, "Svgf::specular", specular)?,
            ])
        };
        let variance = || picture(gpu, Room::Radiance, "Svgf::variance", size, VARIANCE);
        Ok(Self { lobes: [lobes()?, lobes()?], variances: [variance()?, variance()?] })
    }
}

impl Svgf {
    /// Compiles its kernels.
    ///
    /// # Errors
    /// A kernel was refused.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        Ok(Self {
            settings: Settings::default(),
            packer: EdgePacker::new(gpu, "denoise/svgf/edge")?,
            kernels: Kernels::new(gpu)?,
            history: History::new(gpu, [1, 1], false)?,
            pictures: Pictures::new(gpu, [1, 1], false)?,
        })
    }

    /// Writes the accumulated light to the first pictures.
    fn reproject(
        &self,
        recorder: &mut Recorder<'_>,
        frame: &FrameInfo,
        uniform: &Uniform,
        guides: &GBuffer,
        noisy: &RadianceImage,
    ) {
        let History { edge, moments, frames, lobes, now } = &self.history;
        let (now, before) = (*now, 1 - *now);
        let params = recorder.uniform(&self.settings.reproject_params(frame));
        recorder.compute(
            "denoise/svgf/reproject",
            &self.kernels.reproject,
            &[
                uniform.binding(),
                params.binding(),
                View(edge[now].view()),
                View(guides.motion_id.view()),
                View(noisy.diffuse.view()),
                View(noisy.specular.as_ref().unwrap_or(&noisy.diffuse).view()),
                View(edge[before].view()),
                View(lobes[0].view()),
                View(lobes[1].view()),
                View(moments[before].view()),
                View(frames[before].view()),
                View(self.pictures.lobes[0][0].view()),
                View(self.pictures.lobes[0][1].view()),
                View(moments[now].view()),
                View(frames[now].view()),
            ],
            edge::workgroups(noisy.size()),
        );
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
        Guides {
            surface: Need::Required,
            distance: Need::Required,
            face_normal: Need::Required,
            motion_id: Need::Required,
        }
    }

    fn history_bytes(&self) -> u64 {
        self.history.bytes()
    }

    fn resize(&mut self, gpu: &Gpu, size: [u32; 2], specular: bool) -> Result<(), GpuError> {
        self.history = History::new(gpu, size, specular)?;
        self.pictures = Pictures::new(gpu, size, specular)?;
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
        let workgroups = edge::workgroups(noisy.size());
        let has_specular = noisy.specular.is_some();
        let now = self.history.now;
        let edges = EdgeParams::new(self.settings.roughness_min, has_specular, true);
        self.packer.pack(recorder, uniform, &edges, guides, noisy, &self.history.edge[now]);
        self.reproject(recorder, frame, uniform, guides, noisy);

        let [even, odd] = &self.pictures.lobes;
        let variances = &self.pictures.variances;
        let edge = &self.history.edge[now];
        let params = recorder.uniform(&self.settings.level_params(0, frame.columns_per_row()));
        recorder.compute(
            "denoise/svgf/variance",
            &self.kernels.variance,
            &[
                uniform.binding(),
                params.binding(),
                View(edge.view()),
                View(self.history.moments[now].view()),
                View(self.history.frames[now].view()),
                View(variances[0].view()),
            ],
            workgroups,
        );
        recorder.output("denoise/svgf/frames", &self.history.frames[now]);

        let mut input = even;
        for level in 0..self.settings.levels {
            let params = recorder.uniform(&self.settings.level_params(level, frame.columns_per_row()));
            // The first level writes what the next frame remembers; its input is free from then on.
            let output = match level {
                0 => &self.history.lobes,
                _ if level % 2 == 0 => even,
                _ => odd,
            };
            let turn = level as usize % 2;
            recorder.compute(
                &format!("denoise/svgf/level{level}"),
                &self.kernels.level,
                &[
                    uniform.binding(),
                    params.binding(),
                    View(edge.view()),
                    View(input[0].view()),
                    View(input[1].view()),
                    View(variances[turn].view()),
                    View(output[0].view()),
                    View(output[1].view()),
                    View(variances[1 - turn].view()),
                ],
                workgroups,
            );
            input = output;
        }

        let clean = RadianceImage {
            diffuse: input[0].clone(),
            specular: has_specular.then(|| input[1].clone()),
            samples: noisy.samples.clone(),
        };
        recorder.output("denoise/svgf/diffuse", &clean.diffuse);
        if let Some(specular) = &clean.specular {
            recorder.output("denoise/svgf/specular", specular);
        }
        self.history.now = 1 - now;
        clean
    }
}

#[cfg(test)]
mod tests;
