//! Joins what stays of a level that moved with the bricks that came into it.
//!
//! In: the level where it was, and a grid where it is now that holds new bricks only. Out: the grid where it is now with all
//! of them. Marks, scan, slots and skip levels as in a build; then the words and records of each brick are copied from
//! where they are. Slots and records are in the order that a build gives them, so the two are equal to the bit.
//!
//! Longest loops: 21 words per invocation, and 512 x 4 words by 64 invocations.

use super::Level;
use crate::grid::{GRID_WGSL, Layout};
use crate::structure::{Structure, Sums, rows};
use crate::voxelizer::words;
use crate::{Grid, VoxelGrid};
use frame::scan::SCAN_WGSL;
use frame::{Bind, Buffer, Gpu, GpuError, Kernel, KernelDesc, KernelError, Recorder, Room};
use glam::IVec3;

const STAGE: &str = "voxel/cascades";

frame::gpu_struct! {
    /// See `merge.wgsl`.
    pub struct MergeParams {
        /// From a brick's place in the new grid to that in the old one.
        pub shift: [i32; 3],
        /// Brick cells or slots.
        pub count: u32,
        /// The first brick of the new grid that is the old one's.
        pub kept_low: [i32; 3],
        /// Invocations, or workgroups, per row of the dispatch.
        pub row: u32,
        /// One behind the last.
        pub kept_high: [i32; 3],
        /// Words per record.
        pub record_words: u32,
        /// Of the old grid.
        pub old_bricks: [i32; 3],
        /// Of the old grid.
        pub old_table_at: u32,
        /// Of the old grid.
        pub old_bricks_at: u32,
        /// Of the old grid.
        pub old_first_record: u32,
        /// WGSL rounds uniforms up.
        pub _pad: [u32; 2],
    }
}

/// The passes that a level takes when it moves.
pub(crate) struct Merger {
    marks: Kernel,
    counts: Kernel,
    bricks: Kernel,
    records: Kernel,
}

/// A run of bricks: the first, and one behind the last.
pub(super) type Bricks = [IVec3; 2];

/// The bricks of a level that were in it before it moved, as it counts them now, and what to add for how it counted
/// them then.
pub(super) fn kept(old: &Layout, new: &Layout) -> (Bricks, IVec3) {
    let shift = (new.low - old.low) / 8;
    let size = |layout: &Layout| IVec3::from(layout.bricks().map(|n| n as i32));
    let low = (-shift).max(IVec3::ZERO);
    let high = (size(old) - shift).min(size(new));
    let kept = if high.cmpgt(low).all() { [low, high] } else { [IVec3::ZERO; 2] };
    (kept, shift)
}

impl Merger {
    pub(crate) fn new(gpu: &Gpu) -> Result<Self, KernelError> {
        let read = |at, name| Bind::storage_read(2, at, name);
        let (new, old, bricks) = (read(0, "in_new"), read(1, "in_old"), read(4, "in_bricks"));
        let kernel = |entry, after: &[Bind]| {
            let mut bindings = vec![Bind::uniform::<MergeParams>(0, 1, "params")];
            bindings.extend([Bind::uniform::<Grid>(1, 18, "grid"), new, old]);
            bindings.extend(after);
            Kernel::new(
                gpu,
                &KernelDesc {
                    name: entry,
                    sources: &[SCAN_WGSL, GRID_WGSL, include_str!("merge.wgsl")],
                    entry,
                    workgroup: [64, 1, 1],
                    bindings: &bindings,
                    constants: &[],
                },
            )
        };
        let sums = [read(5, "in_before"), read(6, "in_blocks")];
        let records = [read(2, "in_new_records"), read(3, "in_old_records")];
        Ok(Self {
            marks: kernel("merge_marks", &[Bind::storage(3, 0, "out_marks")])?,
            counts: kernel("merge_counts", &[bricks, Bind::storage(3, 1, "out_counts")])?,
            bricks: kernel(
                "merge_bricks",
                &[bricks, sums[0], sums[1], Bind::storage(3, 2, "out_structure")],
            )?,
            records: kernel(
                "merge_records",
                &[
                    records[0],
                    records[1],
                    bricks,
                    read(7, "in_structure"),
                    Bind::storage(3, 3, "out_records"),
                ],
            )?,
        })
    }

    /// `new` has the new bricks of `layout` alone, `old` is the level where it was.
    pub(super) fn merge(
        &self,
        gpu: &Gpu,
        structure: &Structure,
        layout: &Layout,
        new: VoxelGrid,
        old: &Level,
    ) -> Result<VoxelGrid, GpuError> {
        let shared = layout.uniform(0);
        let brick_cells = shared.bricks_at - shared.table_at;
        let (bricks, shift) = kept(&old.layout, layout);
        let params = MergeParams {
            shift: shift.into(),
            kept_low: bricks[0].into(),
            kept_high: bricks[1].into(),
            record_words: new.record.words(),
            old_bricks: old.layout.bricks().map(|n| n as i32),
            old_table_at: old.table_at,
            old_bricks_at: old.bricks_at,
            old_first_record: old.first_record,
            ..Default::default()
        };
        let mut recorder = Recorder::new(gpu);
        let of_both = [&new.uniform, &new.structure, &old.structure];
        let run = |recorder: &mut Recorder<'_>, pass: &str, kernel, count, after: &[&Buffer]| {
            let (workgroups, row) = rows(count);
            let params = recorder.uniform(&MergeParams { count, row, ..params });
            let mut resources = vec![params.binding()];
            resources.extend(of_both.iter().chain(after).map(|b| b.as_entire_binding()));
            recorder.compute(&format!("{STAGE}/{pass}"), kernel, &resources, workgroups);
        };
        let marks = words(gpu, "Merger::marks", brick_cells.into())?;
        run(&mut recorder, "marks", &self.marks, brick_cells, &[&marks]);
        let sums = Sums::new(gpu, Room::Voxels, brick_cells)?;
        structure.scan(&mut recorder, STAGE, &marks, brick_cells, &sums);
        let brick_count = sums.total(&mut recorder)?;
        let merged = words(gpu, "VoxelGrid::structure", layout.structure_words(brick_count))?;
        let slots = words(gpu, "Merger::bricks", brick_count.into())?;
        structure.levels(&mut recorder, &shared, &new.uniform, &marks, &sums, &merged, &slots);

        let counts = words(gpu, "Merger::counts", brick_count.into())?;
        run(&mut recorder, "counts", &self.counts, brick_count, &[&slots, &counts]);
        let sums = Sums::new(gpu, Room::Voxels, brick_count)?;
        structure.scan(&mut recorder, STAGE, &counts, brick_count, &sums);
        let voxel_count = sums.total(&mut recorder)?;
        let record_words = u64::from(new.record.words());
        let records = words(gpu, "VoxelGrid::records", record_words * u64::from(voxel_count.max(1)))?;
        run(
            &mut recorder,
            "bricks",
            &self.bricks,
            brick_count,
            &[&slots, &sums.before, &sums.blocks, &merged],
        );
        // A workgroup per brick, in rows of at most the default limit.
        let width = brick_count.clamp(1, 65_535);
        let params = recorder.uniform(&MergeParams { count: brick_count, row: width, ..params });
        let mut resources = vec![params.binding()];
        resources.extend(of_both.iter().map(|b| b.as_entire_binding()));
        let after = [&new.records, &old.records, &slots, &merged, &records];
        resources.extend(after.map(|b| b.as_entire_binding()));
        let workgroups = [width, brick_count.div_ceil(width), 1];
        recorder.compute(&format!("{STAGE}/records"), &self.records, &resources, workgroups);
        recorder.finish()?;
        Ok(VoxelGrid { structure: merged, records, brick_count, voxel_count, ..new })
    }
}
