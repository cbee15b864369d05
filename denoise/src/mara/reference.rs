//! The CPU half: the same loop as `mara.wgsl`, in f32 like it; one lobe at a time.

use super::MaraParams;
use crate::edge::reference::{TAKES, geometry_weight, lobe_weight};
use crate::light::reference::{LightSum, at, mirrored, size_of};
use frame::cpu::Image;
use frame::info::Frame;
use glam::{IVec2, Vec2};

/// One lobe, blurred along one axis.
pub fn blur(
    params: &MaraParams,
    frame: &Frame,
    edge: &Image<[u32; 4]>,
    lobe: usize,
    light: &Image<[f32; 4]>,
    frames: &Image<u32>,
) -> Image<[f32; 4]> {
    let size = size_of(edge);
    Image::from_fn(edge.size(), |x, y| {
        let p = IVec2::new(x as i32, y as i32);
        let before = at(light, p);
        if at(edge, p)[3] & TAKES[lobe] == 0 {
            return before;
        }
        let mut sum = LightSum::default();
        for j in -params.radius..=params.radius {
            let offset = j * IVec2::from(params.step);
            let q = mirrored(p + offset, size);
            if at(frames, q) == 0 {
                continue;
            }
            let part = j as f32 / (params.radius + 1) as f32;
            let mut weight = (-2.0 * part * part).exp()
                * geometry_weight(frame, edge, [p, q], params.sigma_normal, params.sigma_depth);
            if lobe == 1 {
                let rows = offset.as_vec2() * Vec2::new(params.rows_per_column, 1.0);
                let limits = [params.lobe_spread, params.roughness_fraction];
                weight *= lobe_weight(frame, [at(edge, p), at(edge, q)], rows, size, limits);
            }
            sum.add(at(light, q), weight);
        }
        sum.mean(before)
    })
}
