// What edge-avoiding filters ask about a pixel and its taps, after info and surface. Layout, units: mod.rs beside this file.

const EDGE_OBJECT_MASK = 0x0fffffffu;
const EDGE_DIFFUSE_TAKES = 0x10000000u;
const EDGE_DIFFUSE_GIVES = 0x20000000u;
const EDGE_SPECULAR_TAKES = 0x40000000u;
const EDGE_SPECULAR_GIVES = 0x80000000u;

// Relative to the eye, metres.
fn edge_position(texel: vec4u, pixel: vec2i, size: vec2i) -> vec3f {
    let point = vec2f(pixel) + vec2f(0.5) + frame.jitter;
    let ndc = vec2f(2.0, -2.0) * (point / vec2f(size)) + vec2f(-1.0, 1.0);
    return bitcast<f32>(texel.x) * (frame.forward + ndc.x * frame.right + ndc.y * frame.up);
}

fn edge_normal(texel: vec4u) -> vec3f {
    return surface_normal_unpack(texel.y);
}

fn edge_face_normal(texel: vec4u) -> vec3f {
    return surface_face_normal_unpack(texel.z);
}

fn edge_roughness(texel: vec4u) -> f32 {
    return f32(texel.y >> 24u) / 255.0;
}

// Metres that one row spans at the depth of the pixel; where nothing was hit, of no use, but not 0.
fn edge_footprint(texel: vec4u, size: vec2i) -> f32 {
    return max(bitcast<f32>(texel.x) * 2.0 * length(frame.up) / f32(size.y), 1e-30);
}

// What the specular lobe's width leaves of a tap `rows` away. `spread` is the share of the lobe's tangent that a kernel
// may span, `fraction` how far roughness may differ, relative to the centre's.
fn edge_lobe_weight(centre: vec4u, tap: vec4u, rows: vec2f, size: vec2i, spread: f32, fraction: f32) -> f32 {
    let roughness = edge_roughness(centre);
    let radius = spread * roughness * roughness * f32(size.y) / (2.0 * length(frame.up));
    let far = dot(rows, rows) / max(radius * radius, 1e-6);
    let unlike = abs(edge_roughness(tap) - roughness) / max(fraction * roughness, 1e-6);
    return exp(-0.5 * far) * max(1.0 - unlike, 0.0);
}

// Weighted sums of a lobe; lengths only over taps that have one.
struct EdgeSum {
    rgb: vec3f,
    weight: f32,
    length: f32,
    length_weight: f32,
}

fn edge_sum_add(sum: EdgeSum, light: vec4f, weight: f32) -> EdgeSum {
    let length_weight = select(0.0, weight, light.a > 0.0);
    return EdgeSum(
        sum.rgb + weight * light.rgb,
        sum.weight + weight,
        sum.length + length_weight * light.a,
        sum.length_weight + length_weight,
    );
}

// Where every tap lies beyond an edge or has nothing to give, what was there before stays: a pixel without light of its
// own that an earlier pass filled.
fn edge_sum_mean(sum: EdgeSum, before: vec4f) -> vec4f {
    let rgb = select(before.rgb, sum.rgb / max(sum.weight, 1e-20), sum.weight > 1e-20);
    let length = select(before.a, sum.length / max(sum.length_weight, 1e-20), sum.length_weight > 1e-20);
    return half_rounded(vec4f(rgb, length));
}

fn edge_untouched(light: vec4f) -> vec4f {
    return select(vec4f(0.0), light, all(half_is_finite(light)));
}
