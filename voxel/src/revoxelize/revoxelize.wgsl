// What a moving frame does beside the passes it shares with a build. After the constants of the scan and grid.inc.wgsl.

struct RevoxelizeParams {
    // Brick cells, bricks or voxels, by entry point.
    count: u32,
    // First slot of the pool for bricks that something moves in, or of the batch.
    first_slot: u32,
    // Invocations per row of the dispatch.
    row: u32,
    // Word of in_blocks that holds the sum of all.
    total_word: u32,
    first_moving: u32,
}

@group(0) @binding(1) var<uniform> params: RevoxelizeParams;
// Per brick cell: its entry in the table of what stands still.
@group(2) @binding(0) var<storage, read> in_home: array<u32>;
// Sums of a scan, in and before its blocks.
@group(2) @binding(1) var<storage, read> in_before: array<u32>;
@group(2) @binding(2) var<storage, read> in_blocks: array<u32>;
@group(2) @binding(3) var<storage, read> in_keys: array<u32>;
// Brick cell by slot.
@group(2) @binding(4) var<storage, read> in_bricks: array<u32>;
// By record of what stands still: the key of its winner.
@group(2) @binding(5) var<storage, read> in_kept: array<u32>;
// As structure.wgsl fills it.
@group(2) @binding(6) var<storage, read> in_list: array<vec2u>;
// By brick of what stands still, a bit per cell: it is bent.
@group(2) @binding(7) var<storage, read> in_bends: array<u32>;
@group(3) @binding(0) var<storage, read_write> out_structure: array<u32>;
@group(3) @binding(1) var<storage, read_write> out_bricks: array<u32>;
// Per brick cell, in: 1 where something moves; out: 1 where something is.
@group(3) @binding(2) var<storage, read_write> out_marks: array<u32>;
@group(3) @binding(3) var<storage, read_write> out_keys: array<u32>;
@group(3) @binding(4) var<storage, read_write> out_kept: array<u32>;
// 64-bit counters, in the order of COUNTERS in mod.rs.
@group(3) @binding(5) var<storage, read_write> out_counters: array<atomic<u32>>;
// ResolveParams.
@group(3) @binding(6) var<storage, read_write> out_resolve: vec4u;
// Workgroups of the resolve.
@group(3) @binding(7) var<storage, read_write> out_groups: array<u32, 3>;

// The same by brick of the batch.
@group(3) @binding(8) var<storage, read_write> out_bends: array<u32>;

const REVOXELIZE_DIRTY = 0u;
const REVOXELIZE_COVERED_BRICKS = 2u;
const REVOXELIZE_COVERED_VOXELS = 4u;
const REVOXELIZE_MOVING_VOXELS = 6u;

// Voxels of a brick, given by its first word.
fn revoxelize_voxels(brick_at: u32) -> u32 {
    let before_last = out_structure[brick_at + GRID_PREFIX_WORD + 3u] >> 16u;
    return before_last + countOneBits(out_structure[brick_at + 14u]) + countOneBits(out_structure[brick_at + 15u]);
}

// One invocation per brick cell: where something moves a slot of the second pool, elsewhere what stands still. Entries of
// slots lack their masks until structure_masks, those of empty cells are not whole before structure_sides.
@compute @workgroup_size(64)
fn revoxelize_slots(@builtin(global_invocation_id) id: vec3u) {
    let brick = id.x + params.row * id.y;
    if (brick >= params.count) {
        return;
    }
    let at = grid.table_at + brick;
    let last = out_structure[at];
    let was_touched = last < GRID_EMPTY && (last & GRID_SLOTS) >= params.first_slot;
    let is_touched = out_marks[brick] != 0u;
    var entry = min(in_home[brick], GRID_EMPTY);
    let has_rest = entry < GRID_EMPTY;
    if (was_touched || is_touched) {
        atomicAdd(&out_counters[REVOXELIZE_DIRTY], 1u);
    }
    if (is_touched) {
        if (has_rest) {
            atomicAdd(&out_counters[REVOXELIZE_COVERED_BRICKS], 1u);
            let voxels = revoxelize_voxels(grid.bricks_at + GRID_BRICK_WORDS * (entry & GRID_SLOTS));
            atomicAdd(&out_counters[REVOXELIZE_COVERED_VOXELS], voxels);
        }
        entry = params.first_slot + in_before[brick] + in_blocks[brick / SCAN_BLOCK];
        out_bricks[entry] = brick;
    }
    out_structure[at] = entry;
    out_marks[brick] = select(0u, 1u, entry < GRID_EMPTY);
}

// One workgroup per brick of the batch: its cells begin with the winners of what stands still.
@compute @workgroup_size(64)
fn revoxelize_keys(@builtin(local_invocation_index) bit: u32, @builtin(workgroup_id) group: vec3u) {
    let home = in_home[in_bricks[params.first_slot + group.x]];
    let brick = grid.bricks_at + GRID_BRICK_WORDS * (home & GRID_SLOTS);
    for (var part = 0u; part < 8u; part += 1u) {
        var key = 0u;
        if (home < GRID_EMPTY) {
            let mask = grid_mask(brick + 2u * part);
            let is_set = ((select(mask.x, mask.y, bit >= 32u) >> (bit % 32u)) & 1u) != 0u;
            if (is_set) {
                key = in_kept[grid_record_in(brick, part, bit)];
            }
        }
        out_keys[GRID_BRICK_CELLS * group.x + 64u * part + bit] = key;
    }
}

// One workgroup per brick of the batch, one invocation per word of its bends: those of what stands still, but for cells
// that something moving won, which are bent if they were not empty and it lets no light through.
@compute @workgroup_size(64)
fn revoxelize_bends(@builtin(local_invocation_index) word: u32, @builtin(workgroup_id) group: vec3u) {
    if (word >= GRID_BRICK_CELLS / 32u) {
        return;
    }
    let home = in_home[in_bricks[params.first_slot + group.x]];
    let slot = home & GRID_SLOTS;
    var rest = 0u;
    var bends = 0u;
    if (home < GRID_EMPTY) {
        rest = grid_structure[grid.bricks_at + GRID_BRICK_WORDS * slot + word];
        bends = in_bends[GRID_BRICK_CELLS / 32u * slot + word];
    }
    for (var i = 0u; i < 32u; i += 1u) {
        let stored = in_keys[GRID_BRICK_CELLS * group.x + 32u * word + i];
        let is_won = stored != 0u && (~stored & 0xffffffu) >= params.first_moving;
        if (is_won) {
            let is_bent = (~stored >> 30u) != 2u && ((rest >> i) & 1u) != 0u;
            bends = (bends & ~(1u << i)) | (select(0u, 1u, is_bent) << i);
        }
    }
    out_bends[GRID_BRICK_CELLS / 32u * group.x + word] = bends;
}

// One invocation per voxel of a batch of what stands still.
@compute @workgroup_size(64)
fn revoxelize_keep(@builtin(global_invocation_id) id: vec3u) {
    let record = id.x + params.row * id.y;
    if (record < params.count) {
        out_kept[record] = in_keys[in_list[record].x];
    }
}

// Once per batch: how much the resolve has to do.
@compute @workgroup_size(1)
fn revoxelize_size() {
    let voxels = in_blocks[params.total_word];
    let groups = (voxels + 63u) / 64u;
    // Default limit of workgroups per axis.
    let width = clamp(groups, 1u, 65535u);
    out_resolve = vec4u(params.first_slot, voxels, 64u * width, 0u);
    out_groups[0] = width;
    out_groups[1] = (groups + width - 1u) / width;
    out_groups[2] = 1u;
    atomicAdd(&out_counters[REVOXELIZE_MOVING_VOXELS], voxels);
}
