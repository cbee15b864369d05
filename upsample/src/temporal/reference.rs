//! The CPU half of `temporal.wgsl`, in the same order; what is kept stays f32 here, half floats there.

use super::{PARTS, Settings, TemporalParams};
use crate::joint_bilateral::reference::light;
use crate::modulate::reference::{Inputs, load};
use crate::search::reference::{Wanted, lobe, tap, wanted};
use frame::cpu::Image;
use frame::surface;
use glam::{IVec2, UVec2, Vec2, Vec3, Vec4, Vec4Swizzles};

const SHARE_MIN: f32 = 0.01;

/// What is kept from frame to frame: light with its weight, diffuse and specular; normal and distance with the object.
#[derive(Clone)]
pub struct History {
    light: [Image<[f32; 4]>; 2],
    guides: Image<([f32; 3], f32, u32)>,
}

/// What the accumulation reads besides [`Inputs`].
pub struct Before<'a> {
    /// None at a restart.
    pub history: Option<&'a History>,
    /// The last frame's view.
    pub params: &'a TemporalParams,
    /// Motion (display pixels) and object of each display pixel.
    pub motion: &'a Image<([f32; 2], u32)>,
}

fn kept(inputs: &Inputs<'_>, before: &Before<'_>, wanted: &Wanted, pixel: UVec2) -> [Vec4; 2] {
    let nothing = [Vec4::ZERO; 2];
    let (Some(history), Some((motion, object))) =
        (before.history, before.motion.get(pixel.x as i32, pixel.y as i32))
    else {
        return nothing;
    };
    let params = before.params;
    let place = pixel.as_vec2() - Vec2::from(motion);
    let (mut sums, mut total) = (nothing, 0.0);
    for (q, share) in crate::bilinear::reference::corners(place) {
        let Some((normal, distance, other)) = history.guides.get(q.x, q.y) else { continue };
        let size = UVec2::from(inputs.frame.display_size).as_vec2();
        let ndc = Vec2::new(2.0, -2.0) * ((q.as_vec2() + 0.5) / size) + Vec2::new(-1.0, 1.0);
        let [forward, right, up] =
            [params.previous_forward, params.previous_right, params.previous_up].map(Vec3::from);
        let position = distance * (forward + ndc.x * right + ndc.y * up).normalize();
        let expected = wanted.position + Vec3::from(params.eye_offset);
        let off_plane = wanted.surface.normal.dot(position - expected).abs();
        let is_same = share > 0.0
            && distance > 0.0
            && other == object & 0xff
            && off_plane <= params.plane_tolerance * wanted.distance
            && Vec3::from(normal).dot(wanted.surface.normal) >= params.normal_min;
        if is_same {
            for (sum, image) in sums.iter_mut().zip(&history.light) {
                *sum += share * Vec4::from(image.get(q.x, q.y).unwrap_or_default());
            }
            total += share;
        }
    }
    if total < SHARE_MIN { nothing } else { sums.map(|sum| params.keeps_history / total * sum) }
}

fn ycocg(c: Vec3) -> Vec3 {
    Vec3::new(
        0.25 * c.x + 0.5 * c.y + 0.25 * c.z,
        0.5 * c.x - 0.5 * c.z,
        -0.25 * c.x + 0.5 * c.y - 0.25 * c.z,
    )
}

fn rectified(params: &TemporalParams, kept: Vec4, spread: &[Vec3]) -> Vec4 {
    if spread.is_empty() {
        return kept;
    }
    let count = spread.len() as f32;
    let mean = spread.iter().map(|c| ycocg(*c)).sum::<Vec3>() / count;
    let squares = spread.iter().map(|c| ycocg(*c) * ycocg(*c)).sum::<Vec3>() / count;
    let deviation = (squares - mean * mean).max(Vec3::ZERO).map(f32::sqrt);
    let width = params.clamp_width * deviation + (0.02 * mean.x + 1e-6);
    let off = (ycocg(kept.xyz()) - mean).abs();
    let left = (width / off.max(width)).min_element();
    let middle = spread.iter().sum::<Vec3>() / count;
    middle.lerp(kept.xyz(), left).extend(left * kept.w)
}

/// The picture and what is kept for the next frame.
pub fn temporal(settings: &Settings, inputs: &Inputs<'_>, before: &Before<'_>) -> (Image<[f32; 4]>, History) {
    let size = inputs.frame.display_size;
    let offsets = settings.joint.search.offsets(inputs.frame.trace_size, size);
    let joint = settings.joint.params(PARTS);
    let mut next = History {
        light: [Image::filled(size, [0.0; 4]), Image::filled(size, [0.0; 4])],
        guides: Image::filled(size, ([0.0; 3], 0.0, 0)),
    };
    let picture = inputs.picture(|pixel| {
        let wanted = wanted(inputs, pixel);
        let now = light(&settings.joint.search, &offsets, &joint, inputs, pixel);
        let mut shown = now.light;
        let kept = kept(inputs, before, &wanted, pixel);
        let centre = inputs.trace_pixel(pixel).as_ivec2();
        let around: Vec<_> = (0..9)
            .filter_map(|k| tap(inputs, &wanted, centre + IVec2::new(k % 3 - 1, k / 3 - 1)))
            .filter(|tap| tap.facing > 0.5)
            .collect();
        for i in (0..2).filter(|i| wanted.needs[*i]) {
            let spread: Vec<_> =
                around.iter().filter(|tap| tap.has[i]).map(|tap| lobe(inputs, i, tap.pixel)).collect();
            let old = rectified(before.params, kept[i], &spread);
            let total = old.w + now.weight[i];
            let share = if old.w > 0.0 { old.w / total.max(1e-6) } else { 0.0 };
            shown[i] = now.light[i].lerp(old.xyz(), share);
            if let Some(texel) = next.light[i].get_mut(pixel.x as i32, pixel.y as i32) {
                *texel = shown[i].extend(total.min(before.params.weight_max)).to_array();
            }
        }
        if let Some(texel) = next.guides.get_mut(pixel.x as i32, pixel.y as i32) {
            let object = before.motion.get(pixel.x as i32, pixel.y as i32).map_or(0, |(_, object)| object);
            let normal = surface::Surface::unpack_gbuffer(load(&inputs.display.surface, pixel)).normal;
            *texel = (normal.to_array(), wanted.distance, object & 0xff);
        }
        inputs.modulate(pixel, shown[0], shown[1])
    });
    (picture, next)
}
