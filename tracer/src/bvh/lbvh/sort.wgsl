// One digit of a stable radix sort: SORT_BLOCK pairs per workgroup, 256 at a time.

const SORT_ROUNDS = SORT_BLOCK / 256u;
const SORT_WORDS = 8u; // of 32 invocations each

@group(2) @binding(0) var<storage, read> in_pairs: array<vec2u>;
// Per digit and block: how many keys have it; after sort_scan: how many in the blocks before.
@group(3) @binding(0) var<storage, read_write> sort_counts: array<u32>;
// Per digit how many keys have it.
@group(3) @binding(1) var<storage, read_write> sort_totals: array<u32>;
@group(3) @binding(2) var<storage, read_write> out_pairs: array<vec2u>;

fn sort_digit(code: u32) -> u32 {
    return (code >> params.shift) & 255u;
}

var<workgroup> sort_histogram: array<atomic<u32>, 256>;

@compute @workgroup_size(256)
fn sort_count(@builtin(local_invocation_index) local: u32, @builtin(workgroup_id) group: vec3u) {
    for (var round = 0u; round < SORT_ROUNDS; round += 1u) {
        let i = SORT_BLOCK * group.x + 256u * round + local;
        if (i < params.triangle_count) {
            atomicAdd(&sort_histogram[sort_digit(in_pairs[i].x)], 1u);
        }
    }
    workgroupBarrier();
    sort_counts[params.block_count * local + group.x] = atomicLoad(&sort_histogram[local]);
}

var<workgroup> sort_sums: array<u32, 256>;

// Sum of `value` over the invocations up to this one (Hillis and Steele).
fn sort_inclusive(local: u32, value: u32) -> u32 {
    sort_sums[local] = value;
    workgroupBarrier();
    for (var reach = 1u; reach < 256u; reach *= 2u) {
        let earlier = select(0u, sort_sums[max(local, reach) - reach], local >= reach);
        workgroupBarrier();
        sort_sums[local] += earlier;
        workgroupBarrier();
    }
    return sort_sums[local];
}

// One digit per workgroup: sums over the blocks before.
@compute @workgroup_size(256)
fn sort_scan(@builtin(local_invocation_index) local: u32, @builtin(workgroup_id) group: vec3u) {
    var carried = 0u;
    for (var first = 0u; first < params.block_count; first += 256u) {
        let block = first + local;
        let at = params.block_count * group.x + block;
        var count = 0u;
        if (block < params.block_count) {
            count = sort_counts[at];
        }
        let inclusive = sort_inclusive(local, count);
        if (block < params.block_count) {
            sort_counts[at] = carried + inclusive - count;
        }
        carried += sort_sums[255];
        workgroupBarrier();
    }
    if (local == 0u) {
        sort_totals[group.x] = carried;
    }
}

// Where the next key of each digit goes.
var<workgroup> sort_next: array<u32, 256>;
// Per digit, which of the round's 256 invocations hold a key with it.
var<workgroup> sort_holders: array<array<atomic<u32>, SORT_WORDS>, 256>;

@compute @workgroup_size(256)
fn sort_scatter(@builtin(local_invocation_index) local: u32, @builtin(workgroup_id) group: vec3u) {
    let total = sort_totals[local];
    let before = sort_inclusive(local, total) - total;
    sort_next[local] = before + sort_counts[params.block_count * local + group.x];
    workgroupBarrier();
    for (var round = 0u; round < SORT_ROUNDS; round += 1u) {
        let i = SORT_BLOCK * group.x + 256u * round + local;
        let is_key = i < params.triangle_count;
        var pair = vec2u(0u);
        if (is_key) {
            pair = in_pairs[i];
            atomicOr(&sort_holders[sort_digit(pair.x)][local / 32u], 1u << (local & 31u));
        }
        workgroupBarrier();
        if (is_key) {
            // Keys of the same digit keep their order: those of lower invocations go first.
            let digit = sort_digit(pair.x);
            var place = sort_next[digit];
            for (var word = 0u; word < SORT_WORDS; word += 1u) {
                let lower = select(0u, 0xffffffffu, word < local / 32u);
                let mask = select(lower, (1u << (local & 31u)) - 1u, word == local / 32u);
                place += countOneBits(atomicLoad(&sort_holders[digit][word]) & mask);
            }
            out_pairs[place] = pair;
        }
        workgroupBarrier();
        for (var word = 0u; word < SORT_WORDS; word += 1u) {
            sort_next[local] += countOneBits(atomicLoad(&sort_holders[local][word]));
            atomicStore(&sort_holders[local][word], 0u);
        }
        workgroupBarrier();
    }
}
