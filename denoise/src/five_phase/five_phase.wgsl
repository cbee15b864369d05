// One phase of the blur along one axis, both lobes at once. Formula and units: mod.rs beside this file.
// Worst case: 2 * 64 + 1 taps a pixel, 1,032 loop iterations per 8 lanes. Taps are loaded where they are needed:
// keeping a line of them in workgroup memory took the software adapter twice as long.

struct PhaseParams {
    // One pixel along the axis.
    step: vec2i,
    // 0..4.
    phase: u32,
    // Pixels along this axis per trace row.
    radius_scale: f32,
    // Trace rows; per growth step; most of it.
    kernel_radius: f32,
    radius_growth: f32,
    radius_growth_max: f32,
    // Metres; per growth step; most of it.
    radial_cutoff: f32,
    cutoff_growth: f32,
    cutoff_growth_max: f32,
    // Metres from the viewer per growth step.
    growth_step: f32,
    // 1: weights fall linearly to the kernel's end.
    is_triangular: u32,
    // 1: specular taps must be of this bracket or above.
    same_bracket: u32,
    // 1: the picture's mirror image lies beyond its border, 0: nothing.
    is_mirrored: u32,
    // 1: the cut-off is of the difference in distance from the viewer, 0: of the distance between points.
    by_depth: u32,
}

override has_specular: bool = true;

@group(0) @binding(1) var<uniform> params: PhaseParams;
@group(2) @binding(0) var in_guide: texture_2d<u32>;
@group(2) @binding(1) var in_diffuse: texture_2d<f32>;
@group(2) @binding(2) var in_specular: texture_2d<f32>;
@group(3) @binding(0) var out_diffuse: texture_storage_2d<rgba16float, write>;
@group(3) @binding(1) var out_specular: texture_storage_2d<rgba16float, write>;

const RADIUS_MAX = 64;

@compute @workgroup_size(8, 8)
fn filter_phase(@builtin(global_invocation_id) id: vec3u) {
    let size = vec2i(textureDimensions(in_guide));
    let p = vec2i(id.xy);
    if (any(p >= size)) {
        return;
    }
    let centre = textureLoad(in_guide, p, 0);
    let is_diffuse = (centre.w >> 30u & 1u) == 1u;
    let is_specular = has_specular && (centre.w >> (24u + params.phase) & 1u) == 1u;

    let position = bitcast<vec3f>(centre.xyz);
    let normal = surface_normal_unpack(centre.w);
    let viewer = length(position);
    let growth = floor(viewer / params.growth_step);
    let rows = params.kernel_radius + min(params.radius_growth * growth, params.radius_growth_max);
    let cutoff = params.radial_cutoff + min(params.cutoff_growth * growth, params.cutoff_growth_max);
    var radius = min(i32(floor(rows * params.radius_scale + 0.5)), RADIUS_MAX);
    if (!is_diffuse && !is_specular) {
        radius = -1;
    }
    let falloff = select(0.0, 1.0 / f32(radius + 1), params.is_triangular == 1u && radius > 0);

    let along = dot(p, params.step);
    let last = dot(size - vec2i(1), params.step);
    var diffuse = light_nothing();
    var specular = diffuse;
    let first_step = select(max(-radius, -along), -radius, params.is_mirrored == 1u);
    let last_step = select(min(radius, last - along), radius, params.is_mirrored == 1u);
    for (var j = first_step; j <= last_step; j++) {
        let q = light_mirrored(p + j * params.step, size);
        let guide = textureLoad(in_guide, q, 0);
        let offset = bitcast<vec3f>(guide.xyz) - position;
        let facing = dot(normal, surface_normal_unpack(guide.w));
        let apart = select(length(offset), abs(length(bitcast<vec3f>(guide.xyz)) - viewer), params.by_depth == 1u);
        if (facing <= 0.0 || apart > cutoff) {
            continue;
        }
        let weight = facing * (1.0 - falloff * f32(abs(j)));
        if (is_diffuse && (guide.w >> 31u) == 1u) {
            diffuse = light_add(diffuse, textureLoad(in_diffuse, q, 0), weight);
        }
        let is_bracket = params.same_bracket == 0u || (guide.w >> (24u + params.phase) & 1u) == 1u;
        if (is_specular && is_bracket && (guide.w >> 29u & 1u) == 1u) {
            specular = light_add(specular, textureLoad(in_specular, q, 0), weight);
        }
    }

    if (is_diffuse) {
        textureStore(out_diffuse, p, light_mean(diffuse, light_mended(in_diffuse, p)));
    } else {
        textureStore(out_diffuse, p, light_mended(in_diffuse, p));
    }
    if (has_specular) {
        if (is_specular) {
            textureStore(out_specular, p, light_mean(specular, light_mended(in_specular, p)));
        } else {
            textureStore(out_specular, p, light_mended(in_specular, p));
        }
    }
}
