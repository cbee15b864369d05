// What share of its history a pixel should forget, from the strata around it. Formula: mod.rs beside this file.
// 25 strata a pixel.

struct HasteParams {
    // Power of the cosine.
    sigma_normal: f32,
    // Rows.
    sigma_depth: f32,
    // Standard errors.
    lag_sigma: f32,
}

@group(0) @binding(1) var<uniform> params: HasteParams;
@group(2) @binding(0) var in_edge: texture_2d<u32>;
// Now, before, squared difference, pixels.
@group(2) @binding(1) var in_diffuse_strata: texture_2d<f32>;
@group(2) @binding(2) var in_specular_strata: texture_2d<f32>;
// Bits of f32: diffuse, specular.
@group(3) @binding(0) var out_haste: texture_storage_2d<rg32uint, write>;

const HASTE_STRATUM = 3;
const HASTE_REACH = 2;

fn haste_of(sum: vec4f) -> f32 {
    let count = max(sum.w, 1e-20);
    let apart = abs(sum.x - sum.y) / count;
    let error = sqrt(sum.z / count / max(count, 1.0));
    let brighter = max(sum.x, sum.y) / count;
    let share = clamp((apart - params.lag_sigma * error) / max(brighter, 1e-20), 0.0, 1.0);
    return select(0.0, share, sum.w > 0.0);
}

@compute @workgroup_size(8, 8)
fn haste(@builtin(global_invocation_id) id: vec3u) {
    let size = vec2i(textureDimensions(in_edge));
    let p = vec2i(id.xy);
    if (any(p >= size)) {
        return;
    }
    let centre = edge_centre(textureLoad(in_edge, p, 0), p, size);
    let strata = vec2i(textureDimensions(in_diffuse_strata));
    var diffuse = vec4f(0.0);
    var specular = vec4f(0.0);
    for (var j = -HASTE_REACH; j <= HASTE_REACH; j++) {
        for (var i = -HASTE_REACH; i <= HASTE_REACH; i++) {
            let stratum = p / HASTE_STRATUM + vec2i(i, j);
            if (any(stratum < vec2i(0)) || any(stratum >= strata)) {
                continue;
            }
            let q = min(stratum * HASTE_STRATUM + vec2i(1), size - vec2i(1));
            let tap = textureLoad(in_edge, q, 0);
            let weight = exp(-edge_fall(centre, tap, q, size, params.sigma_normal, params.sigma_depth));
            diffuse += weight * textureLoad(in_diffuse_strata, stratum, 0);
            specular += weight * textureLoad(in_specular_strata, stratum, 0);
        }
    }
    textureStore(out_haste, p, vec4u(bitcast<vec2u>(vec2f(haste_of(diffuse), haste_of(specular))), 0u, 0u));
}
