//! The CPU half of `nearest.wgsl`.

use crate::modulate::reference::{Inputs, rgb};
use frame::cpu::Image;
use glam::Vec3;

/// The light of the trace pixel under the centre of each display pixel.
pub fn nearest(inputs: &Inputs<'_>) -> Image<[f32; 4]> {
    inputs.picture(|pixel| {
        let q = inputs.trace_pixel(pixel);
        let diffuse = rgb(&inputs.light.diffuse, q);
        let specular = inputs.light.specular.as_ref().map_or(Vec3::ZERO, |image| rgb(image, q));
        inputs.modulate(pixel, diffuse, specular)
    })
}
