//! Gathers the detail of many jittered frames: light is kept at display size and found again by motion.
//!
//! Paper: nothing. Sources: Karis 2014, "High quality temporal supersampling"; Yang et al. 2020, "A survey of temporal
//! antialiasing techniques"; Salvi 2016 for the clamp by variance.
//!
//! In: light and G-buffer at trace size, seen through a jittered camera ([`crate::Upsampler::jitter`]); G-buffer at display
//! size, without jitter; what this stage kept. Out: the picture at display size, through [`crate::modulate`]. Kept per
//! display pixel and lobe is demodulated light and its weight W, so that textures stay those of the display:
//!
//! 1. *This frame*: the four trace pixels around, weighed as in [`crate::joint_bilateral`] but for
//!    `narrow = exp(-d^2 / (2 0.47^2))` + 0.05 bilinear in place of the bilinear weight, d display pixels from the sample to
//!    the pixel's centre. Their sum w says how much this frame knows about this pixel.
//! 2. *Before*: the pixel minus its motion, bilinear over those of four kept pixels that saw the same object, within
//!    `plane_tolerance` of the plane and `normal_min` of the normal.
//! 3. *Rectified*: what was kept is pulled towards the mean m of this frame's 3x3 trace pixels until it is within
//!    `clamp_width` standard deviations (plus 2 % of m) in YCoCg; W is scaled by the share of its distance that is left.
//! 4. `light = (W kept + w new) / (W + w)`, `W = min(W + w, weight_max)`.
//!
//! Jitter: Halton (2, 3) within the trace pixel, `8 * ratio` offsets, ratio = display pixels per trace pixel. At equal sizes
//! there is no jitter, nothing is kept, and a pixel takes its own light.
//!
//! Departs from its sources: light instead of final colour.

pub mod reference;
mod settings;

pub use settings::Settings;

use crate::{Upsampler, joint_bilateral, modulate, search};
use frame::info::FrameInfo;
use frame::scene_gpu::GpuScene;
use frame::{
    Bind, ColorImage, GBuffer, Gpu, GpuError, Kernel, KernelDesc, Knob, RadianceImage, Recorder, Room,
    Texture, Uniform, gpu_struct,
};
use wgpu::{TextureFormat, TextureUsages};

gpu_struct! {
    /// See `temporal.wgsl`.
    pub struct TemporalParams {
        /// The last frame's view, as `frame` has this one's.
        pub previous_forward: [f32; 3],
        /// Most weight kept.
        pub weight_max: f32,
        /// See `previous_forward`.
        pub previous_right: [f32; 3],
        /// Standard deviations.
        pub clamp_width: f32,
        /// See `previous_forward`.
        pub previous_up: [f32; 3],
        /// Metres off the plane per metre of distance.
        pub plane_tolerance: f32,
        /// This frame's eye minus the last one's, metres.
        pub eye_offset: [f32; 3],
        /// Cosine between shading normals.
        pub normal_min: f32,
        /// 0 or 1: a factor.
        pub keeps_history: f32,
        /// To 16 bytes.
        pub _pad: [f32; 3],
    }
}

/// Weights of the bilinear part and of the Gaussian one.
pub(crate) const PARTS: [f32; 2] = [0.05, 1.0];

const WORKGROUP: [u32; 3] = [8, 8, 1];
const NAME: &str = "upsample/temporal";

/// What is kept from frame to frame.
struct History {
    diffuse: Texture,
    specular: Texture,
    guides: Texture,
}

impl History {
    fn new(gpu: &Gpu, [width, height]: [u32; 2], specular: bool) -> Result<Self, GpuError> {
        let usage = TextureUsages::TEXTURE_BINDING | TextureUsages::STORAGE_BINDING;
        let make = |label, [width, height]: [u32; 2], format| {
            gpu.texture(Room::History, label, [width, height, 1], 1, format, usage)
        };
        let size = [width, height];
        Ok(Self {
            diffuse: make("Temporal::diffuse", size, RadianceImage::FORMAT)?,
            specular: make(
                "Temporal::specular",
                if specular { size } else { [1, 1] },
                RadianceImage::FORMAT,
            )?,
            guides: make("Temporal::guides", size, TextureFormat::Rg32Uint)?,
        })
    }

    fn bytes(&self) -> u64 {
        self.diffuse.bytes() + self.specular.bytes() + self.guides.bytes()
    }
}

/// Light of many frames.
pub struct Temporal {
    settings: Settings,
    kernel: Kernel,
    history: [History; 2],
    current: usize,
    is_new: bool,
    trace_size: [u32; 2],
    picture: ColorImage,
}

impl Temporal {
    /// Compiles its kernel.
    ///
    /// # Errors
    /// The kernel was refused.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let own = [
            Bind::uniform::<joint_bilateral::JointParams>(0, 2, "joint_params"),
            Bind::uniform::<TemporalParams>(0, 3, "params"),
            Bind::texture_uint(2, 9, "display_motion_id"),
            Bind::texture(2, 10, "kept_diffuse"),
            Bind::texture(2, 11, "kept_specular"),
            Bind::texture_uint(2, 12, "kept_guides"),
            Bind::storage_texture(3, 0, "out_color", ColorImage::FORMAT),
            Bind::storage_texture(3, 1, "out_diffuse", RadianceImage::FORMAT),
            Bind::storage_texture(3, 2, "out_specular", RadianceImage::FORMAT),
            Bind::storage_texture(3, 3, "out_guides", TextureFormat::Rg32Uint),
        ];
        let kernel = Kernel::new(
            gpu,
            &KernelDesc {
                name: NAME,
                sources: &search::sources(&[
                    search::MIX_WGSL,
                    joint_bilateral::WGSL,
                    include_str!("temporal.wgsl"),
                ]),
                entry: "temporal",
                workgroup: WORKGROUP,
                bindings: &search::binds(&own),
                constants: &[],
            },
        )?;
        Ok(Self {
            settings: Settings::default(),
            kernel,
            history: [History::new(gpu, [1, 1], false)?, History::new(gpu, [1, 1], false)?],
            current: 0,
            is_new: true,
            trace_size: [1, 1],
            picture: ColorImage::new(gpu, [1, 1])?,
        })
    }
}

/// Number `index` of the van der Corput sequence in this base, from 1 on; in 0..1.
fn radical_inverse(mut index: u32, base: u32) -> f32 {
    let (mut inverse, mut digit) = (0.0, 1.0);
    while index > 0 {
        digit /= base as f32;
        inverse += digit * (index % base) as f32;
        index /= base;
    }
    inverse
}

/// Offset of the sample from the trace pixel's centre.
fn jitter(frame_index: u32, trace_size: [u32; 2], display_size: [u32; 2]) -> [f32; 2] {
    if trace_size == display_size {
        return [0.0; 2];
    }
    let pixels = |[width, height]: [u32; 2]| f64::from(width.max(1)) * f64::from(height.max(1));
    let period = (8.0 * pixels(display_size) / pixels(trace_size)).ceil().clamp(8.0, 1024.0) as u32;
    [2, 3].map(|base| radical_inverse(frame_index % period + 1, base) - 0.5)
}

impl Upsampler for Temporal {
    fn name(&self) -> &'static str {
        "temporal"
    }

    fn knobs(&mut self) -> Vec<Knob<'_>> {
        self.settings.knobs()
    }

    fn history_bytes(&self) -> u64 {
        self.history.iter().map(History::bytes).sum()
    }

    fn jitter(&self, frame_index: u32) -> [f32; 2] {
        jitter(frame_index, self.trace_size, self.picture.size())
    }

    fn resize(
        &mut self,
        gpu: &Gpu,
        trace_size: [u32; 2],
        display_size: [u32; 2],
        specular: bool,
    ) -> Result<(), GpuError> {
        self.picture = ColorImage::new(gpu, display_size)?;
        self.history =
            [History::new(gpu, display_size, specular)?, History::new(gpu, display_size, specular)?];
        self.trace_size = trace_size;
        self.is_new = true;
        Ok(())
    }

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
    ) -> ColorImage {
        use wgpu::BindingResource::TextureView as View;
        let keeps = !frame.restart && !self.is_new;
        self.is_new = false;
        let (kept, next) = (&self.history[self.current], &self.history[1 - self.current]);
        let search_params = recorder.uniform(&self.settings.joint.search.params(frame, light, direct));
        let joint = recorder.uniform(&self.settings.joint.params(PARTS));
        let params = recorder.uniform(&self.settings.params(frame, keeps));
        let mut resources = modulate::resources(uniform, scene, light, display, direct).to_vec();
        resources.extend(search::resources(&search_params, trace, light));
        resources.extend([joint.binding(), params.binding()]);
        resources.extend(
            [
                &display.motion_id,
                &kept.diffuse,
                &kept.specular,
                &kept.guides,
                &self.picture.texture,
                &next.diffuse,
                &next.specular,
                &next.guides,
            ]
            .map(|texture| View(texture.view())),
        );
        let [width, height] = self.picture.size();
        let workgroups = [width.div_ceil(WORKGROUP[0]), height.div_ceil(WORKGROUP[1]), 1];
        recorder.compute(NAME, &self.kernel, &resources, workgroups);
        recorder.output(NAME, &self.picture.texture);
        recorder.output("upsample/temporal/diffuse", &next.diffuse);
        self.current = 1 - self.current;
        self.picture.clone()
    }
}

#[cfg(test)]
mod tests;
