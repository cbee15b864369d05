// Finds the cells in which triangles are not one surface. After bend.inc.wgsl and cells.wgsl.

// Winners, as votes.wgsl left them.
@group(2) @binding(0) var<storage, read> in_keys: array<u32>;
// Per cell of a batch a bit: it has no plane.
@group(3) @binding(0) var<storage, read_write> out_bends: array<atomic<u32>>;

// Of the chunk's brick.
var<private> compute_slot: u32;

fn compute_meet(triangle: u32, normal: vec3f, cell: vec3i, key: u32) {
    let at = GRID_BRICK_CELLS * compute_slot + grid_cell_index(cell);
    if (bend_is(Bend(params.flat, params.apart, params.first_moving), in_keys[at], triangle, normal, cell)) {
        atomicOr(&out_bends[at >> 5u], 1u << (at & 31u));
    }
}

// One workgroup per chunk.
@compute @workgroup_size(64)
fn compute_bend(@builtin(local_invocation_index) local: u32, @builtin(workgroup_id) group: vec3u) {
    let chunk = compute_chunk_of(group);
    compute_slot = compute_slot_of(chunk);
    if (compute_slot < params.slot_count) {
        compute_chunk(chunk, local);
    }
}
