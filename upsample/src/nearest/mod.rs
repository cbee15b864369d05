//! Takes the light of the trace pixel under the centre of the display pixel, whatever surface that pixel saw.
//!
//! Paper: nothing; this is the least an upsampler can do, against which others are measured.
//!
//! In: light at trace size. Out: the picture at display size, through [`crate::modulate`]. With p in display pixels:
//! `q = floor((p + 1/2) trace_size / display_size)`, in integers, so at equal sizes q = p.
//!
//! Departs from the paper: the paper searches (see [`crate::best_candidate`]).

pub mod reference;

use crate::{Upsampler, modulate};
use frame::info::FrameInfo;
use frame::scene_gpu::GpuScene;
use frame::{
    Bind, ColorImage, GBuffer, Gpu, GpuError, Kernel, KernelDesc, Knob, RadianceImage, Recorder, Uniform,
    gpu_struct,
};

gpu_struct! {
    /// See `nearest.wgsl`.
    pub struct NearestParams {
        /// 0: one lobe only.
        pub has_specular: u32,
        /// Lobes of direct light.
        pub direct_lobes: u32,
    }
}

const WORKGROUP: [u32; 3] = [8, 8, 1];
const NAME: &str = "upsample/nearest";

/// The light of the trace pixel under the display pixel.
pub struct Nearest {
    kernel: Kernel,
    picture: ColorImage,
}

impl Nearest {
    /// Compiles its kernel.
    ///
    /// # Errors
    /// The kernel was refused.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let own = [
            Bind::uniform::<NearestParams>(0, 1, "params"),
            Bind::storage_texture(3, 0, "out_color", ColorImage::FORMAT),
        ];
        let kernel = Kernel::new(
            gpu,
            &KernelDesc {
                name: NAME,
                sources: &[&modulate::SOURCES[..], &[include_str!("nearest.wgsl")]].concat(),
                entry: "nearest",
                workgroup: WORKGROUP,
                bindings: &[&modulate::BINDS[..], &own].concat(),
                constants: &[],
            },
        )?;
        Ok(Self { kernel, picture: ColorImage::new(gpu, [1, 1])? })
    }
}

impl Upsampler for Nearest {
    fn name(&self) -> &'static str {
        "nearest"
    }

    fn knobs(&mut self) -> Vec<Knob<'_>> {
        Vec::new()
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
        _frame: &FrameInfo,
        uniform: &Uniform,
        scene: &GpuScene,
        _trace: &GBuffer,
        light: &RadianceImage,
        display: &GBuffer,
        direct: Option<&RadianceImage>,
    ) -> ColorImage {
        use wgpu::BindingResource::TextureView as View;
        let params = recorder.uniform(&NearestParams {
            has_specular: u32::from(light.specular.is_some()),
            direct_lobes: modulate::lobe_count(direct),
        });
        let mut resources = modulate::resources(uniform, scene, light, display, direct).to_vec();
        resources.extend([params.binding(), View(self.picture.texture.view())]);
        let [width, height] = self.picture.size();
        let workgroups = [width.div_ceil(WORKGROUP[0]), height.div_ceil(WORKGROUP[1]), 1];
        recorder.compute(NAME, &self.kernel, &resources, workgroups);
        recorder.output(NAME, &self.picture.texture);
        self.picture.clone()
    }
}

#[cfg(test)]
mod tests;
