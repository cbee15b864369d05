//! What rays search: the voxel grid and the BVHs, each built when the first tracer asks for it and kept, so that swapping
//! stages builds nothing twice. Where something moves, of the grid only the bricks it touches are made anew.

use crate::Error;
use frame::scene_gpu::{GpuMesh, GpuScene};
use frame::{Buffer, FrameLog, Gpu, Knob, Recorder};
use glam::Vec3;
use scene::Aabb;
use tracer::bvh::cwbvh::{self, Cwbvh};
use tracer::bvh::lbvh::{Lbvh, LbvhBuilder};
use tracer::{LightList, RadianceCache, Search, World};
use voxel::{Cascades, Rest, VoxelError, VoxelGrid, Voxelizer};

/// The structures that stand, and what builds them.
pub struct Searches {
    voxelizer: Voxelizer,
    lbvh_builder: LbvhBuilder,
    grid: Option<VoxelGrid>,
    /// What stands still in the grid, where not all does.
    rest: Option<Rest>,
    /// Its levels around the viewer, where it has any.
    cascades: Option<Cascades>,
    lbvh: Option<Lbvh>,
    cwbvh: Option<Cwbvh>,
    grid_moved: bool,
    lbvh_moved: bool,
    grid_lights: Option<LightList>,
    cache: Option<RadianceCache>,
    triangle_lights: Option<LightList>,
    /// The triangles they were built of.
    triangles: Option<Buffer>,
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
    /// Where the viewer is, m.
    pub eye: Vec3,
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
            rest: None,
            cascades: None,
            lbvh: None,
            cwbvh: None,
            grid_moved: false,
            lbvh_moved: false,
            grid_lights: None,
            cache: None,
            triangle_lights: None,
            triangles: None,
        })
    }

    /// Settings of the grid.
    pub fn knobs(&mut self) -> Vec<Knob<'_>> {
        self.voxelizer.knobs()
    }

    /// Whether voxels are in nested levels.
    pub fn has_levels(&self) -> bool {
        self.voxelizer.cascades() > 1
    }

    /// The voxels, once they were asked for.
    pub fn grid(&self) -> Option<&VoxelGrid> {
        self.grid.as_ref()
    }

    /// Another number of cells or another setting of the voxelizer: the grid is built anew when it is asked for.
    pub fn forget_grid(&mut self) {
        self.grid = None;
        self.rest = None;
        self.cascades = None;
        self.grid_lights = None;
        self.cache = None;
    }

    /// Triangles moved: what depends on their places is built anew, refitted, or made anew where they are or were, when
    /// it is asked for.
    pub fn moved(&mut self) {
        match self.rest {
            Some(_) => self.grid_moved = true,
            None => self.forget_grid(),
        }
        self.cwbvh = None;
        self.lbvh_moved = true;
        self.triangle_lights = None;
    }

    /// Begins to look for what moved in the grid, so that [`Searches::build`] need not wait for it if there is other work
    /// for the device in between. Submits what is recorded so far.
    ///
    /// # Errors
    /// Out of memory.
    pub fn find_moving(
        &mut self,
        recorder: &mut Recorder<'_>,
        what: Search,
        site: Site<'_>,
    ) -> Result<(), Error> {
        self.recognise(site);
        if self.rest.as_ref().is_some_and(|rest| !self.voxelizer.can_follow(rest, site.mesh)) {
            self.forget_grid();
        }
        if let (Search::Grid, true, Some(grid), Some(rest)) =
            (what, self.grid_moved, &self.grid, &mut self.rest)
        {
            self.voxelizer.mark_moving(recorder, site.scene, site.mesh, grid, rest)?;
        }
        Ok(())
    }

    /// Takes over what a frame counted, once it is done.
    pub fn settle(&mut self, log: &mut FrameLog) {
        if let (Some(grid), Some(rest)) = (&mut self.grid, &self.rest) {
            rest.settle(grid, log);
        }
    }

    /// A tessellator says by other buffers that it made another mesh: then nothing that stands is of use.
    fn recognise(&mut self, site: Site<'_>) {
        if self.triangles.as_ref().is_some_and(|known| **known != *site.mesh.triangles) {
            self.forget_grid();
            self.lbvh = None;
            self.cwbvh = None;
            self.triangle_lights = None;
        }
        self.triangles = Some(site.mesh.triangles.clone());
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
        self.recognise(site);
        match what {
            Search::Grid => {
                if site.cache && self.has_levels() {
                    return Err(VoxelError::CascadedCache { cascades: self.voxelizer.cascades() }.into());
                }
                if self.grid.is_none() {
                    recorder.flush();
                    log = self.build_grid(gpu, site)?;
                } else if let (Some(grid), Some(cascades)) = (&mut self.grid, &mut self.cascades) {
                    if cascades.moves(site.eye) {
                        recorder.flush();
                    }
                    let (scene, mesh) = (site.scene, site.mesh);
                    if let Some(moved) = self.voxelizer.follow(gpu, scene, mesh, grid, cascades, site.eye)? {
                        self.grid_lights = None;
                        log = moved;
                    }
                }
                if let (true, Some(grid), Some(rest)) = (self.grid_moved, &mut self.grid, &mut self.rest) {
                    self.voxelizer.revoxelize(recorder, site.scene, site.mesh, grid, rest)?;
                    if rest.moves_light() {
                        self.grid_lights = None;
                    }
                    match &self.cache {
                        Some(cache) if cache.is_for(grid) => {
                            cache.forget_from(recorder, rest.first_moving_record())
                        }
                        _ => self.cache = None,
                    }
                }
                self.grid_moved = false;
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
            Search::Cwbvh => {}
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

    /// The whole grid, or what stands still of it.
    fn build_grid(&mut self, gpu: &Gpu, site: Site<'_>) -> Result<FrameLog, Error> {
        let Site { scene, mesh, bounds, grid, eye, .. } = site;
        let (grid, log) = if self.has_levels() {
            let (grid, cascades, log) =
                self.voxelizer.voxelize_levels(gpu, scene, mesh, bounds, grid, eye)?;
            self.cascades = Some(cascades);
            (grid, log)
        } else if self.voxelizer.follows(mesh) {
            let (grid, rest, log) = self.voxelizer.voxelize_rest(gpu, scene, mesh, bounds, grid)?;
            (self.rest, self.grid_moved) = (Some(rest), true);
            (grid, log)
        } else {
            self.voxelizer.voxelize(gpu, scene, mesh, bounds, grid)?
        };
        self.grid = Some(grid);
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
