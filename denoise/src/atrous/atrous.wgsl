// One level of the wavelet, both lobes at once. Formula and units: mod.rs beside this file.
// 25 taps a pixel at most, 240 loop iterations per 8 lanes at most.

struct AtrousParams {
    // Pixels from the centre to the first and the second tap along x and y.
    first_tap: vec2i,
    second_tap: vec2i,
    // Relative difference of light, at this level.
    sigma_color: f32,
    // Radians, roughly.
    sigma_normal: f32,
    // Rows.
    sigma_plane: f32,
    // Share of the specular lobe's tangent.
    lobe_spread: f32,
    // Relative difference of roughness.
    roughness_fraction: f32,
    // Trace rows per pixel along a row.
    rows_per_column: f32,
    // Of the outermost tap: 1 or 2.
    reach: i32,
    // Of the centre, the first and the second tap along an axis.
    kernel: vec3f,
}

override has_specular: bool = true;

@group(0) @binding(1) var<uniform> params: AtrousParams;
@group(2) @binding(0) var in_edge: texture_2d<u32>;
@group(2) @binding(1) var in_diffuse: texture_2d<f32>;
@group(2) @binding(2) var in_specular: texture_2d<f32>;
@group(3) @binding(0) var out_diffuse: texture_storage_2d<rgba16float, write>;
@group(3) @binding(1) var out_specular: texture_storage_2d<rgba16float, write>;

// Minus the logarithm of a Gaussian weight.
fn atrous_fall(x: f32, sigma: f32) -> f32 {
    let t = x / max(sigma, 1e-6);
    return min(t * t, 80.0);
}

// w_c: relative to the brighter of the two, so that no unit is needed and both see the same. A centre that does not give
// has no say.
fn atrous_alike(centre: vec4f, tap: vec4f, centre_gives: bool) -> f32 {
    let brighter = max(max(length(centre.rgb), length(tap.rgb)), 1e-7);
    let fall = atrous_fall(length(tap.rgb - centre.rgb) / brighter, params.sigma_color);
    return select(1.0, exp(-fall), centre_gives);
}

fn atrous_add(sum: LightSum, centre: vec4f, tap: vec4f, alike: f32, weight: f32) -> LightSum {
    return light_add(sum, vec4f(mix(centre.rgb, tap.rgb, alike), tap.a), weight);
}

@compute @workgroup_size(8, 8)
fn atrous_level(@builtin(global_invocation_id) id: vec3u) {
    let size = vec2i(textureDimensions(in_edge));
    let p = vec2i(id.xy);
    if (any(p >= size)) {
        return;
    }
    let centre = textureLoad(in_edge, p, 0);
    let takes_diffuse = (centre.w & EDGE_DIFFUSE_TAKES) != 0u;
    let takes_specular = has_specular && (centre.w & EDGE_SPECULAR_TAKES) != 0u;
    let diffuse_gives = (centre.w & EDGE_DIFFUSE_GIVES) != 0u;
    let specular_gives = (centre.w & EDGE_SPECULAR_GIVES) != 0u;
    let diffuse_before = light_mended(in_diffuse, p);
    var specular_before = vec4f(0.0);
    if (has_specular) {
        specular_before = light_mended(in_specular, p);
    }
    let position = edge_position(centre, p, size);
    let normal = edge_normal(centre);
    let face_normal = edge_face_normal(centre);
    let footprint = edge_footprint(centre, size);

    let reach = select(-1, params.reach, takes_diffuse || takes_specular);
    var diffuse = light_nothing();
    var specular = diffuse;
    for (var j = -reach; j <= reach; j++) {
        for (var i = -reach; i <= reach; i++) {
            let steps = vec2i(i, j);
            let offset = sign(steps) * select(params.first_tap, params.second_tap, abs(steps) == vec2i(2));
            let q = light_mirrored(p + offset, size);
            let tap = textureLoad(in_edge, q, 0);
            let gives_diffuse = takes_diffuse && (tap.w & EDGE_DIFFUSE_GIVES) != 0u;
            let gives_specular = takes_specular && (tap.w & EDGE_SPECULAR_GIVES) != 0u;
            if (!gives_diffuse && !gives_specular) {
                continue;
            }
            let plane = dot(face_normal, edge_position(tap, q, size) - position) / footprint;
            let fall = atrous_fall(length(edge_normal(tap) - normal), params.sigma_normal)
                + atrous_fall(plane, params.sigma_plane);
            let weight = params.kernel[abs(i)] * params.kernel[abs(j)] * exp(-fall);
            if (gives_diffuse) {
                let light = textureLoad(in_diffuse, q, 0);
                let alike = atrous_alike(diffuse_before, light, diffuse_gives);
                diffuse = atrous_add(diffuse, diffuse_before, light, alike, weight);
            }
            if (has_specular && gives_specular) {
                let light = textureLoad(in_specular, q, 0);
                let rows = vec2f(offset) * vec2f(params.rows_per_column, 1.0);
                let lobe = edge_lobe_weight(centre, tap, rows, size, params.lobe_spread, params.roughness_fraction);
                let alike = atrous_alike(specular_before, light, specular_gives);
                specular = atrous_add(specular, specular_before, light, alike, weight * lobe);
            }
        }
    }

    if (takes_diffuse) {
        textureStore(out_diffuse, p, light_mean(diffuse, diffuse_before));
    } else {
        textureStore(out_diffuse, p, diffuse_before);
    }
    if (has_specular) {
        if (takes_specular) {
            textureStore(out_specular, p, light_mean(specular, specular_before));
        } else {
            textureStore(out_specular, p, specular_before);
        }
    }
}
