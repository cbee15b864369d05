//! The CPU half of `bilinear.wgsl`.

use crate::modulate::reference::Inputs;
use crate::search::mix::Mix;
use crate::search::reference::{lobe, place, tap, wanted};
use frame::cpu::Image;
use glam::{IVec2, Vec2, Vec3};

/// The four around `place` with their bilinear weights, in the shader's order.
pub(crate) fn corners(place: Vec2) -> [(IVec2, f32); 4] {
    let (low, part) = (place.floor().as_ivec2(), place - place.floor());
    std::array::from_fn(|k| {
        let corner = IVec2::new(k as i32 & 1, k as i32 >> 1);
        let weight = |axis: usize| if corner[axis] == 1 { part[axis] } else { 1.0 - part[axis] };
        (low + corner, weight(0) * weight(1))
    })
}

/// The picture.
pub fn bilinear(inputs: &Inputs<'_>) -> Image<[f32; 4]> {
    inputs.picture(|pixel| {
        let wanted = wanted(inputs, pixel);
        let mut sums = [Mix::default(); 2];
        for (p, weight) in corners(place(inputs, pixel)) {
            let Some(tap) = tap(inputs, &wanted, p) else { continue };
            sums.iter_mut().enumerate().for_each(|(i, sum)| sum.tap(inputs, i, &tap, weight));
        }
        let [diffuse, specular] = [0, 1].map(|i| {
            if wanted.is_same_size {
                lobe(inputs, i, inputs.trace_pixel(pixel))
            } else if wanted.needs[i] {
                sums[i].taken(inputs, i, &wanted.surface)
            } else {
                Vec3::ZERO
            }
        });
        inputs.modulate(pixel, diffuse, specular)
    })
}
