//! GPU against CPU, and what is left of noise.
#![allow(clippy::unwrap_used, clippy::panic)]

use super::{Mara, reference};
use crate::Denoiser;
use crate::edge::{self, EdgeParams};
use crate::fixture::{Shot, gpu, noise, outliers};
use crate::light::reference::mended;
use frame::cpu::Image;
use frame::set_knob;
use glam::IVec2;

#[test]
fn the_gpu_does_what_the_twin_does() {
    let (gpu, size) = (gpu(), [45, 33]);
    let wide = [("sigma_n", "1"), ("sigma_z", "100"), ("lobe_spread", "10"), ("roughness_fraction", "10")];
    for (seed, variant) in (20..).zip([&[][..], &wide[..], &wide[..2]]) {
        let mut denoiser = Mara::new(&gpu).unwrap();
        for (name, value) in variant {
            set_knob(&mut denoiser.knobs(), name, value).unwrap();
        }
        let mut shot = Shot::random(size, seed);
        shot.break_pixels(6);
        let (clean, _) = shot.denoise(&gpu, &mut denoiser);
        let (frame, scale) = (shot.frame.uniform(), shot.frame.columns_per_row());
        let others = shot.others.map(|[face_normal, _, object]| [face_normal, object]);
        let params = EdgeParams::new(denoiser.settings.roughness_min, true, true);
        let edges =
            edge::reference::pack(&params, &frame, &shot.surface, &shot.distance, &others, &shot.noisy);
        for (lobe, found) in [&clean.diffuse, clean.specular.as_ref().unwrap()].into_iter().enumerate() {
            // In a first frame what is accumulated is what came in.
            let noisy = shot.noisy.lobe(lobe).unwrap();
            let mut light = Image::from_fn(size, |x, y| mended(noisy, IVec2::new(x as i32, y as i32)));
            let frames = edges.map(|texel| u32::from(texel[3] & edge::reference::GIVES[lobe] != 0));
            let before = light.clone();
            for pass in 0..2 * denoiser.settings.rounds {
                let params = denoiser.settings.params(pass, scale);
                light = reference::blur(&params, &frame, &edges, lobe, &light, &frames);
            }
            // One step of a half float a pass.
            let wrong = outliers(found, &light, 5.0);
            assert_eq!(wrong, 0, "{variant:?}, lobe {lobe}");
            let halves: Vec<_> = before.texels().iter().map(|t| t.map(half::f16::from_f32)).collect();
            assert!(outliers(&halves, &light, 5.0) > 300, "{variant:?}, lobe {lobe}: nothing was filtered");
        }
    }
}

#[test]
fn a_wall_gets_quiet_and_keeps_its_energy() {
    let (gpu, size) = (gpu(), [96, 80]);
    let mut denoiser = Mara::new(&gpu).unwrap();
    denoiser.resize(&gpu, size, true).unwrap();
    let still = Shot::wall(size, 1.0);
    let mut left = Vec::new();
    for index in 0..32 {
        let mut shot = still.sequel(index);
        shot.noisy.diffuse = noise(size, index);
        let (clean, _) = shot.next(&gpu, &mut denoiser);
        let values = || clean.diffuse.iter().map(|t| t[0].to_f64());
        let mean = values().sum::<f64>() / clean.diffuse.len() as f64;
        left.push(values().map(|v| (v - mean).powi(2)).sum::<f64>() / clean.diffuse.len() as f64);
        // 7,680 draws with a deviation of 58 % of the mean: 0.66 % in the first frame, less later; three deviations.
        assert!((mean - 1.0).abs() < 0.02, "frame {index}: mean {mean}");
    }
    // Nine taps of that Gauss are worth about six, the second round spreads them apart: 1/36 of 1/36 at best; time leaves
    // a / (2 - a) = 1/19.
    assert!(left[0] < 0.01 / 3.0 && left[31] < 0.1 * left[0], "{} at first, {} at last", left[0], left[31]);
}
