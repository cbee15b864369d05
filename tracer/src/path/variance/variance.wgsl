// How noisy each pixel's light is, and how many more samples it gets. See mod.rs.

// 0 and 1: the means of sigma and of w; behind them one sum per workgroup. x over what, y how many.
@group(1) @binding(35) var<storage, read_write> variance_sums: array<vec2f>;

const VARIANCE_MEANS = 2u;
const VARIANCE_REACH = 3;
// Sums are over w, not over sigma.
override variance_of_weights = false;

fn variance_light(index: u32) -> f32 {
    let light = pixels[index].diffuse.rgb + pixels[index].specular.rgb;
    return dot(light, vec3f(0.2126, 0.7152, 0.0722));
}

fn variance_is_in(id: vec2u) -> bool {
    return all(id < vec2u(frame.trace_size.x, params.rows));
}

fn variance_weight(sigma: f32) -> f32 {
    let mean = variance_sums[0].x;
    return min(sigma, 2.0 * mean) + 0.7 * mean + 1e-20;
}

@compute @workgroup_size(8, 8)
fn variance_note(@builtin(workgroup_id) group: vec3u, @builtin(global_invocation_id) id: vec3u) {
    params = params_of[group.z];
    if (variance_is_in(id.xy)) {
        pixels[path_index(id.xy)].aside.x = variance_light(path_index(id.xy));
    }
}

@compute @workgroup_size(8, 8)
fn variance_square(@builtin(workgroup_id) group: vec3u, @builtin(global_invocation_id) id: vec3u) {
    params = params_of[group.z];
    if (variance_is_in(id.xy)) {
        let index = path_index(id.xy);
        let apart = min(abs(variance_light(index) - 2.0 * pixels[index].aside.x), 1e15);
        pixels[index].aside.x = apart * apart;
    }
}

@compute @workgroup_size(8, 8)
fn variance_spread(@builtin(workgroup_id) group: vec3u, @builtin(global_invocation_id) id: vec3u) {
    params = params_of[group.z];
    if (!variance_is_in(id.xy)) {
        return;
    }
    var sum = 0.0;
    var count = 0.0;
    for (var y = -VARIANCE_REACH; y <= VARIANCE_REACH; y += 1) {
        for (var x = -VARIANCE_REACH; x <= VARIANCE_REACH; x += 1) {
            let at = vec2i(id.xy) + vec2i(x, y);
            if ((x == 0 && y == 0) || any(at < vec2i(0)) || !variance_is_in(vec2u(at))) {
                continue;
            }
            let other = path_index(vec2u(at));
            if (pixels[other].samples != 0u) {
                sum += pixels[other].aside.x;
                count += 1.0;
            }
        }
    }
    pixels[path_index(id.xy)].aside.y = sqrt(sum / max(count, 1.0));
}

var<workgroup> variance_group: array<vec2f, 64>;

// Of the workgroup's 64 values, in a fixed order.
fn variance_reduce(local: u32, value: vec2f) -> vec2f {
    variance_group[local] = value;
    workgroupBarrier();
    for (var half = 32u; half > 0u; half >>= 1u) {
        if (local < half) {
            variance_group[local] += variance_group[local + half];
        }
        workgroupBarrier();
    }
    return variance_group[0];
}

@compute @workgroup_size(8, 8)
fn variance_sum(@builtin(workgroup_id) group: vec3u, @builtin(num_workgroups) groups: vec3u, @builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) local: u32) {
    params = params_of[group.z];
    var value = vec2f(0.0);
    if (variance_is_in(id.xy)) {
        let pixel = path_index(id.xy);
        if (pixels[pixel].samples != 0u) {
            value = vec2f(pixels[pixel].aside.y, 1.0);
            if (variance_of_weights) {
                value.x = variance_weight(value.x);
            }
        }
    }
    let sum = variance_reduce(local, value);
    if (local == 0u) {
        variance_sums[VARIANCE_MEANS + group.y * groups.x + group.x] = sum;
    }
}

@compute @workgroup_size(8, 8)
fn variance_mean(@builtin(local_invocation_index) local: u32) {
    var value = vec2f(0.0);
    for (var i = VARIANCE_MEANS + local; i < arrayLength(&variance_sums); i += 64u) {
        value += variance_sums[i];
    }
    let sum = variance_reduce(local, value);
    if (local == 0u) {
        variance_sums[select(0u, 1u, variance_of_weights)] = vec2f(sum.x / max(sum.y, 1.0), sum.y);
    }
}

@compute @workgroup_size(8, 8)
fn variance_plan(@builtin(workgroup_id) group: vec3u, @builtin(global_invocation_id) id: vec3u) {
    params = params_of[group.z];
    if (variance_is_in(id.xy)) {
        let index = path_index(id.xy);
        let share = variance_weight(pixels[index].aside.y) / max(variance_sums[1].x, 1e-20);
        let wanted = f32(params.rest) * share + noise_at(id.xy, params.first_sample, 1u).w;
        pixels[index].aside.z = floor(wanted);
    }
}
