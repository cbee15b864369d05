//! Prefix sums on the device: from counts to places.
//!
//! In: n counts. Out: the exclusive sums within blocks of [`SCAN_BLOCK`], the sums of the blocks before, and the sum of all.
//! Element i is at `before[i] + blocks[i / SCAN_BLOCK]`. Longest loop: n / (256 SCAN_BLOCK) rounds over the blocks' totals, 9 steps
//! each; 2^26 counts, the most a dispatch takes, are 256 rounds.

use crate::{Bind, Buffer, Gpu, GpuError, Kernel, KernelDesc, KernelError, Recorder, Room};

/// Counts per block of a scan, for Rust and for shaders.
macro_rules! scan_block {
    () => {
        1024
    };
}
/// Counts per block.
pub const SCAN_BLOCK: u32 = scan_block!();
/// The snippet: `SCAN_BLOCK`, for shaders that read sums.
pub const SCAN_WGSL: &str = concat!("const SCAN_BLOCK = ", scan_block!(), "u;\n");

crate::gpu_struct! {
    /// See `scan.wgsl`.
    pub struct ScanParams {
        /// Counts.
        pub count: u32,
        /// WGSL rounds uniforms up.
        pub _pad: [u32; 3],
    }
}

/// Both passes.
pub struct Scan {
    blocks: Kernel,
    totals: Kernel,
}

/// Where a scan's sums are.
pub struct Sums {
    /// Sum of the words before, within a block.
    pub before: Buffer,
    /// Sum of the blocks before; after the last the sum of all.
    pub blocks: Buffer,
    /// Words there is room for.
    count: u32,
}

impl Scan {
    /// Compiles both.
    ///
    /// # Errors
    /// The driver refuses one.
    pub fn new(gpu: &Gpu) -> Result<Self, KernelError> {
        let kernel = |entry, bindings: &[Bind]| {
            Kernel::new(
                gpu,
                &KernelDesc {
                    name: "scan",
                    sources: &[SCAN_WGSL, include_str!("scan.wgsl")],
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

    /// Sums up the first `count` words, at most as many as the sums have room for.
    pub fn record(&self, recorder: &mut Recorder<'_>, stage: &str, counts: &Buffer, count: u32, sums: &Sums) {
        let pass = format!("{stage}/scan");
        let params = recorder.uniform(&ScanParams { count, _pad: [0; 3] });
        let [from, before, blocks] = [counts, &sums.before, &sums.blocks].map(|b| b.as_entire_binding());
        recorder.compute(
            &pass,
            &self.blocks,
            &[params.binding(), from, before, blocks.clone()],
            [count.div_ceil(SCAN_BLOCK), 1, 1],
        );
        recorder.compute(&pass, &self.totals, &[params.binding(), blocks], [1, 1, 1]);
    }
}

impl Sums {
    /// Room for the sums of this many words.
    ///
    /// # Errors
    /// Too many, or out of memory.
    pub fn new(gpu: &Gpu, room: Room, count: u32) -> Result<Self, GpuError> {
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
        let words = |label, n: u32| gpu.buffer(room, label, 4 * u64::from(n), usage);
        Ok(Self {
            before: words("Scan::before", count)?,
            blocks: words("Scan::blocks", count.div_ceil(SCAN_BLOCK) + 1)?,
            count,
        })
    }

    /// Word of `blocks` that holds the sum of all, after a scan of this many words.
    pub fn total_word(count: u32) -> u32 {
        count.div_ceil(SCAN_BLOCK)
    }

    /// Waits for the sum of all, after a scan of as many words as there is room for.
    ///
    /// # Errors
    /// The device was lost.
    pub fn total(&self, recorder: &mut Recorder<'_>) -> Result<u32, GpuError> {
        recorder.flush();
        let blocks: Vec<u32> = recorder.gpu().read_buffer(&self.blocks)?;
        Ok(blocks.get(Self::total_word(self.count) as usize).copied().unwrap_or(0))
    }
}
