// How noisy a pixel's luminance is: by its own history where that is long enough, by its neighbours' where not.
// 49 taps a pixel at most.

@group(2) @binding(1) var in_moments: texture_2d<f32>;
@group(2) @binding(2) var in_frames: texture_2d<u32>;
// Bits of f32: diffuse, specular; negative: the lobe has no light here.
@group(3) @binding(0) var out_variance: texture_storage_2d<rg32uint, write>;

const VARIANCE_FRAMES = 4u;
const VARIANCE_REACH = 3;

// Of both lobes, from their moments.
fn variance_of(moments: vec4f) -> vec2f {
    return max(moments.yw - moments.xz * moments.xz, vec2f(0.0));
}

@compute @workgroup_size(8, 8)
fn variance(@builtin(global_invocation_id) id: vec3u) {
    let size = vec2i(textureDimensions(in_edge));
    let p = vec2i(id.xy);
    if (any(p >= size)) {
        return;
    }
    let centre = edge_centre(textureLoad(in_edge, p, 0), p, size);
    let packed = textureLoad(in_frames, p, 0).r;
    let frames = vec2u(packed & 0xffffu, packed >> 16u);
    let is_short = frames < vec2u(VARIANCE_FRAMES);

    // Long histories need the Gauss over 3x3 pixels, short ones all that is within reach.
    var reach = select(1, VARIANCE_REACH, any(is_short & (frames > vec2u(0u))));
    reach = select(-1, reach, packed != 0u);
    var moments = vec4f(0.0);
    var moments_weight = vec2f(0.0);
    var long = vec2f(0.0);
    var long_weight = vec2f(0.0);
    for (var j = -reach; j <= reach; j++) {
        for (var i = -reach; i <= reach; i++) {
            let offset = vec2i(i, j);
            let q = p + offset;
            if (any(q < vec2i(0)) || any(q >= size)) {
                continue;
            }
            let tap = textureLoad(in_edge, q, 0);
            let tap_packed = textureLoad(in_frames, q, 0).r;
            let tap_frames = vec2u(tap_packed & 0xffffu, tap_packed >> 16u);
            let tap_moments = textureLoad(in_moments, q, 0);
            let geometry = exp(-svgf_geometry_fall(centre, tap, q, size));
            let lobes = vec2f(geometry, geometry * svgf_lobe_weight(centre, tap, offset, size));
            let weight = select(vec2f(0.0), lobes, tap_frames > vec2u(0u));
            moments += weight.xxyy * tap_moments;
            moments_weight += weight;
            let steps = abs(i) + abs(j);
            let gauss = select(0.0, 1.0 / f32(1u << u32(steps)), max(abs(i), abs(j)) <= 1);
            let long_share = select(vec2f(0.0), vec2f(gauss), tap_frames >= vec2u(VARIANCE_FRAMES));
            long += long_share * variance_of(tap_moments);
            long_weight += long_share;
        }
    }
    // The centre's own weight is 1 wherever it has a frame.
    let spatial = variance_of(moments / max(moments_weight, vec2f(1e-20)).xxyy);
    let doubt = vec2f(f32(VARIANCE_FRAMES)) / max(vec2f(frames), vec2f(1.0));
    let mixed = max(vec2f(1.0) / max(vec2f(frames), vec2f(1.0)), vec2f(params.least_variance));
    var variances = mixed * select(long / max(long_weight, vec2f(1e-20)), spatial * doubt, is_short);
    variances = select(vec2f(-1.0), variances, frames > vec2u(0u));
    textureStore(out_variance, p, vec4u(bitcast<vec2u>(variances), 0u, 0u));
}
