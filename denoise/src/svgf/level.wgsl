// One level of the wavelet, guided by the variance, both lobes at once. Formula, units: mod.rs beside this file.
// 25 + 9 taps a pixel.

@group(2) @binding(1) var in_diffuse: texture_2d<f32>;
@group(2) @binding(2) var in_specular: texture_2d<f32>;
@group(2) @binding(3) var in_variance: texture_2d<u32>;
@group(3) @binding(0) var out_diffuse: texture_storage_2d<rgba16float, write>;
@group(3) @binding(1) var out_specular: texture_storage_2d<rgba16float, write>;
@group(3) @binding(2) var out_variance: texture_storage_2d<rg32uint, write>;

const LEVEL_KERNEL = array<f32, 3>(0.375, 0.25, 0.0625);
// Below these, a difference of luminance is rounding: a few steps of a half float, relative and next to 0.
const LEVEL_RELATIVE = 0.00390625;
const LEVEL_ABSOLUTE = 2.4e-7;

struct LevelSum {
    light: EdgeSum,
    // Of squared weights.
    variance: f32,
}

// Diffuse, specular; negative: no light here.
fn level_variances(p: vec2i) -> vec2f {
    return bitcast<vec2f>(textureLoad(in_variance, p, 0).rg);
}

// The variance after a Gauss over 3x3 pixels, of both lobes; only those that have light count.
fn level_blurred_variance(p: vec2i, size: vec2i) -> vec2f {
    var sum = vec2f(0.0);
    var weights = vec2f(0.0);
    for (var k = 0; k < 9; k++) {
        let offset = vec2i(k % 3, k / 3) - vec2i(1);
        let q = p + offset;
        if (any(q < vec2i(0)) || any(q >= size)) {
            continue;
        }
        let found = level_variances(q);
        let weight = select(vec2f(0.0), vec2f(0.25 / f32(1 << u32(abs(offset.x) + abs(offset.y)))), found >= vec2f(0.0));
        sum += weight * found;
        weights += weight;
    }
    return sum / max(weights, vec2f(1e-20));
}

fn level_add(sum: LevelSum, light: vec4f, variance: f32, weight: f32) -> LevelSum {
    return LevelSum(edge_sum_add(sum.light, light, weight), sum.variance + weight * weight * variance);
}

// Minus the logarithm of w_l. `deviation` is sigma_luminance standard deviations of the centre; a centre that has no light has no say.
fn level_luminance_fall(centre: f32, tap: f32, deviation: f32, centre_gives: bool) -> f32 {
    let rounding = LEVEL_RELATIVE * max(abs(centre), abs(tap)) + LEVEL_ABSOLUTE;
    return select(0.0, min(abs(tap - centre) / (deviation + rounding), 80.0), centre_gives);
}

fn level_variance(sum: LevelSum, before: f32) -> f32 {
    let weight = max(sum.light.weight, 1e-15);
    return select(before, sum.variance / (weight * weight), before >= 0.0);
}

@compute @workgroup_size(8, 8)
fn level(@builtin(global_invocation_id) id: vec3u) {
    let size = vec2i(textureDimensions(in_edge));
    let p = vec2i(id.xy);
    if (any(p >= size)) {
        return;
    }
    let centre = svgf_centre(p, size);
    let takes_diffuse = (centre.texel.w & EDGE_DIFFUSE_TAKES) != 0u;
    let takes_specular = (centre.texel.w & EDGE_SPECULAR_TAKES) != 0u;
    let diffuse_before = edge_untouched(textureLoad(in_diffuse, p, 0));
    let specular_before = edge_untouched(textureLoad(in_specular, p, 0));
    let luminance = vec2f(brdf_luminance(diffuse_before.rgb), brdf_luminance(specular_before.rgb));
    let variance_before = level_variances(p);
    let deviation = params.sigma_luminance * sqrt(level_blurred_variance(p, size));

    let reach = select(-1, 2, takes_diffuse || takes_specular);
    var diffuse = LevelSum(EdgeSum(vec3f(0.0), 0.0, 0.0, 0.0), 0.0);
    var specular = diffuse;
    for (var j = -reach; j <= reach; j++) {
        for (var i = -reach; i <= reach; i++) {
            let steps = vec2i(i, j);
            let offset = sign(steps) * select(params.first_tap, params.second_tap, abs(steps) == vec2i(2));
            let q = p + offset;
            if (any(q < vec2i(0)) || any(q >= size)) {
                continue;
            }
            let tap_variance = level_variances(q);
            let gives_diffuse = takes_diffuse && tap_variance.x >= 0.0;
            let gives_specular = takes_specular && tap_variance.y >= 0.0;
            if (!gives_diffuse && !gives_specular) {
                continue;
            }
            let tap = textureLoad(in_edge, q, 0);
            let kernel = LEVEL_KERNEL[abs(i)] * LEVEL_KERNEL[abs(j)];
            let fall = svgf_geometry_fall(centre, tap, q, size);
            if (gives_diffuse) {
                let light = textureLoad(in_diffuse, q, 0);
                let y = brdf_luminance(light.rgb);
                let all = fall + level_luminance_fall(luminance.x, y, deviation.x, variance_before.x >= 0.0);
                diffuse = level_add(diffuse, light, tap_variance.x, kernel * exp(-all));
            }
            if (gives_specular) {
                let light = textureLoad(in_specular, q, 0);
                let y = brdf_luminance(light.rgb);
                let all = fall + level_luminance_fall(luminance.y, y, deviation.y, variance_before.y >= 0.0);
                let lobe = svgf_lobe_weight(centre, tap, offset, size);
                specular = level_add(specular, light, tap_variance.y, kernel * lobe * exp(-all));
            }
        }
    }

    if (takes_diffuse) {
        textureStore(out_diffuse, p, edge_sum_mean(diffuse.light, diffuse_before));
    } else {
        textureStore(out_diffuse, p, diffuse_before);
    }
    // Without a specular lobe the texture is a single texel that nobody reads.
    if (all(p < vec2i(textureDimensions(out_specular)))) {
        if (takes_specular) {
            textureStore(out_specular, p, edge_sum_mean(specular.light, specular_before));
        } else {
            textureStore(out_specular, p, specular_before);
        }
    }
    let variances = vec2f(level_variance(diffuse, variance_before.x), level_variance(specular, variance_before.y));
    textureStore(out_variance, p, vec4u(bitcast<vec2u>(variances), 0u, 0u));
}
