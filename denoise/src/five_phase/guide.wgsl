// What every tap of the filter asks about a pixel, in 16 bytes: where it is, how it faces, whose light it shares.
// Bits of the last word: ../mod.rs and reference.rs; the filter beside this file reads them.

struct GuideParams {
    // Least roughness code of phases 0..3, and of phase 4.
    thresholds: vec4u,
    last_threshold: u32,
    // 0: there is no specular lobe, and in_specular is anything.
    has_specular: u32,
}

@group(0) @binding(1) var<uniform> params: GuideParams;
@group(2) @binding(0) var in_surface: texture_2d<u32>;
@group(2) @binding(1) var in_distance: texture_2d<f32>;
@group(2) @binding(2) var in_diffuse: texture_2d<f32>;
@group(2) @binding(3) var in_specular: texture_2d<f32>;
@group(2) @binding(4) var in_samples: texture_2d<u32>;
@group(3) @binding(0) var out_guide: texture_storage_2d<rgba32uint, write>;
@group(3) @binding(1) var<storage, read_write> out_invalid: atomic<u32>;

// One bit per phase whose threshold this roughness reaches.
fn guide_phases(code: u32) -> u32 {
    var phases = 0u;
    for (var k = 0u; k < 4u; k++) {
        phases |= select(0u, 1u << k, code >= params.thresholds[k]);
    }
    return phases | select(0u, 16u, code >= params.last_threshold);
}

@compute @workgroup_size(8, 8)
fn guide_pack(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(out_guide);
    if (any(id.xy >= size)) {
        return;
    }
    let distance = textureLoad(in_distance, id.xy, 0).r;
    let diffuse_is_valid = light_is_valid(textureLoad(in_diffuse, id.xy, 0));
    let specular_is_valid = params.has_specular == 0u || light_is_valid(textureLoad(in_specular, id.xy, 0));
    if (!diffuse_is_valid || !specular_is_valid) {
        atomicAdd(&out_invalid, 1u);
    }
    if (!(distance > 0.0)) {
        textureStore(out_guide, id.xy, vec4u(0u));
        return;
    }

    let words = textureLoad(in_surface, id.xy, 0);
    let surface = surface_unpack_gbuffer(words);
    let is_traced = textureLoad(in_samples, id.xy, 0).r != 0u;
    var bits = words.x & 0xffffffu;
    if (params.has_specular != 0u && brdf_has_specular(surface)) {
        // The overall roughness is the higher of the two.
        let code = max(words.w & 0xffu, (words.w >> 8u) & 0xffu);
        bits |= guide_phases(code) << 24u;
        bits |= select(0u, 1u << 29u, is_traced && specular_is_valid);
    }
    if (any(brdf_diffuse_albedo(surface) > vec3f(0.0))) {
        bits |= 1u << 30u;
        bits |= select(0u, 1u << 31u, is_traced && diffuse_is_valid);
    }
    let point = vec2f(id.xy) + vec2f(0.5) + frame.jitter;
    let position = distance * frame_view_direction(point, size);
    textureStore(out_guide, id.xy, vec4u(bitcast<vec3u>(position), bits));
}
