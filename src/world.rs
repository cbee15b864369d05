//! What rays search: the voxel grid and the BVHs, each built when the first tracer asks for it and kept while nothing
//! moves, so that swapping stages builds nothing twice.

use crate::Error;
use frame::scene_gpu::{GpuMesh, GpuScene};
use frame::{FrameLog, Gpu, Knob, Recorder};
use scene::Aabb;
use tracer::bvh::cwbvh::{self, Cwbvh};
use tracer::bvh::lbvh::{Lbvh, LbvhBuilder};
use tracer::{LightList, RadianceCache, Search, World};
use voxel::{VoxelGrid, Voxelizer};

/// The structures that stand, and what builds them.
pub struct Searches {
    voxelizer: Voxelizer,
    lbvh_builder: LbvhBuilder,
    grid: Option<VoxelGrid>,
    lbvh: Option<Lbvh>,
    cwbvh: Option<Cwbvh>,
    lbvh_moved: bool,
    grid_lights: Option<LightList>,
    cache: Option<RadianceCache>,
    triangle_lights: Option<LightList>,
}

/// What a structure is built of.
#[derive(Clone, Copy)]
pub struct Site<'a> {
    /// Materials.
    pub scene: &'a GpuScene,
    /// The triangles, tessellated.
    pub mesh: &'a GpuMesh,
    /// Box around every pose, m.
    pub bounds: Aabb,
    /// Cells on the longest axis.
    pub grid: u32,
    /// Voxels keep radiance.
    pub cache: bool,
}

impl Searches {
    /// Builds nothing yet.
    ///
    /// # Errors
    /// The driver refuses a kernel.
    pub fn new(gpu: &Gpu, scene: &GpuScene) -> Result<Self, Error> {
        Ok(Self {
            voxelizer: Voxelizer::new(gpu, scene)?,
            lbvh_builder: LbvhBuilder::new(gpu, scene)?,
            grid: None,
            lbvh: None,
            cwbvh: None,
            lbvh_moved: false,
            grid_lights: None,
            cache: None,
            triangle_lights: None,
        })
    }

    /// Settings of the grid.
    pub fn knobs(&mut self) -> Vec<Knob<'_>> {
        self.voxelizer.knobs()
    }

    /// The voxels, once they were asked for.
    pub fn grid(&self) -> Option<&VoxelGrid> {
        self.grid.as_ref()
    }

    /// Another number of cells or another setting of the voxelizer: the grid is built anew when it is asked for.
    pub fn forget_grid(&mut self) {
        self.grid = None;
        self.grid_lights = None;
        self.cache = None;
    }

    /// Triangles moved: what depends on their places is built anew, or refitted, when it is asked for.
    pub fn moved(&mut self) {
        self.forget_grid();
        self.cwbvh = None;
        self.lbvh_moved = true;
        self.triangle_lights = None;
    }

    /// Makes sure that `what` stands. Submits what is recorded so far where building has to wait for it. The log has what
    /// did not go through the recorder.
    ///
    /// # Errors
    /// It does not fit the adapter.
    pub fn build(
        &mut self,
        recorder: &mut Recorder<'_>,
        what: Search,
        site: Site<'_>,
    ) -> Result<FrameLog, Error> {
        let gpu = recorder.gpu();
        let mut log = FrameLog::default();
        match what {
            Search::Grid if self.grid.is_none() => {
                recorder.flush();
                let (grid, of_grid) =
                    self.voxelizer.voxelize(gpu, site.scene, site.mesh, site.bounds, site.grid)?;
                self.grid = Some(grid);
                log = of_grid;
            }
            Search::Lbvh => match &mut self.lbvh {
                None => self.lbvh = Some(self.lbvh_builder.build(recorder, site.mesh)?),
                Some(lbvh) if self.lbvh_moved => self.lbvh_builder.refit(recorder, site.mesh, lbvh)?,
                Some(_) => {}
            },
            Search::Cwbvh if self.cwbvh.is_none() => {
                recorder.flush();
                let built = cwbvh::build(gpu, site.scene, site.mesh, cwbvh::Quality::default())?;
                log.counts.insert("bvh_build_cpu_ms".into(), built.build_ms);
                self.cwbvh = Some(built);
            }
            Search::Grid | Search::Cwbvh => {}
        }
        if what == Search::Lbvh {
            self.lbvh_moved = false;
        }
        match (what, &self.grid) {
            (Search::Grid, Some(grid)) if self.grid_lights.is_none() => {
                self.grid_lights = Some(LightList::of_voxels(gpu, site.scene, grid)?);
            }
            (Search::Lbvh | Search::Cwbvh, _) if self.triangle_lights.is_none() => {
                // What tessellates may still be on its way.
                recorder.flush();
                self.triangle_lights = Some(LightList::of_triangles(gpu, site.scene, site.mesh)?);
            }
            _ => {}
        }
        match (what, &self.grid) {
            (Search::Grid, Some(grid)) if site.cache && self.cache.is_none() => {
                self.cache = Some(RadianceCache::new(gpu, grid)?);
            }
            _ => {}
        }
        Ok(log)
    }

    /// What tracers borrow.
    pub fn world<'a>(&'a self, scene: &'a GpuScene, mesh: &'a GpuMesh) -> World<'a> {
        World {
            scene,
            mesh,
            grid: self.grid.as_ref(),
            lbvh: self.lbvh.as_deref(),
            cwbvh: self.cwbvh.as_ref().map(|built| &built.bvh),
            grid_lights: self.grid_lights.as_ref(),
            cache: self.cache.as_ref(),
            triangle_lights: self.triangle_lights.as_ref(),
        }
    }
}
