//! The CPU half of `best_candidate.wgsl`.

use super::Settings;
use crate::modulate::reference::Inputs;
use crate::search::reference::{lobe, outward, wanted};
use frame::cpu::Image;
use glam::Vec3;

/// The picture, and the number of pixels that had to do with less than an accepted candidate.
pub fn best_candidate(settings: &Settings, inputs: &Inputs<'_>) -> (Image<[f32; 4]>, u64) {
    let offsets = settings.offsets(inputs.frame.trace_size, inputs.frame.display_size);
    let mut fallbacks = 0;
    let picture = inputs.picture(|pixel| {
        let wanted = wanted(inputs, pixel);
        let found = outward(settings, &offsets, inputs, &wanted, inputs.trace_pixel(pixel), wanted.needs);
        fallbacks += u64::from((0..2).any(|i| wanted.needs[i] && !found[i].is_accepted));
        let [diffuse, specular] = [0, 1].map(|i| match wanted.needs[i] || wanted.is_same_size {
            true => lobe(inputs, i, found[i].pixel),
            false => Vec3::ZERO,
        });
        inputs.modulate(pixel, diffuse, specular)
    });
    (picture, fallbacks)
}
