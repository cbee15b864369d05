// The four trace pixels around a display pixel, weighed by whether they lie on its surface, and the search where none
// does. After search.inc.wgsl and mix.inc.wgsl; formula: mod.rs beside this file.

struct JointParams {
    normal_power: f32,
    plane_scale: f32,
    // Weight of the bilinear part, and of a Gaussian around the display pixel's centre.
    wide: f32,
    narrow: f32,
}

@group(0) @binding(2) var<uniform> joint_params: JointParams;

const JOINT_WEIGHT_MIN = 1e-3;
// The Gaussian's standard deviation in display pixels: that of the least-squares fit to a Blackman-Harris window.
const JOINT_NARROW_SIGMA = 0.47;

struct JointLight {
    diffuse: vec3f,
    diffuse_weight: f32,
    specular: vec3f,
    specular_weight: f32,
    searched: bool,
    fell_back: bool,
}

fn joint_light(pixel: vec2u, wanted: SearchPixel) -> JointLight {
    let place = search_place(pixel);
    let low = vec2i(floor(place));
    let part = place - floor(place);
    let pixel_per_tap = vec2f(frame.display_size) / vec2f(frame.trace_size);
    var lobes = MixLobes(MIX_NOTHING, MIX_NOTHING);
    for (var k = 0; k < 4; k++) {
        let corner = vec2i(k & 1, k >> 1u);
        let tap = search_tap(wanted, low + corner);
        let shares = select(vec2f(1.0) - part, part, corner == vec2i(1));
        let away = (vec2f(low + corner) - place) * pixel_per_tap / JOINT_NARROW_SIGMA;
        let nearness = joint_params.wide * shares.x * shares.y + joint_params.narrow * exp(-0.5 * dot(away, away));
        let facing = pow(max(tap.facing, 1e-6), joint_params.normal_power);
        let plane = exp(-tap.off_plane / (joint_params.plane_scale * max(wanted.distance, 1e-6)));
        lobes = mix_tap(lobes, tap, nearness * facing * plane);
    }
    let least = JOINT_WEIGHT_MIN * joint_params.wide;
    let searches_diffuse = wanted.needs_diffuse && lobes.diffuse.weight < least;
    let searches_specular = wanted.needs_specular && lobes.specular.weight < least;
    let found = search_outward(wanted, modulate_trace_pixel(pixel), searches_diffuse, searches_specular);

    var light = JointLight(vec3f(0.0), 0.0, vec3f(0.0), 0.0, searches_diffuse || searches_specular, false);
    light.fell_back = (searches_diffuse && !found.diffuse.is_accepted) || (searches_specular && !found.specular.is_accepted);
    if (wanted.needs_diffuse || wanted.is_same_size) {
        light.diffuse = mix_mean(lobes.diffuse);
        light.diffuse_weight = lobes.diffuse.weight;
        if (searches_diffuse || wanted.is_same_size) {
            light.diffuse = textureLoad(light_diffuse, found.diffuse.pixel, 0).rgb;
            light.diffuse_weight = least;
        }
    }
    if (wanted.needs_specular || (wanted.is_same_size && search_params.has_specular == 1u)) {
        light.specular = mix_specular(lobes.specular, wanted.surface);
        light.specular_weight = lobes.specular.weight;
        if (searches_specular || wanted.is_same_size) {
            light.specular = textureLoad(light_specular, found.specular.pixel, 0).rgb;
            light.specular_weight = least;
        }
    }
    return light;
}
