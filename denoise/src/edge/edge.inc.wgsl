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

// A pixel, unpacked.
struct EdgeCentre {
    texel: vec4u,
    position: vec3f,
    normal: vec3f,
    face_normal: vec3f,
    footprint: f32,
}

fn edge_centre(texel: vec4u, p: vec2i, size: vec2i) -> EdgeCentre {
    return EdgeCentre(
        texel,
        edge_position(texel, p, size),
        edge_normal(texel),
        edge_face_normal(texel),
        edge_footprint(texel, size),
    );
}

// Minus the logarithm of a tap's weight by its geometry: the cosine between normals to a power, and the distance from the
// centre's plane in `rows`.
fn edge_fall(centre: EdgeCentre, tap: vec4u, q: vec2i, size: vec2i, power: f32, rows: f32) -> f32 {
    let plane = abs(dot(centre.face_normal, edge_position(tap, q, size) - centre.position)) / centre.footprint;
    let facing = dot(edge_normal(tap), centre.normal);
    let turned = select(80.0, -power * log(clamp(facing, 0.01, 1.0)), facing > 0.0);
    return turned + min(plane / max(rows, 1e-6), 80.0);
}

// How unlike two roughnesses may be: 1 for equal ones, 0 from `fraction` of the centre's on.
fn edge_roughness_weight(centre: vec4u, tap: vec4u, fraction: f32) -> f32 {
    let roughness = edge_roughness(centre);
    let unlike = abs(edge_roughness(tap) - roughness) / max(fraction * roughness, 1e-6);
    return max(1.0 - unlike, 0.0);
}

// What the specular lobe's width leaves of a tap `rows` away. `spread` is the share of the lobe's tangent that a kernel
// may span, `fraction` how far roughness may differ, relative to the centre's.
fn edge_lobe_weight(centre: vec4u, tap: vec4u, rows: vec2f, size: vec2i, spread: f32, fraction: f32) -> f32 {
    let roughness = edge_roughness(centre);
    let radius = spread * roughness * roughness * f32(size.y) / (2.0 * length(frame.up));
    let far = dot(rows, rows) / max(radius * radius, 1e-6);
    return exp(-0.5 * far) * edge_roughness_weight(centre, tap, fraction);
}
