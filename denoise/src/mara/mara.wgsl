// One blur along one axis, both lobes at once. Formula, units: mod.rs beside this file. 2 * 16 + 1 taps a pixel at most.

struct MaraParams {
    // Pixels from tap to tap.
    step: vec2i,
    // Taps on either side.
    radius: i32,
    // Power of the cosine.
    sigma_normal: f32,
    // Rows.
    sigma_depth: f32,
    // Share of the specular lobe's slope.
    lobe_spread: f32,
    // Relative difference of roughness.
    roughness_fraction: f32,
    // Trace rows per pixel along a row.
    rows_per_column: f32,
}

@group(0) @binding(1) var<uniform> params: MaraParams;
@group(2) @binding(0) var in_edge: texture_2d<u32>;
@group(2) @binding(1) var in_diffuse: texture_2d<f32>;
@group(2) @binding(2) var in_specular: texture_2d<f32>;
// Diffuse in the low half, specular in the high one; 0: no light.
@group(2) @binding(3) var in_frames: texture_2d<u32>;
@group(3) @binding(0) var out_diffuse: texture_storage_2d<rgba16float, write>;
@group(3) @binding(1) var out_specular: texture_storage_2d<rgba16float, write>;

@compute @workgroup_size(8, 8)
fn mara(@builtin(global_invocation_id) id: vec3u) {
    let size = vec2i(textureDimensions(in_edge));
    let p = vec2i(id.xy);
    if (any(p >= size)) {
        return;
    }
    let centre = edge_centre(textureLoad(in_edge, p, 0), p, size);
    let takes_diffuse = (centre.texel.w & EDGE_DIFFUSE_TAKES) != 0u;
    let takes_specular = (centre.texel.w & EDGE_SPECULAR_TAKES) != 0u;
    let before_diffuse = textureLoad(in_diffuse, p, 0);
    let before_specular = textureLoad(in_specular, p, 0);

    let reach = select(-1, params.radius, takes_diffuse || takes_specular);
    var diffuse = light_nothing();
    var specular = light_nothing();
    for (var j = -reach; j <= reach; j++) {
        let offset = j * params.step;
        let q = light_mirrored(p + offset, size);
        let tap = textureLoad(in_edge, q, 0);
        let frames = textureLoad(in_frames, q, 0).r;
        let part = f32(j) / f32(params.radius + 1);
        let fall = edge_fall(centre, tap, q, size, params.sigma_normal, params.sigma_depth);
        let weight = exp(-2.0 * part * part - fall);
        if (takes_diffuse && (frames & 0xffffu) != 0u) {
            diffuse = light_add(diffuse, textureLoad(in_diffuse, q, 0), weight);
        }
        if (takes_specular && (frames >> 16u) != 0u) {
            let rows = vec2f(offset) * vec2f(params.rows_per_column, 1.0);
            let lobe =
                edge_lobe_weight(centre.texel, tap, rows, size, params.lobe_spread, params.roughness_fraction);
            specular = light_add(specular, textureLoad(in_specular, q, 0), weight * lobe);
        }
    }
    if (takes_diffuse) {
        textureStore(out_diffuse, p, light_mean(diffuse, before_diffuse));
    } else {
        textureStore(out_diffuse, p, before_diffuse);
    }
    // Without a specular lobe the texture is a single texel that nobody reads.
    if (all(p < vec2i(textureDimensions(out_specular)))) {
        if (takes_specular) {
            textureStore(out_specular, p, light_mean(specular, before_specular));
        } else {
            textureStore(out_specular, p, before_specular);
        }
    }
}
