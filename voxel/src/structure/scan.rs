//! Prefix sums on the device: from counts to places.
//!
//! In: n counts. Out: the exclusive sums within blocks of [`SCAN_BLOCK`], the sums of the blocks before, and the sum of all.
//! Element i is at `before[i] + blocks[i / SCAN_BLOCK]`. Longest loop: n / (256 SCAN_BLOCK) rounds over the blocks' totals, 9 steps
//! each; 2^26 counts, the most a dispatch takes, are 256 rounds.

use super::{SCAN_BLOCK, SCAN_CONSTANTS};
use frame::{Bind, Buffer, Gpu, GpuError, Kernel, KernelDesc, KernelError, Recorder, Room};

frame::gpu_struct! {
    /// See `scan.wgsl`.
    pub struct ScanParams {
        /// Counts.
        pub count: u32,
        /// WGSL rounds uniforms up.
        pub _pad: [u32; 3],
    }
}

/// Both passes.
pub(super) struct Scan {
    blocks: Kernel,
    totals: Kernel,
}

/// Where a scan's sums are.
pub(crate) struct Sums {
    pub(crate) before: Buffer,
    pub(crate) blocks: Buffer,
    count: u32,
}

impl Scan {
    pub(super) fn new(gpu: &Gpu) -> Result<Self, KernelError> {
        let kernel = |entry, bindings: &[Bind]| {
            Kernel::new(
                gpu,
                &KernelDesc {
                    name: "voxel/structure/scan",
                    sources: &[SCAN_CONSTANTS, include_str!("scan.wgsl")],
                    entry,
                    workgroup: [256, 1, 1],
                    bindings,
                    constants: &[],
                },
            )
        };
        let params = Bind::uniform::<ScanParams>(0, 1, "params");
        let blocks = Bind::storage(3, 1, "out_blocks");
        let counts = Bind::storage_read(2, 0, "in_counts");
        Ok(Self {
            blocks: kernel("scan_blocks", &[params, counts, Bind::storage(3, 0, "out_before"), blocks])?,
            totals: kernel("scan_totals", &[params, blocks])?,
        })
    }

    /// Sums up the first `count` words.
    pub(super) fn record(
        &self,
        recorder: &mut Recorder<'_>,
        counts: &Buffer,
        count: u32,
    ) -> Result<Sums, GpuError> {
        let gpu = recorder.gpu();
        let block_count = count.div_ceil(SCAN_BLOCK);
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
        let words = |label, n: u32| gpu.buffer(Room::Voxels, label, 4 * u64::from(n), usage);
        let sums = Sums {
            before: words("Scan::before", count)?,
            blocks: words("Scan::blocks", block_count + 1)?,
            count,
        };
        let params = recorder.uniform(&ScanParams { count, _pad: [0; 3] });
        let [from, before, blocks] = [counts, &sums.before, &sums.blocks].map(|b| b.as_entire_binding());
        recorder.compute(
            "voxel/structure/scan",
            &self.blocks,
            &[params.binding(), from, before, blocks.clone()],
            [block_count, 1, 1],
        );
        recorder.compute("voxel/structure/scan", &self.totals, &[params.binding(), blocks], [1, 1, 1]);
        Ok(sums)
    }
}

impl Sums {
    /// Waits for the sum of all.
    pub(crate) fn total(&self, recorder: &mut Recorder<'_>) -> Result<u32, GpuError> {
        recorder.flush();
        let blocks: Vec<u32> = recorder.gpu().read_buffer(&self.blocks)?;
        Ok(blocks.get(self.count.div_ceil(SCAN_BLOCK) as usize).copied().unwrap_or(0))
    }
}
