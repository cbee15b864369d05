// A disc of eight taps around each pixel, both lobes at once, each with a radius of its own. 17 taps a pixel.

// Four of the taps, of a disc of radius 1; the other four lie opposite, so that what one pixel gives another gets.
const BLUR_TAPS = array<vec2f, 4>(
    vec2f(1.0, 0.0),
    vec2f(0.389, 0.389),
    vec2f(0.0, 0.8),
    vec2f(-0.247, 0.247),
);

// Rows. Diffuse light changes as fast over a surface as what it comes from is near.
fn blur_radius_diffuse(light: vec4f, depth: f32, frames: f32) -> f32 {
    let far = params.hit_far.x + params.hit_far.y * depth;
    let near = mix(0.25, 1.0, clamp(light.a / far, 0.0, 1.0));
    return max(params.radius * near / sqrt(max(frames, 1.0)), params.radius_min);
}

// A reflection is as blurred as its lobe is wide at what it shows, seen from the eye.
fn blur_radius_specular(light: vec4f, texel: vec4u, depth: f32, frames: f32, size: vec2i) -> f32 {
    let roughness = edge_roughness(texel);
    let angle = roughness * roughness * light.a / max(light.a + depth, 1e-6);
    let lobe = angle * f32(size.y) / (2.0 * length(frame.up));
    return min(lobe, max(params.radius / sqrt(max(frames, 1.0)), params.radius_min));
}

@compute @workgroup_size(8, 8)
fn blur(@builtin(global_invocation_id) id: vec3u) {
    let size = vec2i(textureDimensions(in_edge));
    let p = vec2i(id.xy);
    if (any(p >= size)) {
        return;
    }
    let centre = edge_centre(textureLoad(in_edge, p, 0), p, size);
    let depth = bitcast<f32>(centre.texel.x);
    let frames = recurrent_frames(p);
    let before_diffuse = textureLoad(in_diffuse, p, 0);
    let before_specular = textureLoad(in_specular, p, 0);
    let takes_diffuse = (centre.texel.w & EDGE_DIFFUSE_TAKES) != 0u;
    let takes_specular = (centre.texel.w & EDGE_SPECULAR_TAKES) != 0u;
    let radius_diffuse = blur_radius_diffuse(before_diffuse, depth, frames.x);
    let radius_specular = blur_radius_specular(before_specular, centre.texel, depth, frames.y, size);

    let count = select(0, 8, takes_diffuse || takes_specular);
    var diffuse = light_add(light_nothing(), before_diffuse, select(0.0, 1.0, frames.x > 0.0));
    var specular = light_add(light_nothing(), before_specular, select(0.0, 1.0, frames.y > 0.0));
    for (var k = 0; k < count; k++) {
        let flat = BLUR_TAPS[k >> 1u] * select(1.0, -1.0, (k & 1) == 1);
        let tap = vec2f(dot(flat, vec2f(params.turn.x, -params.turn.y)), dot(flat, params.turn.yx));
        let gauss = exp(-2.0 * dot(flat, flat));
        let q = light_mirrored(p + recurrent_pixels(radius_diffuse * tap), size);
        diffuse = light_add(diffuse, textureLoad(in_diffuse, q, 0), gauss * recurrent_weights(centre, q, size).x);
        let r = light_mirrored(p + recurrent_pixels(radius_specular * tap), size);
        specular = light_add(specular, textureLoad(in_specular, r, 0), gauss * recurrent_weights(centre, r, size).y);
    }
    if (takes_diffuse) {
        textureStore(out_diffuse, p, light_mean(diffuse, before_diffuse));
    } else {
        textureStore(out_diffuse, p, before_diffuse);
    }
    // Without a specular lobe the texture is a single texel that nobody reads.
    if (all(p < vec2i(textureDimensions(out_specular)))) {
        if (takes_specular) {
            textureStore(out_specular, p, light_mean(specular, before_specular));
        } else {
            textureStore(out_specular, p, before_specular);
        }
    }
}
