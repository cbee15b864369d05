//! From marked bricks and winners to the structure buffer: slots, skip levels, masks, places of records.
//!
//! In: a mark per brick cell; keys per cell of a batch of bricks. Out: the buffer that [`crate::grid`] describes, the
//! brick cell of each slot, and per record of the batch the cell it is for. Slots follow brick cells, x fastest; records
//! follow slots, then masks, then bits: the same triangles give the same words.
//!
//! Longest loops: 64 children per mask, 32 bits per word; [`frame::scan`] says its own.

pub(crate) use frame::scan::Sums;

use crate::Grid;
use crate::grid::GRID_WGSL;
use frame::scan::{SCAN_WGSL, Scan};
use frame::{Bind, Buffer, Gpu, Kernel, KernelDesc, KernelError, Recorder};

frame::gpu_struct! {
    /// See `structure.wgsl`.
    pub struct StructureParams {
        /// Brick cells, groups, regions or bricks.
        pub count: u32,
        /// Of the batch.
        pub first_slot: u32,
        /// Records before the batch.
        pub first_record: u32,
        /// Invocations per row of the dispatch.
        pub row: u32,
    }
}

/// All passes that fill the structure.
pub(crate) struct Structure {
    scan: Scan,
    slots: Kernel,
    groups: Kernel,
    regions: Kernel,
    sides: Kernel,
    masks: Kernel,
    list: Kernel,
}

/// A run of slots whose cells fit the keys.
pub(crate) struct Batch<'a> {
    /// What passes' names begin with.
    pub(crate) stage: &'a str,
    pub(crate) uniform: &'a Buffer,
    pub(crate) structure: &'a Buffer,
    pub(crate) slots: std::ops::Range<u32>,
}

/// Workgroups of 64 invocations as rows of a 2D dispatch, and the invocations per row.
pub(crate) fn rows(count: u32) -> ([u32; 3], u32) {
    /// Default limit of workgroups per axis.
    const MOST: u32 = 65_535;
    let groups = count.div_ceil(64).max(1);
    let width = groups.min(MOST);
    ([width, groups.div_ceil(width), 1], 64 * width)
}

impl Structure {
    pub(crate) fn new(gpu: &Gpu) -> Result<Self, KernelError> {
        let kernel = |entry, after: &[Bind]| {
            let mut bindings = vec![Bind::uniform::<StructureParams>(0, 1, "params")];
            bindings.push(Bind::uniform::<Grid>(1, 18, "grid"));
            bindings.extend(after);
            Kernel::new(
                gpu,
                &KernelDesc {
                    name: entry,
                    sources: &[SCAN_WGSL, GRID_WGSL, include_str!("structure.wgsl")],
                    entry,
                    workgroup: [64, 1, 1],
                    bindings: &bindings,
                    constants: &[],
                },
            )
        };
        let marks = Bind::storage_read(2, 0, "in_marks");
        let sums = [Bind::storage_read(2, 1, "in_before"), Bind::storage_read(2, 2, "in_blocks")];
        let keys = Bind::storage_read(2, 3, "in_keys");
        let structure = Bind::storage(3, 0, "out_structure");
        let bricks = Bind::storage(3, 1, "out_bricks");
        let in_bricks = Bind::storage_read(2, 4, "in_bricks");
        let counts = Bind::storage(3, 2, "out_counts");
        let list = Bind::storage(3, 3, "out_list");
        Ok(Self {
            scan: Scan::new(gpu)?,
            slots: kernel("structure_slots", &[marks, sums[0], sums[1], structure, bricks])?,
            groups: kernel("structure_groups", &[marks, structure])?,
            regions: kernel("structure_regions", &[structure])?,
            sides: kernel("structure_sides", &[structure])?,
            masks: kernel("structure_masks", &[keys, in_bricks, structure, counts])?,
            list: kernel("structure_list", &[sums[0], sums[1], structure, list])?,
        })
    }

    /// Sums up the first `count` marks or counts.
    pub(crate) fn scan(
        &self,
        recorder: &mut Recorder<'_>,
        stage: &str,
        counts: &Buffer,
        count: u32,
        sums: &Sums,
    ) {
        self.scan.record(recorder, stage, counts, count, sums);
    }

    /// Table, slots and skip levels of all bricks.
    pub(crate) fn levels(
        &self,
        recorder: &mut Recorder<'_>,
        grid: &Grid,
        uniform: &Buffer,
        marks: &Buffer,
        sums: &Sums,
        structure: &Buffer,
        bricks: &Buffer,
    ) {
        let count = grid.bricks.iter().product::<i32>() as u32;
        let (workgroups, row) = rows(count);
        let params = recorder.uniform(&StructureParams { count, row, ..Default::default() });
        let mut resources = vec![params.binding()];
        let buffers = [uniform, marks, &sums.before, &sums.blocks, structure, bricks];
        resources.extend(buffers.map(|b| b.as_entire_binding()));
        recorder.compute("voxel/structure/slots", &self.slots, &resources, workgroups);
        self.skips(recorder, "voxel/structure", grid, uniform, marks, structure);
    }

    /// The same without slots: the skip levels over the bricks that are marked, and the sides of the empty entries.
    pub(crate) fn skips(
        &self,
        recorder: &mut Recorder<'_>,
        stage: &str,
        grid: &Grid,
        uniform: &Buffer,
        marks: &Buffer,
        structure: &Buffer,
    ) {
        let count = |n: [i32; 3]| n.iter().product::<i32>() as u32;
        let passes: [(_, _, _, &[&Buffer]); 3] = [
            ("groups", &self.groups, count(grid.groups), &[uniform, marks, structure]),
            ("regions", &self.regions, count(grid.regions), &[uniform, structure]),
            ("sides", &self.sides, count(grid.bricks), &[uniform, structure]),
        ];
        for (pass, kernel, count, buffers) in passes {
            let (workgroups, row) = rows(count);
            let params = recorder.uniform(&StructureParams { count, row, ..Default::default() });
            let mut resources = vec![params.binding()];
            resources.extend(buffers.iter().map(|b| b.as_entire_binding()));
            recorder.compute(&format!("{stage}/{pass}"), kernel, &resources, workgroups);
        }
    }

    /// Masks of a batch, which of them hold voxels, and voxels by brick. `bricks` is what [`Self::levels`] filled.
    pub(crate) fn masks(
        &self,
        recorder: &mut Recorder<'_>,
        batch: &Batch<'_>,
        keys: &Buffer,
        bricks: &Buffer,
        counts: &Buffer,
    ) {
        let buffers = [batch.uniform, keys, bricks, batch.structure, counts];
        self.per_brick(recorder, "masks", &self.masks, batch, 0, &buffers);
    }

    /// First records of a batch's bricks, and the cell of each record.
    pub(crate) fn list(
        &self,
        recorder: &mut Recorder<'_>,
        batch: &Batch<'_>,
        first_record: u32,
        sums: &Sums,
        list: &Buffer,
    ) {
        let buffers = [batch.uniform, &sums.before, &sums.blocks, batch.structure, list];
        self.per_brick(recorder, "list", &self.list, batch, first_record, &buffers);
    }

    fn per_brick(
        &self,
        recorder: &mut Recorder<'_>,
        pass: &str,
        kernel: &Kernel,
        batch: &Batch<'_>,
        first_record: u32,
        buffers: &[&Buffer],
    ) {
        let count = batch.slots.len() as u32;
        let params =
            recorder.uniform(&StructureParams { count, first_slot: batch.slots.start, first_record, row: 0 });
        let mut resources = vec![params.binding()];
        resources.extend(buffers.iter().map(|b| b.as_entire_binding()));
        // Sixteen invocations per brick; a batch is at most 2^16 bricks.
        let pass = format!("{}/{pass}", batch.stage);
        recorder.compute(&pass, kernel, &resources, [count.div_ceil(4), 1, 1]);
    }
}
