//! Mixes the light of the four trace pixels around the display pixel that lie on its surface; searches where none does.
//!
//! Paper: nothing; Kopf et al. 2007, "Joint bilateral upsampling", with the paper's own search as the way out.
//!
//! In: light and G-buffer at trace size, G-buffer at display size. Out: the picture at display size, through
//! [`crate::modulate`]. With n, x, z the normal, position and distance (m) of display pixel p, over those of the four
//! trace pixels q around it that count for the lobe ([`crate::search`]):
//!
//! ```text
//! w_q = bilinear_q max(0, n . n_q)^normal_power exp(-|n . (x_q - x)| / (plane_scale z))
//! light = sum w_q light_q / sum w_q          where sum w_q >= 1e-3, else the outward search's candidate
//! ```
//!
//! Pixels whose search had to do with less than an accepted candidate are counted as `upsample_fallbacks`, those that
//! searched at all as `upsample_searches`. Mirrors and clear glass take the light of the heaviest of the four. At equal
//! sizes a pixel takes its own light.
//!
//! Departs from the paper: four pixels are mixed where the paper copies one.

pub mod reference;
mod settings;

pub use settings::Settings;

use crate::{Upsampler, modulate, search};
use frame::info::FrameInfo;
use frame::scene_gpu::GpuScene;
use frame::{
    Bind, Buffer, ColorImage, GBuffer, Gpu, GpuError, Kernel, KernelDesc, Knob, RadianceImage, Recorder,
    Room, Uniform, gpu_struct,
};

gpu_struct! {
    /// See `joint.inc.wgsl`.
    pub struct JointParams {
        /// Of the cosine between normals.
        pub normal_power: f32,
        /// Metres off the plane per metre of distance at which a weight is 1/e.
        pub plane_scale: f32,
        /// Weight of the bilinear part.
        pub wide: f32,
        /// Weight of the Gaussian around the display pixel's centre.
        pub narrow: f32,
    }
}

/// `joint_*`: the mix of the four and the search, also for [`crate::temporal`].
pub(crate) const WGSL: &str = include_str!("joint.inc.wgsl");

const WORKGROUP: [u32; 3] = [8, 8, 1];
const NAME: &str = "upsample/joint_bilateral";

/// The four around, where they are of the same surface.
pub struct JointBilateral {
    settings: Settings,
    kernel: Kernel,
    counts: Buffer,
    picture: ColorImage,
}

impl JointBilateral {
    /// Compiles its kernel.
    ///
    /// # Errors
    /// The kernel was refused.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let own = [
            Bind::uniform::<JointParams>(0, 2, "joint_params"),
            Bind::storage_texture(3, 0, "out_color", ColorImage::FORMAT),
            Bind::storage(3, 1, "out_counts"),
        ];
        let kernel = Kernel::new(
            gpu,
            &KernelDesc {
                name: NAME,
                sources: &search::sources(&[search::MIX_WGSL, WGSL, include_str!("joint_bilateral.wgsl")]),
                entry: "joint_bilateral",
                workgroup: WORKGROUP,
                bindings: &search::binds(&own),
                constants: &[],
            },
        )?;
        Ok(Self {
            settings: Settings::default(),
            kernel,
            counts: gpu.storage(Room::Radiance, "JointBilateral::counts", &[0u32; 4])?,
            picture: ColorImage::new(gpu, [1, 1])?,
        })
    }
}

impl Upsampler for JointBilateral {
    fn name(&self) -> &'static str {
        "joint_bilateral"
    }

    fn knobs(&mut self) -> Vec<Knob<'_>> {
        self.settings.knobs()
    }

    fn history_bytes(&self) -> u64 {
        0
    }

    fn resize(
        &mut self,
        gpu: &Gpu,
        _trace_size: [u32; 2],
        display_size: [u32; 2],
        _specular: bool,
    ) -> Result<(), GpuError> {
        self.picture = ColorImage::new(gpu, display_size)?;
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
        recorder.clear(&self.counts);
        let params = recorder.uniform(&self.settings.search.params(frame, light, direct));
        let joint = recorder.uniform(&self.settings.params([1.0, 0.0]));
        let mut resources = modulate::resources(uniform, scene, light, display, direct).to_vec();
        resources.extend(search::resources(&params, trace, light));
        resources.extend([
            joint.binding(),
            View(self.picture.texture.view()),
            self.counts.as_entire_binding(),
        ]);
        let [width, height] = self.picture.size();
        let workgroups = [width.div_ceil(WORKGROUP[0]), height.div_ceil(WORKGROUP[1]), 1];
        recorder.compute(NAME, &self.kernel, &resources, workgroups);
        recorder.output(NAME, &self.picture.texture);
        recorder.counter("upsample_fallbacks", &self.counts, 0);
        recorder.counter("upsample_searches", &self.counts, 8);
        self.picture.clone()
    }
}

#[cfg(test)]
mod tests;
