// Fills the structure buffer, part by part; the layout is that of grid/mod.rs.

struct StructureParams {
    // Brick cells, groups, regions or bricks, by entry point.
    count: u32,
    // Of the batch.
    first_slot: u32,
    // Records before the batch.
    first_record: u32,
    // Invocations per row of the dispatch.
    row: u32,
}

@group(0) @binding(1) var<uniform> params: StructureParams;
// Per brick cell: 1 where something is.
@group(2) @binding(0) var<storage, read> in_marks: array<u32>;
// Sums of a scan, in and before its blocks.
@group(2) @binding(1) var<storage, read> in_before: array<u32>;
@group(2) @binding(2) var<storage, read> in_blocks: array<u32>;
// Per cell of the batch: 0 = empty.
@group(2) @binding(3) var<storage, read> in_keys: array<u32>;
@group(3) @binding(0) var<storage, read_write> out_structure: array<u32>;
// Brick cell by slot.
@group(3) @binding(1) var<storage, read_write> out_bricks: array<u32>;
@group(2) @binding(4) var<storage, read> in_bricks: array<u32>;
// Voxels by brick of the batch.
@group(3) @binding(2) var<storage, read_write> out_counts: array<u32>;
// By record of the batch: cell of the batch, factor of its emission (0 = as it is).
@group(3) @binding(3) var<storage, read_write> out_list: array<vec2u>;

const STRUCTURE_MASK_WORDS = GRID_BASE_WORD;

fn structure_scanned(i: u32) -> u32 {
    return in_before[i] + in_blocks[i / SCAN_BLOCK];
}

fn structure_point(index: u32, size: vec3i) -> vec3i {
    let i = i32(index);
    return vec3i(i % size.x, (i / size.x) % size.y, i / (size.x * size.y));
}

// The child with this bit in a 4^3 mask; none where the parent reaches beyond the last child.
fn structure_child(parent: vec3i, bit: u32) -> vec3i {
    return 4 * parent + vec3i((vec3u(bit) >> vec3u(0u, 2u, 4u)) & vec3u(3u));
}

// One invocation per brick cell. An empty one's entry is not whole before structure_sides.
@compute @workgroup_size(64)
fn structure_slots(@builtin(global_invocation_id) id: vec3u) {
    let brick = id.x + params.row * id.y;
    if (brick >= params.count) {
        return;
    }
    var slot = GRID_EMPTY;
    if (in_marks[brick] != 0u) {
        slot = structure_scanned(brick);
        out_bricks[slot] = brick;
    }
    out_structure[grid.table_at + brick] = slot;
}

// One invocation per group.
@compute @workgroup_size(64)
fn structure_groups(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + params.row * id.y;
    if (index >= params.count) {
        return;
    }
    let group = structure_point(index, grid.groups);
    var mask = vec2u(0u);
    for (var bit = 0u; bit < 64u; bit += 1u) {
        let brick = structure_child(group, bit);
        if (all(brick < grid.bricks) && in_marks[grid_index(brick, grid.bricks)] != 0u) {
            mask[bit / 32u] |= 1u << (bit % 32u);
        }
    }
    out_structure[grid.groups_at + 2u * index] = mask.x;
    out_structure[grid.groups_at + 2u * index + 1u] = mask.y;
}

// One invocation per region.
@compute @workgroup_size(64)
fn structure_regions(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + params.row * id.y;
    if (index >= params.count) {
        return;
    }
    let region = structure_point(index, grid.regions);
    var mask = vec2u(0u);
    for (var bit = 0u; bit < 64u; bit += 1u) {
        let group = structure_child(region, bit);
        if (all(group < grid.groups)) {
            let at = grid.groups_at + 2u * grid_index(group, grid.groups);
            if ((out_structure[at] | out_structure[at + 1u]) != 0u) {
                mask[bit / 32u] |= 1u << (bit % 32u);
            }
        }
    }
    out_structure[2u * index] = mask.x;
    out_structure[2u * index + 1u] = mask.y;
}

fn structure_mask(at: u32) -> vec2u {
    return vec2u(out_structure[at], out_structure[at + 1u]);
}

// One invocation per brick cell: an empty one tells how far the emptiness around it goes.
@compute @workgroup_size(64)
fn structure_sides(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + params.row * id.y;
    if (index >= params.count || out_structure[grid.table_at + index] != GRID_EMPTY) {
        return;
    }
    let brick = structure_point(index, grid.bricks);
    let group = brick >> vec3u(2u);
    let bricks = grid_empty_side(structure_mask(grid.groups_at + 2u * grid_index(group, grid.groups)), brick & vec3i(3));
    let region = group >> vec3u(2u);
    let groups = grid_empty_side(structure_mask(2u * grid_index(region, grid.regions)), group & vec3i(3));
    out_structure[grid.table_at + index] = GRID_EMPTY + u32(select(8 * bricks, 32 * groups, bricks == 4));
}

var<workgroup> structure_counts: array<u32, 64>;

// Sixteen invocations per brick of the batch, one per word of its masks.
@compute @workgroup_size(64)
fn structure_masks(@builtin(local_invocation_index) local: u32, @builtin(workgroup_id) group: vec3u) {
    let brick = 4u * group.x + local / STRUCTURE_MASK_WORDS;
    let word = local % STRUCTURE_MASK_WORDS;
    let at = grid.bricks_at + GRID_BRICK_WORDS * (params.first_slot + brick);
    var mask = 0u;
    if (brick < params.count) {
        for (var bit = 0u; bit < 32u; bit += 1u) {
            let is_set = in_keys[GRID_BRICK_CELLS * brick + 32u * word + bit] != 0u;
            mask |= select(0u, 1u, is_set) << bit;
        }
        out_structure[at + word] = mask;
    }
    structure_counts[local] = countOneBits(mask);
    workgroupBarrier();
    // Four of the sixteen write the counts before two masks each, a fifth the total, a sixth which masks hold a voxel.
    if (brick >= params.count || word > 5u) {
        return;
    }
    let first = local - word;
    if (word == 5u) {
        let slot = params.first_slot + brick;
        var parts = 0u;
        for (var part = 0u; part < 8u; part += 1u) {
            let voxels = structure_counts[first + 2u * part] + structure_counts[first + 2u * part + 1u];
            parts |= select(0u, 1u, voxels > 0u) << part;
        }
        out_structure[grid.table_at + in_bricks[slot]] = slot | (parts << GRID_PARTS_BIT);
        return;
    }
    var before = 0u;
    for (var i = 0u; i < 4u * word; i += 1u) {
        before += structure_counts[first + i];
    }
    if (word == 4u) {
        out_counts[brick] = before;
        return;
    }
    let next = before + structure_counts[first + 4u * word] + structure_counts[first + 4u * word + 1u];
    out_structure[at + GRID_PREFIX_WORD + word] = before | (next << 16u);
}

// Sixteen invocations per brick of the batch: the number of its first record, and which cell each record is for.
@compute @workgroup_size(64)
fn structure_list(@builtin(local_invocation_index) local: u32, @builtin(workgroup_id) group: vec3u) {
    let brick = 4u * group.x + local / STRUCTURE_MASK_WORDS;
    let word = local % STRUCTURE_MASK_WORDS;
    if (brick >= params.count) {
        return;
    }
    let at = grid.bricks_at + GRID_BRICK_WORDS * (params.first_slot + brick);
    var record = structure_scanned(brick);
    if (word == 0u) {
        out_structure[at + GRID_BASE_WORD] = params.first_record + record;
    }
    let part = word / 2u;
    record += (out_structure[at + GRID_PREFIX_WORD + part / 2u] >> (16u * (part & 1u))) & 0xffffu;
    if ((word & 1u) == 1u) {
        record += countOneBits(out_structure[at + word - 1u]);
    }
    var remaining = out_structure[at + word];
    for (var i = 0u; i < 32u && remaining != 0u; i += 1u) {
        out_list[record] = vec2u(GRID_BRICK_CELLS * brick + 32u * word + firstTrailingBit(remaining), 0u);
        remaining &= remaining - 1u;
        record += 1u;
    }
}
