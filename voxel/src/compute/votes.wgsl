// Marks bricks and votes for winners. After cells.wgsl.

@group(3) @binding(6) var<storage, read_write> out_marks: array<u32>;
// As the raster's: complement of the least key.
@group(3) @binding(7) var<storage, read_write> out_keys: array<atomic<u32>>;

fn compute_meet(triangle: u32, normal: vec3f, cell: vec3i, key: u32) {
    atomicMax(&compute_keys[grid_cell_index(cell)], ~key);
}

// One workgroup per chunk: whether any cell of its brick is met.
@compute @workgroup_size(64)
fn compute_mark(@builtin(local_invocation_index) local: u32, @builtin(workgroup_id) group: vec3u) {
    let chunk = compute_chunk_of(group);
    workgroupBarrier();
    compute_chunk(chunk, local);
    workgroupBarrier();
    if (local == 0u && atomicLoad(&compute_keys[0]) != 0u) {
        out_marks[chunk.x] = 1u;
    }
}

// One workgroup per chunk: the least keys of its brick's cells.
@compute @workgroup_size(64)
fn compute_vote(@builtin(local_invocation_index) local: u32, @builtin(workgroup_id) group: vec3u) {
    var chunk = compute_chunk_of(group);
    let slot = compute_slot_of(chunk);
    if (slot == params.slot_count) {
        chunk.z = 0u;
    }
    workgroupBarrier();
    compute_chunk(chunk, local);
    workgroupBarrier();
    if (chunk.z == 0u) {
        return;
    }
    for (var i = local; i < GRID_BRICK_CELLS; i += 64u) {
        let key = atomicLoad(&compute_keys[i]);
        if (key != 0u) {
            atomicMax(&out_keys[GRID_BRICK_CELLS * slot + i], key);
        }
    }
}
