//! The CPU half: the same functions as the shaders, in the same order, in f32 like them.

use super::{ReprojectParams, SvgfParams};
use crate::edge::reference::{
    EdgeSum, GIVES, OBJECT_MASK, TAKES, at, face_normal, footprint, lobe_weight, normal, position, stored,
    untouched,
};
use crate::five_phase::reference::Light;
use frame::cpu::{Image, luminance};
use frame::info::Frame;
use glam::{IVec2, Vec2, Vec3};
use half::f16;

const WEIGHT_MIN: f32 = 0.01;
const VARIANCE_FRAMES: u32 = 4;
const VARIANCE_REACH: i32 = 3;
const KERNEL: [f32; 3] = [0.375, 0.25, 0.0625];
const RELATIVE: f32 = 0.00390625;
const ABSOLUTE: f32 = 2.4e-7;

/// What a frame knows of one lobe, before the wavelet or left to the next frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Lobe {
    /// rgb, and metres.
    pub light: Image<[f32; 4]>,
    /// Means of luminance and of its square.
    pub moments: Image<[f32; 2]>,
    /// Frames that a pixel has been followed.
    pub frames: Image<u32>,
}

/// What the last frame left behind.
#[derive(Clone, Debug, PartialEq)]
pub struct History {
    /// Packed edges.
    pub edge: Image<[u32; 4]>,
    /// Diffuse, specular.
    pub lobes: [Lobe; 2],
}

fn size_of([width, height]: [u32; 2]) -> IVec2 {
    IVec2::new(width as i32, height as i32)
}

fn lobe_of(noisy: &Light, lobe: usize) -> Option<&Image<[f32; 4]>> {
    if lobe == 0 { Some(&noisy.diffuse) } else { noisy.specular.as_ref() }
}

fn previous_ray(params: &ReprojectParams, point: Vec2, size: IVec2) -> Vec3 {
    let ndc = Vec2::new(2.0, -2.0) * (point / size.as_vec2()) + Vec2::new(-1.0, 1.0);
    let [forward, right, up] =
        [params.previous_forward, params.previous_right, params.previous_up].map(Vec3::from);
    forward + ndc.x * right + ndc.y * up
}

#[derive(Clone, Copy, Default)]
struct Kept {
    light: EdgeSum,
    moments: Vec2,
    frames: f32,
}

/// One pixel that looks for itself in the last frame.
struct Search<'a> {
    params: &'a ReprojectParams,
    frame: &'a Frame,
    before: &'a History,
    size: IVec2,
    texel: [u32; 4],
    position: Vec3,
    depth: f32,
}

impl Search<'_> {
    fn tap(&self, kept: &mut [Kept; 2], q: IVec2, weight: f32) {
        let Some(tap) = self.before.edge.get(q.x, q.y) else { return };
        if weight <= 0.0 {
            return;
        }
        let depth = f32::from_bits(tap[0]);
        let point = q.as_vec2() + 0.5 + Vec2::from(self.frame.previous_jitter);
        let position = depth * previous_ray(self.params, point, self.size);
        let plane = face_normal(self.texel).dot(position - self.position).abs();
        let is_same = depth > 0.0
            && (tap[3] ^ self.texel[3]) & OBJECT_MASK == 0
            && plane <= self.params.plane_tolerance * self.depth
            && normal(tap).dot(normal(self.texel)) >= self.params.normal_min;
        if !is_same {
            return;
        }
        for (kept, lobe) in kept.iter_mut().zip(&self.before.lobes) {
            let frames = at(&lobe.frames, q) * self.params.keeps_history;
            let share = if frames > 0 { weight } else { 0.0 };
            kept.light.add(at(&lobe.light, q), share);
            kept.moments += share * Vec2::from(at(&lobe.moments, q));
            kept.frames += share * frames as f32;
        }
    }

    fn around(&self, p: IVec2, motion: Vec2) -> [Kept; 2] {
        let place = p.as_vec2() - motion;
        let part = place - place.floor();
        let mut kept = [Kept::default(); 2];
        for k in 0..4 {
            let corner = IVec2::new(k & 1, k >> 1);
            let weight = |corner: i32, part: f32| if corner == 1 { part } else { 1.0 - part };
            let weight = weight(corner.x, part.x) * weight(corner.y, part.y);
            self.tap(&mut kept, place.floor().as_ivec2() + corner, weight);
        }
        if kept[0].light.weight().max(kept[1].light.weight()) < WEIGHT_MIN {
            kept = [Kept::default(); 2];
            let nearest = (place + 0.5).floor().as_ivec2();
            for k in 0..9 {
                self.tap(&mut kept, nearest + IVec2::new(k % 3, k / 3) - 1, 1.0);
            }
        }
        kept
    }
}

fn mix(a: f32, b: f32, t: f32) -> f32 {
    a * (1.0 - t) + b * t
}

fn accumulate(
    params: &ReprojectParams,
    kept: &Kept,
    light: [f32; 4],
    gives: bool,
) -> ([f32; 4], [f32; 2], u32) {
    let weight = kept.light.weight().max(WEIGHT_MIN);
    let frames_before =
        if kept.light.weight() >= WEIGHT_MIN { (kept.frames / weight + 0.5).floor() } else { 0.0 };
    let frames = (frames_before + f32::from(u8::from(gives))).min(params.history_max);
    if frames == 0.0 {
        return ([0.0; 4], [0.0; 2], 0);
    }
    let share = |least: f32| if gives { (1.0 / frames.max(1.0)).max(least) } else { 0.0 };
    let (alpha_color, alpha_moments) = (share(params.alpha_color), share(params.alpha_moments));
    let [r, g, b, length] = kept.light.over(weight, WEIGHT_MIN);
    let length_now = if gives { light[3] } else { 0.0 };
    let length = match (length > 0.0, length_now > 0.0) {
        (true, true) => mix(length, length_now, alpha_color),
        _ => length.max(length_now),
    };
    let rgb = [(r, light[0]), (g, light[1]), (b, light[2])].map(|(a, b)| mix(a, b, alpha_color));
    let y = luminance([light[0], light[1], light[2]]);
    let moments = kept.moments / weight;
    (
        stored([rgb[0], rgb[1], rgb[2], length]),
        [mix(moments.x, y, alpha_moments), mix(moments.y, y * y, alpha_moments)],
        frames as u32,
    )
}

/// Both lobes after this frame. `motion` in pixels.
pub fn reproject(
    params: &ReprojectParams,
    frame: &Frame,
    edge: &Image<[u32; 4]>,
    motion: &Image<u32>,
    noisy: &Light,
    before: &History,
) -> [Lobe; 2] {
    let size = size_of(edge.size());
    let pixel = |p: IVec2, lobe: usize| {
        let texel = at(edge, p);
        let light = lobe_of(noisy, lobe).map_or([0.0; 4], |light| untouched(at(light, p)));
        if texel[3] & TAKES[lobe] == 0 {
            return (light, [0.0; 2], 0);
        }
        let code = at(motion, p);
        let [x, y] = [code & 0xffff, code >> 16].map(|half| f16::from_bits(half as u16).to_f32());
        let moves = x.is_finite() && y.is_finite();
        let seen = position(frame, texel, p, size) + Vec3::from(params.eye_offset);
        let depth = Vec3::from(params.previous_forward).dot(seen);
        let mut kept = [Kept::default(); 2];
        if moves && depth > 0.0 {
            let motion = Vec2::new(x, y);
            let point = p.as_vec2() + 0.5 + Vec2::from(frame.jitter) - motion;
            let position = depth * previous_ray(params, point, size);
            kept = Search { params, frame, before, size, texel, position, depth }.around(p, motion);
        }
        accumulate(params, &kept[lobe], light, texel[3] & GIVES[lobe] != 0)
    };
    [0, 1].map(|lobe| {
        let found = Image::from_fn(edge.size(), |x, y| pixel(IVec2::new(x as i32, y as i32), lobe));
        Lobe { light: found.map(|f| f.0), moments: found.map(|f| f.1), frames: found.map(|f| f.2) }
    })
}

fn geometry_weight(
    params: &SvgfParams,
    frame: &Frame,
    edge: &Image<[u32; 4]>,
    [p, q]: [IVec2; 2],
    lobe: usize,
) -> f32 {
    let size = size_of(edge.size());
    let (centre, tap) = (at(edge, p), at(edge, q));
    let away = position(frame, tap, q, size) - position(frame, centre, p, size);
    let plane = face_normal(centre).dot(away).abs() / footprint(frame, centre, size);
    let facing = normal(tap).dot(normal(centre));
    let turned = if facing > 0.0 { -params.sigma_normal * facing.clamp(0.01, 1.0).ln() } else { 80.0 };
    let weight = (-(turned + (plane / params.sigma_depth.max(1e-6)).min(80.0))).exp();
    if lobe == 0 {
        return weight;
    }
    let rows = (q - p).as_vec2() * Vec2::new(params.rows_per_column, 1.0);
    weight * lobe_weight(frame, [centre, tap], rows, size, [params.lobe_spread, params.roughness_fraction])
}

/// Of a lobe's luminance; -1 where the lobe has no light.
pub fn variance(
    params: &SvgfParams,
    frame: &Frame,
    edge: &Image<[u32; 4]>,
    lobe: usize,
    known: &Lobe,
) -> Image<f32> {
    Image::from_fn(edge.size(), |x, y| {
        let p = IVec2::new(x as i32, y as i32);
        let frames = at(&known.frames, p);
        if frames == 0 {
            return -1.0;
        }
        let mut moments = Vec2::from(at(&known.moments, p));
        if frames < VARIANCE_FRAMES {
            let (mut sum, mut weights) = (Vec2::ZERO, 0.0);
            let reach = -VARIANCE_REACH..=VARIANCE_REACH;
            for q in reach.clone().flat_map(|j| reach.clone().map(move |i| p + IVec2::new(i, j))) {
                if known.frames.get(q.x, q.y).unwrap_or(0) == 0 {
                    continue;
                }
                let weight = geometry_weight(params, frame, edge, [p, q], lobe);
                sum += weight * Vec2::from(at(&known.moments, q));
                weights += weight;
            }
            moments = sum / weights.max(1e-20);
        }
        let doubt = (VARIANCE_FRAMES as f32 / frames as f32).max(1.0);
        (moments.y - moments.x * moments.x).max(0.0) * doubt
    })
}

fn blurred_variance(variance: &Image<f32>, p: IVec2) -> f32 {
    let (mut sum, mut weights) = (0.0, 0.0);
    for k in 0..9 {
        let offset = IVec2::new(k % 3, k / 3) - 1;
        let Some(found) = variance.get(p.x + offset.x, p.y + offset.y) else { continue };
        if found >= 0.0 {
            let weight = 0.25 / (1 << (offset.x.abs() + offset.y.abs())) as f32;
            sum += weight * found;
            weights += weight;
        }
    }
    sum / f32::max(weights, 1e-20)
}

fn y_of([r, g, b, _]: [f32; 4]) -> f32 {
    luminance([r, g, b])
}

/// One level of the wavelet over one lobe: light and variance.
pub fn level(
    params: &SvgfParams,
    frame: &Frame,
    edge: &Image<[u32; 4]>,
    lobe: usize,
    light: &Image<[f32; 4]>,
    variance: &Image<f32>,
) -> (Image<[f32; 4]>, Image<f32>) {
    let reach = [params.first_tap, params.second_tap].map(IVec2::from);
    let filtered = Image::from_fn(edge.size(), |x, y| {
        let p = IVec2::new(x as i32, y as i32);
        let (before, variance_before) = (untouched(at(light, p)), at(variance, p));
        if at(edge, p)[3] & TAKES[lobe] == 0 {
            return (before, -1.0);
        }
        let deviation = params.sigma_luminance * blurred_variance(variance, p).sqrt();
        let (mut sum, mut variances) = (EdgeSum::default(), 0.0);
        for (j, i) in (-2i32..=2).flat_map(|j| (-2i32..=2).map(move |i| (j, i))) {
            let along_x = i.signum() * reach[usize::from(i.abs() == 2)].x;
            let along_y = j.signum() * reach[usize::from(j.abs() == 2)].y;
            let q = p + IVec2::new(along_x, along_y);
            let tap_variance = variance.get(q.x, q.y).unwrap_or(-1.0);
            if tap_variance < 0.0 {
                continue;
            }
            let tap = at(light, q);
            let (here, there) = (y_of(before), y_of(tap));
            let rounding = RELATIVE * here.abs().max(there.abs()) + ABSOLUTE;
            let alike = (-((there - here).abs() / (deviation + rounding)).min(80.0)).exp();
            let weight = KERNEL[i.unsigned_abs() as usize]
                * KERNEL[j.unsigned_abs() as usize]
                * geometry_weight(params, frame, edge, [p, q], lobe)
                * if variance_before >= 0.0 { alike } else { 1.0 };
            sum.add(tap, weight);
            variances += weight * weight * tap_variance;
        }
        let weight = sum.weight().max(1e-15);
        let variance = if variance_before >= 0.0 { variances / (weight * weight) } else { variance_before };
        (sum.mean(before), variance)
    });
    (filtered.map(|f| f.0), filtered.map(|f| f.1))
}
