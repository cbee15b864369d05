//! Settings of the voxelizer, and what follows from them.

use super::Voxelizer;
use crate::bend::Bend;
use crate::grid::LEVELS;
use crate::raster::Axes;
use crate::{Cover, Grid, VoxelGrid};
use frame::{Gpu, Knob};

impl Voxelizer {
    /// Settings.
    pub fn knobs(&mut self) -> Vec<Knob<'_>> {
        vec![
            Knob::choice(
                "elevation",
                &mut self.elevation,
                &["normal", "voxel"],
                "How far above a surface paths start. `normal`: (|n|_1 + |n|_inf) / 2 voxels along the face normal n, \
                 the least that clears the surface's own voxels (1 to 1.23; derived). `voxel`: one voxel, as the paper \
                 says; 1.25 % of starts then lie inside their own surface.",
            ),
            Knob::choice(
                "voxelizer",
                &mut self.voxelizer,
                &["raster", "compute"],
                "Who finds the cells of a triangle. `raster`: the rasterizer, as in the paper. `compute`: tests of boxes \
                 against triangles, binned to bricks.",
            ),
            Knob::choice(
                "cover",
                &mut self.cover,
                &["auto", "thin", "conservative"],
                "Which cells those are. `thin`: enough to stop a ray. `conservative`: all that a triangle passes, 1.8 \
                 times as many. `auto`: conservative with contours, thin without.",
            ),
            Knob::choice(
                "contours",
                &mut self.contours,
                &["off", "on"],
                "What a ray meets of a voxel. `off`: its cube. `on`: the plane of its surface (Laine and Karras 2010), \
                 which needs conservative voxels of the rasterizer; normal maps are left out.",
            ),
            Knob::choice(
                "axes",
                &mut self.axes,
                &["all", "dominant"],
                "Axes that triangles are projected along. `all` closes closed surfaces and draws three times as many \
                 triangles. `dominant` is the paper's; some 0.4 % of rays leave a sphere of radius 44 voxels (measured).",
            ),
            Knob::choice(
                "rebuild",
                &mut self.rebuild,
                &["moving", "all"],
                "What of the grid is made anew when something moves. `moving`: the bricks that moving triangles touch, or \
                 touched in the frame before. `all`: every brick; the voxels are the same, the time is not.",
            ),
            Knob::int(
                "cascades",
                &mut self.cascades,
                1..=LEVELS,
                "levels",
                "Grids around the viewer, each with voxels half as large as those of the one around it; the outermost is \
                 the whole scene. 1: that alone. Found by `compute`, without contours.",
            ),
        ]
    }

    pub(crate) fn cover(&self) -> Cover {
        let voxelizer = if self.cascades > 1 { 1 } else { self.voxelizer };
        match (voxelizer, self.is_conservative(), self.axes) {
            (0, false, 0) => Cover::Columns(Axes::All),
            (0, false, _) => Cover::Columns(Axes::Dominant),
            (0, true, _) => Cover::Boxes,
            (_, false, _) => Cover::Thin,
            (_, true, _) => Cover::Conservative,
        }
    }

    fn is_conservative(&self) -> bool {
        self.cover == 2 || (self.cover == 0 && self.contours == 1)
    }

    pub(crate) fn bend(&self) -> Bend {
        Bend::of(self.contours == 1)
    }

    /// Hands settings that need no new voxels to a grid.
    pub fn apply_knobs(&self, gpu: &Gpu, grid: &VoxelGrid) {
        gpu.queue.write_buffer(
            &grid.uniform,
            std::mem::offset_of!(Grid, elevation) as u64,
            bytemuck::bytes_of(&self.elevation()),
        );
    }

    /// As shaders have it.
    pub(crate) fn elevation(&self) -> u32 {
        if self.elevation == 0 && self.is_conservative() { 2 } else { self.elevation }
    }
}
