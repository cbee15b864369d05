// A level that moved: bricks that were there already, from where they were, and new ones. After the constants of the scan
// and the grid, which is the new one's. Steps: merge.rs beside this file.

struct MergeParams {
    // From a brick's place in the new grid to that in the old one.
    shift: vec3i,
    // Brick cells or slots, by entry point.
    count: u32,
    // Bricks of the new grid that are the old one's: first, and one behind the last.
    kept_low: vec3i,
    // Invocations, or workgroups, per row of the dispatch.
    row: u32,
    kept_high: vec3i,
    record_words: u32,
    // Of the old grid, whose buffers may hold those of other levels too.
    old_bricks: vec3i,
    old_table_at: u32,
    old_bricks_at: u32,
    old_first_record: u32,
}

@group(0) @binding(1) var<uniform> params: MergeParams;
@group(2) @binding(0) var<storage, read> in_new: array<u32>;
@group(2) @binding(1) var<storage, read> in_old: array<u32>;
@group(2) @binding(2) var<storage, read> in_new_records: array<u32>;
@group(2) @binding(3) var<storage, read> in_old_records: array<u32>;
// Brick cell by slot.
@group(2) @binding(4) var<storage, read> in_bricks: array<u32>;
// Sums of the voxels by slot, in and before blocks of a scan.
@group(2) @binding(5) var<storage, read> in_before: array<u32>;
@group(2) @binding(6) var<storage, read> in_blocks: array<u32>;
// What they become.
@group(2) @binding(7) var<storage, read> in_structure: array<u32>;
@group(3) @binding(0) var<storage, read_write> out_marks: array<u32>;
@group(3) @binding(1) var<storage, read_write> out_counts: array<u32>;
@group(3) @binding(2) var<storage, read_write> out_structure: array<u32>;
@group(3) @binding(3) var<storage, read_write> out_records: array<u32>;

fn merge_is_kept(brick: vec3i) -> bool {
    return all(brick >= params.kept_low) && all(brick < params.kept_high);
}

fn merge_brick(index: u32) -> vec3i {
    let size = vec3u(grid.bricks);
    return vec3i(vec3u(index, index / size.x, index / (size.x * size.y)) % vec3u(size.xy, 0xffffffffu));
}

// The table's word in whichever grid has it.
fn merge_entry(index: u32) -> u32 {
    let brick = merge_brick(index);
    if (merge_is_kept(brick)) {
        return in_old[params.old_table_at + grid_index(brick + params.shift, params.old_bricks)];
    }
    return in_new[grid.table_at + index];
}

// First word of a brick that is there, where it comes from.
fn merge_at(index: u32, entry: u32) -> u32 {
    let bricks_at = select(grid.bricks_at, params.old_bricks_at, merge_is_kept(merge_brick(index)));
    return bricks_at + GRID_BRICK_WORDS * (entry & GRID_SLOTS);
}

fn merge_word(index: u32, at: u32) -> u32 {
    if (merge_is_kept(merge_brick(index))) {
        return in_old[at];
    }
    return in_new[at];
}

// Voxels of a brick.
fn merge_voxels(index: u32, at: u32) -> u32 {
    let before_last = merge_word(index, at + GRID_PREFIX_WORD + 3u) >> 16u;
    return before_last + countOneBits(merge_word(index, at + 14u)) + countOneBits(merge_word(index, at + 15u));
}

// One invocation per brick cell: whether something is in it.
@compute @workgroup_size(64)
fn merge_marks(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + params.row * id.y;
    if (index < params.count) {
        out_marks[index] = select(0u, 1u, merge_entry(index) < GRID_EMPTY);
    }
}

// One invocation per slot: its voxels.
@compute @workgroup_size(64)
fn merge_counts(@builtin(global_invocation_id) id: vec3u) {
    let slot = id.x + params.row * id.y;
    if (slot < params.count) {
        let index = in_bricks[slot];
        out_counts[slot] = merge_voxels(index, merge_at(index, merge_entry(index)));
    }
}

// One invocation per slot: its words, and which of its masks hold a voxel.
@compute @workgroup_size(64)
fn merge_bricks(@builtin(global_invocation_id) id: vec3u) {
    let slot = id.x + params.row * id.y;
    if (slot >= params.count) {
        return;
    }
    let index = in_bricks[slot];
    let entry = merge_entry(index);
    let old_at = merge_at(index, entry);
    let at = grid.bricks_at + GRID_BRICK_WORDS * slot;
    for (var i = 0u; i < GRID_BRICK_WORDS; i += 1u) {
        out_structure[at + i] = merge_word(index, old_at + i);
    }
    out_structure[at + GRID_BASE_WORD] = in_before[slot] + in_blocks[slot / SCAN_BLOCK];
    out_structure[grid.table_at + index] = slot | (entry & ~(GRID_SLOTS | GRID_EMPTY));
}

// One workgroup per slot: its records.
@compute @workgroup_size(64)
fn merge_records(@builtin(local_invocation_index) local: u32, @builtin(workgroup_id) group: vec3u) {
    let slot = group.x + params.row * group.y;
    if (slot >= params.count) {
        return;
    }
    let index = in_bricks[slot];
    let old_at = merge_at(index, merge_entry(index));
    let words = params.record_words * merge_voxels(index, old_at);
    let base = merge_word(index, old_at + GRID_BASE_WORD);
    let is_kept = merge_is_kept(merge_brick(index));
    let first = params.record_words * select(base, params.old_first_record + base, is_kept);
    let to = params.record_words * in_structure[grid.bricks_at + GRID_BRICK_WORDS * slot + GRID_BASE_WORD];
    for (var i = local; i < words; i += 64u) {
        if (is_kept) {
            out_records[to + i] = in_old_records[first + i];
        } else {
            out_records[to + i] = in_new_records[first + i];
        }
    }
}
