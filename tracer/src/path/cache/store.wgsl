// What paths found for voxels' sides goes into their means. See mod.rs.

const STORE_FAST = 8.0;
const STORE_SLOW = 32.0;
// Samples that the slow mean counts as when it has just become the fast one.
const STORE_RESTART = 4.0;
const STORE_ERRORS = 2.0;

// To a half float, up or down by chance so that the mean is exact.
fn store_rounded(x: f32, random: u32) -> f32 {
    return bitcast<f32>((bitcast<u32>(clamp(x, 0.0, 65000.0)) + (random & 0x1fffu)) & 0xffffe000u);
}

fn store_rounded_3(x: vec3f, random: u32) -> vec3f {
    let more = random * vec3u(1u, 747796405u, 2891336453u);
    return vec3f(store_rounded(x.x, more.x), store_rounded(x.y, more.y >> 7u), store_rounded(x.z, more.z >> 13u));
}

fn store_sample(slot: u32, found: vec3f, random: vec2u) {
    let at = cache_values(slot);
    let word_1 = unpack2x16float(atomicLoad(&cache[at + 1u]));
    let word_3 = unpack2x16float(atomicLoad(&cache[at + 3u]));
    var slow = vec3f(unpack2x16float(atomicLoad(&cache[at])), word_1.x);
    var fast = vec3f(unpack2x16float(atomicLoad(&cache[at + 2u])), word_3.x);
    var spread = word_1.y;
    var samples = word_3.y;

    samples = min(samples + 1.0, STORE_SLOW);
    slow = mix(slow, found, 1.0 / samples);
    fast = mix(fast, found, 1.0 / min(samples, STORE_FAST));
    // Standard deviation of one sample, from the mean's last place.
    let apart = brdf_luminance(found) - brdf_luminance(slow);
    spread = sqrt(mix(spread * spread, apart * apart, 1.0 / min(samples, 32.0)));
    // An exponential mean of memory n has the error of 2 n - 1 samples.
    let error = spread * inverseSqrt(2.0 * STORE_FAST - 1.0);
    if (samples > STORE_FAST && abs(brdf_luminance(fast) - brdf_luminance(slow)) > STORE_ERRORS * error) {
        slow = fast;
        samples = STORE_RESTART;
    }
    slow = store_rounded_3(slow, random.x);
    fast = store_rounded_3(fast, random.y);
    atomicStore(&cache[at], pack2x16float(slow.xy));
    atomicStore(&cache[at + 1u], pack2x16float(vec2f(slow.z, min(spread, 65000.0))));
    atomicStore(&cache[at + 2u], pack2x16float(fast.xy));
    atomicStore(&cache[at + 3u], pack2x16float(vec2f(fast.z, samples)));
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
            store_sample(feed - 1u, found, noise_pcg4d(vec4u(feed, frame.frame_index, 0x73746f72u, frame.seed)).xy);
        }
        atomicStore(&cache[cache_key_at(feed - 1u)], 0u);
        paths[index].feed = 0u;
    }
}
