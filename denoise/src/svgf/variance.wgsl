// How noisy a pixel's luminance is: by its own history where that is long enough, by its neighbours' where not.
// 49 taps a pixel at most.

@group(2) @binding(1) var in_moments: texture_2d<f32>;
@group(2) @binding(2) var in_frames: texture_2d<u32>;
// Bits of f32: diffuse, specular.
@group(3) @binding(0) var out_variance: texture_storage_2d<rg32uint, write>;

const VARIANCE_FRAMES = 4u;
const VARIANCE_REACH = 3;

// Negative: the lobe has no light here. `frames` below four is trusted less.
fn variance_of(moments: vec2f, frames: u32) -> f32 {
    let doubt = max(f32(VARIANCE_FRAMES) / max(f32(frames), 1.0), 1.0);
    return select(-1.0, max(moments.y - moments.x * moments.x, 0.0) * doubt, frames > 0u);
}

@compute @workgroup_size(8, 8)
fn variance(@builtin(global_invocation_id) id: vec3u) {
    let size = vec2i(textureDimensions(in_edge));
    let p = vec2i(id.xy);
    if (any(p >= size)) {
        return;
    }
    let centre = svgf_centre(p, size);
    let packed = textureLoad(in_frames, p, 0).r;
    let frames = vec2u(packed & 0xffffu, packed >> 16u);
    var moments = textureLoad(in_moments, p, 0);
    let is_short = (frames > vec2u(0u)) & (frames < vec2u(VARIANCE_FRAMES));

    let reach = select(-1, VARIANCE_REACH, any(is_short));
    var sum = vec4f(0.0);
    var weights = vec2f(0.0);
    for (var j = -reach; j <= reach; j++) {
        for (var i = -reach; i <= reach; i++) {
            let offset = vec2i(i, j);
            let q = p + offset;
            if (any(q < vec2i(0)) || any(q >= size)) {
                continue;
            }
            let tap = textureLoad(in_edge, q, 0);
            let tap_frames = textureLoad(in_frames, q, 0).r;
            let geometry = exp(-svgf_geometry_fall(centre, tap, q, size));
            let lobes = vec2f(geometry, geometry * svgf_lobe_weight(centre, tap, offset, size));
            let gives = vec2u(tap_frames & 0xffffu, tap_frames >> 16u) > vec2u(0u);
            let weight = select(vec2f(0.0), lobes, gives);
            sum += weight.xxyy * textureLoad(in_moments, q, 0);
            weights += weight;
        }
    }
    // The centre's own weight is 1 wherever it has a frame.
    let means = sum / max(weights, vec2f(1e-20)).xxyy;
    moments = select(moments, means, vec4<bool>(is_short.xx, is_short.yy));
    let variances = vec2f(variance_of(moments.xy, frames.x), variance_of(moments.zw, frames.y));
    textureStore(out_variance, p, vec4u(bitcast<vec2u>(variances), 0u, 0u));
}
