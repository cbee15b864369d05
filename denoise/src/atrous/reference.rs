//! The CPU half: the same functions as `atrous.wgsl`, in the same order, in f32 like the shader.

use super::{AtrousParams, Settings};
use crate::edge::reference::{GIVES, TAKES, face_normal, footprint, lobe_weight, normal, position};
use crate::light::reference::{Light, LightSum, at, mended, mirrored, size_of};
use frame::cpu::Image;
use frame::info::Frame;
use glam::{IVec2, Vec2, Vec3};

fn fall(x: f32, sigma: f32) -> f32 {
    let t = x / sigma.max(1e-6);
    (t * t).min(80.0)
}

fn alike(params: &AtrousParams, centre: [f32; 4], tap: [f32; 4], centre_gives: bool) -> f32 {
    let [centre, tap] = [centre, tap].map(|[r, g, b, _]| Vec3::new(r, g, b));
    let brighter = centre.length().max(tap.length()).max(1e-7);
    let fall = fall((tap - centre).length() / brighter, params.sigma_color);
    if centre_gives { (-fall).exp() } else { 1.0 }
}

fn offset(params: &AtrousParams, steps: IVec2) -> IVec2 {
    let reach = [params.first_tap, params.second_tap].map(IVec2::from);
    IVec2::new(
        steps.x.signum() * reach[usize::from(steps.x.abs() == 2)].x,
        steps.y.signum() * reach[usize::from(steps.y.abs() == 2)].y,
    )
}

/// One level.
pub fn level(params: &AtrousParams, frame: &Frame, edge: &Image<[u32; 4]>, input: &Light) -> Light {
    let size = size_of(edge);
    let filtered = |lobe: usize, light: &Image<[f32; 4]>| {
        Image::from_fn(edge.size(), |x, y| {
            let p = IVec2::new(x as i32, y as i32);
            let centre = at(edge, p);
            let before = mended(light, p);
            if centre[3] & TAKES[lobe] == 0 {
                return before;
            }
            let gives = centre[3] & GIVES[lobe] != 0;
            let mut sum = LightSum::default();
            let reach = -params.reach..=params.reach;
            for (j, i) in reach.clone().flat_map(|j| reach.clone().map(move |i| (j, i))) {
                let offset = offset(params, IVec2::new(i, j));
                let q = mirrored(p + offset, size);
                let tap = at(edge, q);
                if tap[3] & GIVES[lobe] == 0 {
                    continue;
                }
                let away = position(frame, tap, q, size) - position(frame, centre, p, size);
                let plane = face_normal(centre).dot(away) / footprint(frame, centre, size);
                let all = fall((normal(tap) - normal(centre)).length(), params.sigma_normal)
                    + fall(plane, params.sigma_plane);
                let mut weight = params.kernel[i.unsigned_abs() as usize]
                    * params.kernel[j.unsigned_abs() as usize]
                    * (-all).exp();
                if lobe == 1 {
                    let rows = offset.as_vec2() * Vec2::new(params.rows_per_column, 1.0);
                    let limits = [params.lobe_spread, params.roughness_fraction];
                    weight *= lobe_weight(frame, [centre, tap], rows, size, limits);
                }
                let tap_light = at(light, q);
                let alike = alike(params, before, tap_light, gives);
                let mixed = |channel: usize| before[channel] * (1.0 - alike) + tap_light[channel] * alike;
                sum.add([mixed(0), mixed(1), mixed(2), tap_light[3]], weight);
            }
            sum.mean(before)
        })
    };
    Light {
        diffuse: filtered(0, &input.diffuse),
        specular: input.specular.as_ref().map(|light| filtered(1, light)),
        samples: input.samples.clone(),
    }
}

/// All levels.
pub fn denoise(
    settings: &Settings,
    frame: &Frame,
    columns_per_row: f32,
    edge: &Image<[u32; 4]>,
    noisy: &Light,
) -> Light {
    (0..settings.levels)
        .fold(noisy.clone(), |light, i| level(&settings.params(i, columns_per_row), frame, edge, &light))
}
