//! Gather and path tracing: what the camera sees, and the light that reaches it.
//!
//! A [`Tracer`] turns a G-buffer into a [`RadianceImage`]: demodulated radiance at trace size in two lobes, never NaN,
//! never negative, the same bits for the same seed. [`all`] lists those there are. They share the light, noise and path
//! code in the folders beside them, so that a comparison compares structures and nothing else.

pub mod bvh;
pub mod gather;
mod lights;
pub mod noise;
mod path;
mod voxel_trace;

pub use gather::Gather;
pub use path::{PathSettings, SampleRule};
pub use voxel_trace::VoxelTracer;

use frame::scene_gpu::GpuScene;
use frame::{FrameInfo, GBuffer, Gpu, GpuError, Knob, RadianceImage, Recorder, Uniform};
use voxel::VoxelGrid;

/// What tracers borrow: built once from the union of what the chosen ones need.
#[derive(Clone, Copy)]
pub struct World<'a> {
    /// Materials, sky, lights.
    pub scene: &'a GpuScene,
    /// The voxels, if a chosen tracer traces them.
    pub grid: Option<&'a VoxelGrid>,
}

/// Finds light for a G-buffer.
pub trait Tracer {
    /// The id that logs print.
    fn name(&self) -> &'static str;

    /// Its settings.
    fn knobs(&mut self) -> Vec<Knob<'_>>;

    /// Whether it traces the voxel grid.
    fn needs_grid(&self) -> bool;

    /// Bytes kept from frame to frame.
    fn history_bytes(&self) -> u64 {
        0
    }

    /// Builds the kernels for what the scene needs, and allocates for a trace size; all allocation happens here.
    ///
    /// # Errors
    /// The driver refuses a kernel, the size is too large for the adapter, or memory is out.
    fn resize(&mut self, gpu: &Gpu, scene: &GpuScene, size: [u32; 2]) -> Result<(), GpuError>;

    /// Records one frame's paths. The image stays valid until the next call.
    fn trace(
        &mut self,
        recorder: &mut Recorder<'_>,
        frame: &FrameInfo,
        uniform: &Uniform,
        world: World<'_>,
        gbuffer: &GBuffer,
        paths: &PathSettings,
    ) -> RadianceImage;
}

/// A tracer's name and how it is made.
pub type Constructor = (&'static str, fn(&Gpu) -> Result<Box<dyn Tracer>, GpuError>);

/// All tracers, in the order they are listed.
pub fn all() -> &'static [Constructor] {
    &[("voxel", |_| Ok(Box::new(VoxelTracer::default())))]
}
