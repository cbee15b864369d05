// Which light counts, weighted sums of it, and what stands in for what does not count. After half.

// Radiance and lengths are finite and not negative; what was too large for a half float came in as infinity.
fn light_is_valid(light: vec4f) -> bool {
    return all(half_is_finite(light)) && all(light >= vec4f(0.0));
}

// Weighted sums of a lobe; lengths only over taps that have one.
struct LightSum {
    rgb: vec3f,
    weight: f32,
    length: f32,
    length_weight: f32,
}

fn light_nothing() -> LightSum {
    return LightSum(vec3f(0.0), 0.0, 0.0, 0.0);
}

fn light_add(sum: LightSum, light: vec4f, weight: f32) -> LightSum {
    let length_weight = select(0.0, weight, light.a > 0.0);
    return LightSum(
        sum.rgb + weight * light.rgb,
        sum.weight + weight,
        sum.length + length_weight * light.a,
        sum.length_weight + length_weight,
    );
}

// Where no tap had anything to give, what was there before stays.
fn light_mean(sum: LightSum, before: vec4f) -> vec4f {
    let rgb = select(before.rgb, sum.rgb / max(sum.weight, 1e-20), sum.weight > 1e-20);
    let length = select(before.a, sum.length / max(sum.length_weight, 1e-20), sum.length_weight > 1e-20);
    return half_rounded(vec4f(rgb, length));
}

// The light of a pixel; where it is not valid, the mean of the valid ones around it, or 0.
fn light_mended(image: texture_2d<f32>, p: vec2i) -> vec4f {
    let light = textureLoad(image, p, 0);
    if (light_is_valid(light)) {
        return light;
    }
    let size = vec2i(textureDimensions(image));
    var sum = light_nothing();
    for (var k = 0; k < 9; k++) {
        let q = p + vec2i(k % 3, k / 3) - vec2i(1);
        if (all(q >= vec2i(0)) && all(q < size)) {
            let tap = textureLoad(image, q, 0);
            if (light_is_valid(tap)) {
                sum = light_add(sum, tap, 1.0);
            }
        }
    }
    return light_mean(sum, vec4f(0.0));
}

// A pixel's place beyond the border is taken by its mirror image: every pixel then gives as much as it takes, and a
// filter keeps the picture's light up to its edges.
fn light_mirrored(q: vec2i, size: vec2i) -> vec2i {
    let period = 2 * size;
    let inside = ((q % period) + period) % period;
    return min(inside, period - vec2i(1) - inside);
}
