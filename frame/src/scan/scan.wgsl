// Exclusive prefix sums, a block of SCAN_BLOCK numbers per workgroup, then the blocks' totals in one workgroup.

struct ScanParams {
    count: u32,
}

@group(0) @binding(1) var<uniform> params: ScanParams;
@group(2) @binding(0) var<storage, read> in_counts: array<u32>;
// Sum of the numbers before, within the block.
@group(3) @binding(0) var<storage, read_write> out_before: array<u32>;
// Per block its total, then the sum of the blocks before; one more element takes the sum of all.
@group(3) @binding(1) var<storage, read_write> out_blocks: array<u32>;

const SCAN_PER_INVOCATION = SCAN_BLOCK / 256u;

var<workgroup> scan_sums: array<u32, 256>;

// Sum of `value` over the invocations up to this one (Hillis and Steele).
fn scan_inclusive(local: u32, value: u32) -> u32 {
    scan_sums[local] = value;
    workgroupBarrier();
    for (var reach = 1u; reach < 256u; reach *= 2u) {
        let earlier = select(0u, scan_sums[max(local, reach) - reach], local >= reach);
        workgroupBarrier();
        scan_sums[local] += earlier;
        workgroupBarrier();
    }
    return scan_sums[local];
}

@compute @workgroup_size(256)
fn scan_blocks(@builtin(local_invocation_index) local: u32, @builtin(workgroup_id) group: vec3u) {
    let first = SCAN_BLOCK * group.x + SCAN_PER_INVOCATION * local;
    var sum = 0u;
    for (var i = first; i < min(first + SCAN_PER_INVOCATION, params.count); i += 1u) {
        sum += in_counts[i];
    }
    let inclusive = scan_inclusive(local, sum);
    var before = inclusive - sum;
    for (var i = first; i < min(first + SCAN_PER_INVOCATION, params.count); i += 1u) {
        out_before[i] = before;
        before += in_counts[i];
    }
    if (local == 255u) {
        out_blocks[group.x] = inclusive;
    }
}

@compute @workgroup_size(256)
fn scan_totals(@builtin(local_invocation_index) local: u32) {
    let blocks = (params.count + SCAN_BLOCK - 1u) / SCAN_BLOCK;
    var carried = 0u;
    for (var first = 0u; first < blocks; first += 256u) {
        let i = first + local;
        var total = 0u;
        if (i < blocks) {
            total = out_blocks[i];
        }
        let inclusive = scan_inclusive(local, total);
        if (i < blocks) {
            out_blocks[i] = carried + inclusive - total;
        }
        carried += scan_sums[255];
        workgroupBarrier();
    }
    if (local == 0u) {
        out_blocks[blocks] = carried;
    }
}
