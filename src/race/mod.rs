//! Races voxels against BVHs over the same rays, tracing alone.
//!
//! In: a [`Pipeline`] with a view. Out: rays per second and visits per ray of the voxel grid, the wide BVH and the BVH
//! built on the GPU, for the view's primary rays and for the secondary rays that start where they end, apart.
//!
//! **Fairness.** All three get the same rays, so all start where voxel paths do: one elevation above the triangle. A BVH
//! could start on the triangle itself; then each structure would trace other rays, and the one elevation (about a voxel)
//! is small beside what a ray travels. All answer the same question: what is nearest, and how far. None reads what is
//! stored about it: no record, no normal, no material.
//!
//! **Times** are those of the tracing dispatches by the adapter's clock; structures take turns, [`ROUNDS`] times after
//! one round to warm up, and the median counts. Visits are nodes of a BVH and steps through a grid: they compare a
//! structure with itself, not with another.

pub mod rays;
#[cfg(test)]
mod tests;

use crate::Error;
use crate::pipeline::Pipeline;
use frame::Gpu;
use glam::Vec2;
use rays::Normals;
use serde::{Deserialize, Serialize};
use tracer::bvh::{cwbvh, lbvh};
use tracer::rays::{Met, Ray, RayBatch};
use tracer::{Search, World};

/// Timed turns of each structure.
const ROUNDS: usize = 7;

/// What is raced, and the name of the tracer that searches it.
const STRUCTURES: [(Search, &str); 3] =
    [(Search::Grid, "voxel"), (Search::Cwbvh, "bvh_cwbvh"), (Search::Lbvh, "bvh_lbvh")];

/// Structures over the same rays.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RayRace {
    /// Cells on the longest axis of the grid that was raced.
    pub grid: u32,
    /// One ray per trace pixel.
    pub primary: Heat,
    /// One cosine-distributed ray from each point that a primary ray met.
    pub secondary: Heat,
}

/// One set of rays.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Heat {
    /// How many.
    pub rays: usize,
    /// The voxels first.
    pub entrants: Vec<Entrant>,
}

/// A structure and what it took.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Entrant {
    /// Name of the tracer that searches it.
    pub structure: String,
    /// Million rays per second; none where the adapter has no clock.
    pub mrays_per_s: Option<f64>,
    /// Its time over that of the voxels: how many times as fast voxels are.
    pub voxels_times_as_fast: Option<f64>,
    /// Nodes looked at or steps taken, mean.
    pub visits_per_ray: f64,
    /// Share of the rays that met something.
    pub hit_share: f64,
}

/// Kernels of all structures.
pub(crate) struct Batches([RayBatch; 3]);

impl Batches {
    pub(crate) fn new(gpu: &Gpu) -> Result<Self, Error> {
        Ok(Self([
            RayBatch::of_grid(gpu).map_err(frame::GpuError::from)?,
            RayBatch::of_bvh(gpu, cwbvh::WGSL).map_err(frame::GpuError::from)?,
            RayBatch::of_bvh(gpu, lbvh::WGSL).map_err(frame::GpuError::from)?,
        ]))
    }

    /// What each ray meets in the structure of this place in [`STRUCTURES`], and how long it took, ms. A structure that
    /// was not built is met nowhere.
    fn trace(
        &self,
        gpu: &Gpu,
        world: World<'_>,
        k: usize,
        rays: &[Ray],
    ) -> Result<(Vec<Met>, Option<f64>), Error> {
        let resources = tracer::rays::resources(world, STRUCTURES[k].0);
        let Some(resources) = resources else { return Ok((Vec::new(), None)) };
        let traced = self.0[k].closest(gpu, &resources, rays)?;
        Ok((traced.answers, traced.gpu_ms))
    }

    /// Voxels along each ray.
    pub(crate) fn voxels(&self, gpu: &Gpu, world: World<'_>, rays: &[Ray]) -> Result<Vec<Met>, Error> {
        Ok(self.trace(gpu, world, 0, rays)?.0)
    }

    /// Triangles along each ray.
    pub(crate) fn triangles(&self, gpu: &Gpu, world: World<'_>, rays: &[Ray]) -> Result<Vec<Met>, Error> {
        Ok(self.trace(gpu, world, 1, rays)?.0)
    }

    fn heat(&self, gpu: &Gpu, world: World<'_>, rays: &[Ray]) -> Result<Heat, Error> {
        let mut times: [Vec<Option<f64>>; 3] = Default::default();
        let mut met: [Vec<Met>; 3] = Default::default();
        for round in 0..=ROUNDS {
            for k in 0..STRUCTURES.len() {
                let (answers, ms) = self.trace(gpu, world, k, rays)?;
                met[k] = answers;
                // The first round warms up.
                if round > 0 {
                    times[k].push(ms);
                }
            }
        }
        let medians = times.map(median);
        let entrants = STRUCTURES.iter().zip(&met).zip(medians).map(|(((_, name), met), ms)| {
            let mean = |of: fn(&Met) -> f64| met.iter().map(of).sum::<f64>() / met.len().max(1) as f64;
            Entrant {
                structure: (*name).into(),
                mrays_per_s: ms.filter(|ms| *ms > 0.0).map(|ms| rays.len() as f64 / (1e3 * ms)),
                voxels_times_as_fast: ms
                    .zip(medians[0])
                    .filter(|(_, own)| *own > 0.0)
                    .map(|(ms, own)| ms / own),
                visits_per_ray: mean(|met| met.visits.into()),
                hit_share: mean(|met| f64::from(u8::from(met.is_hit()))),
            }
        });
        Ok(Heat { rays: rays.len(), entrants: entrants.collect() })
    }
}

/// None where a time is not known.
fn median(times: Vec<Option<f64>>) -> Option<f64> {
    let mut times = times.into_iter().collect::<Option<Vec<f64>>>()?;
    times.sort_by(f64::total_cmp);
    times.get(times.len() / 2).copied()
}

/// Builds what is missing and races over the rays of the pipeline's view, at its grid.
///
/// # Errors
/// A structure cannot be built, or the device was lost.
pub fn run(pipeline: &mut Pipeline) -> Result<RayRace, Error> {
    pipeline.progress().report("racing rays", 0.0);
    let grid = pipeline.settings().grid;
    let batches = Batches::new(pipeline.gpu())?;
    pipeline.with_world(&STRUCTURES.map(|(search, _)| search), |gpu, frame, world| {
        let first = rays::primary(frame, Vec2::ZERO);
        let met = batches.triangles(gpu, world, &first)?;
        let normals = Normals::read(gpu, world.mesh)?;
        let voxel_size = world.grid.map_or(0.0, |grid| grid.voxel_size);
        let second = rays::secondary(frame, &first, &met, &normals, voxel_size);
        Ok(RayRace {
            grid,
            primary: batches.heat(gpu, world, &first)?,
            secondary: batches.heat(gpu, world, &second)?,
        })
    })
}
