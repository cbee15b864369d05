//! The CPU half.

use crate::light::reference::{Light, mended};
use frame::cpu::Image;
use glam::IVec2;

/// Both lobes, mended.
pub fn denoise(noisy: &Light) -> Light {
    let all = |image: &Image<[f32; 4]>| {
        Image::from_fn(image.size(), |x, y| mended(image, IVec2::new(x as i32, y as i32)))
    };
    Light {
        diffuse: all(&noisy.diffuse),
        specular: noisy.specular.as_ref().map(all),
        samples: noisy.samples.clone(),
    }
}
