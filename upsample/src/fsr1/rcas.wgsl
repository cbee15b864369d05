// Robust contrast-adaptive sharpening, then the sky and direct light of display size. Source: mod.rs beside this file.

struct RcasParams {
    // 0..1: share of the largest sharpening.
    strength: f32,
    direct_lobes: u32,
}

@group(0) @binding(1) var<uniform> params: RcasParams;
@group(2) @binding(6) var in_color: texture_2d<f32>;
@group(3) @binding(0) var out_color: texture_storage_2d<rgba16float, write>;

// More would show noise and blocks.
const RCAS_LOBE_MOST = 0.1875;

fn rcas_load(p: vec2i) -> vec3f {
    let q = clamp(p, vec2i(0), vec2i(frame.display_size) - vec2i(1));
    return tone_mapped(textureLoad(in_color, q, 0).rgb);
}

@compute @workgroup_size(8, 8)
fn rcas(@builtin(global_invocation_id) id: vec3u) {
    let pixel = id.xy;
    if (any(pixel >= frame.display_size)) {
        return;
    }
    let p = vec2i(pixel);
    let centre = rcas_load(p);
    let up = rcas_load(p + vec2i(0, -1));
    let left = rcas_load(p + vec2i(-1, 0));
    let right = rcas_load(p + vec2i(1, 0));
    let down = rcas_load(p + vec2i(0, 1));
    let least = min(min(up, left), min(right, down));
    let most = max(max(up, left), max(right, down));
    // The lobe (negative) at which the result reaches 0 or 1.
    let to_black = min(least, centre) / max(4.0 * most, vec3f(1e-6));
    let to_white = (1.0 - max(most, centre)) / max(4.0 - 4.0 * least, vec3f(1e-6));
    let allowed = min(to_black, to_white);
    let lobe = -params.strength * clamp(min(allowed.r, min(allowed.g, allowed.b)), 0.0, RCAS_LOBE_MOST);
    let sharpened = (centre + lobe * (up + left + right + down)) / (1.0 + 4.0 * lobe);
    let color = tone_unmapped(sharpened) + modulate_direct(pixel, params.direct_lobes);
    let is_hit = textureLoad(display_distance, pixel, 0).r > 0.0;
    let sky = sky_radiance(modulate_view_direction(pixel));
    textureStore(out_color, pixel, half_rounded(vec4f(select(sky, color, is_hit), 1.0)));
}
