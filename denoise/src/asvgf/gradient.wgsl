// How light has changed since the last frame, summed over strata of 3x3 pixels. Formula: mod.rs beside this file.

@group(2) @binding(3) var in_diffuse: texture_2d<f32>;
@group(2) @binding(4) var in_specular: texture_2d<f32>;
// Bits of f32: diffuse, specular; negative where there is none.
@group(2) @binding(5) var in_luminance_before: texture_2d<u32>;
// Now, before, squared difference, pixels.
@group(3) @binding(0) var out_diffuse_strata: texture_storage_2d<rgba32float, write>;
@group(3) @binding(1) var out_specular_strata: texture_storage_2d<rgba32float, write>;
@group(3) @binding(2) var out_luminance: texture_storage_2d<rg32uint, write>;

const GRADIENT_STRATUM = 3;

fn gradient_term(now: f32, before: f32) -> vec4f {
    let counts = now >= 0.0 && before >= 0.0;
    return select(vec4f(0.0), vec4f(now, before, (now - before) * (now - before), 1.0), counts);
}

@compute @workgroup_size(8, 8)
fn gradient(@builtin(global_invocation_id) id: vec3u) {
    let size = vec2i(textureDimensions(in_edge));
    let stratum = vec2i(id.xy);
    if (any(stratum >= vec2i(textureDimensions(out_diffuse_strata)))) {
        return;
    }
    var diffuse = vec4f(0.0);
    var specular = vec4f(0.0);
    for (var k = 0; k < GRADIENT_STRATUM * GRADIENT_STRATUM; k++) {
        let p = stratum * GRADIENT_STRATUM + vec2i(k % GRADIENT_STRATUM, k / GRADIENT_STRATUM);
        if (any(p >= size)) {
            continue;
        }
        let texel = textureLoad(in_edge, p, 0);
        let gives = (vec2u(texel.w) & vec2u(EDGE_DIFFUSE_GIVES, EDGE_SPECULAR_GIVES)) != vec2u(0u);
        let lights = vec2f(
            brdf_luminance(light_mended(in_diffuse, p).rgb),
            brdf_luminance(light_mended(in_specular, p).rgb),
        );
        let now = select(vec2f(-1.0), lights, gives);
        textureStore(out_luminance, p, vec4u(bitcast<vec2u>(now), 0u, 0u));

        let motion = temporal_motion(p);
        let expected = temporal_expected(texel, p, motion.pixels, size);
        let q = vec2i(floor(vec2f(p) - motion.pixels + vec2f(0.5)));
        let is_there = params.keeps_history != 0u && motion.is_known && expected.depth > 0.0
            && all(q >= vec2i(0)) && all(q < size);
        if (!is_there || !temporal_is_same(expected, q, size)) {
            continue;
        }
        let before = bitcast<vec2f>(textureLoad(in_luminance_before, q, 0).rg);
        diffuse += gradient_term(now.x, before.x);
        specular += gradient_term(now.y, before.y);
    }
    textureStore(out_diffuse_strata, stratum, diffuse);
    textureStore(out_specular_strata, stratum, specular);
}
