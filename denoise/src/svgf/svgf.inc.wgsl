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
}

@group(0) @binding(1) var<uniform> params: SvgfParams;
@group(2) @binding(0) var in_edge: texture_2d<u32>;

struct SvgfCentre {
    texel: vec4u,
    position: vec3f,
    normal: vec3f,
    face_normal: vec3f,
    footprint: f32,
}

fn svgf_centre(p: vec2i, size: vec2i) -> SvgfCentre {
    let texel = textureLoad(in_edge, p, 0);
    return SvgfCentre(
        texel,
        edge_position(texel, p, size),
        edge_normal(texel),
        edge_face_normal(texel),
        edge_footprint(texel, size),
    );
}

// Minus the logarithm of w_z w_n. The luminance's is added to it, so that a tap costs one exponential per lobe.
fn svgf_geometry_fall(centre: SvgfCentre, tap: vec4u, q: vec2i, size: vec2i) -> f32 {
    let plane = abs(dot(centre.face_normal, edge_position(tap, q, size) - centre.position)) / centre.footprint;
    let facing = dot(edge_normal(tap), centre.normal);
    let turned = select(80.0, -params.sigma_normal * log(clamp(facing, 0.01, 1.0)), facing > 0.0);
    return turned + min(plane / max(params.sigma_depth, 1e-6), 80.0);
}

fn svgf_lobe_weight(centre: SvgfCentre, tap: vec4u, offset: vec2i, size: vec2i) -> f32 {
    let rows = vec2f(offset) * vec2f(params.rows_per_column, 1.0);
    return edge_lobe_weight(centre.texel, tap, rows, size, params.lobe_spread, params.roughness_fraction);
}
