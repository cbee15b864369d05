// Edge-adaptive spatial upsampling. Source: mod.rs beside this file.
//
// The twelve trace pixels, f the one up and left of the place:
//
//       b c
//     e f g h
//     i j k l
//       n o

@group(2) @binding(6) var in_color: texture_2d<f32>;
@group(3) @binding(0) var out_color: texture_storage_2d<rgba16float, write>;

fn easu_load(p: vec2i) -> vec3f {
    let q = clamp(p, vec2i(0), vec2i(frame.trace_size) - vec2i(1));
    return tone_mapped(textureLoad(in_color, q, 0).rgb);
}

// Twice the luma, green counted double.
fn easu_luma(c: vec3f) -> f32 {
    return c.g + 0.5 * (c.r + c.b);
}

// Direction across the edge, and how much of an edge there is.
struct EasuEdge {
    direction: vec2f,
    strength: f32,
}

// How monotonic luma is along an axis, 0..1: low - centre - high.
fn easu_axis(low: f32, centre: f32, high: f32) -> vec2f {
    let slope = high - low;
    let steepest = max(abs(high - centre), abs(centre - low));
    let ratio = clamp(abs(slope) / max(steepest, 1e-8), 0.0, 1.0);
    return vec2f(slope, ratio * ratio);
}

fn easu_edge_add(edge: EasuEdge, share: f32, up: f32, left: f32, centre: f32, right: f32, down: f32) -> EasuEdge {
    let x = easu_axis(left, centre, right);
    let y = easu_axis(up, centre, down);
    return EasuEdge(edge.direction + share * vec2f(x.x, y.x), edge.strength + share * (x.y + y.y));
}

struct EasuSum {
    color: vec3f,
    weight: f32,
}

// `lobe` and `cut` shape the window: how negative it gets, and where it ends.
fn easu_tap(sum: EasuSum, away: vec2f, direction: vec2f, stretch: vec2f, lobe: f32, cut: f32, color: vec3f) -> EasuSum {
    let turned = vec2f(dot(away, direction), dot(away, vec2f(-direction.y, direction.x))) * stretch;
    let d2 = min(dot(turned, turned), cut);
    // (25/16 (2/5 d^2 - 1)^2 - 9/16) (lobe d^2 - 1)^2: Lanczos 2 without sines.
    let base = 0.4 * d2 - 1.0;
    let window = lobe * d2 - 1.0;
    let weight = (1.5625 * base * base - 0.5625) * window * window;
    return EasuSum(sum.color + weight * color, sum.weight + weight);
}

@compute @workgroup_size(8, 8)
fn easu(@builtin(global_invocation_id) id: vec3u) {
    let pixel = id.xy;
    if (any(pixel >= frame.display_size)) {
        return;
    }
    let place = (vec2f(pixel) + vec2f(0.5)) * vec2f(frame.trace_size) / vec2f(frame.display_size) - vec2f(0.5);
    let at = vec2i(floor(place));
    let part = place - floor(place);
    let b = easu_load(at + vec2i(0, -1));
    let c = easu_load(at + vec2i(1, -1));
    let e = easu_load(at + vec2i(-1, 0));
    let f = easu_load(at);
    let g = easu_load(at + vec2i(1, 0));
    let h = easu_load(at + vec2i(2, 0));
    let i = easu_load(at + vec2i(-1, 1));
    let j = easu_load(at + vec2i(0, 1));
    let k = easu_load(at + vec2i(1, 1));
    let l = easu_load(at + vec2i(2, 1));
    let n = easu_load(at + vec2i(0, 2));
    let o = easu_load(at + vec2i(1, 2));
    let lf = easu_luma(f);
    let lg = easu_luma(g);
    let lj = easu_luma(j);
    let lk = easu_luma(k);
    var edge = EasuEdge(vec2f(0.0), 0.0);
    edge = easu_edge_add(edge, (1.0 - part.x) * (1.0 - part.y), easu_luma(b), easu_luma(e), lf, lg, lj);
    edge = easu_edge_add(edge, part.x * (1.0 - part.y), easu_luma(c), lf, lg, easu_luma(h), lk);
    edge = easu_edge_add(edge, (1.0 - part.x) * part.y, lf, easu_luma(i), lj, lk, easu_luma(n));
    edge = easu_edge_add(edge, part.x * part.y, lg, lj, lk, easu_luma(l), easu_luma(o));

    let length_2 = dot(edge.direction, edge.direction);
    let has_direction = length_2 >= 1.0 / 32768.0;
    let direction = select(vec2f(1.0, 0.0), edge.direction * inverseSqrt(max(length_2, 1e-12)), has_direction);
    // 0 where nothing leads anywhere, 1 on a straight edge.
    let half_strength = 0.5 * edge.strength;
    let straight = half_strength * half_strength;
    // Along the diagonals pixels lie sqrt(2) apart.
    let diagonal = 1.0 / max(abs(direction.x), abs(direction.y));
    let stretch = vec2f(1.0 + (diagonal - 1.0) * straight, 1.0 - 0.5 * straight);
    let lobe = 0.5 - 0.29 * straight;
    let cut = 1.0 / lobe;

    var sum = EasuSum(vec3f(0.0), 0.0);
    sum = easu_tap(sum, vec2f(0.0, -1.0) - part, direction, stretch, lobe, cut, b);
    sum = easu_tap(sum, vec2f(1.0, -1.0) - part, direction, stretch, lobe, cut, c);
    sum = easu_tap(sum, vec2f(-1.0, 0.0) - part, direction, stretch, lobe, cut, e);
    sum = easu_tap(sum, vec2f(0.0, 0.0) - part, direction, stretch, lobe, cut, f);
    sum = easu_tap(sum, vec2f(1.0, 0.0) - part, direction, stretch, lobe, cut, g);
    sum = easu_tap(sum, vec2f(2.0, 0.0) - part, direction, stretch, lobe, cut, h);
    sum = easu_tap(sum, vec2f(-1.0, 1.0) - part, direction, stretch, lobe, cut, i);
    sum = easu_tap(sum, vec2f(0.0, 1.0) - part, direction, stretch, lobe, cut, j);
    sum = easu_tap(sum, vec2f(1.0, 1.0) - part, direction, stretch, lobe, cut, k);
    sum = easu_tap(sum, vec2f(2.0, 1.0) - part, direction, stretch, lobe, cut, l);
    sum = easu_tap(sum, vec2f(0.0, 2.0) - part, direction, stretch, lobe, cut, n);
    sum = easu_tap(sum, vec2f(1.0, 2.0) - part, direction, stretch, lobe, cut, o);
    // The nearest four bound it: no ringing.
    let least = min(min(f, g), min(j, k));
    let most = max(max(f, g), max(j, k));
    let mean = clamp(sum.color / max(sum.weight, 1e-6), least, most);
    textureStore(out_color, pixel, half_rounded(vec4f(tone_unmapped(mean), 1.0)));
}
