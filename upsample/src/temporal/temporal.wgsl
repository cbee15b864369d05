// Light of many jittered frames, kept at display size. Steps, units: mod.rs beside this file. After joint.inc.wgsl.

struct TemporalParams {
    // The last frame's view, as `frame` has this one's.
    previous_forward: vec3f,
    weight_max: f32,
    previous_right: vec3f,
    clamp_width: f32,
    previous_up: vec3f,
    // Metres off the plane per metre of distance.
    plane_tolerance: f32,
    // This frame's eye minus the last one's, metres.
    eye_offset: vec3f,
    // Cosine between shading normals.
    normal_min: f32,
    // 0 or 1, a factor: a branch on it would have Mesa's software driver build the kernel anew for each dispatch.
    keeps_history: f32,
}

@group(0) @binding(3) var<uniform> params: TemporalParams;
@group(2) @binding(9) var display_motion_id: texture_2d<u32>;
@group(2) @binding(10) var kept_diffuse: texture_2d<f32>;  // a: weight
@group(2) @binding(11) var kept_specular: texture_2d<f32>; // a: weight
@group(2) @binding(12) var kept_guides: texture_2d<u32>;   // normal 24, object 8; distance
@group(3) @binding(0) var out_color: texture_storage_2d<rgba16float, write>;
@group(3) @binding(1) var out_diffuse: texture_storage_2d<rgba16float, write>;
@group(3) @binding(2) var out_specular: texture_storage_2d<rgba16float, write>;
@group(3) @binding(3) var out_guides: texture_storage_2d<rg32uint, write>;

const TEMPORAL_SHARE_MIN = 0.01;

// ---- what was kept ----

struct Kept {
    diffuse: vec4f,
    specular: vec4f,
    share: f32,
}

fn temporal_ray(point: vec2f) -> vec3f {
    let ndc = vec2f(2.0, -2.0) * (point / vec2f(frame.display_size)) + vec2f(-1.0, 1.0);
    return normalize(params.previous_forward + ndc.x * params.previous_right + ndc.y * params.previous_up);
}

// `object`: the low 8 bits, shifted up by 24.
fn temporal_tap(kept: Kept, wanted: SearchPixel, object: u32, q: vec2i, share: f32) -> Kept {
    if (share <= 0.0 || any(q < vec2i(0)) || any(q >= vec2i(frame.display_size))) {
        return kept;
    }
    let guides = textureLoad(kept_guides, q, 0);
    let distance = bitcast<f32>(guides.y);
    let position = distance * temporal_ray(vec2f(q) + vec2f(0.5));
    let off_plane = abs(dot(wanted.surface.normal, position - (wanted.position + params.eye_offset)));
    let is_same = distance > 0.0
        && (guides.x & 0xff000000u) == object
        && off_plane <= params.plane_tolerance * wanted.distance
        && dot(surface_normal_unpack(guides.x), wanted.surface.normal) >= params.normal_min;
    if (!is_same) {
        return kept;
    }
    return Kept(
        kept.diffuse + share * textureLoad(kept_diffuse, q, 0),
        kept.specular + share * textureLoad(kept_specular, q, 0),
        kept.share + share,
    );
}

fn temporal_kept(wanted: SearchPixel, object: u32, motion: vec2f, pixel: vec2u) -> Kept {
    let place = vec2f(pixel) - motion;
    let first = vec2i(floor(place));
    let part = place - floor(place);
    var kept = Kept(vec4f(0.0), vec4f(0.0), 0.0);
    for (var k = 0; k < 4; k++) {
        let corner = vec2i(k & 1, k >> 1u);
        let shares = select(vec2f(1.0) - part, part, corner == vec2i(1));
        kept = temporal_tap(kept, wanted, object, first + corner, shares.x * shares.y);
    }
    return kept;
}

// ---- what it may be ----

fn temporal_ycocg(c: vec3f) -> vec3f {
    return vec3f(0.25 * c.r + 0.5 * c.g + 0.25 * c.b, 0.5 * c.r - 0.5 * c.b, -0.25 * c.r + 0.5 * c.g - 0.25 * c.b);
}

// Sums over trace pixels.
struct Spread {
    rgb: vec3f,
    ycocg: vec3f,
    squares: vec3f,
    count: f32,
}

fn temporal_spread_add(sum: Spread, light: vec3f) -> Spread {
    let y = temporal_ycocg(light);
    return Spread(sum.rgb + light, sum.ycocg + y, sum.squares + y * y, sum.count + 1.0);
}

// rgb pulled into the spread, a scaled by how far it had to be pulled.
fn temporal_rectified(kept: vec4f, spread: Spread) -> vec4f {
    let count = max(spread.count, 1.0);
    let mean = spread.ycocg / count;
    let variance = max(spread.squares / count - mean * mean, vec3f(0.0));
    let width = params.clamp_width * sqrt(variance) + vec3f(0.02 * mean.x + 1e-6);
    let off = abs(temporal_ycocg(kept.rgb) - mean);
    let ratios = width / max(off, width);
    let left = select(1.0, min(ratios.x, min(ratios.y, ratios.z)), spread.count > 0.0);
    return vec4f(mix(spread.rgb / count, kept.rgb, left), left * kept.a);
}

// This frame's light and its weight, with what was kept.
fn temporal_accumulated(light: vec3f, weight: f32, kept: vec4f, spread: Spread) -> vec4f {
    let before = temporal_rectified(kept, spread);
    let total = before.a + weight;
    // A pixel of which nothing is known yet takes what there is, however little.
    let share = select(0.0, before.a / max(total, 1e-6), before.a > 0.0);
    return half_rounded(vec4f(mix(light, before.rgb, share), min(total, params.weight_max)));
}

@compute @workgroup_size(8, 8)
fn temporal(@builtin(global_invocation_id) id: vec3u) {
    let pixel = id.xy;
    if (any(pixel >= frame.display_size)) {
        return;
    }
    let wanted = search_pixel(pixel);
    let light = joint_light(pixel, wanted);
    let needs_any = wanted.needs_diffuse || wanted.needs_specular;

    let motion_id = textureLoad(display_motion_id, pixel, 0);
    let object = motion_id.y << 24u;
    let moves = (motion_id.x & 0x7c00u) != 0x7c00u && (motion_id.x & 0x7c000000u) != 0x7c000000u;
    let motion = unpack2x16float(select(0u, motion_id.x, moves));
    var kept = Kept(vec4f(0.0), vec4f(0.0), 0.0);
    var diffuse_spread = Spread(vec3f(0.0), vec3f(0.0), vec3f(0.0), 0.0);
    var specular_spread = diffuse_spread;
    if (needs_any && moves) {
        kept = temporal_kept(wanted, object, motion, pixel);
        let centre = vec2i(modulate_trace_pixel(pixel));
        for (var k = 0; k < 9; k++) {
            let tap = search_tap(wanted, centre + vec2i(k % 3, k / 3) - vec2i(1));
            if (tap.has_diffuse && tap.facing > 0.5) {
                diffuse_spread = temporal_spread_add(diffuse_spread, textureLoad(light_diffuse, tap.pixel, 0).rgb);
            }
            if (tap.has_specular && tap.facing > 0.5) {
                specular_spread = temporal_spread_add(specular_spread, textureLoad(light_specular, tap.pixel, 0).rgb);
            }
        }
    }
    let share = select(0.0, params.keeps_history / max(kept.share, TEMPORAL_SHARE_MIN), kept.share >= TEMPORAL_SHARE_MIN);
    let diffuse = temporal_accumulated(light.diffuse, light.diffuse_weight, share * kept.diffuse, diffuse_spread);
    let specular = temporal_accumulated(light.specular, light.specular_weight, share * kept.specular, specular_spread);
    let nothing = vec4f(0.0);
    textureStore(out_diffuse, pixel, select(nothing, diffuse, wanted.needs_diffuse));
    // Without a specular lobe the texture is a single texel that nobody reads.
    if (all(pixel < textureDimensions(out_specular))) {
        textureStore(out_specular, pixel, select(nothing, specular, wanted.needs_specular));
    }
    let normal = surface_normal_pack(wanted.surface.normal) & 0xffffffu;
    textureStore(out_guides, pixel, vec4u(normal | object, bitcast<u32>(wanted.distance), 0u, 0u));
    let shown_diffuse = select(light.diffuse, diffuse.rgb, wanted.needs_diffuse);
    let shown_specular = select(light.specular, specular.rgb, wanted.needs_specular);
    textureStore(out_color, pixel, modulate_pixel(pixel, shown_diffuse, shown_specular, search_params.direct_lobes));
}
