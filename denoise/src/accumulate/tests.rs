//! A mean over time is a mean over time. The rest of what it does is tested with [`crate::svgf`].
#![allow(clippy::unwrap_used, clippy::panic)]

use super::Accumulate;
use crate::Denoiser;
use crate::fixture::{Shot, gpu, halves, noise};
use frame::cpu::Image;
use frame::surface::Surface;
use glam::Vec2;

#[test]
fn a_still_picture_is_the_mean_of_its_frames() {
    let (gpu, size, count) = (gpu(), [24, 16], 16);
    let mut denoiser = Accumulate::new(&gpu).unwrap();
    denoiser.resize(&gpu, size, true).unwrap();
    let mut still = Shot::wall(size, 2.0);
    let rough = Surface { f0: 0.04, roughness: Vec2::splat(0.1), ..Surface::default() };
    still.surface = Image::filled(size, rough.pack_gbuffer(0));
    let mut mean = vec![0.0f64; 24 * 16];
    let mut last = None;
    for index in 0..count {
        let mut shot = still.sequel(index);
        shot.noisy.diffuse = noise(size, index);
        shot.noisy.specular = Some(shot.noisy.diffuse.clone());
        let light = halves(&shot.noisy.diffuse);
        mean.iter_mut().zip(&light).for_each(|(m, l)| *m += l[0].to_f64() / f64::from(count));
        last = Some(shot.next(&gpu, &mut denoiser).0);
    }
    let clean = last.unwrap();
    for (i, wanted) in mean.iter().enumerate() {
        // Half a step of a half float below 2, and what f32 rounds on the way.
        let found = [clean.diffuse[i][0].to_f64(), clean.specular.as_ref().unwrap()[i][0].to_f64()];
        assert!(found.iter().all(|f| (f - wanted).abs() < 1.01 * 2f64.powi(-11)), "{found:?}, not {wanted}");
    }
}
