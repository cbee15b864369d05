// Finds a pixel in the last frame, and mixes its light and moments with what was found. Formula, units: mod.rs beside
// this file. After one of the two that say what light is kept as.

@group(2) @binding(3) var in_diffuse: texture_2d<f32>;
@group(2) @binding(4) var in_specular: texture_2d<f32>;
@group(2) @binding(5) var in_diffuse_before: texture_2d<f32>;
@group(2) @binding(6) var in_specular_before: texture_2d<f32>;
@group(2) @binding(7) var in_moments_before: texture_2d<f32>;
@group(2) @binding(8) var in_frames_before: texture_2d<u32>;
// Share of history to forget, bits of f32, diffuse in x, specular in y; read only where `has_haste`.
@group(2) @binding(9) var in_haste: texture_2d<u32>;
@group(3) @binding(2) var out_moments: texture_storage_2d<rgba32float, write>;
@group(3) @binding(3) var out_frames: texture_storage_2d<r32uint, write>;

override has_haste: bool = false;

const TEMPORAL_WEIGHT_MIN = 0.01;
// Standard deviations between taps: noise below the first, an edge of light above the second.
const TEMPORAL_EDGE = vec2f(1.0, 2.0);
// What half floats round.
const TEMPORAL_EDGE_RELATIVE = 0.00390625;
const TEMPORAL_EDGE_ABSOLUTE = 2.4e-7;

// Weighted sums of what a lobe kept.
struct Kept {
    light: LightSum,
    moments: vec2f,
    frames: f32,
}

struct KeptLobes {
    diffuse: Kept,
    specular: Kept,
}

fn temporal_kept_nothing() -> KeptLobes {
    let nothing = Kept(light_nothing(), vec2f(0.0), 0.0);
    return KeptLobes(nothing, nothing);
}

fn temporal_add(kept: Kept, light: vec4f, moments: vec2f, frames: u32, weight: f32) -> Kept {
    let share = select(0.0, weight, frames > 0u);
    return Kept(
        light_add(kept.light, light, share),
        kept.moments + share * moments,
        kept.frames + share * f32(frames),
    );
}

// Whether pixel q of the last frame lies inside and shows the same surface.
fn temporal_has(expected: Expected, q: vec2i, size: vec2i) -> bool {
    return all(q >= vec2i(0)) && all(q < size) && temporal_is_same(expected, clamp(q, vec2i(0), size - vec2i(1)), size);
}

// Frames that a pixel had in the last frame: diffuse, specular.
fn temporal_frames_before(q: vec2i) -> vec2u {
    let packed = textureLoad(in_frames_before, q, 0).r * params.keeps_history;
    return vec2u(packed & 0xffffu, packed >> 16u);
}

// Weights of the diffuse and the specular lobe.
fn temporal_tap(kept: KeptLobes, q: vec2i, weights: vec2f) -> KeptLobes {
    let frames = temporal_frames_before(q);
    let moments = textureLoad(in_moments_before, q, 0);
    let diffuse = textureLoad(in_diffuse_before, q, 0);
    let specular = textureLoad(in_specular_before, q, 0);
    return KeptLobes(
        temporal_add(kept.diffuse, diffuse, moments.xy, frames.x, weights.x),
        temporal_add(kept.specular, specular, moments.zw, frames.y, weights.y),
    );
}

// The taps around a place as either lobe sees them.
struct Taps {
    // By geometry; 0 where nothing was followed.
    weights: array<vec2f, 4>,
    luminances: array<vec2f, 4>,
    // Root of the mean variance.
    deviation: vec2f,
}

fn temporal_taps(expected: Expected, place: vec2f, size: vec2i) -> Taps {
    let first = vec2i(floor(place));
    let part = place - floor(place);
    var taps: Taps;
    var variance = vec2f(0.0);
    var total = vec2f(0.0);
    for (var k = 0; k < 4; k++) {
        let corner = vec2i(k & 1, k >> 1u);
        let shares = select(vec2f(1.0) - part, part, corner == vec2i(1));
        let share = shares.x * shares.y;
        if (share <= 0.0 || !temporal_has(expected, first + corner, size)) {
            taps.weights[k] = vec2f(0.0);
            taps.luminances[k] = vec2f(0.0);
            continue;
        }
        let q = first + corner;
        let weights = select(vec2f(0.0), vec2f(share), temporal_frames_before(q) > vec2u(0u));
        let moments = textureLoad(in_moments_before, q, 0);
        variance += weights * max(moments.yw - moments.xz * moments.xz, vec2f(0.0));
        total += weights;
        taps.weights[k] = weights;
        taps.luminances[k] = vec2f(
            brdf_luminance(textureLoad(in_diffuse_before, q, 0).rgb),
            brdf_luminance(textureLoad(in_specular_before, q, 0).rgb),
        );
    }
    taps.deviation = sqrt(variance / max(total, vec2f(1e-20)));
    return taps;
}

// The same, of taps that lie on two sides of an edge of light those that are like what is seen now. All keep the weight
// that they have together.
fn temporal_choose(taps: Taps, now: vec2f) -> array<vec2f, 4> {
    var least = vec2f(1e30);
    var most = vec2f(-1e30);
    var nearest = vec2f(1e30);
    for (var k = 0; k < 4; k++) {
        let is_there = taps.weights[k] > vec2f(0.0);
        least = select(least, min(least, taps.luminances[k]), is_there);
        most = select(most, max(most, taps.luminances[k]), is_there);
        nearest = select(nearest, min(nearest, abs(taps.luminances[k] - now)), is_there);
    }
    let deviation = taps.deviation + TEMPORAL_EDGE_RELATIVE * max(most, vec2f(0.0)) + vec2f(TEMPORAL_EDGE_ABSOLUTE);
    let spread = max(most - least, vec2f(0.0)) / deviation;
    let apart = smoothstep(vec2f(TEMPORAL_EDGE.x), vec2f(TEMPORAL_EDGE.y), spread);
    var chosen: array<vec2f, 4>;
    var before = vec2f(0.0);
    var after = vec2f(0.0);
    for (var k = 0; k < 4; k++) {
        let fall = clamp((abs(taps.luminances[k] - now) - nearest) / deviation, vec2f(0.0), vec2f(80.0));
        chosen[k] = taps.weights[k] * mix(vec2f(1.0), exp(-fall), apart);
        before += taps.weights[k];
        after += chosen[k];
    }
    let scale = before / max(after, vec2f(1e-20));
    for (var k = 0; k < 4; k++) {
        chosen[k] *= scale;
    }
    return chosen;
}

fn temporal_search(expected: Expected, motion: vec2f, p: vec2i, size: vec2i, now: vec2f) -> KeptLobes {
    let place = vec2f(p) - motion;
    let weights = temporal_choose(temporal_taps(expected, place, size), now);
    var kept = temporal_kept_nothing();
    for (var k = 0; k < 4; k++) {
        if (any(weights[k] > vec2f(0.0))) {
            kept = temporal_tap(kept, vec2i(floor(place)) + vec2i(k & 1, k >> 1u), weights[k]);
        }
    }
    if (max(kept.diffuse.light.weight, kept.specular.light.weight) < TEMPORAL_WEIGHT_MIN) {
        // Thin things slip between the four: anything of the same surface next to the place will do.
        kept = temporal_kept_nothing();
        let nearest = vec2i(floor(place + vec2f(0.5)));
        for (var k = 0; k < 9; k++) {
            let q = nearest + vec2i(k % 3, k / 3) - vec2i(1);
            if (temporal_has(expected, q, size)) {
                kept = temporal_tap(kept, q, vec2f(1.0));
            }
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

fn temporal_accumulate(kept: Kept, light: vec4f, gives: bool, haste: f32) -> Accumulated {
    let weight = max(kept.light.weight, TEMPORAL_WEIGHT_MIN);
    let is_found = kept.light.weight >= TEMPORAL_WEIGHT_MIN;
    // A pixel that has nothing new cannot hurry.
    let kept_share = 1.0 - select(0.0, haste, gives);
    let frames_before = select(0.0, floor(kept_share * kept.frames / weight + 0.5), is_found);
    let frames = min(frames_before + select(0.0, 1.0, gives), params.history_max);
    let least = select(0.0, 1.0 / max(frames, 1.0), gives);
    let share = select(0.0, 1.0, gives);
    let alpha_color = 1.0 - kept_share * (1.0 - max(least, share * params.alpha_color));
    let alpha_moments = 1.0 - kept_share * (1.0 - max(least, share * params.alpha_moments));

    let rgb = mix(kept.light.rgb / weight, light.rgb, alpha_color);
    // A length that one of the two lacks is the other's.
    let length_weight = max(kept.light.length_weight, TEMPORAL_WEIGHT_MIN);
    let length_before = kept.light.length / length_weight;
    let length_now = select(0.0, light.a, gives);
    let mixed = mix(length_before, length_now, alpha_color);
    let length = select(max(length_before, length_now), mixed, length_before > 0.0 && length_now > 0.0);

    let y = brdf_luminance(light.rgb);
    let moments = mix(kept.moments / weight, vec2f(y, y * y), alpha_moments);
    let exists = frames > 0.0;
    return Accumulated(
        temporal_stored(select(light, vec4f(rgb, length), exists)),
        select(vec2f(0.0), moments, exists),
        u32(frames),
    );
}

@compute @workgroup_size(8, 8)
fn temporal_accumulate_frame(@builtin(global_invocation_id) id: vec3u) {
    let size = vec2i(textureDimensions(in_edge));
    let p = vec2i(id.xy);
    if (any(p >= size)) {
        return;
    }
    let centre = textureLoad(in_edge, p, 0);
    let takes_diffuse = (centre.w & EDGE_DIFFUSE_TAKES) != 0u;
    let takes_specular = (centre.w & EDGE_SPECULAR_TAKES) != 0u;
    let light_diffuse = light_mended(in_diffuse, p);
    let light_specular = light_mended(in_specular, p);
    let motion = temporal_motion(p);
    let expected = temporal_expected(centre, p, motion.pixels, size);
    var kept = temporal_kept_nothing();
    if (motion.is_known && expected.depth > 0.0 && (takes_diffuse || takes_specular)) {
        let now = vec2f(brdf_luminance(light_diffuse.rgb), brdf_luminance(light_specular.rgb));
        kept = temporal_search(expected, motion.pixels, p, size, now);
    }

    var haste = vec2f(0.0);
    if (has_haste) {
        haste = bitcast<vec2f>(textureLoad(in_haste, p, 0).xy);
    }
    var diffuse = Accumulated(light_diffuse, vec2f(0.0), 0u);
    var specular = Accumulated(light_specular, vec2f(0.0), 0u);
    if (takes_diffuse) {
        diffuse = temporal_accumulate(kept.diffuse, light_diffuse, (centre.w & EDGE_DIFFUSE_GIVES) != 0u, haste.x);
    }
    if (takes_specular) {
        specular = temporal_accumulate(kept.specular, light_specular, (centre.w & EDGE_SPECULAR_GIVES) != 0u, haste.y);
    }
    textureStore(out_diffuse, p, diffuse.light);
    // Without a specular lobe the texture is a single texel that nobody reads.
    if (all(p < vec2i(textureDimensions(out_specular)))) {
        textureStore(out_specular, p, specular.light);
    }
    textureStore(out_moments, p, vec4f(diffuse.moments, specular.moments));
    textureStore(out_frames, p, vec4u(diffuse.frames | (specular.frames << 16u), 0u, 0u, 0u));
}
