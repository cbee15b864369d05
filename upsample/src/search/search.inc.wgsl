// Trace pixels around a display pixel, after modulate. Rules: mod.rs beside this file.
// Worst case of the search: 49 loop iterations a pixel, 392 per 8 lanes.

struct SearchParams {
    // dx in the low half, dy in the high half, nearest first.
    offsets: array<vec4u, 13>,
    offset_count: u32,
    least_cosine: f32,
    // Metres off the plane per metre of distance; negative: no test.
    plane_distance: f32,
    has_specular: u32,
    direct_lobes: u32,
}

@group(0) @binding(1) var<uniform> search_params: SearchParams;
@group(2) @binding(6) var trace_surface: texture_2d<u32>;
@group(2) @binding(7) var trace_distance: texture_2d<f32>;
@group(2) @binding(8) var light_samples: texture_2d<u32>;

// A display pixel and what it needs from elsewhere: nothing where it hit nothing, or where it has light of its own.
struct SearchPixel {
    surface: Surface,
    // From the eye, m.
    position: vec3f,
    distance: f32,
    needs_diffuse: bool,
    needs_specular: bool,
    is_same_size: bool,
}

fn search_pixel(pixel: vec2u) -> SearchPixel {
    let distance = textureLoad(display_distance, pixel, 0).r;
    let surface = surface_unpack_gbuffer(textureLoad(display_surface, pixel, 0));
    let is_same_size = all(frame.trace_size == frame.display_size);
    let needs = distance > 0.0 && !is_same_size;
    return SearchPixel(
        surface,
        distance * modulate_view_direction(pixel),
        distance,
        needs && any(brdf_diffuse_albedo(surface) > vec3f(0.0)),
        needs && search_params.has_specular == 1u && brdf_has_specular(surface),
        is_same_size,
    );
}

// Where a display pixel's centre lies among the centres of trace pixels: a whole number is on one of them.
fn search_place(pixel: vec2u) -> vec2f {
    return (vec2f(pixel) + vec2f(0.5)) * vec2f(frame.trace_size) / vec2f(frame.display_size) - vec2f(0.5) - frame.jitter;
}

// A trace pixel as a display pixel sees it.
struct SearchTap {
    pixel: vec2u,
    // Whether it says something about the lobe.
    has_diffuse: bool,
    has_specular: bool,
    // Cosine between the normals.
    facing: f32,
    // Metres.
    off_plane: f32,
}

fn search_tap(wanted: SearchPixel, p: vec2i) -> SearchTap {
    if (any(p < vec2i(0)) || any(p >= vec2i(frame.trace_size))) {
        return SearchTap(vec2u(0u), false, false, -2.0, 0.0);
    }
    let q = vec2u(p);
    let distance = textureLoad(trace_distance, q, 0).r;
    let counts = distance > 0.0 && textureLoad(light_samples, q, 0).r != 0u;
    let surface = surface_unpack_gbuffer(textureLoad(trace_surface, q, 0));
    let point = vec2f(q) + vec2f(0.5) + frame.jitter;
    let position = distance * frame_view_direction(point, frame.trace_size);
    return SearchTap(
        q,
        counts && any(brdf_diffuse_albedo(surface) > vec3f(0.0)),
        counts && brdf_has_specular(surface),
        dot(wanted.surface.normal, surface.normal),
        abs(dot(wanted.surface.normal, position - wanted.position)),
    );
}

struct SearchCandidate {
    pixel: vec2u,
    facing: f32,
    is_accepted: bool,
}

// The first accepted one stays; until then, the one that faces best, the earlier of two equals.
fn search_offer(held: SearchCandidate, offered: SearchCandidate) -> SearchCandidate {
    if (!held.is_accepted && (offered.is_accepted || offered.facing > held.facing)) {
        return offered;
    }
    return held;
}

fn search_offset(index: u32) -> vec2i {
    let packed = search_params.offsets[index / 4u][index % 4u];
    return vec2i(i32(packed << 16u) >> 16u, i32(packed) >> 16u);
}

struct SearchFound {
    diffuse: SearchCandidate,
    specular: SearchCandidate,
}

// The best candidate for each lobe that is needed.
fn search_outward(wanted: SearchPixel, centre: vec2u, needs_diffuse: bool, needs_specular: bool) -> SearchFound {
    // Nothing facing better than this is nothing at all.
    var diffuse = SearchCandidate(centre, -2.0, false);
    var specular = diffuse;
    let most = select(0u, search_params.offset_count, needs_diffuse || needs_specular);
    for (var i = 0u; i < most; i++) {
        if ((diffuse.is_accepted || !needs_diffuse) && (specular.is_accepted || !needs_specular)) {
            break;
        }
        let tap = search_tap(wanted, vec2i(centre) + search_offset(i));
        let is_on_plane =
            search_params.plane_distance < 0.0 || tap.off_plane <= search_params.plane_distance * wanted.distance;
        let is_accepted = tap.facing >= search_params.least_cosine && is_on_plane;
        let offered = SearchCandidate(tap.pixel, tap.facing, is_accepted);
        if (tap.has_diffuse) {
            diffuse = search_offer(diffuse, offered);
        }
        if (tap.has_specular) {
            specular = search_offer(specular, offered);
        }
    }
    return SearchFound(diffuse, specular);
}
