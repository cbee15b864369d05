//! The CPU half of `joint.inc.wgsl` and `joint_bilateral.wgsl`, in f32 like the shader.

use super::{JointParams, Settings};
use crate::bilinear::reference::corners;
use crate::modulate::reference::Inputs;
use crate::search;
use crate::search::mix::Mix;
use crate::search::reference::{lobe, outward, place, tap, wanted};
use frame::cpu::Image;
use glam::{UVec2, Vec2, Vec3};

const WEIGHT_MIN: f32 = 1e-3;
const NARROW_SIGMA: f32 = 0.47;

/// `JointLight`: diffuse and specular.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Light {
    pub(crate) light: [Vec3; 2],
    pub(crate) weight: [f32; 2],
    pub(crate) searched: bool,
    pub(crate) fell_back: bool,
}

/// `joint_light`.
pub(crate) fn light(
    search: &search::Settings,
    offsets: &[[i32; 2]],
    params: &JointParams,
    inputs: &Inputs<'_>,
    pixel: UVec2,
) -> Light {
    let wanted = wanted(inputs, pixel);
    let place = place(inputs, pixel);
    let size = |size: [u32; 2]| UVec2::from(size).as_vec2();
    let pixel_per_tap = size(inputs.frame.display_size) / size(inputs.frame.trace_size);
    let mut sums = [Mix::default(); 2];
    for (p, share) in corners(place) {
        let Some(tap) = tap(inputs, &wanted, p) else { continue };
        let away: Vec2 = (p.as_vec2() - place) * pixel_per_tap / NARROW_SIGMA;
        let nearness = params.wide * share + params.narrow * (-0.5 * away.length_squared()).exp();
        let facing = tap.facing.max(1e-6).powf(params.normal_power);
        let plane = (-tap.off_plane / (params.plane_scale * wanted.distance.max(1e-6))).exp();
        sums.iter_mut().enumerate().for_each(|(i, sum)| sum.tap(inputs, i, &tap, nearness * facing * plane));
    }
    let least = WEIGHT_MIN * params.wide;
    let searches = [0, 1].map(|i| wanted.needs[i] && sums[i].weight < least);
    let found = outward(search, offsets, inputs, &wanted, inputs.trace_pixel(pixel), searches);
    let mut result = Light {
        searched: searches[0] || searches[1],
        fell_back: (0..2).any(|i| searches[i] && !found[i].is_accepted),
        ..Light::default()
    };
    for i in 0..2 {
        if searches[i] || wanted.is_same_size {
            result.light[i] = lobe(inputs, i, found[i].pixel);
            result.weight[i] = least;
        } else if wanted.needs[i] {
            result.light[i] = sums[i].taken(inputs, i, &wanted.surface);
            result.weight[i] = sums[i].weight;
        }
    }
    result
}

/// The picture, and the numbers of pixels that searched and that found nothing acceptable.
pub fn joint_bilateral(settings: &Settings, inputs: &Inputs<'_>) -> (Image<[f32; 4]>, u64, u64) {
    let offsets = settings.search.offsets(inputs.frame.trace_size, inputs.frame.display_size);
    let params = settings.params([1.0, 0.0]);
    let (mut searches, mut fallbacks) = (0, 0);
    let picture = inputs.picture(|pixel| {
        let light = light(&settings.search, &offsets, &params, inputs, pixel);
        searches += u64::from(light.searched);
        fallbacks += u64::from(light.fell_back);
        inputs.modulate(pixel, light.light[0], light.light[1])
    });
    (picture, searches, fallbacks)
}
