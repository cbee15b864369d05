//! The CPU half: the same functions as the shaders, in the same order, in f32 like them.

use super::TemporalParams;
use crate::edge::reference::{GIVES, OBJECT_MASK, TAKES, face_normal, normal, position};
use crate::light::reference::{Light, LightSum, at, mended, size_of, stored};
use frame::cpu::{Image, luminance};
use frame::info::Frame;
use glam::{IVec2, Vec2, Vec3};
use half::f16;

const WEIGHT_MIN: f32 = 0.01;

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

fn previous_ray(params: &TemporalParams, point: Vec2, size: IVec2) -> Vec3 {
    let ndc = Vec2::new(2.0, -2.0) * (point / size.as_vec2()) + Vec2::new(-1.0, 1.0);
    let [forward, right, up] =
        [params.previous_forward, params.previous_right, params.previous_up].map(Vec3::from);
    forward + ndc.x * right + ndc.y * up
}

#[derive(Clone, Copy, Default)]
struct Kept {
    light: LightSum,
    moments: Vec2,
    frames: f32,
}

/// Where a pixel is expected in the last frame.
pub struct Place {
    texel: [u32; 4],
    /// Relative to the last frame's eye, metres.
    position: Vec3,
    depth: f32,
    size: IVec2,
}

impl Place {
    /// The place and the motion in pixels; none where nothing is expected.
    pub fn of(
        params: &TemporalParams,
        frame: &Frame,
        edge: &Image<[u32; 4]>,
        motion: &Image<u32>,
        p: IVec2,
    ) -> Option<(Self, Vec2)> {
        let (size, texel, code) = (size_of(edge), at(edge, p), at(motion, p));
        let motion = Vec2::from([code & 0xffff, code >> 16].map(|half| f16::from_bits(half as u16).to_f32()));
        let seen = position(frame, texel, p, size) + Vec3::from(params.eye_offset);
        let depth = Vec3::from(params.previous_forward).dot(seen);
        let point = p.as_vec2() + 0.5 + Vec2::from(frame.jitter) - motion;
        let position = depth * previous_ray(params, point, size);
        (motion.is_finite() && depth > 0.0).then_some((Self { texel, position, depth, size }, motion))
    }

    /// Whether the last frame's pixel shows the same surface.
    pub fn is_same(
        &self,
        params: &TemporalParams,
        frame: &Frame,
        before: &Image<[u32; 4]>,
        q: IVec2,
    ) -> bool {
        let Some(tap) = before.get(q.x, q.y) else { return false };
        let depth = f32::from_bits(tap[0]);
        let point = q.as_vec2() + 0.5 + Vec2::from(frame.previous_jitter);
        let position = depth * previous_ray(params, point, self.size);
        let plane = face_normal(self.texel).dot(position - self.position).abs();
        depth > 0.0
            && (tap[3] ^ self.texel[3]) & OBJECT_MASK == 0
            && plane <= params.plane_tolerance * self.depth
            && normal(tap).dot(normal(self.texel)) >= params.normal_min
    }
}

/// One pixel that looks for itself in the last frame.
struct Search<'a> {
    params: &'a TemporalParams,
    frame: &'a Frame,
    before: &'a History,
    place: Place,
}

impl Search<'_> {
    fn has(&self, q: IVec2) -> bool {
        self.place.is_same(self.params, self.frame, &self.before.edge, q)
    }

    fn tap(&self, kept: &mut [Kept; 2], q: IVec2, weights: [f32; 2]) {
        for ((kept, lobe), weight) in kept.iter_mut().zip(&self.before.lobes).zip(weights) {
            let frames = at(&lobe.frames, q) * self.params.keeps_history;
            let share = if frames > 0 { weight } else { 0.0 };
            kept.light.add(at(&lobe.light, q), share);
            kept.moments += share * Vec2::from(at(&lobe.moments, q));
            kept.frames += share * frames as f32;
        }
    }

    /// The four taps around a place as one lobe sees them: weights by geometry, and what the light of this frame makes of
    /// them.
    fn weights(&self, place: Vec2, lobe: usize, now: f32) -> [f32; 4] {
        let (part, first, lobe) = (place - place.floor(), place.floor().as_ivec2(), &self.before.lobes[lobe]);
        let (mut weights, mut luminances) = ([0.0; 4], [0.0; 4]);
        let (mut variance, mut total) = (0.0, 0.0);
        for (k, corner) in CORNERS.into_iter().enumerate() {
            let share = |corner: i32, part: f32| if corner == 1 { part } else { 1.0 - part };
            let share = share(corner.x, part.x) * share(corner.y, part.y);
            let q = first + corner;
            if share <= 0.0 || !self.has(q) || at(&lobe.frames, q) * self.params.keeps_history == 0 {
                continue;
            }
            let ([mean, square], [r, g, b, _]) = (at(&lobe.moments, q), at(&lobe.light, q));
            weights[k] = share;
            luminances[k] = luminance([r, g, b]);
            variance += share * (square - mean * mean).max(0.0);
            total += share;
        }
        choose(weights, luminances, (variance / total.max(1e-20)).sqrt(), now)
    }

    fn around(&self, p: IVec2, motion: Vec2, now: [f32; 2]) -> [Kept; 2] {
        let place = p.as_vec2() - motion;
        let weights = [0, 1].map(|lobe| self.weights(place, lobe, now[lobe]));
        let mut kept = [Kept::default(); 2];
        for (k, corner) in CORNERS.into_iter().enumerate() {
            let weights = weights.map(|lobe| lobe[k]);
            if weights != [0.0; 2] {
                self.tap(&mut kept, place.floor().as_ivec2() + corner, weights);
            }
        }
        if kept[0].light.weight().max(kept[1].light.weight()) < WEIGHT_MIN {
            kept = [Kept::default(); 2];
            let nearest = (place + 0.5).floor().as_ivec2();
            for k in 0..9 {
                let q = nearest + IVec2::new(k % 3, k / 3) - 1;
                if self.has(q) {
                    self.tap(&mut kept, q, [1.0; 2]);
                }
            }
        }
        kept
    }
}

const CORNERS: [IVec2; 4] = [IVec2::ZERO, IVec2::X, IVec2::Y, IVec2::ONE];
/// Standard deviations between taps: noise below the first, an edge of light above the second.
const EDGE: [f32; 2] = [1.0, 2.0];
/// What half floats round.
const EDGE_RELATIVE: f32 = 0.003_906_25;
const EDGE_ABSOLUTE: f32 = 2.4e-7;

/// Weights of taps that lie on two sides of an edge of light, by how like they are to what is seen now; all keep the weight
/// that they have together.
fn choose(weights: [f32; 4], luminances: [f32; 4], deviation: f32, now: f32) -> [f32; 4] {
    let there = || weights.iter().zip(luminances).filter(|(weight, _)| **weight > 0.0).map(|(_, l)| l);
    let (least, most) = (there().fold(1e30, f32::min), there().fold(-1e30, f32::max));
    let nearest = there().map(|l| (l - now).abs()).fold(1e30, f32::min);
    let deviation = deviation + EDGE_RELATIVE * most.max(0.0) + EDGE_ABSOLUTE;
    let step = (((most - least).max(0.0) / deviation - EDGE[0]) / (EDGE[1] - EDGE[0])).clamp(0.0, 1.0);
    let apart = step * step * (3.0 - 2.0 * step);
    let mut chosen = weights;
    for (weight, l) in chosen.iter_mut().zip(luminances) {
        let fall = (((l - now).abs() - nearest) / deviation).clamp(0.0, 80.0);
        *weight *= mix(1.0, (-fall).exp(), apart);
    }
    let scale = weights.iter().sum::<f32>() / chosen.iter().sum::<f32>().max(1e-20);
    chosen.map(|weight| weight * scale)
}

fn mix(a: f32, b: f32, t: f32) -> f32 {
    a * (1.0 - t) + b * t
}

fn accumulate(
    params: &TemporalParams,
    kept: &Kept,
    light: [f32; 4],
    gives: bool,
    haste: f32,
) -> ([f32; 4], [f32; 2], u32) {
    let weight = kept.light.weight().max(WEIGHT_MIN);
    let is_found = kept.light.weight() >= WEIGHT_MIN;
    let kept_share = if gives { 1.0 - haste } else { 1.0 };
    let frames_before = if is_found { (kept_share * kept.frames / weight + 0.5).floor() } else { 0.0 };
    let frames = (frames_before + f32::from(u8::from(gives))).min(params.history_max);
    if frames == 0.0 {
        return (light, [0.0; 2], 0);
    }
    let share = |least: f32| {
        let alpha = if gives { (1.0 / frames.max(1.0)).max(least) } else { 0.0 };
        1.0 - kept_share * (1.0 - alpha)
    };
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

/// Both lobes after this frame. `motion` is packed as in the G-buffer; `haste` in shares, per lobe.
pub fn accumulate_frame(
    params: &TemporalParams,
    frame: &Frame,
    edge: &Image<[u32; 4]>,
    motion: &Image<u32>,
    noisy: &Light,
    before: &History,
    haste: Option<&Image<[f32; 2]>>,
) -> [Lobe; 2] {
    let pixel = |p: IVec2, lobe: usize| {
        let texel = at(edge, p);
        let lights = [0, 1].map(|lobe| noisy.lobe(lobe).map_or([0.0; 4], |light| mended(light, p)));
        let light = lights[lobe];
        if texel[3] & TAKES[lobe] == 0 {
            return (light, [0.0; 2], 0);
        }
        let kept = match Place::of(params, frame, edge, motion, p) {
            Some((place, motion)) => {
                let now = lights.map(|[r, g, b, _]| luminance([r, g, b]));
                Search { params, frame, before, place }.around(p, motion, now)
            }
            None => [Kept::default(); 2],
        };
        let haste = haste.map_or(0.0, |haste| at(haste, p)[lobe]);
        accumulate(params, &kept[lobe], light, texel[3] & GIVES[lobe] != 0, haste)
    };
    [0, 1].map(|lobe| {
        let found = Image::from_fn(edge.size(), |x, y| pixel(IVec2::new(x as i32, y as i32), lobe));
        Lobe { light: found.map(|f| f.0), moments: found.map(|f| f.1), frames: found.map(|f| f.2) }
    })
}
