//! Sorts pairs of a 30-bit code and a triangle by their codes, stably: a radix sort of four 8-bit digits.
//!
//! In: pairs. Out: the same buffer, sorted; equal codes keep their order. Per digit: how often each value occurs in each
//! block of [`SORT_BLOCK`] pairs, sums of that over values and blocks, and each pair's way to its place. A pair's rank
//! within its block comes from bit masks of who holds which value, 256 pairs at a time, so that no order of atomics
//! shows in the result.

use super::{LbvhParams, PARAMS_WGSL, WORKGROUP, params_bind};
use frame::{Bind, Buffer, Gpu, GpuError, Kernel, KernelDesc, KernelError, Recorder, Room};
use wgpu::BufferUsages;

/// Pairs that one workgroup brings to their places.
const SORT_BLOCK: u32 = 2048;
/// Values of a digit.
const DIGITS: u32 = 256;

/// Blocks of so many pairs.
pub(super) fn block_count(pairs: u32) -> u32 {
    pairs.div_ceil(SORT_BLOCK)
}

/// The three kernels.
pub(super) struct Sort {
    count: Kernel,
    scan: Kernel,
    scatter: Kernel,
}

impl Sort {
    pub(super) fn new(gpu: &Gpu) -> Result<Self, KernelError> {
        let prelude = format!("const SORT_BLOCK = {SORT_BLOCK}u;");
        let kernel = |entry: &str, bindings: &[Bind]| {
            Kernel::new(
                gpu,
                &KernelDesc {
                    name: &format!("bvh/lbvh/{entry}"),
                    sources: &[PARAMS_WGSL, &prelude, include_str!("sort.wgsl")],
                    entry,
                    workgroup: [WORKGROUP, 1, 1],
                    bindings: &[&[params_bind()], bindings].concat(),
                    constants: &[],
                },
            )
        };
        let pairs = Bind::storage_read(2, 0, "in_pairs");
        let counts = Bind::storage(3, 0, "sort_counts");
        let totals = Bind::storage(3, 1, "sort_totals");
        Ok(Self {
            count: kernel("sort_count", &[pairs, counts])?,
            scan: kernel("sort_scan", &[counts, totals])?,
            scatter: kernel("sort_scatter", &[pairs, counts, totals, Bind::storage(3, 2, "out_pairs")])?,
        })
    }

    /// Room for so many pairs, 8 bytes each.
    pub(super) fn pairs(gpu: &Gpu, count: u32) -> Result<Buffer, GpuError> {
        gpu.buffer(
            Room::Bvh,
            "Sort::pairs",
            8 * u64::from(count),
            BufferUsages::STORAGE | BufferUsages::COPY_SRC,
        )
    }

    /// Sorts `pairs` in place, with a copy of it on the way.
    pub(super) fn record(
        &self,
        recorder: &mut Recorder<'_>,
        params: &LbvhParams,
        pairs: &Buffer,
    ) -> Result<(), GpuError> {
        let gpu = recorder.gpu();
        let words = |label, n: u32| gpu.buffer(Room::Bvh, label, 4 * u64::from(n), BufferUsages::STORAGE);
        let counts = words("Sort::counts", DIGITS * params.block_count)?;
        let totals = words("Sort::totals", DIGITS)?;
        let other = Self::pairs(gpu, params.triangle_count)?;
        // An even number of digits: the last one brings the pairs back to where they came from.
        for (shift, from, to) in
            [(0, pairs, &other), (8, &other, pairs), (16, pairs, &other), (24, &other, pairs)]
        {
            let uniform = recorder.uniform(&LbvhParams { shift, ..*params });
            let [from, to, counts, totals] = [from, to, &counts, &totals].map(|b| b.as_entire_binding());
            let mut compute = |kernel, resources: &[wgpu::BindingResource<'_>], groups| {
                let resources = [&[uniform.binding()], resources].concat();
                recorder.compute("bvh/lbvh/sort", kernel, &resources, [groups, 1, 1]);
            };
            compute(&self.count, &[from.clone(), counts.clone()], params.block_count);
            compute(&self.scan, &[counts.clone(), totals.clone()], DIGITS);
            compute(&self.scatter, &[from, counts, totals, to], params.block_count);
        }
        Ok(())
    }
}
