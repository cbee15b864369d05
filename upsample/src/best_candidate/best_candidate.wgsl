// Outward search for the nearest trace pixel that faces as the display pixel does. Rules: mod.rs beside this file.
// Worst case: 49 loop iterations a pixel, 392 per 8 lanes.

struct BestCandidateParams {
    // dx in the low half, dy in the high half, nearest first.
    offsets: array<vec4u, 13>,
    offset_count: u32,
    least_cosine: f32,
    // Metres off the plane per metre of distance; negative: no test.
    plane_distance: f32,
    has_specular: u32,
    direct_lobes: u32,
}

@group(0) @binding(1) var<uniform> params: BestCandidateParams;
@group(2) @binding(6) var trace_surface: texture_2d<u32>;
@group(2) @binding(7) var trace_distance: texture_2d<f32>;
@group(2) @binding(8) var light_samples: texture_2d<u32>;
@group(3) @binding(0) var out_color: texture_storage_2d<rgba16float, write>;
@group(3) @binding(1) var<storage, read_write> out_fallbacks: atomic<u32>;

struct Candidate {
    pixel: vec2u,
    facing: f32,
    is_accepted: bool,
}

// The first accepted one stays; until then, the one that faces best, the earlier of two equals.
fn candidate_offer(held: Candidate, offered: Candidate) -> Candidate {
    if (!held.is_accepted && (offered.is_accepted || offered.facing > held.facing)) {
        return offered;
    }
    return held;
}

fn candidate_offset(index: u32) -> vec2i {
    let packed = params.offsets[index / 4u][index % 4u];
    return vec2i(i32(packed << 16u) >> 16u, i32(packed) >> 16u);
}

@compute @workgroup_size(8, 8)
fn best_candidate(@builtin(global_invocation_id) id: vec3u) {
    let pixel = id.xy;
    if (any(pixel >= frame.display_size)) {
        return;
    }
    let distance = textureLoad(display_distance, pixel, 0).r;
    let surface = surface_unpack_gbuffer(textureLoad(display_surface, pixel, 0));
    let position = distance * modulate_view_direction(pixel);
    let centre = modulate_trace_pixel(pixel);

    // Nothing facing better than this is nothing at all.
    var diffuse = Candidate(centre, -2.0, false);
    var specular = diffuse;
    let is_same_size = all(frame.trace_size == frame.display_size);
    let is_searched = distance > 0.0 && !is_same_size;
    let needs_diffuse = is_searched && any(brdf_diffuse_albedo(surface) > vec3f(0.0));
    let needs_specular = is_searched && params.has_specular == 1u && brdf_has_specular(surface);
    let most = select(0u, params.offset_count, is_searched);
    for (var i = 0u; i < most; i++) {
        if ((diffuse.is_accepted || !needs_diffuse) && (specular.is_accepted || !needs_specular)) {
            break;
        }
        let p = vec2i(centre) + candidate_offset(i);
        if (any(p < vec2i(0)) || any(p >= vec2i(frame.trace_size))) {
            continue;
        }
        let q = vec2u(p);
        let q_distance = textureLoad(trace_distance, q, 0).r;
        if (!(q_distance > 0.0) || textureLoad(light_samples, q, 0).r == 0u) {
            continue;
        }
        let q_surface = surface_unpack_gbuffer(textureLoad(trace_surface, q, 0));
        let facing = dot(surface.normal, q_surface.normal);
        let point = vec2f(q) + vec2f(0.5) + frame.jitter;
        let q_position = q_distance * frame_view_direction(point, frame.trace_size);
        let off_plane = abs(dot(surface.normal, q_position - position));
        let is_on_plane = params.plane_distance < 0.0 || off_plane <= params.plane_distance * distance;
        let offered = Candidate(q, facing, facing >= params.least_cosine && is_on_plane);
        if (any(brdf_diffuse_albedo(q_surface) > vec3f(0.0))) {
            diffuse = candidate_offer(diffuse, offered);
        }
        if (brdf_has_specular(q_surface)) {
            specular = candidate_offer(specular, offered);
        }
    }
    if ((needs_diffuse && !diffuse.is_accepted) || (needs_specular && !specular.is_accepted)) {
        atomicAdd(&out_fallbacks, 1u);
    }

    // A lobe that the surface lacks gets no light from elsewhere.
    var light = BrdfModulators(vec3f(0.0), vec3f(0.0));
    if (needs_diffuse || is_same_size) {
        light.diffuse = textureLoad(light_diffuse, diffuse.pixel, 0).rgb;
    }
    if (needs_specular || (is_same_size && params.has_specular == 1u)) {
        light.specular = textureLoad(light_specular, specular.pixel, 0).rgb;
    }
    textureStore(out_color, pixel, modulate_pixel(pixel, light.diffuse, light.specular, params.direct_lobes));
}
