// Sums of all paths become the mean of each lobe, in half floats. See mod.rs.
@group(1) @binding(31) var<storage, read> sums: array<vec4f>;
@group(1) @binding(32) var<storage, read> sample_counts: array<u32>;
@group(1) @binding(33) var<storage, read_write> counters: array<atomic<u32>>;
@group(3) @binding(0) var out_diffuse: texture_storage_2d<rgba16float, write>;
@group(3) @binding(1) var out_specular: texture_storage_2d<rgba16float, write>;
@group(3) @binding(2) var out_samples: texture_storage_2d<r32uint, write>;

const RESOLVE_LARGEST = 65504.0;
// Pair of words after the tally's.
const RESOLVE_CLAMPED = 8u;

fn resolve_lobe(sum: vec4f, paths_of_pixel: u32, paths_of_lobe: u32) -> vec4f {
    let mean = sum.rgb / f32(max(paths_of_pixel, 1u));
    // Not below infinity, by its bits: neither a comparison nor a minimum is sure to see a NaN.
    let strange = (bitcast<vec3u>(mean) & vec3u(0x7f800000u)) == vec3u(0x7f800000u);
    if (any(strange) || any(mean > vec3f(RESOLVE_LARGEST))) {
        atomicAdd(&counters[RESOLVE_CLAMPED], 1u);
    }
    let kept = min(select(mean, vec3f(0.0), strange), vec3f(RESOLVE_LARGEST));
    return vec4f(kept, min(sum.a / f32(max(paths_of_lobe, 1u)), RESOLVE_LARGEST));
}

@compute @workgroup_size(8, 8)
fn path_resolve(@builtin(global_invocation_id) id: vec3u) {
    if (any(id.xy >= frame.trace_size)) {
        return;
    }
    let index = id.y * frame.trace_size.x + id.x;
    let samples = sample_counts[index];
    let diffuse = samples & 0xffffu;
    let specular = samples >> 16u;
    textureStore(out_diffuse, id.xy, resolve_lobe(sums[2u * index], diffuse + specular, diffuse));
    textureStore(out_specular, id.xy, resolve_lobe(sums[2u * index + 1u], diffuse + specular, specular));
    textureStore(out_samples, id.xy, vec4u(samples, 0u, 0u, 0u));
}
