// What paths found for voxels' sides goes into their means, and regions notice that the light has changed. See mod.rs.

const STORE_FAST = 8.0;
const STORE_SLOW = 64.0;
// Samples that the slow mean counts as when it has just become the fast one; and the fast one's memory then.
const STORE_RESTART = 3.0;
const STORE_ERRORS = 2.0;

// One sample's deviation counts as at most so many times the mean, in steps of 1/256.
const STORE_MOST = 8.0;
const STORE_STEPS = 256.0;

// What a region remembers of the frame before.
const REGION_KEPT = 0.75;
// A change: the region's mean deviation is beyond so many of its standard errors, and beyond this share of the light.
const REGION_ERRORS = 4.0;
const REGION_LEAST = 0.05;

// To a half float, up or down by chance so that the mean is exact.
fn store_rounded(x: f32, random: u32) -> f32 {
    return bitcast<f32>((bitcast<u32>(clamp(x, 0.0, 65000.0)) + (random & 0x1fffu)) & 0xffffe000u);
}

fn store_rounded_3(x: vec3f, random: u32) -> vec3f {
    let more = random * vec3u(1u, 747796405u, 2891336453u);
    return vec3f(store_rounded(x.x, more.x), store_rounded(x.y, more.y >> 7u), store_rounded(x.z, more.z >> 13u));
}

// What a sample says of its region: how far it is from what was expected there.
fn store_deviation(region: u32, found: f32, expected: f32) {
    let deviation = clamp(found / max(expected, 1e-6), 0.0, STORE_MOST) - 1.0;
    atomicAdd(&cache[region + REGION_SUM], bitcast<u32>(i32(round(STORE_STEPS * deviation))));
    atomicAdd(&cache[region + REGION_SQUARES], u32(STORE_STEPS * deviation * deviation));
    atomicAdd(&cache[region + REGION_SAMPLES], 1u);
}

fn store_sample(slot: u32, region: u32, found: vec3f, random: vec2u) {
    let at = cache_values(slot);
    let word_1 = unpack2x16float(atomicLoad(&cache[at + 1u]));
    let word_3 = atomicLoad(&cache[at + 3u]);
    var slow = vec3f(unpack2x16float(atomicLoad(&cache[at])), word_1.x);
    var fast = vec3f(unpack2x16float(atomicLoad(&cache[at + 2u])), unpack2x16float(word_3).x);
    var spread = word_1.y;
    var samples = f32(cache_samples(word_3));
    let epoch = atomicLoad(&cache[region + REGION_EPOCH]) & 0xffu;
    let has_changed = samples > STORE_RESTART && (word_3 >> 24u) != epoch;
    if (samples >= STORE_RESTART) {
        store_deviation(region, brdf_luminance(found), brdf_luminance(slow));
    }

    samples = min(samples + 1.0, STORE_SLOW);
    slow = mix(slow, found, 1.0 / samples);
    fast = mix(fast, found, 1.0 / min(samples, select(STORE_FAST, STORE_RESTART, has_changed)));
    // Standard deviation of one sample, from the mean's last place.
    let apart = brdf_luminance(found) - brdf_luminance(slow);
    spread = sqrt(mix(spread * spread, apart * apart, 1.0 / min(samples, 32.0)));
    // An exponential mean of memory n has the error of 2 n - 1 samples.
    let error = spread * inverseSqrt(2.0 * STORE_FAST - 1.0);
    let is_apart = samples > STORE_FAST && abs(brdf_luminance(fast) - brdf_luminance(slow)) > STORE_ERRORS * error;
    if (has_changed || is_apart) {
        slow = fast;
        samples = STORE_RESTART;
    }
    slow = store_rounded_3(slow, random.x);
    fast = store_rounded_3(fast, random.y);
    atomicStore(&cache[at], pack2x16float(slow.xy));
    atomicStore(&cache[at + 1u], pack2x16float(vec2f(slow.z, min(spread, 65000.0))));
    atomicStore(&cache[at + 2u], pack2x16float(fast.xy));
    atomicStore(&cache[at + 3u], (pack2x16float(vec2f(fast.z, 0.0)) & 0xffffu) | (u32(samples) << 16u) | (epoch << 24u));
}

@compute @workgroup_size(8, 8)
fn path_store(@builtin(workgroup_id) group: vec3u, @builtin(global_invocation_id) id: vec3u) {
    params = params_of[group.z];
    if (any(id.xy >= vec2u(frame.trace_size.x, params.rows))) {
        return;
    }
    let index = path_index(id.xy);
    let feed = paths[index].feed;
    if (feed != 0u) {
        let found = pixels[index].aside;
        // Not NaN: comparisons with it are false.
        if (all(found >= vec3f(0.0)) && all(found < vec3f(1e30))) {
            let random = noise_pcg4d(vec4u(feed, frame.frame_index, 0x73746f72u, frame.seed)).xy;
            store_sample(feed - 1u, cache_region_at(paths[index].feed_entry), found, random);
        }
        atomicStore(&cache[cache_key_at(feed - 1u)], 0u);
        paths[index].feed = 0u;
    }
}

// A region whose samples are off together enters another epoch: its sides count as new when they are next renewed.
@compute @workgroup_size(64)
fn path_regions(@builtin(global_invocation_id) id: vec3u) {
    let at = cache_region_at(id.x << CACHE_REGION_SHIFT);
    let of_frame = vec3f(
        f32(bitcast<i32>(atomicLoad(&cache[at + REGION_SUM]))) / STORE_STEPS,
        f32(atomicLoad(&cache[at + REGION_SQUARES])) / STORE_STEPS,
        f32(atomicLoad(&cache[at + REGION_SAMPLES])),
    );
    let kept = vec3f(
        bitcast<f32>(atomicLoad(&cache[at + REGION_KEPT_SUMS])),
        bitcast<f32>(atomicLoad(&cache[at + REGION_KEPT_SUMS + 1u])),
        bitcast<f32>(atomicLoad(&cache[at + REGION_KEPT_SUMS + 2u])),
    );
    let sums = REGION_KEPT * kept + of_frame;
    if (abs(sums.x) > max(REGION_ERRORS * sqrt(sums.y), REGION_LEAST * sums.z)) {
        atomicAdd(&cache[at + REGION_EPOCH], 1u);
    }
    for (var i = 0u; i < 3u; i += 1u) {
        atomicStore(&cache[at + i], 0u);
        atomicStore(&cache[at + REGION_KEPT_SUMS + i], bitcast<u32>(sums[i]));
    }
}
