//! Paths through the voxel grid.
//!
//! Paper: "uni-directional path tracing begins as a post-process at one voxel above the surface. This elevation is
//! performed using world space face normals to avoid self occlusion" (section 2).
//!
//! In: the G-buffer, the grid (world positions in metres), sky and lights. Out: demodulated radiance in two lobes.
//! Formulas: [`crate::path`]; what a ray meets is [`voxel::GRID_WGSL`]'s exact traversal.
//!
//! Departs from the paper: the elevation is h(n) of the design's 4.5 instead of one voxel, which lets 1.25 % of starts
//! lie in the surface's own voxels (knob `voxel.elevation`); in a corner, where that is inside the next wall, a path
//! starts between the surface and the viewer, where the camera ray has shown that nothing is. A path that leaves or passes
//! a voxel starts at that voxel's face. It takes along a point of the side it is on ([`voxel::grid`], "Sides"): for a pixel
//! that is a point towards the viewer, after a voxel the empty cell in front of it.

#[cfg(test)]
mod reference;
#[cfg(test)]
mod tests;

use crate::path::{PathSettings, Paths, Searched, Structure};
use crate::{Search, Tracer, World};
use frame::scene_gpu::GpuScene;
use frame::{FrameInfo, GBuffer, Gpu, GpuError, Knob, RadianceImage, Recorder, Uniform};
use voxel::{RecordLayout, VoxelGrid};

const HIT_WGSL: &str = include_str!("voxel_hit.inc.wgsl");

/// What a grid with such records brings to paths, or nested levels of it.
pub(crate) fn structure(record: RecordLayout, levels: bool) -> Structure {
    let (grid, trace, binds) = match levels {
        true => (voxel::LEVELS_WGSL, voxel::TRACE_LEVELS_WGSL, voxel::LEVELS_BINDS),
        false => (voxel::GRID_WGSL, voxel::TRACE_WGSL, voxel::GRID_BINDS),
    };
    let mut sources = vec![grid];
    sources.extend(record.sources());
    sources.extend([trace, HIT_WGSL]);
    Structure { pass: "trace/voxel", sources, binds: binds.to_vec(), of_triangles: false }
}

/// Most iterations of one ray. It never turns back, so that it crosses a level's cells once.
pub(crate) fn worst_case(grid: &VoxelGrid) -> u32 {
    // Levels are as large as the coarsest, or have the least cells that they may.
    let cells = grid.cells.iter().copied().max().unwrap_or(0).max(voxel::cascades::LEAST_CELLS);
    voxel::grid::STEPS_PER_CELL * cells * grid.levels
}

/// The id `voxel`.
pub struct VoxelTracer {
    paths: Paths,
}

impl Default for VoxelTracer {
    fn default() -> Self {
        Self { paths: Paths::new(structure(RecordLayout::FULL, false)) }
    }
}

impl Tracer for VoxelTracer {
    fn name(&self) -> &'static str {
        "voxel"
    }

    fn knobs(&mut self) -> Vec<Knob<'_>> {
        Vec::new()
    }

    fn search(&self) -> Search {
        Search::Grid
    }

    fn resize(
        &mut self,
        gpu: &Gpu,
        scene: &GpuScene,
        size: [u32; 2],
        paths: &PathSettings,
    ) -> Result<(), GpuError> {
        self.paths.structure = structure(RecordLayout::of(&scene.needs), paths.build.levels);
        self.paths.resize(gpu, scene, size, paths)
    }

    fn trace(
        &mut self,
        recorder: &mut Recorder<'_>,
        frame: &FrameInfo,
        uniform: &Uniform,
        world: World<'_>,
        gbuffer: &GBuffer,
        paths: &PathSettings,
    ) -> RadianceImage {
        let (Some(grid), Some(lights)) = (world.grid, world.lights(Search::Grid)) else {
            unreachable!("the pipeline builds what every tracer says it searches");
        };
        let resources = grid.resources();
        let searched =
            Searched { resources: &resources, worst_case: worst_case(grid), lights, cache: world.cache };
        self.paths.trace(recorder, uniform, world.scene, searched, frame, gbuffer, paths)
    }
}
