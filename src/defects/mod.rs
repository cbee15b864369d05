//! What voxels get wrong, in six figures: the defect score of a scene and a grid.
//!
//! In: a [`Pipeline`] with a view. Out: a [`Defects`] for its grid. Silhouettes, missed cells and flicker compare what
//! single rays meet among voxels and among triangles, no paths traced; brightness compares two small renders of the
//! view; the leak is measured in boxes of its own ([`leak`]), for few scenes have a place that no light can reach.
//!
//! Rays are those of the race ([`crate::race::rays`]): one per trace pixel, and one from each point that they meet.

pub mod leak;
mod rays;
#[cfg(test)]
mod tests;

use crate::pipeline::Pipeline;
use crate::race::Batches;
use crate::race::rays::{Normals, primary, secondary};
use crate::{Error, RenderSettings, output};
use frame::cpu::luminance;
use glam::Vec2;
use rays::{Pair, flicker_voxels, missed_per_million, silhouette_error};
use serde::{Deserialize, Serialize};
use tracer::Search;
use tracer::rays::{Met, Ray};

/// Paths per pixel of the renders that brightness is measured on: the mean over all pixels hardly needs more.
const SPP: u32 = 2;
/// A camera step, trace pixels.
const STEP: Vec2 = Vec2::new(0.25, 0.0);

/// The voxels' defects; 0, and 1 for brightness, is flawless.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Defects {
    /// Cells on the longest axis.
    pub grid: u32,
    /// Radiance inside closed boxes over radiance of their lit outside, ratio, for walls of one, two and three voxels
    /// ([`leak`]); the same for every scene and grid, for the boxes bring their own.
    pub leaked: [f64; 3],
    /// Share of the view's rays, 0..1, for which triangles and voxels disagree whether there is anything, or
    /// meet it more than two voxels apart along the triangle's normal.
    pub silhouette_error: f64,
    /// Mean luminance of a render through voxels over one through triangles, ratio, at half the grid and at the grid: two
    /// paths per pixel, no filter.
    pub brightness: [f64; 2],
    /// Of a million rays that meet a triangle, how many meet no voxel up to two voxels behind it, along its normal: rays
    /// of the view and rays that go on from what it sees. Triangles count as solid, so that holes of masks are missed, too.
    pub missed_per_million: f64,
    /// Mean change of a ray's voxel distance beyond that of its triangle distance when the camera turns by a quarter of a
    /// pixel, voxels; jumps count as at most two, and rays whose triangle jumps are left out.
    pub flicker_voxels: f64,
}

/// Measures all of them for the pipeline's view and grid, and leaves the pipeline as it was, restarted.
///
/// # Errors
/// A structure cannot be built, or the device was lost.
pub fn run(pipeline: &mut Pipeline) -> Result<Defects, Error> {
    let settings = pipeline.settings().clone();
    pipeline.progress().report("measuring defects", 0.0);
    let batches = Batches::new(pipeline.gpu())?;
    let (silhouette_error, missed_per_million, flicker_voxels) =
        pipeline.with_world(&[Search::Grid, Search::Cwbvh], |gpu, frame, world| {
            let voxel_size = world.grid.map_or(1.0, |grid| grid.voxel_size);
            let normals = Normals::read(gpu, world.mesh)?;
            let pairs = |rays: &[Ray]| -> Result<Vec<Pair>, Error> {
                let voxels = batches.voxels(gpu, world, rays)?;
                let triangles = batches.triangles(gpu, world, rays)?;
                let all = rays.iter().zip(&triangles).zip(&voxels);
                let pair = |((ray, triangle), voxel): ((&Ray, &Met), &Met)| {
                    let normal = normals.towards(ray, triangle);
                    let cosine = normal.map_or(1.0, |n| n.dot(ray.direction.into()).abs());
                    Pair::new(triangle, voxel, cosine, voxel_size)
                };
                Ok(all.map(pair).collect())
            };
            let seen = primary(frame, Vec2::ZERO);
            let met = batches.triangles(gpu, world, &seen)?;
            let on = pairs(&secondary(frame, &seen, &met, &normals, voxel_size))?;
            let (before, after) = (pairs(&seen)?, pairs(&primary(frame, STEP))?);
            Ok((
                silhouette_error(&before),
                missed_per_million(&[&before[..], &on].concat()),
                flicker_voxels(&before, &after),
            ))
        })?;
    let brightness = brightness(pipeline, &settings)?;
    let leaked = leak::run(pipeline.gpu(), &settings)?;
    pipeline.change(&settings)?;
    Ok(Defects {
        grid: settings.grid,
        leaked,
        silhouette_error,
        brightness,
        missed_per_million,
        flicker_voxels,
    })
}

/// Without a filter, and without the knobs of what then takes no part.
fn plain(settings: &RenderSettings, tracer: &str) -> RenderSettings {
    let stays = |id: &str| ["voxel", "gather", "tracer", &settings.tessellator].contains(&id);
    RenderSettings {
        tracer: tracer.into(),
        denoiser: "identity".into(),
        upsampler: "nearest".into(),
        spp: SPP,
        sets: settings.sets.iter().filter(|set| stays(&set.id)).cloned().collect(),
        ..settings.clone()
    }
}

/// Voxels over triangles at half the grid and at the grid; 1 where triangles are black.
fn brightness(pipeline: &mut Pipeline, settings: &RenderSettings) -> Result<[f64; 2], Error> {
    let triangles = luminance_of(pipeline, &plain(settings, "bvh_cwbvh"))?;
    let mut ratio = |grid| -> Result<f64, Error> {
        let voxels = luminance_of(pipeline, &RenderSettings { grid, ..plain(settings, "voxel") })?;
        Ok(if triangles > 0.0 { voxels / triangles } else { 1.0 })
    };
    // A grid has no fewer than five cells.
    Ok([ratio((settings.grid / 2).max(5))?, ratio(settings.grid)?])
}

/// Mean luminance of the first frame.
fn luminance_of(pipeline: &mut Pipeline, settings: &RenderSettings) -> Result<f64, Error> {
    pipeline.change(settings)?;
    let rendered = pipeline.render()?;
    let picture = output::color(pipeline.gpu(), &rendered.color, rendered.frame.radiance_scale)?;
    let sum: f64 = picture.texels().iter().map(|texel| f64::from(luminance(*texel))).sum();
    Ok(sum / picture.texels().len().max(1) as f64)
}
