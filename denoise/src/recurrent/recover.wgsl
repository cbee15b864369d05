// Helps short histories with longer ones around, and shortens those that light has left behind. 25 + 9 taps a pixel.

@group(2) @binding(4) var in_moments: texture_2d<f32>;
@group(3) @binding(2) var out_frames: texture_storage_2d<r32uint, write>;

const RECOVER_REACH = 2;

// Sums over 3x3 pixels, both lobes: luminance of the slow and of the fast history, and the variance of one frame.
struct Pace {
    slow: vec2f,
    fast: vec2f,
    variance: vec2f,
    weight: vec2f,
    squares: vec2f,
}

// By what share each lobe's history is out of date, and what its luminance must be multiplied with.
struct Lag {
    share: vec2f,
    scale: vec2f,
}

fn recover_pace(centre: EdgeCentre, p: vec2i, size: vec2i) -> Pace {
    var pace = Pace(vec2f(0.0), vec2f(0.0), vec2f(0.0), vec2f(0.0), vec2f(0.0));
    for (var k = 0; k < 9; k++) {
        let q = light_mirrored(p + vec2i(k % 3, k / 3) - vec2i(1), size);
        let weight = recurrent_weights(centre, q, size);
        let moments = textureLoad(in_moments, q, 0);
        let diffuse = brdf_luminance(textureLoad(in_diffuse, q, 0).rgb);
        let specular = brdf_luminance(textureLoad(in_specular, q, 0).rgb);
        pace.slow += weight * vec2f(diffuse, specular);
        pace.fast += weight * moments.xz;
        pace.variance += weight * max(moments.yw - moments.xz * moments.xz, vec2f(0.0));
        pace.weight += weight;
        pace.squares += weight * weight;
    }
    return pace;
}

fn recover_lag(pace: Pace, frames: vec2f) -> Lag {
    let weight = max(pace.weight, vec2f(1e-20));
    let slow = pace.slow / weight;
    let fast = pace.fast / weight;
    // Of a mean over pixels and over time, where a share of 1/n leaves 1 / (2 n - 1) of the variance; half floats round the
    // slow one.
    let means = max(pace.squares / (weight * weight), vec2f(0.1));
    let error = sqrt(pace.variance / weight * means / (2.0 * params.fast_frames - 1.0)) + 0.01 * slow;
    let apart = abs(slow - fast);
    let beyond = clamp((apart - params.lag_sigma * error) / max(apart, vec2f(1e-20)), vec2f(0.0), vec2f(1.0));
    // Both histories are one and the same until the fast one forgets.
    let share = select(vec2f(0.0), beyond, frames > vec2f(params.fast_frames));
    let scale = clamp(fast / max(slow, vec2f(1e-20)), vec2f(0.0), vec2f(4.0));
    return Lag(share, mix(vec2f(1.0), scale, share));
}

@compute @workgroup_size(8, 8)
fn recover(@builtin(global_invocation_id) id: vec3u) {
    let size = vec2i(textureDimensions(in_edge));
    let p = vec2i(id.xy);
    if (any(p >= size)) {
        return;
    }
    let centre = edge_centre(textureLoad(in_edge, p, 0), p, size);
    let takes = vec2<bool>(
        (centre.texel.w & EDGE_DIFFUSE_TAKES) != 0u,
        (centre.texel.w & EDGE_SPECULAR_TAKES) != 0u,
    );
    let frames = recurrent_frames(p);
    let before_diffuse = textureLoad(in_diffuse, p, 0);
    let before_specular = textureLoad(in_specular, p, 0);

    // Neighbours are worth as many frames as they have, those of a short history lie farther apart.
    let is_short = takes & (frames < vec2f(params.fix_frames));
    let least = min(select(1e6, frames.x, is_short.x), select(1e6, frames.y, is_short.y));
    let stride = max(params.fix_stride / (1.0 + least), 1.0);
    let reach = select(-1, RECOVER_REACH, any(is_short));
    var diffuse = light_nothing();
    var specular = light_nothing();
    for (var j = -reach; j <= reach; j++) {
        for (var i = -reach; i <= reach; i++) {
            let q = light_mirrored(p + recurrent_pixels(stride * vec2f(f32(i), f32(j))), size);
            let weight = recurrent_weights(centre, q, size) * recurrent_frames(q);
            diffuse = light_add(diffuse, textureLoad(in_diffuse, q, 0), weight.x);
            specular = light_add(specular, textureLoad(in_specular, q, 0), weight.y);
        }
    }
    var light_diffuse = before_diffuse;
    if (is_short.x) {
        light_diffuse = light_mean(diffuse, before_diffuse);
    }
    var light_specular = before_specular;
    if (is_short.y) {
        light_specular = light_mean(specular, before_specular);
    }

    let lag = recover_lag(recover_pace(centre, p, size), frames);
    let kept = max(floor(frames * (vec2f(1.0) - lag.share) + vec2f(0.5)), min(frames, vec2f(1.0)));
    if (takes.x) {
        light_diffuse = half_rounded(light_diffuse * vec4f(vec3f(lag.scale.x), 1.0));
    }
    textureStore(out_diffuse, p, light_diffuse);
    // Without a specular lobe the texture is a single texel that nobody reads.
    if (all(p < vec2i(textureDimensions(out_specular)))) {
        if (takes.y) {
            light_specular = half_rounded(light_specular * vec4f(vec3f(lag.scale.y), 1.0));
        }
        textureStore(out_specular, p, light_specular);
    }
    textureStore(out_frames, p, vec4u(u32(kept.x) | (u32(kept.y) << 16u), 0u, 0u, 0u));
}
