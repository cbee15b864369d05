//! Gather and path tracing: what the camera sees, and the light that reaches it.
//!
//! A [`Tracer`] turns a G-buffer into a [`RadianceImage`]: demodulated radiance at trace size in two lobes, never NaN,
//! never negative, the same bits for the same seed. [`all`] lists those there are. They share the light, noise and path
//! code in the folders beside them, so that a comparison compares structures and nothing else.

pub mod bvh;
mod bvh_trace;
mod converge;
pub mod gather;
mod lights;
pub mod noise;
mod path;
pub mod rays;
mod voxel_trace;

pub use bvh_trace::BvhTracer;
pub use converge::{Converger, Moment};
pub use gather::Gather;
pub use lights::LightList;
pub use noise::Noise;
pub use path::{Conventions, PathBuild, PathChoices, PathSettings, RadianceCache, SampleRule};
pub use voxel_trace::VoxelTracer;

use bvh::Bvh;
use frame::scene_gpu::{GpuMesh, GpuScene};
use frame::{FrameInfo, GBuffer, Gpu, GpuError, Knob, RadianceImage, Recorder, Uniform};
use voxel::VoxelGrid;

/// What tracers borrow: built once from the union of what the chosen ones need.
#[derive(Clone, Copy)]
pub struct World<'a> {
    /// Materials, sky, lights.
    pub scene: &'a GpuScene,
    /// The triangles, tessellated.
    pub mesh: &'a GpuMesh,
    /// The voxels, if a chosen tracer traces them.
    pub grid: Option<&'a VoxelGrid>,
    /// The BVH built on the GPU, likewise.
    pub lbvh: Option<&'a Bvh>,
    /// The wide BVH built on the CPU, likewise.
    pub cwbvh: Option<&'a Bvh>,
    /// Emitters as the grid holds them; stands with the grid.
    pub grid_lights: Option<&'a LightList>,
    /// What the voxels keep, if a chosen tracer's settings ask for it ([`PathBuild::cache`]).
    pub cache: Option<&'a RadianceCache>,
    /// Emitters among the triangles; stands with a BVH.
    pub triangle_lights: Option<&'a LightList>,
}

impl<'a> World<'a> {
    /// The BVH that is searched.
    fn bvh(&self, search: Search) -> Option<&'a Bvh> {
        match search {
            Search::Grid => None,
            Search::Lbvh => self.lbvh,
            Search::Cwbvh => self.cwbvh,
        }
    }

    /// What finds light there.
    fn lights(&self, search: Search) -> Option<&'a LightList> {
        if search == Search::Grid { self.grid_lights } else { self.triangle_lights }
    }
}

/// What rays search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Search {
    /// The voxel grid.
    Grid,
    /// [`bvh::lbvh`].
    Lbvh,
    /// [`bvh::cwbvh`].
    Cwbvh,
}

/// Finds light for a G-buffer.
pub trait Tracer {
    /// The id that logs print.
    fn name(&self) -> &'static str;

    /// Its settings.
    fn knobs(&mut self) -> Vec<Knob<'_>>;

    /// What it traces: the pipeline builds it into the [`World`] before the first frame.
    fn search(&self) -> Search;

    /// Bytes kept from frame to frame.
    fn history_bytes(&self) -> u64 {
        0
    }

    /// Builds the kernels for what the scene needs, and allocates for a trace size; all allocation happens here. Of the
    /// settings only the conventions are read.
    ///
    /// # Errors
    /// The driver refuses a kernel, the size is too large for the adapter, or memory is out.
    fn resize(
        &mut self,
        gpu: &Gpu,
        scene: &GpuScene,
        size: [u32; 2],
        paths: &PathSettings,
    ) -> Result<(), GpuError>;

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
    &[
        ("voxel", |_| Ok(Box::new(VoxelTracer::default()))),
        ("bvh_lbvh", |_| Ok(Box::new(BvhTracer::new(Search::Lbvh)))),
        ("bvh_cwbvh", |_| Ok(Box::new(BvhTracer::new(Search::Cwbvh)))),
    ]
}
