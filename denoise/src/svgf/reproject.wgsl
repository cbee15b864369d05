// Finds a pixel in the last frame, and mixes its light and moments with what was found. Formula, units: mod.rs beside
// this file.

struct ReprojectParams {
    // The last frame's view, as `frame` has this one's.
    previous_forward: vec3f,
    alpha_color: f32,
    previous_right: vec3f,
    alpha_moments: f32,
    previous_up: vec3f,
    // Distance from the expected plane, relative to depth.
    plane_tolerance: f32,
    // This frame's eye minus the last one's, metres.
    eye_offset: vec3f,
    // Cosine between shading normals.
    normal_min: f32,
    // 0 or 1, a factor: a branch on it would have Mesa's software driver build the kernel anew for each dispatch.
    keeps_history: u32,
    // Frames.
    history_max: f32,
}

@group(0) @binding(1) var<uniform> params: ReprojectParams;
@group(2) @binding(0) var in_edge: texture_2d<u32>;
@group(2) @binding(1) var in_motion_id: texture_2d<u32>;
@group(2) @binding(2) var in_diffuse: texture_2d<f32>;
@group(2) @binding(3) var in_specular: texture_2d<f32>;
@group(2) @binding(4) var in_edge_before: texture_2d<u32>;
@group(2) @binding(5) var in_diffuse_before: texture_2d<f32>;
@group(2) @binding(6) var in_specular_before: texture_2d<f32>;
@group(2) @binding(7) var in_moments_before: texture_2d<f32>;
@group(2) @binding(8) var in_frames_before: texture_2d<u32>;
@group(3) @binding(0) var out_diffuse: texture_storage_2d<rgba16float, write>;
@group(3) @binding(1) var out_specular: texture_storage_2d<rgba16float, write>;
@group(3) @binding(2) var out_moments: texture_storage_2d<rgba32float, write>;
@group(3) @binding(3) var out_frames: texture_storage_2d<r32uint, write>;

const REPROJECT_WEIGHT_MIN = 0.01;

// Weighted sums of what a lobe kept.
struct Kept {
    light: EdgeSum,
    moments: vec2f,
    frames: f32,
}

struct KeptLobes {
    diffuse: Kept,
    specular: Kept,
}

// What taps are tested against: the pixel's texel, and its position relative to the last frame's eye.
struct Expected {
    texel: vec4u,
    position: vec3f,
    depth: f32,
}

fn reproject_ray(point: vec2f, size: vec2i) -> vec3f {
    let ndc = vec2f(2.0, -2.0) * (point / vec2f(size)) + vec2f(-1.0, 1.0);
    return params.previous_forward + ndc.x * params.previous_right + ndc.y * params.previous_up;
}

fn reproject_kept_nothing() -> KeptLobes {
    let nothing = Kept(EdgeSum(vec3f(0.0), 0.0, 0.0, 0.0), vec2f(0.0), 0.0);
    return KeptLobes(nothing, nothing);
}

fn reproject_add(kept: Kept, light: vec4f, moments: vec2f, frames: u32, weight: f32) -> Kept {
    let share = select(0.0, weight, frames > 0u);
    return Kept(
        edge_sum_add(kept.light, light, share),
        kept.moments + share * moments,
        kept.frames + share * f32(frames),
    );
}

fn reproject_tap(kept: KeptLobes, expected: Expected, q: vec2i, size: vec2i, weight: f32) -> KeptLobes {
    if (weight <= 0.0 || any(q < vec2i(0)) || any(q >= size)) {
        return kept;
    }
    let tap = textureLoad(in_edge_before, q, 0);
    let depth = bitcast<f32>(tap.x);
    let position = depth * reproject_ray(vec2f(q) + vec2f(0.5) + frame.previous_jitter, size);
    let plane = abs(dot(edge_face_normal(expected.texel), position - expected.position));
    let is_same = depth > 0.0
        && ((tap.w ^ expected.texel.w) & EDGE_OBJECT_MASK) == 0u
        && plane <= params.plane_tolerance * expected.depth
        && dot(edge_normal(tap), edge_normal(expected.texel)) >= params.normal_min;
    if (!is_same) {
        return kept;
    }
    let frames = textureLoad(in_frames_before, q, 0).r * params.keeps_history;
    let moments = textureLoad(in_moments_before, q, 0);
    let diffuse = textureLoad(in_diffuse_before, q, 0);
    let specular = textureLoad(in_specular_before, q, 0);
    return KeptLobes(
        reproject_add(kept.diffuse, diffuse, moments.xy, frames & 0xffffu, weight),
        reproject_add(kept.specular, specular, moments.zw, frames >> 16u, weight),
    );
}

fn reproject_search(expected: Expected, motion: vec2f, p: vec2i, size: vec2i) -> KeptLobes {
    let place = vec2f(p) - motion;
    let first = vec2i(floor(place));
    let part = place - floor(place);
    var kept = reproject_kept_nothing();
    for (var k = 0; k < 4; k++) {
        let corner = vec2i(k & 1, k >> 1u);
        let weights = select(vec2f(1.0) - part, part, corner == vec2i(1));
        kept = reproject_tap(kept, expected, first + corner, size, weights.x * weights.y);
    }
    if (max(kept.diffuse.light.weight, kept.specular.light.weight) < REPROJECT_WEIGHT_MIN) {
        // Thin things slip between the four: anything of the same surface next to the place will do.
        kept = reproject_kept_nothing();
        let nearest = vec2i(floor(place + vec2f(0.5)));
        for (var k = 0; k < 9; k++) {
            kept = reproject_tap(kept, expected, nearest + vec2i(k % 3, k / 3) - vec2i(1), size, 1.0);
        }
    }
    return kept;
}

// One lobe after this frame; what did not come to be traced keeps what it had.
struct Accumulated {
    light: vec4f,
    moments: vec2f,
    frames: u32,
}

fn reproject_accumulate(kept: Kept, light: vec4f, gives: bool) -> Accumulated {
    let weight = max(kept.light.weight, REPROJECT_WEIGHT_MIN);
    let frames_before = select(0.0, floor(kept.frames / weight + 0.5), kept.light.weight >= REPROJECT_WEIGHT_MIN);
    let frames = min(frames_before + select(0.0, 1.0, gives), params.history_max);
    let least = select(0.0, 1.0 / max(frames, 1.0), gives);
    let alpha_color = max(least, select(0.0, params.alpha_color, gives));
    let alpha_moments = max(least, select(0.0, params.alpha_moments, gives));

    let rgb = mix(kept.light.rgb / weight, light.rgb, alpha_color);
    // A length that one of the two lacks is the other's.
    let length_weight = max(kept.light.length_weight, REPROJECT_WEIGHT_MIN);
    let length_before = kept.light.length / length_weight;
    let length_now = select(0.0, light.a, gives);
    let mixed = mix(length_before, length_now, alpha_color);
    let length = select(max(length_before, length_now), mixed, length_before > 0.0 && length_now > 0.0);

    let y = brdf_luminance(light.rgb);
    let moments = mix(kept.moments / weight, vec2f(y, y * y), alpha_moments);
    let exists = frames > 0.0;
    return Accumulated(
        half_rounded(select(vec4f(0.0), vec4f(rgb, length), exists)),
        select(vec2f(0.0), moments, exists),
        u32(frames),
    );
}

@compute @workgroup_size(8, 8)
fn reproject(@builtin(global_invocation_id) id: vec3u) {
    let size = vec2i(textureDimensions(in_edge));
    let p = vec2i(id.xy);
    if (any(p >= size)) {
        return;
    }
    let centre = textureLoad(in_edge, p, 0);
    let takes_diffuse = (centre.w & EDGE_DIFFUSE_TAKES) != 0u;
    let takes_specular = (centre.w & EDGE_SPECULAR_TAKES) != 0u;
    let code = textureLoad(in_motion_id, p, 0).x;
    let moves = (code & 0x7c00u) != 0x7c00u && (code & 0x7c000000u) != 0x7c000000u;
    let motion = unpack2x16float(select(0u, code, moves));

    // Exact for what stands still. What moves on its own is expected at the depth it would have at rest: it may come
    // nearer by `plane_tolerance` a frame.
    let depth = dot(params.previous_forward, edge_position(centre, p, size) + params.eye_offset);
    let point = vec2f(p) + vec2f(0.5) + frame.jitter - motion;
    let expected = Expected(centre, depth * reproject_ray(point, size), depth);
    var kept = reproject_kept_nothing();
    if (moves && depth > 0.0 && (takes_diffuse || takes_specular)) {
        kept = reproject_search(expected, motion, p, size);
    }

    let light_diffuse = edge_untouched(textureLoad(in_diffuse, p, 0));
    let light_specular = edge_untouched(textureLoad(in_specular, p, 0));
    var diffuse = Accumulated(light_diffuse, vec2f(0.0), 0u);
    var specular = Accumulated(light_specular, vec2f(0.0), 0u);
    if (takes_diffuse) {
        diffuse = reproject_accumulate(kept.diffuse, light_diffuse, (centre.w & EDGE_DIFFUSE_GIVES) != 0u);
    }
    if (takes_specular) {
        specular = reproject_accumulate(kept.specular, light_specular, (centre.w & EDGE_SPECULAR_GIVES) != 0u);
    }
    textureStore(out_diffuse, p, diffuse.light);
    // Without a specular lobe the texture is a single texel that nobody reads.
    if (all(p < vec2i(textureDimensions(out_specular)))) {
        textureStore(out_specular, p, specular.light);
    }
    textureStore(out_moments, p, vec4f(diffuse.moments, specular.moments));
    textureStore(out_frames, p, vec4u(diffuse.frames | (specular.frames << 16u), 0u, 0u, 0u));
}
