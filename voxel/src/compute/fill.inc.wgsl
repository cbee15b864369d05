// The second visit: writes the triangles of each brick. Counts run down from what the first one found.

// Sums of the counts, in and before blocks of a scan.
@group(2) @binding(0) var<storage, read> in_before: array<u32>;
@group(2) @binding(1) var<storage, read> in_blocks: array<u32>;
@group(3) @binding(2) var<storage, read_write> out_counts: array<atomic<u32>>;
@group(3) @binding(3) var<storage, read_write> out_lists: array<u32>;

fn compute_found(brick: u32, triangle: u32) {
    let place = atomicSub(&out_counts[brick], 1u) - 1u;
    out_lists[in_before[brick] + in_blocks[brick / SCAN_BLOCK] + place] = triangle;
}
