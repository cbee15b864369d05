// What the variance and the wavelet share: their parameters, and the weight of a tap by its geometry.

struct SvgfParams {
    // Pixels from the centre to the first and the second tap along x and y.
    first_tap: vec2i,
    second_tap: vec2i,
    // Standard deviations.
    sigma_luminance: f32,
    // Power of the cosine.
    sigma_normal: f32,
    // Rows.
    sigma_depth: f32,
    // Share of the specular lobe's tangent.
    lobe_spread: f32,
    // Relative difference of roughness.
    roughness_fraction: f32,
    // Trace rows per pixel along a row.
    rows_per_column: f32,
    // Of a level's outermost tap: 1 or 2.
    reach: i32,
    // Share of one frame's variance that the mean over frames has at least.
    least_variance: f32,
    // Of the centre, the first and the second tap along an axis.
    kernel: vec3f,
}

@group(0) @binding(1) var<uniform> params: SvgfParams;
@group(2) @binding(0) var in_edge: texture_2d<u32>;

// Minus the logarithm of w_z w_n.
fn svgf_geometry_fall(centre: EdgeCentre, tap: vec4u, q: vec2i, size: vec2i) -> f32 {
    return edge_fall(centre, tap, q, size, params.sigma_normal, params.sigma_depth);
}

fn svgf_lobe_weight(centre: EdgeCentre, tap: vec4u, offset: vec2i, size: vec2i) -> f32 {
    let rows = vec2f(offset) * vec2f(params.rows_per_column, 1.0);
    return edge_lobe_weight(centre.texel, tap, rows, size, params.lobe_spread, params.roughness_fraction);
}
