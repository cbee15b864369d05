// Sums of all paths become the mean of each lobe, in half floats. See mod.rs.
@group(1) @binding(31) var<storage, read> pixels: array<Pixel>;
@group(1) @binding(33) var<storage, read_write> counters: array<atomic<u32>>;
@group(3) @binding(0) var out_diffuse: texture_storage_2d<rgba16float, write>;
@group(3) @binding(1) var out_specular: texture_storage_2d<rgba16float, write>;
@group(3) @binding(2) var out_samples: texture_storage_2d<r32uint, write>;

// Pair of words after the tally's.
const RESOLVE_CLAMPED = 8u;

fn resolve_lobe(sum: vec4f, paths_of_pixel: u32, paths_of_lobe: u32) -> vec4f {
    let mean = vec4f(sum.rgb / f32(max(paths_of_pixel, 1u)), sum.a / f32(max(paths_of_lobe, 1u)));
    if (!all(half_is_finite(mean)) || any(mean > vec4f(HALF_LARGEST))) {
        atomicAdd(&counters[RESOLVE_CLAMPED], 1u);
    }
    return half_rounded(mean);
}

@compute @workgroup_size(8, 8)
fn path_resolve(@builtin(global_invocation_id) id: vec3u) {
    if (any(id.xy >= frame.trace_size)) {
        return;
    }
    let index = id.y * frame.trace_size.x + id.x;
    let samples = pixels[index].samples;
    let diffuse = samples & 0xffffu;
    let specular = samples >> 16u;
    textureStore(out_diffuse, id.xy, resolve_lobe(pixels[index].diffuse, diffuse + specular, diffuse));
    textureStore(out_specular, id.xy, resolve_lobe(pixels[index].specular, diffuse + specular, specular));
    textureStore(out_samples, id.xy, vec4u(samples, 0u, 0u, 0u));
}
