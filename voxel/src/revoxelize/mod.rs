//! Moving things: per frame only the bricks that moving triangles touch in this frame, or touched in the last, are made
//! anew.
//!
//! Paper: "only re-voxelize dynamic segments".
//!
//! In: the grid of what stands still and the winner of each of its voxels ([`Rest`]); the mesh of this frame (world, m).
//! Out: the same grid with the moving triangles in it; cell by cell what a build of the whole mesh would give.
//!
//! - **Two pools**: bricks of what stands still keep their slots and records, which never move. A brick that a moving
//!   triangle touches gets one of the slots behind them, in the order of brick cells, and 512 records there, enough for
//!   every cell. The table points to the one or the other; leaving is a pointer back, to the brick beneath or to nothing.
//!   Bricks of last frame that nothing touches any more cost a word of the table.
//! - **Winners**: a slot begins with the keys of what stands still, 4 bytes per voxel kept from the build, and the moving
//!   triangles vote against them. The key is the same total order as in a build and its minimum does not ask who came
//!   first; so no history can show. (Lists of triangles per brick, the other way to have them, would be drawn anew each
//!   frame; the keys are less: at 512 cells Sponza's are 8.6 MB, and nothing where nothing moves.)
//! - **Bends** ([`crate::bend`]): a slot begins with those of what stands still, a bit per cell kept from the build. Cells
//!   that a moving triangle won are bent where anything stands still in them; then only the moving triangles are compared
//!   with the winners. A build finds the same, because what moves and what stands still are never one surface.
//! - **All else is shared**: masks, scan, list, factors of emitters and resolve are those of the build, over these bricks.
//! - **Waiting**: the number of bricks sizes the dispatches. It is asked for by [`Voxelizer::mark_moving`] and awaited by
//!   [`Voxelizer::revoxelize`]: whoever has other work for the device records it in between. Nothing else is read back,
//!   but where an emitter moves: its factor is counted on the CPU, as in a build.
//! - **Growing**: where slots are too few, both pools move to buffers with a quarter to spare, before anything is written.
//!   What does not fit a binding is an error.
//!
//! Moving triangles that reach outside the grid are clipped, and counted in `clipped_triangles`.

mod passes;
mod rest;
#[cfg(test)]
mod tests;

pub(crate) use passes::Revoxelizer;
pub use rest::Rest;

use crate::cover::Found;
use crate::emitters::{Emitters, Factors};
use crate::grid::BRICK_CELLS;
use crate::raster::Input;
use crate::structure::{Batch, Sums};
use crate::{VoxelError, VoxelGrid, Voxelizer};
use frame::Recorder;
use frame::scene_gpu::{GpuMesh, GpuScene};
use glam::IVec3;
use rest::{Marked, Scratch};
use std::ops::Range;

/// Bricks whose keys, lists and records are on their way at a time: 8 MB of keys.
const MOST_SLOTS: u32 = 4096;

const STAGE: &str = "voxel/revoxelize";

impl Voxelizer {
    /// Whether a grid of a mesh can be made from the one of which this stands still.
    pub fn can_follow(&self, rest: &Rest, mesh: &GpuMesh) -> bool {
        self.follows(mesh) && rest.static_triangles == mesh.static_triangle_count
    }

    /// Finds the bricks that moving triangles touch, and asks for their number, which [`Voxelizer::revoxelize`] awaits.
    /// Submits what is recorded so far.
    ///
    /// # Errors
    /// Out of memory.
    pub fn mark_moving(
        &self,
        recorder: &mut Recorder<'_>,
        scene: &GpuScene,
        mesh: &GpuMesh,
        grid: &VoxelGrid,
        rest: &mut Rest,
    ) -> Result<(), VoxelError> {
        let brick_cells = rest.brick_cells();
        recorder.clear(&rest.marks);
        let input = self.moving(scene, mesh, grid, rest);
        let found = self.finders.mark(recorder, &self.structure, &input, brick_cells, &rest.marks)?;
        self.structure.scan(recorder, STAGE, &rest.marks, brick_cells, &rest.sums);
        recorder.flush();
        let total = Sums::total_word(brick_cells);
        rest.marked = Some(Marked::ask(recorder.gpu(), &rest.sums.blocks, total, found)?);
        Ok(())
    }

    /// Puts the moving triangles of this frame into a grid, whose buffers may become others, and takes those of the last
    /// one out. The frame's log gets, beside what [`Rest::settle`] makes of it, `dirty_bricks`, the bricks that moving
    /// triangles touch in this frame or touched in the last, and `clipped_triangles`.
    ///
    /// # Errors
    /// The bricks they touch do not fit the device.
    pub fn revoxelize(
        &self,
        recorder: &mut Recorder<'_>,
        scene: &GpuScene,
        mesh: &GpuMesh,
        grid: &mut VoxelGrid,
        rest: &mut Rest,
    ) -> Result<(), VoxelError> {
        let Some(revoxelizer) = &self.revoxelizer else { return Ok(()) };
        if rest.marked.is_none() {
            self.mark_moving(recorder, scene, mesh, grid, rest)?;
        }
        let gpu = recorder.gpu();
        let Some(marked) = rest.marked.take() else { return Ok(()) };
        let (moving_bricks, found) = marked.wait(gpu)?;
        rest.moving_bricks = moving_bricks;
        rest.grow(recorder, grid, rest.moving_bricks)?;
        let moves_light = rest.moves_light;
        let merged = match moves_light && !grid.contours {
            true => {
                let of_mesh = mesh.static_triangle_count..mesh.triangle_count;
                let counted = Emitters::count(gpu, scene, mesh, of_mesh, &rest.layout, self.cover())?;
                Emitters::factors(gpu, rest.counted.iter().chain(&counted))?
            }
            false => None,
        };
        let factors = if moves_light { &merged } else { &rest.factors };
        let Some(scratch) = &rest.scratch else { return Ok(()) };

        revoxelizer.slots(recorder, grid, rest, scratch);
        let shared = rest.layout.uniform(0);
        self.structure.skips(recorder, STAGE, &shared, &grid.uniform, &rest.marks, &grid.structure);
        revoxelizer.clip(recorder, mesh, grid, rest);
        rest.rounds.count(recorder);
        for first in (0..rest.moving_bricks).step_by(MOST_SLOTS as usize) {
            let slots = first..(first + MOST_SLOTS).min(rest.moving_bricks);
            self.moving_batch(
                recorder,
                revoxelizer,
                scene,
                mesh,
                grid,
                rest,
                scratch,
                &found,
                factors.as_ref(),
                slots,
            );
        }
        if moves_light {
            recorder.flush();
            grid.glowing = match factors {
                _ if grid.contours => Emitters::glowing_planes(gpu, &rest.layout, grid)?,
                Some(factors) => self.emitters.glowing(gpu, factors, grid)?,
                None => Vec::new(),
            };
        }
        Ok(())
    }

    fn moving<'a>(
        &self,
        scene: &'a GpuScene,
        mesh: &'a GpuMesh,
        grid: &'a VoxelGrid,
        rest: &'a Rest,
    ) -> Input<'a> {
        let triangles = mesh.static_triangle_count..mesh.triangle_count;
        let (uniform, target, cover) = (&grid.uniform, &rest.target, self.cover());
        let (bend, kept) = (self.bend(), [IVec3::ZERO; 2]);
        Input { stage: STAGE, scene, mesh, triangles, uniform, target, cover, bend, kept }
    }

    /// Winners and records of a run of slots of the second pool.
    fn moving_batch(
        &self,
        recorder: &mut Recorder<'_>,
        revoxelizer: &Revoxelizer,
        scene: &GpuScene,
        mesh: &GpuMesh,
        grid: &VoxelGrid,
        rest: &Rest,
        scratch: &Scratch,
        found: &Found,
        factors: Option<&Factors>,
        moving_slots: Range<u32>,
    ) {
        let count = moving_slots.len() as u32;
        let slots = rest.brick_count + moving_slots.start..rest.brick_count + moving_slots.end;
        let first_record = rest.first_moving_record() + BRICK_CELLS * moving_slots.start;
        let (uniform, structure) = (&grid.uniform, &grid.structure);
        revoxelizer.keys(recorder, grid, rest, scratch, slots.clone());
        let input = self.moving(scene, mesh, grid, rest);
        self.finders.vote(recorder, &input, found, structure, slots.clone(), &scratch.keys, &rest.rounds);
        revoxelizer.bends(recorder, mesh, grid, rest, scratch, slots.clone());
        self.finders.bend(recorder, &input, found, structure, slots.clone(), &scratch.keys, &scratch.bends);
        let batch = Batch { stage: STAGE, uniform, structure, slots: slots.clone() };
        self.structure.masks(recorder, &batch, &scratch.keys, &scratch.bricks, &scratch.counts);
        self.structure.scan(recorder, STAGE, &scratch.counts, count, &scratch.sums);
        self.structure.list(recorder, &batch, first_record, &scratch.sums, &scratch.list);
        if let Some(factors) = factors {
            let records = first_record..first_record + BRICK_CELLS * count;
            self.emitters.record(recorder, factors, &batch, records, &scratch.list);
        }
        revoxelizer.size(recorder, rest, scratch, slots);
        let mut resources = vec![scratch.resolve.as_entire_binding()];
        resources.extend(mesh.resources());
        resources.extend(scene.material_resources());
        let read = [uniform, &scratch.keys, &scratch.bricks, &scratch.list, &scratch.bends];
        resources.extend(read.map(|b| b.as_entire_binding()));
        resources.push(wgpu::BindingResource::Buffer(wgpu::BufferBinding {
            buffer: &grid.records,
            offset: grid.record.bytes() * u64::from(first_record),
            size: None,
        }));
        let pass = format!("{STAGE}/resolve");
        recorder.compute_indirect(&pass, &self.resolve, &resources, &scratch.groups, 0);
    }
}
