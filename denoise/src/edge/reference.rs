//! The CPU half: the same functions as `edge.inc.wgsl` and `pack.wgsl`, in the same order, in f32 like the shaders.

use super::EdgeParams;
use crate::light::reference::{Light, at, is_valid, size_of};
use frame::brdf;
use frame::cpu::Image;
use frame::info::Frame;
use frame::surface::{Surface, face_normal_unpack, normal_unpack};
use glam::{IVec2, Vec2, Vec3};

/// The lobe takes from its neighbours.
pub const TAKES: [u32; 2] = [1 << 28, 1 << 30];
/// The lobe gives to its neighbours.
pub const GIVES: [u32; 2] = [1 << 29, 1 << 31];
/// Bits of the object.
pub const OBJECT_MASK: u32 = super::OBJECT_MASK;

const DISTANCE_LARGEST: f32 = 1e15;

fn ray(frame: &Frame, p: IVec2, size: IVec2) -> Vec3 {
    let point = p.as_vec2() + 0.5 + Vec2::from(frame.jitter);
    let ndc = Vec2::new(2.0, -2.0) * (point / size.as_vec2()) + Vec2::new(-1.0, 1.0);
    Vec3::from(frame.forward) + ndc.x * Vec3::from(frame.right) + ndc.y * Vec3::from(frame.up)
}

/// Relative to the eye, metres.
pub fn position(frame: &Frame, texel: [u32; 4], p: IVec2, size: IVec2) -> Vec3 {
    f32::from_bits(texel[0]) * ray(frame, p, size)
}

/// Shading normal.
pub fn normal(texel: [u32; 4]) -> Vec3 {
    normal_unpack(texel[1])
}

/// Of the triangle.
pub fn face_normal(texel: [u32; 4]) -> Vec3 {
    face_normal_unpack(texel[2])
}

/// 0..1, the higher of the two.
pub fn roughness(texel: [u32; 4]) -> f32 {
    (texel[1] >> 24) as f32 / 255.0
}

/// Metres that one row spans at the depth of the pixel.
pub fn footprint(frame: &Frame, texel: [u32; 4], size: IVec2) -> f32 {
    (f32::from_bits(texel[0]) * 2.0 * Vec3::from(frame.up).length() / size.y as f32).max(1e-30)
}

/// A tap's weight by its geometry: the cosine between normals to a power, and the distance from the centre's plane in
/// `rows`.
pub fn geometry_weight(
    frame: &Frame,
    edge: &Image<[u32; 4]>,
    [p, q]: [IVec2; 2],
    power: f32,
    rows: f32,
) -> f32 {
    let size = size_of(edge);
    let (centre, tap) = (at(edge, p), at(edge, q));
    let away = position(frame, tap, q, size) - position(frame, centre, p, size);
    let plane = face_normal(centre).dot(away).abs() / footprint(frame, centre, size);
    let facing = normal(tap).dot(normal(centre));
    let turned = if facing > 0.0 { -power * facing.clamp(0.01, 1.0).ln() } else { 80.0 };
    (-(turned + (plane / rows.max(1e-6)).min(80.0))).exp()
}

/// How unlike two roughnesses may be: 1 for equal ones, 0 from `fraction` of the centre's on.
pub fn roughness_weight([centre, tap]: [[u32; 4]; 2], fraction: f32) -> f32 {
    let wanted = roughness(centre);
    let unlike = (roughness(tap) - wanted).abs() / (fraction * wanted).max(1e-6);
    (1.0 - unlike).max(0.0)
}

/// What the specular lobe's width leaves of a tap `rows` away.
pub fn lobe_weight(
    frame: &Frame,
    [centre, tap]: [[u32; 4]; 2],
    rows: Vec2,
    size: IVec2,
    [spread, fraction]: [f32; 2],
) -> f32 {
    let wanted = roughness(centre);
    let radius = spread * wanted * wanted * size.y as f32 / (2.0 * Vec3::from(frame.up).length());
    let far = rows.length_squared() / (radius * radius).max(1e-6);
    (-0.5 * far).exp() * roughness_weight([centre, tap], fraction)
}

/// The four words of each pixel; `motion_id` is the object alone.
pub fn pack(
    params: &EdgeParams,
    frame: &Frame,
    surface: &Image<[u32; 4]>,
    distance: &Image<f32>,
    face_normal_and_object: &Image<[u32; 2]>,
    noisy: &Light,
) -> Image<[u32; 4]> {
    let size = size_of(surface);
    Image::from_fn(surface.size(), |x, y| {
        let p = IVec2::new(x as i32, y as i32);
        let distance = at(distance, p);
        if !(distance > 0.0 && distance.is_finite()) {
            return [0; 4];
        }
        let words = at(surface, p);
        let surface = Surface::unpack_gbuffer(words);
        let is_traced = at(&noisy.samples, p) != 0;
        let code = (words[3] & 0xff).max((words[3] >> 8) & 0xff);
        let [face_normal, object] = at(face_normal_and_object, p);
        let mut bits = object & params.object_mask;
        let albedo = surface.base * (1.0 - surface.metalness) * (1.0 - surface.transmission);
        if albedo.max_element() > 0.0 {
            let gives = is_traced && is_valid(at(&noisy.diffuse, p));
            bits |= TAKES[0] | if gives { GIVES[0] } else { 0 };
        }
        if brdf::has_specular(&surface) && code >= params.specular_code_min {
            let gives = is_traced && noisy.specular.as_ref().is_none_or(|light| is_valid(at(light, p)));
            bits |= TAKES[1] | if gives { GIVES[1] } else { 0 };
        }
        let direction = ray(frame, p, size).normalize();
        let depth = distance.min(DISTANCE_LARGEST) * direction.dot(Vec3::from(frame.forward));
        [depth.to_bits(), (words[0] & 0xff_ffff) | (code << 24), face_normal, bits]
    })
}
