// What every tap of an edge-avoiding filter asks about a pixel, in 16 bytes. Layout, units: mod.rs beside this file.

struct EdgeParams {
    // Least roughness code that the specular lobe is filtered at; above 255: not at all.
    specular_code_min: u32,
    // The object bits that are kept.
    object_mask: u32,
}

@group(0) @binding(1) var<uniform> params: EdgeParams;
@group(2) @binding(0) var in_surface: texture_2d<u32>;
@group(2) @binding(1) var in_distance: texture_2d<f32>;
@group(2) @binding(2) var in_face_normal: texture_2d<u32>;
@group(2) @binding(3) var in_motion_id: texture_2d<u32>;
@group(2) @binding(4) var in_diffuse: texture_2d<f32>;
@group(2) @binding(5) var in_specular: texture_2d<f32>;
@group(2) @binding(6) var in_samples: texture_2d<u32>;
@group(3) @binding(0) var out_edge: texture_storage_2d<rgba32uint, write>;
@group(3) @binding(1) var<storage, read_write> out_invalid: atomic<u32>;

const DISTANCE_LARGEST = 1e15;

@compute @workgroup_size(8, 8)
fn edge_pack(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(out_edge);
    if (any(id.xy >= size)) {
        return;
    }
    let diffuse_is_valid = light_is_valid(textureLoad(in_diffuse, id.xy, 0));
    let specular_is_valid = light_is_valid(textureLoad(in_specular, id.xy, 0));
    if (!diffuse_is_valid || !specular_is_valid) {
        atomicAdd(&out_invalid, 1u);
    }
    let distance = textureLoad(in_distance, id.xy, 0).r;
    if (!(distance > 0.0) || !half_is_finite(vec4f(distance)).x) {
        textureStore(out_edge, id.xy, vec4u(0u));
        return;
    }

    let words = textureLoad(in_surface, id.xy, 0);
    let surface = surface_unpack_gbuffer(words);
    let is_traced = textureLoad(in_samples, id.xy, 0).r != 0u;
    // The overall roughness is the higher of the two.
    let code = max(words.w & 0xffu, (words.w >> 8u) & 0xffu);
    var bits = textureLoad(in_motion_id, id.xy, 0).y & params.object_mask;
    if (any(brdf_diffuse_albedo(surface) > vec3f(0.0))) {
        bits |= EDGE_DIFFUSE_TAKES | select(0u, EDGE_DIFFUSE_GIVES, is_traced && diffuse_is_valid);
    }
    if (brdf_has_specular(surface) && code >= params.specular_code_min) {
        bits |= EDGE_SPECULAR_TAKES | select(0u, EDGE_SPECULAR_GIVES, is_traced && specular_is_valid);
    }
    let point = vec2f(id.xy) + vec2f(0.5) + frame.jitter;
    let depth = min(distance, DISTANCE_LARGEST) * dot(frame_view_direction(point, size), frame.forward);
    let face_normal = textureLoad(in_face_normal, id.xy, 0).r;
    textureStore(out_edge, id.xy, vec4u(bitcast<u32>(depth), (words.x & 0xffffffu) | (code << 24u), face_normal, bits));
}
