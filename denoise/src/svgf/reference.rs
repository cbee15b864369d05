//! The CPU half: the same functions as the shaders, in the same order, in f32 like them.

use super::SvgfParams;
use crate::edge::reference::{TAKES, geometry_weight as edge_weight, lobe_weight};
use crate::light::reference::{LightSum, at, mirrored, size_of};
use crate::temporal::reference::Lobe;
use frame::cpu::{Image, luminance};
use frame::info::Frame;
use glam::{IVec2, Vec2};

const VARIANCE_FRAMES: u32 = 4;
const VARIANCE_REACH: i32 = 3;
const RELATIVE: f32 = 0.00390625;
const ABSOLUTE: f32 = 2.4e-7;

fn geometry_weight(
    params: &SvgfParams,
    frame: &Frame,
    edge: &Image<[u32; 4]>,
    [p, q]: [IVec2; 2],
    offset: IVec2,
    lobe: usize,
) -> f32 {
    let weight = edge_weight(frame, edge, [p, q], params.sigma_normal, params.sigma_depth);
    if lobe == 0 {
        return weight;
    }
    let rows = offset.as_vec2() * Vec2::new(params.rows_per_column, 1.0);
    weight
        * lobe_weight(
            frame,
            [at(edge, p), at(edge, q)],
            rows,
            size_of(edge),
            [params.lobe_spread, params.roughness_fraction],
        )
}

fn variance_of([mean, square]: [f32; 2]) -> f32 {
    (square - mean * mean).max(0.0)
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
        let (mut moments, mut moments_weight) = (Vec2::ZERO, 0.0);
        let (mut long, mut long_weight) = (0.0, 0.0);
        let reach = -VARIANCE_REACH..=VARIANCE_REACH;
        for offset in reach.clone().flat_map(|j| reach.clone().map(move |i| IVec2::new(i, j))) {
            let q = p + offset;
            let tap_frames = known.frames.get(q.x, q.y).unwrap_or(0);
            if tap_frames == 0 {
                continue;
            }
            let tap = at(&known.moments, q);
            let weight = geometry_weight(params, frame, edge, [p, q], offset, lobe);
            moments += weight * Vec2::from(tap);
            moments_weight += weight;
            if offset.abs().max_element() <= 1 && tap_frames >= VARIANCE_FRAMES {
                let gauss = 1.0 / (1 << offset.abs().element_sum()) as f32;
                long += gauss * variance_of(tap);
                long_weight += gauss;
            }
        }
        let mixed = (1.0 / frames as f32).max(params.least_variance);
        if frames < VARIANCE_FRAMES {
            let doubt = VARIANCE_FRAMES as f32 / frames as f32;
            return variance_of((moments / f32::max(moments_weight, 1e-20)).to_array()) * doubt * mixed;
        }
        mixed * long / f32::max(long_weight, 1e-20)
    })
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
    let taps = [params.first_tap, params.second_tap].map(IVec2::from);
    let reach = -params.reach..=params.reach;
    let size = size_of(edge);
    let filtered = Image::from_fn(edge.size(), |x, y| {
        let p = IVec2::new(x as i32, y as i32);
        let (before, variance_before) = (at(light, p), at(variance, p));
        if at(edge, p)[3] & TAKES[lobe] == 0 {
            return (before, -1.0);
        }
        let (mut sum, mut variances, mut own) = (LightSum::default(), 0.0, 0.0);
        for (j, i) in reach.clone().flat_map(|j| reach.clone().map(move |i| (j, i))) {
            let along_x = i.signum() * taps[usize::from(i.abs() == 2)].x;
            let along_y = j.signum() * taps[usize::from(j.abs() == 2)].y;
            let offset = IVec2::new(along_x, along_y);
            let q = mirrored(p + offset, size);
            let tap_variance = at(variance, q);
            if tap_variance < 0.0 {
                continue;
            }
            let tap = at(light, q);
            let (here, there) = (y_of(before), y_of(tap));
            let deviation = params.sigma_luminance * (0.5 * (variance_before.max(0.0) + tap_variance)).sqrt();
            let fall = (there - here).abs() / (deviation + RELATIVE * here.max(there) + ABSOLUTE);
            let alike = if variance_before >= 0.0 { (-fall.min(80.0)).exp() } else { 1.0 };
            let weight = params.kernel[i.unsigned_abs() as usize]
                * params.kernel[j.unsigned_abs() as usize]
                * geometry_weight(params, frame, edge, [p, q], offset, lobe);
            let mixed = |channel: usize| before[channel] * (1.0 - alike) + tap[channel] * alike;
            sum.add([mixed(0), mixed(1), mixed(2), tap[3]], weight);
            let taken = if q == p { 0.0 } else { weight * alike };
            variances += taken * taken * tap_variance;
            own += weight - taken;
        }
        let weight = sum.weight().max(1e-15);
        let variance = match variance_before >= 0.0 {
            true => (variances + own * own * variance_before) / (weight * weight),
            false => variance_before,
        };
        (sum.mean(before), variance)
    });
    (filtered.map(|f| f.0), filtered.map(|f| f.1))
}
