//! The CPU half: the same functions as the shaders, in the same order, in f32 like them; one lobe at a time.

use super::RecurrentParams;
use crate::edge::reference::{TAKES, geometry_weight, roughness, roughness_weight};
use crate::light::reference::{LightSum, at, mirrored, size_of, stored};
use crate::temporal::reference::Lobe;
use frame::cpu::{Image, luminance};
use frame::info::Frame;
use glam::{IVec2, Vec2, Vec3};

const REACH: i32 = 2;
const TAPS: [Vec2; 4] =
    [Vec2::new(1.0, 0.0), Vec2::new(0.389, 0.389), Vec2::new(0.0, 0.8), Vec2::new(-0.247, 0.247)];

/// What stays the same over a frame: parameters, view, edges.
#[derive(Clone, Copy)]
pub struct View<'a> {
    /// Of the pass.
    pub params: &'a RecurrentParams,
    /// Camera.
    pub frame: &'a Frame,
    /// Packed.
    pub edge: &'a Image<[u32; 4]>,
}

impl View<'_> {
    fn weight(&self, lobe: usize, frames: &Image<u32>, p: IVec2, q: IVec2) -> f32 {
        if at(frames, q) == 0 {
            return 0.0;
        }
        let RecurrentParams { sigma_normal, sigma_depth, roughness_fraction, .. } = *self.params;
        let weight = geometry_weight(self.frame, self.edge, [p, q], sigma_normal, sigma_depth);
        match lobe {
            0 => weight,
            _ => weight * roughness_weight([at(self.edge, p), at(self.edge, q)], roughness_fraction),
        }
    }

    fn pixels(&self, rows: Vec2) -> IVec2 {
        let pixels = rows * Vec2::new(self.params.columns_per_row, 1.0);
        (pixels.signum() * (pixels.abs() + 0.5).floor()).as_ivec2()
    }
}

fn y_of([r, g, b, _]: [f32; 4]) -> f32 {
    luminance([r, g, b])
}

/// By what share the history is out of date, and what its luminance must be multiplied with.
fn lag(view: &View<'_>, lobe: usize, known: &Lobe, p: IVec2, frames: f32) -> (f32, f32) {
    let size = size_of(view.edge);
    let [mut slow, mut fast, mut variance, mut weights, mut squares] = [0.0f32; 5];
    for k in 0..9 {
        let q = mirrored(p + IVec2::new(k % 3, k / 3) - 1, size);
        let weight = view.weight(lobe, &known.frames, p, q);
        let [mean, square] = at(&known.moments, q);
        slow += weight * y_of(at(&known.light, q));
        fast += weight * mean;
        variance += weight * (square - mean * mean).max(0.0);
        weights += weight;
        squares += weight * weight;
    }
    let weight = weights.max(1e-20);
    let (slow, fast) = (slow / weight, fast / weight);
    let means = (squares / (weight * weight)).max(0.1);
    let error = (variance / weight * means / (2.0 * view.params.fast_frames - 1.0)).sqrt() + 0.01 * slow;
    let apart = (slow - fast).abs();
    let beyond = ((apart - view.params.lag_sigma * error) / apart.max(1e-20)).clamp(0.0, 1.0);
    let share = if frames > view.params.fast_frames { beyond } else { 0.0 };
    let scale = (fast / slow.max(1e-20)).clamp(0.0, 4.0);
    (share, 1.0 - share + scale * share)
}

/// Light and counts of one lobe. `shortest` is the least count of the lobes that need help at each pixel.
pub fn recover(
    view: &View<'_>,
    lobe: usize,
    known: &Lobe,
    shortest: &Image<u32>,
) -> (Image<[f32; 4]>, Image<u32>) {
    let (size, params) = (size_of(view.edge), view.params);
    let recovered = Image::from_fn(view.edge.size(), |x, y| {
        let p = IVec2::new(x as i32, y as i32);
        let (before, frames) = (at(&known.light, p), at(&known.frames, p) as f32);
        let takes = at(view.edge, p)[3] & TAKES[lobe] != 0;
        let mut light = before;
        if takes && frames < params.fix_frames {
            let stride = (params.fix_stride / (1.0 + at(shortest, p) as f32)).max(1.0);
            let mut sum = LightSum::default();
            for (j, i) in (-REACH..=REACH).flat_map(|j| (-REACH..=REACH).map(move |i| (j, i))) {
                let q = mirrored(p + view.pixels(stride * Vec2::new(i as f32, j as f32)), size);
                let weight = view.weight(lobe, &known.frames, p, q) * at(&known.frames, q) as f32;
                sum.add(at(&known.light, q), weight);
            }
            light = sum.mean(before);
        }
        let (share, scale) = lag(view, lobe, known, p, frames);
        let kept = (frames * (1.0 - share) + 0.5).floor().max(frames.min(1.0));
        if takes {
            let [r, g, b, a] = light;
            light = stored([r * scale, g * scale, b * scale, a]);
        }
        (light, kept as u32)
    });
    (recovered.map(|r| r.0), recovered.map(|r| r.1))
}

fn radius(view: &View<'_>, lobe: usize, light: [f32; 4], texel: [u32; 4], frames: f32, height: i32) -> f32 {
    let (params, hit, depth) = (view.params, light[3], f32::from_bits(texel[0]));
    let root = frames.max(1.0).sqrt();
    if lobe == 0 {
        let far = params.hit_far[0] + params.hit_far[1] * depth;
        let near = 0.25 + 0.75 * (hit / far).clamp(0.0, 1.0);
        return (params.radius * near / root).max(params.radius_min);
    }
    let angle = roughness(texel).powi(2) * hit / (hit + depth).max(1e-6);
    let width = angle * height as f32 / (2.0 * Vec3::from(view.frame.up).length());
    width.min((params.radius / root).max(params.radius_min))
}

/// One lobe, blurred.
pub fn blur(view: &View<'_>, lobe: usize, light: &Image<[f32; 4]>, frames: &Image<u32>) -> Image<[f32; 4]> {
    let size = size_of(view.edge);
    let [cos, sin] = view.params.turn;
    Image::from_fn(view.edge.size(), |x, y| {
        let p = IVec2::new(x as i32, y as i32);
        let (before, texel, count) = (at(light, p), at(view.edge, p), at(frames, p));
        if texel[3] & TAKES[lobe] == 0 {
            return before;
        }
        let radius = radius(view, lobe, before, texel, count as f32, size.y);
        let mut sum = LightSum::default();
        sum.add(before, if count > 0 { 1.0 } else { 0.0 });
        for (flat, side) in TAPS.into_iter().flat_map(|flat| [(flat, 1.0), (flat, -1.0)]) {
            let flat = side * flat;
            let tap = Vec2::new(flat.dot(Vec2::new(cos, -sin)), flat.dot(Vec2::new(sin, cos)));
            let q = mirrored(p + view.pixels(radius * tap), size);
            let gauss = (-2.0 * flat.length_squared()).exp();
            sum.add(at(light, q), gauss * view.weight(lobe, frames, p, q));
        }
        sum.mean(before)
    })
}
