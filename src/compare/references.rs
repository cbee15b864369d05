//! What errors are measured against: converged images, found in the cache or made.

use super::plan::traces_voxels;
use super::sequence::Pair;
use super::{Color, Comparison, frames};
use crate::pipeline::Pipeline;
use crate::reference;
use crate::report::{Picture, Reference, ReferenceInfo};
use crate::{Error, Progress, RenderSettings, metrics, output};
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use tracer::Search;

/// The references of one comparison.
pub struct References {
    /// Triangles, in the last frame.
    pub bvh: Color,
    /// Voxels, by grid, in the last frame.
    pub voxel: HashMap<u32, Color>,
    /// How good they are.
    pub infos: Vec<ReferenceInfo>,
    /// Their files.
    pub pictures: Vec<Picture>,
    /// Two of every frame, by structure (voxels of a grid, or triangles); none where everything stands still.
    frames: Option<HashMap<Option<u32>, Vec<Pair>>>,
}

impl References {
    /// Converges, or finds in the cache, triangles and the voxels of every grid that is compared.
    ///
    /// # Errors
    /// A reference does not converge, or a file cannot be written.
    pub fn converge(
        comparison: &Comparison,
        combinations: &[RenderSettings],
        pipeline: &mut Pipeline,
        progress: &Progress,
    ) -> Result<Self, Error> {
        let out = &comparison.out;
        let mut infos = Vec::new();
        let mut pictures = Vec::new();
        let mut converged =
            |pipeline: &mut Pipeline, kind: Reference, grid: Option<u32>| -> Result<Color, Error> {
                let name = grid.map_or("reference_bvh".into(), |grid| format!("reference_voxel_{grid}"));
                progress.report(&format!("converging {name}"), 0.0);
                let search = if kind == Reference::Voxel { Search::Grid } else { Search::Cwbvh };
                let key = reference::key(pipeline, search);
                let folder = comparison.cache.join(reference::key_name(&key));
                let found = reference::run(pipeline, search, comparison.goal, &folder)?;
                let file = format!("{name}.exr");
                output::color_exr(&out.join(&file), &found.mean)?;
                let png = format!("{name}.png");
                output::color_png(&out.join(&png), &found.mean, comparison.exposure)?;
                pictures.push(Picture { id: name, reference: true, file: png, heat: None });
                infos.push(ReferenceInfo {
                    kind,
                    grid,
                    spp: u32::try_from(found.summary.spp).unwrap_or(u32::MAX),
                    noise_rel_mse: Some(found.summary.noise_rel_mse),
                    gap_rmse: None,
                    file,
                });
                Ok(found.mean)
            };
        let still = pipeline.stands_still(comparison.frames)?;
        // What stands still looks the same at every moment, and is found in the cache whatever the number of frames.
        let end = |settings: &RenderSettings| match still {
            true => settings.clone(),
            false => settings.at_frame(comparison.frames.saturating_sub(1)),
        };
        if let Some(first) = combinations.first() {
            pipeline.change(&end(first))?;
        }
        let bvh = converged(pipeline, Reference::Bvh, None)?;
        let mut voxel = HashMap::new();
        for settings in combinations.iter().filter(|s| traces_voxels(&s.tracer)) {
            if voxel.contains_key(&settings.grid) {
                continue;
            }
            pipeline.change(&end(settings))?;
            voxel.insert(settings.grid, converged(pipeline, Reference::Voxel, Some(settings.grid))?);
        }
        for info in infos.iter_mut().filter(|info| info.kind == Reference::Voxel) {
            if let Some(voxel) = info.grid.and_then(|grid| voxel.get(&grid)) {
                info.gap_rmse = metrics::rmse(&bvh, voxel).ok();
            }
        }
        let mut pairs = (!still).then(HashMap::new);
        if let (Some(pairs), 1..) = (&mut pairs, comparison.temporal_spp) {
            for settings in combinations {
                if let Entry::Vacant(missing) = pairs.entry(structure(settings)) {
                    missing.insert(frames::converge(comparison, settings, pipeline, progress)?);
                }
            }
        }
        Ok(Self { bvh, voxel, infos, pictures, frames: pairs })
    }

    /// Those of every frame that a configuration is watched with; an empty list where all stands still, none where its
    /// flicker is not measured.
    pub fn of_frames(&self, settings: &RenderSettings) -> Option<&[Pair]> {
        match &self.frames {
            None => Some(&[]),
            Some(frames) => frames.get(&structure(settings)).map(Vec::as_slice),
        }
    }
}

/// What a row's own references are traced through: voxels of a grid, or triangles.
fn structure(settings: &RenderSettings) -> Option<u32> {
    traces_voxels(&settings.tracer).then_some(settings.grid)
}
