//! The CPU half: the same functions as `gradient.wgsl` and `haste.wgsl`, in the same order, in f32 like them; one lobe at a
//! time. All else is [`crate::svgf::reference`].

use super::{HasteParams, STRATUM};
use crate::edge::reference::{GIVES, geometry_weight};
use crate::light::reference::{Light, at, mended};
use crate::temporal::TemporalParams;
use crate::temporal::reference::Place;
use frame::cpu::{Image, luminance};
use frame::info::Frame;
use glam::IVec2;

const REACH: i32 = 2;

/// Luminance of a lobe's noisy light; -1 where it gives none.
pub fn luminances(edge: &Image<[u32; 4]>, noisy: &Light, lobe: usize) -> Image<f32> {
    Image::from_fn(edge.size(), |x, y| {
        let p = IVec2::new(x as i32, y as i32);
        let [r, g, b, _] = noisy.lobe(lobe).map_or([0.0; 4], |light| mended(light, p));
        if at(edge, p)[3] & GIVES[lobe] != 0 { luminance([r, g, b]) } else { -1.0 }
    })
}

/// Now, before, squared difference, pixels, per stratum.
pub fn gradient(
    params: &TemporalParams,
    frame: &Frame,
    [edge, edge_before]: [&Image<[u32; 4]>; 2],
    motion: &Image<u32>,
    [now, before]: [&Image<f32>; 2],
) -> Image<[f32; 4]> {
    let [width, height] = edge.size();
    Image::from_fn([width.div_ceil(STRATUM), height.div_ceil(STRATUM)], |x, y| {
        let mut sum = [0.0f32; 4];
        for k in 0..STRATUM * STRATUM {
            let p = IVec2::new((x * STRATUM + k % STRATUM) as i32, (y * STRATUM + k / STRATUM) as i32);
            let Some(l_now) = now.get(p.x, p.y) else { continue };
            let Some((place, motion)) = Place::of(params, frame, edge, motion, p) else { continue };
            let q = (p.as_vec2() - motion + 0.5).floor().as_ivec2();
            let Some(l_before) = before.get(q.x, q.y) else { continue };
            if params.keeps_history == 0 || !place.is_same(params, frame, edge_before, q) {
                continue;
            }
            if l_now >= 0.0 && l_before >= 0.0 {
                let term = [l_now, l_before, (l_now - l_before) * (l_now - l_before), 1.0];
                sum.iter_mut().zip(term).for_each(|(s, t)| *s += t);
            }
        }
        sum
    })
}

/// The share of history to forget.
pub fn haste(
    params: &HasteParams,
    frame: &Frame,
    edge: &Image<[u32; 4]>,
    strata: &Image<[f32; 4]>,
) -> Image<f32> {
    let [width, height] = edge.size();
    Image::from_fn(edge.size(), |x, y| {
        let p = IVec2::new(x as i32, y as i32);
        let mut sum = [0.0f32; 4];
        for (j, i) in (-REACH..=REACH).flat_map(|j| (-REACH..=REACH).map(move |i| (j, i))) {
            let stratum = p / STRATUM as i32 + IVec2::new(i, j);
            let Some(found) = strata.get(stratum.x, stratum.y) else { continue };
            let last = IVec2::new(width as i32 - 1, height as i32 - 1);
            let q = (stratum * STRATUM as i32 + 1).min(last);
            let weight = geometry_weight(frame, edge, [p, q], params.sigma_normal, params.sigma_depth);
            sum.iter_mut().zip(found).for_each(|(s, f)| *s += weight * f);
        }
        let [now, before, squares, count] = sum;
        if count <= 0.0 {
            return 0.0;
        }
        let apart = (now - before).abs() / count;
        let error = (squares / count / count.max(1.0)).sqrt();
        let brighter = now.max(before) / count;
        ((apart - params.lag_sigma * error) / brighter.max(1e-20)).clamp(0.0, 1.0)
    })
}
