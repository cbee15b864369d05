// Radiance kept in the voxels: reading it, and offering to renew it. See mod.rs.

// Of record r: words 10 r + 4 side hold (slow r, g), (slow b, spread), (fast r, g), fast b as half floats, and in eight bits
// each the number of samples and the region's epoch; words 10 r + 8 + side hold the key of the path that renews the side.
// At the end the regions: blocks of cells whose light is watched together.
@group(1) @binding(34) var<storage, read_write> cache: array<atomic<u32>>;

const CACHE_WORDS = 10u;
const CACHE_KEYS = 8u;

// What a path came in through, beside the axis of a cell's face: the plane within, a face that looks along the axis
// backwards, a face that is the surface itself.
const CACHE_PLANE = 3u;
const CACHE_NEGATIVE = 4u;
const CACHE_CUBE = 8u;

// Above these bits, the region. CACHE_REGIONS of 8 words each.
const CACHE_REGION_SHIFT = 4u;
const CACHE_REGIONS = 4096u;
const CACHE_REGION_WORDS = 8u;
// Cells along a region's side, as a power of 2.
const CACHE_REGION_CELLS = 4u;
// Words of a region: this frame's sums in fixed point, those of the frames before as floats, and what its sides compare.
const REGION_SUM = 0u;
const REGION_SQUARES = 1u;
const REGION_SAMPLES = 2u;
const REGION_KEPT_SUMS = 3u;
const REGION_EPOCH = 6u;

fn cache_region_at(entry: u32) -> u32 {
    return arrayLength(&cache) - CACHE_REGION_WORDS * (CACHE_REGIONS - (entry >> CACHE_REGION_SHIFT));
}

fn cache_samples(word_3: u32) -> u32 {
    return (word_3 >> 16u) & 0xffu;
}

fn cache_slot(hit: Hit) -> u32 {
    return 2u * hit.record + select(1u, 0u, hit.front);
}

fn cache_values(slot: u32) -> u32 {
    return CACHE_WORDS * (slot >> 1u) + 4u * (slot & 1u);
}

fn cache_key_at(slot: u32) -> u32 {
    return CACHE_WORDS * (slot >> 1u) + CACHE_KEYS + (slot & 1u);
}

// Every pixel's own in a frame, and in another order in the next.
fn cache_key(pixel: vec2u) -> u32 {
    return (path_index(pixel) + 1u + frame.frame_index * 7919u) * 2654435761u;
}

// rgb = C of the side that was met, a = number of its samples, 0 without a value.
fn cache_read(hit: Hit) -> vec4f {
    let at = cache_values(cache_slot(hit));
    let rg = unpack2x16float(atomicLoad(&cache[at]));
    let b = unpack2x16float(atomicLoad(&cache[at + 1u]));
    return vec4f(rg, b.x, f32(cache_samples(atomicLoad(&cache[at + 3u]))));
}

// A path that ended here offers to renew the side.
fn cache_offer(path: ptr<function, Path>, hit: Hit, point: vec3f, pixel: vec2u) {
    let draw = noise_pcg4d(vec4u(pixel, frame.frame_index, 0x66656564u)).x;
    if (path_is_feeding || f32(draw >> 8u) * (1.0 / 16777216.0) >= params.feed_share) {
        return;
    }
    let slot = cache_slot(hit);
    atomicMax(&cache[cache_key_at(slot)], cache_key(pixel));
    (*path).feed = slot + 1u;
    let axis = select(select(2u, 1u, abs(hit.entry.y) > 0.5), 0u, abs(hit.entry.x) > 0.5);
    (*path).feed_entry = select(CACHE_PLANE, axis, hit.at_face)
        | select(0u, CACHE_NEGATIVE, hit.entry.x + hit.entry.y + hit.entry.z < 0.0)
        | select(0u, CACHE_CUBE, all(hit.entry == hit.face))
        | ((noise_pcg4d(vec4u(vec3u(hit.cell) >> vec3u(CACHE_REGION_CELLS), 0x72656769u)).x % CACHE_REGIONS) << CACHE_REGION_SHIFT);
    // Of a face just inside, so that it names the cell.
    (*path).origin = select(point, hit_pass(point, hit, (*path).direction), hit.at_face);
    path_leaves(path, hit.own);
}
