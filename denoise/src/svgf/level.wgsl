// One level of the wavelet, guided by the variance, both lobes at once. Formula, units: mod.rs beside this file.
// 25 taps a pixel at most.

@group(2) @binding(1) var in_diffuse: texture_2d<f32>;
@group(2) @binding(2) var in_specular: texture_2d<f32>;
@group(2) @binding(3) var in_variance: texture_2d<u32>;
@group(3) @binding(0) var out_diffuse: texture_storage_2d<rgba16float, write>;
@group(3) @binding(1) var out_specular: texture_storage_2d<rgba16float, write>;
@group(3) @binding(2) var out_variance: texture_storage_2d<rg32uint, write>;

// Below these, a difference of luminance is rounding: a few steps of a half float, relative and next to 0.
const LEVEL_RELATIVE = 0.00390625;
const LEVEL_ABSOLUTE = 2.4e-7;

// One lobe at the centre; a negative variance: no light of its own.
struct Centre {
    light: vec4f,
    luminance: f32,
    variance: f32,
}

struct LevelSum {
    light: LightSum,
    // Of squared weights, of all but the centre.
    variance: f32,
    // What the centre is worth.
    own: f32,
}

// Diffuse, specular; negative: no light here.
fn level_variances(p: vec2i) -> vec2f {
    return bitcast<vec2f>(textureLoad(in_variance, p, 0).rg);
}

fn level_centre(light: vec4f, variance: f32) -> Centre {
    return Centre(light, brdf_luminance(light.rgb), variance);
}

// w_l, the same seen from either side; a centre without light of its own has no say.
fn level_alike(centre: Centre, luminance: f32, variance: f32) -> f32 {
    let deviation = params.sigma_luminance * sqrt(0.5 * (max(centre.variance, 0.0) + variance));
    let rounding = LEVEL_RELATIVE * max(centre.luminance, luminance) + LEVEL_ABSOLUTE;
    let fall = min(abs(luminance - centre.luminance) / (deviation + rounding), 80.0);
    return select(1.0, exp(-fall), centre.variance >= 0.0);
}

fn level_add(sum: LevelSum, centre: Centre, light: vec4f, variance: f32, weight: f32, is_centre: bool) -> LevelSum {
    let alike = level_alike(centre, brdf_luminance(light.rgb), variance);
    let taken = select(weight * alike, 0.0, is_centre);
    return LevelSum(
        light_add(sum.light, vec4f(mix(centre.light.rgb, light.rgb, alike), light.a), weight),
        sum.variance + taken * taken * variance,
        sum.own + weight - taken,
    );
}

fn level_variance(sum: LevelSum, before: f32) -> f32 {
    let weight = max(sum.light.weight, 1e-15);
    let own = sum.own * sum.own * before;
    return select(before, (sum.variance + own) / (weight * weight), before >= 0.0);
}

@compute @workgroup_size(8, 8)
fn level(@builtin(global_invocation_id) id: vec3u) {
    let size = vec2i(textureDimensions(in_edge));
    let p = vec2i(id.xy);
    if (any(p >= size)) {
        return;
    }
    let centre = edge_centre(textureLoad(in_edge, p, 0), p, size);
    let takes_diffuse = (centre.texel.w & EDGE_DIFFUSE_TAKES) != 0u;
    let takes_specular = (centre.texel.w & EDGE_SPECULAR_TAKES) != 0u;
    let variance_before = level_variances(p);
    let own_diffuse = level_centre(textureLoad(in_diffuse, p, 0), variance_before.x);
    let own_specular = level_centre(textureLoad(in_specular, p, 0), variance_before.y);

    let reach = select(-1, params.reach, takes_diffuse || takes_specular);
    var diffuse = LevelSum(light_nothing(), 0.0, 0.0);
    var specular = diffuse;
    for (var j = -reach; j <= reach; j++) {
        for (var i = -reach; i <= reach; i++) {
            let steps = vec2i(i, j);
            let offset = sign(steps) * select(params.first_tap, params.second_tap, abs(steps) == vec2i(2));
            let q = light_mirrored(p + offset, size);
            let tap_variance = level_variances(q);
            let gives_diffuse = takes_diffuse && tap_variance.x >= 0.0;
            let gives_specular = takes_specular && tap_variance.y >= 0.0;
            if (!gives_diffuse && !gives_specular) {
                continue;
            }
            let tap = textureLoad(in_edge, q, 0);
            let is_centre = all(q == p);
            let fall = svgf_geometry_fall(centre, tap, q, size);
            let weight = params.kernel[abs(i)] * params.kernel[abs(j)] * exp(-fall);
            if (gives_diffuse) {
                let light = textureLoad(in_diffuse, q, 0);
                diffuse = level_add(diffuse, own_diffuse, light, tap_variance.x, weight, is_centre);
            }
            if (gives_specular) {
                let light = textureLoad(in_specular, q, 0);
                let lobe = svgf_lobe_weight(centre, tap, offset, size);
                specular = level_add(specular, own_specular, light, tap_variance.y, weight * lobe, is_centre);
            }
        }
    }

    if (takes_diffuse) {
        textureStore(out_diffuse, p, light_mean(diffuse.light, own_diffuse.light));
    } else {
        textureStore(out_diffuse, p, own_diffuse.light);
    }
    // Without a specular lobe the texture is a single texel that nobody reads.
    if (all(p < vec2i(textureDimensions(out_specular)))) {
        if (takes_specular) {
            textureStore(out_specular, p, light_mean(specular.light, own_specular.light));
        } else {
            textureStore(out_specular, p, own_specular.light);
        }
    }
    let variances = vec2f(level_variance(diffuse, variance_before.x), level_variance(specular, variance_before.y));
    textureStore(out_variance, p, vec4u(bitcast<vec2u>(variances), 0u, 0u));
}
