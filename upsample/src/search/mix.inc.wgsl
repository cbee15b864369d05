// Light of several trace pixels, mixed by weight, after search.inc.wgsl.

struct Mix {
    // Sum of weight times light, and of weights.
    light: vec3f,
    weight: f32,
    // The heaviest one: what a mirror takes.
    pixel: vec2u,
    heaviest: f32,
}

const MIX_NOTHING = Mix(vec3f(0.0), 0.0, vec2u(0u), 0.0);

fn mix_add(sum: Mix, pixel: vec2u, light: vec3f, weight: f32) -> Mix {
    if (!(weight > 0.0)) {
        return sum;
    }
    let is_heaviest = weight > sum.heaviest;
    return Mix(
        sum.light + weight * light,
        sum.weight + weight,
        select(sum.pixel, pixel, is_heaviest),
        max(sum.heaviest, weight),
    );
}

fn mix_is_picture(s: Surface) -> bool {
    return all(s.roughness == vec2f(0.0));
}

struct MixLobes {
    diffuse: Mix,
    specular: Mix,
}

// A trace pixel's light added to the lobes it counts for.
fn mix_tap(sum: MixLobes, tap: SearchTap, weight: f32) -> MixLobes {
    var lobes = sum;
    if (tap.has_diffuse) {
        lobes.diffuse = mix_add(lobes.diffuse, tap.pixel, textureLoad(light_diffuse, tap.pixel, 0).rgb, weight);
    }
    if (tap.has_specular) {
        lobes.specular = mix_add(lobes.specular, tap.pixel, textureLoad(light_specular, tap.pixel, 0).rgb, weight);
    }
    return lobes;
}

// The mean; nothing where nothing was added.
fn mix_mean(sum: Mix) -> vec3f {
    return select(vec3f(0.0), sum.light / max(sum.weight, 1e-30), sum.weight > 0.0);
}

// What the pixel gets of the specular lobe: mirrors take one pixel's light.
fn mix_specular(sum: Mix, surface: Surface) -> vec3f {
    let copied = textureLoad(light_specular, sum.pixel, 0).rgb;
    return select(mix_mean(sum), copied, mix_is_picture(surface) && sum.weight > 0.0);
}
