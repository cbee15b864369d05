//! The passes that only moving frames have: slots, keys to begin with, and how much the resolve has to do.

use super::rest::{COUNTERS, Rest, Scratch};
use crate::grid::GRID_WGSL;
use crate::revoxelize::STAGE;
use crate::structure::{Sums, rows};
use crate::{Grid, VoxelGrid};
use frame::scan::SCAN_WGSL;
use frame::scene_gpu::{GpuMesh, GpuScene, MESH_BINDS, MESH_WGSL};
use frame::{Bind, Buffer, Gpu, Kernel, KernelDesc, KernelError, Recorder, surface};
use std::ops::Range;

frame::gpu_struct! {
    /// See `revoxelize.wgsl`.
    pub struct RevoxelizeParams {
        /// Brick cells, bricks or voxels.
        pub count: u32,
        /// Of the second pool, or of the batch.
        pub first_slot: u32,
        /// Invocations per row of the dispatch.
        pub row: u32,
        /// Word that holds the sum of all.
        pub total_word: u32,
        /// The first triangle that moves.
        pub first_moving: u32,
        /// WGSL rounds uniforms up.
        pub _pad: [u32; 3],
    }
}

frame::gpu_struct! {
    /// See `clip.wgsl`.
    pub struct ClipParams {
        /// The first that moves.
        pub first_triangle: u32,
        /// Moving triangles.
        pub count: u32,
        /// Invocations per row of the dispatch.
        pub row: u32,
        /// WGSL rounds uniforms up.
        pub _pad: u32,
    }
}

/// The passes that only moving frames have.
pub(crate) struct Revoxelizer {
    slots: Kernel,
    keys: Kernel,
    bends: Kernel,
    keep: Kernel,
    size: Kernel,
    clip: Kernel,
}

impl Revoxelizer {
    pub(crate) fn new(gpu: &Gpu, scene: &GpuScene) -> Result<Self, KernelError> {
        let kernel = |entry, workgroup, bindings: &[Bind]| {
            let mut all = vec![Bind::uniform::<RevoxelizeParams>(0, 1, "params")];
            all.extend(bindings);
            Kernel::new(
                gpu,
                &KernelDesc {
                    name: entry,
                    sources: &[SCAN_WGSL, GRID_WGSL, include_str!("revoxelize.wgsl")],
                    entry,
                    workgroup: [workgroup, 1, 1],
                    bindings: &all,
                    constants: &[],
                },
            )
        };
        let grid = Bind::uniform::<Grid>(1, 18, "grid");
        let home = Bind::storage_read(2, 0, "in_home");
        let before = Bind::storage_read(2, 1, "in_before");
        let blocks = Bind::storage_read(2, 2, "in_blocks");
        let keys = Bind::storage_read(2, 3, "in_keys");
        let bricks = Bind::storage_read(2, 4, "in_bricks");
        let kept = Bind::storage_read(2, 5, "in_kept");
        let list = Bind::storage_read(2, 6, "in_list");
        let in_bends = Bind::storage_read(2, 7, "in_bends");
        let out_bends = Bind::storage(3, 8, "out_bends");
        let of_structure = Bind::storage_read(1, 16, "grid_structure");
        let structure = Bind::storage(3, 0, "out_structure");
        let out_bricks = Bind::storage(3, 1, "out_bricks");
        let marks = Bind::storage(3, 2, "out_marks");
        let out_keys = Bind::storage(3, 3, "out_keys");
        let out_kept = Bind::storage(3, 4, "out_kept");
        let counters = Bind::storage(3, 5, "out_counters");
        let resolve = Bind::storage(3, 6, "out_resolve");
        let groups = Bind::storage(3, 7, "out_groups");
        let mut clip = vec![Bind::uniform::<ClipParams>(0, 1, "params")];
        clip.extend(MESH_BINDS);
        clip.extend([grid, Bind::storage(3, 0, "out_clipped")]);
        Ok(Self {
            slots: kernel(
                "revoxelize_slots",
                64,
                &[grid, home, before, blocks, structure, out_bricks, marks, counters],
            )?,
            keys: kernel("revoxelize_keys", 64, &[of_structure, grid, home, bricks, kept, out_keys])?,
            bends: kernel(
                "revoxelize_bends",
                64,
                &[of_structure, grid, home, keys, bricks, in_bends, out_bends],
            )?,
            keep: kernel("revoxelize_keep", 64, &[keys, list, out_kept])?,
            size: kernel("revoxelize_size", 1, &[blocks, counters, resolve, groups])?,
            clip: Kernel::new(
                gpu,
                &KernelDesc {
                    name: "voxel/revoxelize/clip",
                    sources: &[surface::WGSL, MESH_WGSL, GRID_WGSL, include_str!("clip.wgsl")],
                    entry: "clip_count",
                    workgroup: [64, 1, 1],
                    bindings: &clip,
                    constants: &scene.mesh.layout.constants(),
                },
            )?,
        })
    }

    /// Points the table to the slots of this frame, and to what is beneath those of the last.
    pub(super) fn slots(
        &self,
        recorder: &mut Recorder<'_>,
        grid: &VoxelGrid,
        rest: &Rest,
        scratch: &Scratch,
    ) {
        recorder.clear(&rest.counters);
        for (at, name) in (0u64..).zip(COUNTERS) {
            recorder.counter(name, &rest.counters, 8 * at);
        }
        let (workgroups, row) = rows(rest.brick_cells());
        let (count, first_slot) = (rest.brick_cells(), rest.brick_count);
        let params = RevoxelizeParams { count, first_slot, row, ..Default::default() };
        let Sums { before, blocks, .. } = &rest.sums;
        let read = [&grid.uniform, &rest.home, before, blocks];
        let written = [&grid.structure, &scratch.bricks, &rest.marks, &rest.counters];
        Self::run(recorder, "slots", &self.slots, params, &[read, written].concat(), workgroups);
    }

    /// Fills the cells of a batch with the winners of what stands still.
    pub(super) fn keys(
        &self,
        recorder: &mut Recorder<'_>,
        grid: &VoxelGrid,
        rest: &Rest,
        scratch: &Scratch,
        slots: Range<u32>,
    ) {
        let params = RevoxelizeParams { first_slot: slots.start, ..Default::default() };
        let buffers =
            [&grid.structure, &grid.uniform, &rest.home, &scratch.bricks, &rest.keys, &scratch.keys];
        Self::run(recorder, "keys", &self.keys, params, &buffers, [slots.len() as u32, 1, 1]);
    }

    /// Says of a batch which cells are bent, moving triangles in cells that others won left out.
    pub(super) fn bends(
        &self,
        recorder: &mut Recorder<'_>,
        mesh: &GpuMesh,
        grid: &VoxelGrid,
        rest: &Rest,
        scratch: &Scratch,
        slots: Range<u32>,
    ) {
        let first_moving = mesh.static_triangle_count;
        let params = RevoxelizeParams { first_slot: slots.start, first_moving, ..Default::default() };
        let buffers = [
            &grid.structure,
            &grid.uniform,
            &rest.home,
            &scratch.keys,
            &scratch.bricks,
            &rest.bends,
            &scratch.bends,
        ];
        Self::run(recorder, "bends", &self.bends, params, &buffers, [slots.len() as u32, 1, 1]);
    }

    /// Sizes the resolve of a batch by its voxels.
    pub(super) fn size(
        &self,
        recorder: &mut Recorder<'_>,
        rest: &Rest,
        scratch: &Scratch,
        slots: Range<u32>,
    ) {
        let total_word = Sums::total_word(slots.len() as u32);
        let params = RevoxelizeParams { first_slot: slots.start, total_word, ..Default::default() };
        let buffers = [&scratch.sums.blocks, &rest.counters, &scratch.resolve, &scratch.groups];
        Self::run(recorder, "size", &self.size, params, &buffers, [1, 1, 1]);
    }

    /// Counts moving triangles that reach outside the grid.
    pub(super) fn clip(&self, recorder: &mut Recorder<'_>, mesh: &GpuMesh, grid: &VoxelGrid, rest: &Rest) {
        recorder.clear(&rest.clipped);
        recorder.counter("clipped_triangles", &rest.clipped, 0);
        let first_triangle = mesh.static_triangle_count;
        let count = mesh.triangle_count - first_triangle;
        let (workgroups, row) = rows(count);
        let params = recorder.uniform(&ClipParams { first_triangle, count, row, _pad: 0 });
        let mut resources = vec![params.binding()];
        resources.extend(mesh.resources());
        resources.extend([&grid.uniform, &rest.clipped].map(|b| b.as_entire_binding()));
        recorder.compute(&format!("{STAGE}/clip"), &self.clip, &resources, workgroups);
    }

    fn run(
        recorder: &mut Recorder<'_>,
        part: &str,
        kernel: &Kernel,
        params: RevoxelizeParams,
        buffers: &[&Buffer],
        workgroups: [u32; 3],
    ) {
        let params = recorder.uniform(&params);
        let mut resources = vec![params.binding()];
        resources.extend(buffers.iter().map(|b| b.as_entire_binding()));
        recorder.compute(&format!("{STAGE}/{part}"), kernel, &resources, workgroups);
    }

    /// Writes the winner of each voxel of a batch of what stands still.
    pub(crate) fn keep(
        &self,
        recorder: &mut Recorder<'_>,
        count: u32,
        keys: &Buffer,
        list: &Buffer,
        kept: &Buffer,
    ) {
        let (workgroups, row) = rows(count);
        let params = RevoxelizeParams { count, row, ..Default::default() };
        Self::run(recorder, "keep", &self.keep, params, &[keys, list, kept], workgroups);
    }
}
