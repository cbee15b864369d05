//! Images that converge: the sum of many unrounded paths per pixel, what every error is measured against.
//!
//! In: the [`World`], a camera (its jitter is not used: each sample looks through a random point of its pixel), and the number of samples. Out:
//! per pixel the sum of radiance (linear, times `radiance_scale`). Searching triangles it gives the
//! true image; searching the grid, the image that paths through the same voxels give without noise or filter. Camera
//! rays always meet triangles, as the gathered G-buffer does. See `path/camera.rs`.

use crate::path::Searched;
use crate::path::camera::{CameraPaths, Resources};
use crate::{PathSettings, Search, World, bvh_trace, voxel_trace};
use frame::scene_gpu::GpuScene;
use frame::{Gpu, GpuError, Recorder, Uniform};
use std::ops::Range;
use voxel::RecordLayout;

/// Sum of one pixel's samples.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Moment {
    /// Radiance times `radiance_scale`.
    pub sum: [f32; 3],
    /// Samples.
    pub count: f32,
}

/// Kernels and buffers of one structure, one scene, one size.
pub struct Converger {
    search: Search,
    of_camera: Search,
    paths: CameraPaths,
    size: [u32; 2],
}

impl Converger {
    /// `size` is that of the picture; `settings.spp` is not read.
    ///
    /// # Errors
    /// The driver refuses a kernel, the size is too large for the adapter, or memory is out.
    pub fn new(
        gpu: &Gpu,
        scene: &GpuScene,
        search: Search,
        size: [u32; 2],
        settings: &PathSettings,
    ) -> Result<Self, GpuError> {
        let of_camera = if search == Search::Grid { Search::Cwbvh } else { search };
        let structure = if search == Search::Grid {
            voxel_trace::structure(RecordLayout::of(&scene.needs), settings.build.levels)
        } else {
            bvh_trace::structure(search)
        };
        let camera = bvh_trace::structure(of_camera);
        let paths = CameraPaths::new(gpu, scene, &camera, &structure, size, settings)?;
        Ok(Self { search, of_camera, paths, size })
    }

    /// What the [`World`] must hold.
    pub fn searches(&self) -> [Search; 2] {
        [self.search, self.of_camera]
    }

    /// Rows that are traced at once, from the top.
    pub fn bands(&self) -> Vec<Range<u32>> {
        let height = self.size[1];
        let band = self.paths.band as usize;
        (0..height).step_by(band).map(|row| row..(row + self.paths.band).min(height)).collect()
    }

    /// Traces samples number `samples` of a band. [`Converger::moments`] has their sums when the recorder is done.
    pub fn record(
        &self,
        recorder: &mut Recorder<'_>,
        uniform: &Uniform,
        world: World<'_>,
        settings: &PathSettings,
        band: &Range<u32>,
        samples: Range<u32>,
    ) {
        let of_bvh = |search| {
            let Some(bvh) = world.bvh(search) else {
                unreachable!("the pipeline builds what a converger says it searches");
            };
            bvh_trace::resources(world.scene, world.mesh, bvh)
        };
        let of_camera = of_bvh(self.of_camera);
        let (of_paths, worst_case) = match (self.search, world.grid) {
            (Search::Grid, Some(grid)) => (grid.resources().to_vec(), voxel_trace::worst_case(grid)),
            _ => (of_camera.clone(), bvh_trace::worst_case(self.search)),
        };
        let Some(lights) = world.lights(self.search) else {
            unreachable!("they stand with the structure");
        };
        let of_paths = Searched { resources: &of_paths, worst_case, lights, cache: None };
        let resources = Resources { of_camera: &of_camera, of_paths };
        self.paths.record(recorder, uniform, world.scene, &resources, settings, band.start, samples);
    }

    /// The sums of the band recorded last, top row first.
    ///
    /// # Errors
    /// Reading back fails.
    pub fn moments(&self, gpu: &Gpu, band: &Range<u32>) -> Result<Vec<Moment>, GpuError> {
        let mut moments: Vec<Moment> = gpu.read_buffer(&self.paths.sums)?;
        moments.truncate(self.size[0] as usize * band.len());
        Ok(moments)
    }
}
