// The first visit: how many triangles each brick holds.

@group(3) @binding(2) var<storage, read_write> out_counts: array<atomic<u32>>;

fn compute_found(brick: u32, triangle: u32) {
    atomicAdd(&out_counts[brick], 1u);
}
