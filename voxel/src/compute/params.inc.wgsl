// What all passes of the compute voxelizer are told.

struct ComputeParams {
    // Triangles, items, brick cells or chunks, by entry point.
    count: u32,
    // Invocations, or workgroups, per row of the dispatch.
    row: u32,
    // Number of the first triangle.
    first_triangle: u32,
    // Of the batch.
    first_slot: u32,
    slot_count: u32,
    // 1: thin, 0: conservative.
    is_thin: u32,
    // Of bends.
    flat: f32,
    apart: f32,
    first_moving: u32,
    // Bricks that are made already: first, and one behind the last.
    kept_low: vec3i,
    kept_high: vec3i,
}

@group(0) @binding(1) var<uniform> params: ComputeParams;

fn compute_is_thin() -> bool {
    return params.is_thin == 1u;
}
