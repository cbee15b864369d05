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

fn temporal_tap(kept: KeptLobes, expected: Expected, q: vec2i, size: vec2i, weight: f32) -> KeptLobes {
    if (weight <= 0.0 || any(q < vec2i(0)) || any(q >= size)) {
        return kept;
    }
    if (!temporal_is_same(expected, q, size)) {
        return kept;
    }
    let frames = textureLoad(in_frames_before, q, 0).r * params.keeps_history;
    let moments = textureLoad(in_moments_before, q, 0);
    let diffuse = textureLoad(in_diffuse_before, q, 0);
    let specular = textureLoad(in_specular_before, q, 0);
    return KeptLobes(
        temporal_add(kept.diffuse, diffuse, moments.xy, frames & 0xffffu, weight),
        temporal_add(kept.specular, specular, moments.zw, frames >> 16u, weight),
    );
}

fn temporal_search(expected: Expected, motion: vec2f, p: vec2i, size: vec2i) -> KeptLobes {
    let place = vec2f(p) - motion;
    let first = vec2i(floor(place));
    let part = place - floor(place);
    var kept = temporal_kept_nothing();
    for (var k = 0; k < 4; k++) {
        let corner = vec2i(k & 1, k >> 1u);
        let weights = select(vec2f(1.0) - part, part, corner == vec2i(1));
        kept = temporal_tap(kept, expected, first + corner, size, weights.x * weights.y);
    }
    if (max(kept.diffuse.light.weight, kept.specular.light.weight) < TEMPORAL_WEIGHT_MIN) {
        // Thin things slip between the four: anything of the same surface next to the place will do.
        kept = temporal_kept_nothing();
        let nearest = vec2i(floor(place + vec2f(0.5)));
        for (var k = 0; k < 9; k++) {
            kept = temporal_tap(kept, expected, nearest + vec2i(k % 3, k / 3) - vec2i(1), size, 1.0);
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
    let motion = temporal_motion(p);
    let expected = temporal_expected(centre, p, motion.pixels, size);
    var kept = temporal_kept_nothing();
    if (motion.is_known && expected.depth > 0.0 && (takes_diffuse || takes_specular)) {
        kept = temporal_search(expected, motion.pixels, p, size);
    }

    let light_diffuse = light_mended(in_diffuse, p);
    let light_specular = light_mended(in_specular, p);
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
