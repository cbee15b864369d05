//! GPU against CPU, what time does to noise, and what light that changes does to it.
#![allow(clippy::unwrap_used, clippy::panic)]

use super::{Recurrent, reference};
use crate::Denoiser;
use crate::fixture::{Clean, Shot, gpu, halves, noise, outliers, read};
use crate::temporal::reference as temporal;
use frame::cpu::Image;
use frame::{Gpu, set_knob};
use half::f16;

fn floats(texels: &[[f16; 4]], size: [u32; 2]) -> Image<[f32; 4]> {
    Image::from_texels(size, texels.iter().map(|t| t.map(f16::to_f32)).collect()).unwrap()
}

/// What a frame that has ended left in these textures, lobe by lobe.
fn known(gpu: &Gpu, denoiser: &Recurrent, light: [Vec<[f16; 4]>; 2], size: [u32; 2]) -> [temporal::Lobe; 2] {
    let moments = gpu.read_texture::<[f32; 4]>(denoiser.temporal.moments_before()).unwrap();
    // Before they were corrected.
    let frames = gpu.read_texture::<u32>(denoiser.temporal.frames()).unwrap();
    let mut light = light.into_iter();
    [0, 1].map(|lobe| temporal::Lobe {
        light: floats(&light.next().unwrap(), size),
        moments: Image::from_texels(size, moments.iter().map(|m| [m[2 * lobe], m[2 * lobe + 1]]).collect())
            .unwrap(),
        frames: Image::from_texels(size, frames.iter().map(|n| (n >> (16 * lobe)) & 0xffff).collect())
            .unwrap(),
    })
}

fn lobes(gpu: &Gpu, textures: &[frame::Texture; 2]) -> [Vec<[f16; 4]>; 2] {
    textures.each_ref().map(|texture| gpu.read_texture::<[f16; 4]>(texture).unwrap())
}

#[test]
fn the_gpu_does_what_the_twin_does() {
    let (gpu, size) = (gpu(), [45, 33]);
    // Random normals and depths hardly ever agree: these let most of them count as one surface.
    let wide = [("sigma_n", "1"), ("sigma_z", "100"), ("history_plane", "1"), ("history_normal", "-1")];
    let variants: [&[(&str, &str)]; 3] =
        [&[], &[("fast_frames", "1"), ("lag_sigma", "0.5"), ("radius", "5")], &[("fix_frames", "0")]];
    for (seed, variant) in (20..).zip(variants) {
        let mut denoiser = Recurrent::new(&gpu).unwrap();
        for (name, value) in wide.iter().chain(variant) {
            set_knob(&mut denoiser.knobs(), name, value).unwrap();
        }
        denoiser.resize(&gpu, size, true).unwrap();
        let mut first = Shot::random(size, seed);
        first.break_pixels(6);
        first.next(&gpu, &mut denoiser);
        let mut second = first.sequel(1);
        second.noisy = Shot::random(size, seed + 100).noisy;
        // The accumulated light is written over by the second blur, so that the twin begins with the picture before it;
        // accumulating itself is compared in `svgf`.
        let (clean, _) = second.next(&gpu, &mut denoiser);
        let edge =
            Image::from_texels(size, gpu.read_texture::<[u32; 4]>(denoiser.temporal.edge_before()).unwrap())
                .unwrap();
        let corrected = read_frames(&gpu, &denoiser);
        let recovered = lobes(&gpu, &denoiser.recovered);
        let (uniform, found) = (second.frame.uniform(), [clean.diffuse, clean.specular.clone().unwrap()]);
        for lobe in 0..2 {
            let frames =
                Image::from_texels(size, corrected.iter().map(|n| (n >> (16 * lobe)) & 0xffff).collect())
                    .unwrap();
            let mut light = floats(&recovered[lobe], size);
            for turn in 0..2 {
                let params = denoiser.settings.params(&second.frame, turn);
                let view = reference::View { params: &params, frame: &uniform, edge: &edge };
                light = reference::blur(&view, lobe, &light, &frames);
            }
            // A radius that ends between two pixels may round either way: a few taps of a few pixels.
            let wrong = outliers(&found[lobe], &light, 4.0);
            assert!(wrong < 60, "{variant:?}, lobe {lobe}: {wrong} values");
            let changed = outliers(&recovered[lobe], &light, 4.0);
            assert!(changed > 1000, "{variant:?}, lobe {lobe}: only {changed} values were blurred at all");
        }
    }
}

fn read_frames(gpu: &Gpu, denoiser: &Recurrent) -> Vec<u32> {
    gpu.read_texture::<u32>(denoiser.temporal.frames_before()).unwrap()
}

#[test]
fn recovering_is_what_the_twin_does() {
    let (gpu, size) = (gpu(), [45, 33]);
    let mut denoiser = Recurrent::new(&gpu).unwrap();
    let knobs = [("sigma_n", "1"), ("sigma_z", "100"), ("history_plane", "1"), ("history_normal", "-1")];
    // Without blurs, accumulated light is what the last frame left and this one's mixed: both are known.
    let none = [("radius", "0"), ("radius_min", "0"), ("fast_frames", "1"), ("lag_sigma", "1")];
    for (name, value) in knobs.into_iter().chain(none) {
        set_knob(&mut denoiser.knobs(), name, value).unwrap();
    }
    denoiser.resize(&gpu, size, true).unwrap();
    let first = Shot::random(size, 31);
    for index in 0..3 {
        first.sequel(index).next(&gpu, &mut denoiser);
    }
    let history = lobes(&gpu, &denoiser.history);
    let before = [0, 1].map(|lobe| {
        let frames = read_frames(&gpu, &denoiser);
        let moments = gpu.read_texture::<[f32; 4]>(denoiser.temporal.moments_before()).unwrap();
        temporal::Lobe {
            light: floats(&history[lobe], size),
            moments: Image::from_texels(
                size,
                moments.iter().map(|m| [m[2 * lobe], m[2 * lobe + 1]]).collect(),
            )
            .unwrap(),
            frames: Image::from_texels(size, frames.iter().map(|n| (n >> (16 * lobe)) & 0xffff).collect())
                .unwrap(),
        }
    });
    let edge =
        Image::from_texels(size, gpu.read_texture::<[u32; 4]>(denoiser.temporal.edge_before()).unwrap())
            .unwrap();
    let mut next = first.sequel(3);
    next.noisy = Shot::random(size, 131).noisy;
    next.noisy.samples = first.noisy.samples.clone();
    next.next(&gpu, &mut denoiser);
    let params = denoiser.settings.memory().params(&next.frame);
    let motion = next.others.map(|[_, motion, _]| motion);
    let past = temporal::History { edge: edge.clone(), lobes: before };
    let uniform = next.frame.uniform();
    let now = temporal::accumulate_frame(&params, &uniform, &edge, &motion, &next.noisy, &past, None);
    let gpu_known = known(&gpu, &denoiser, [0, 1].map(|l: usize| halves(&now[l].light)), size);
    let recovered = lobes(&gpu, &denoiser.recovered);
    let corrected = read_frames(&gpu, &denoiser);
    let params = denoiser.settings.params(&next.frame, 0);
    let view = reference::View { params: &params, frame: &uniform, edge: &edge };
    let shortest = Image::from_fn(size, |x, y| {
        let short = |lobe: usize| {
            let frames = gpu_known[lobe].frames.get(x as i32, y as i32).unwrap();
            let takes = edge.get(x as i32, y as i32).unwrap()[3] & crate::edge::reference::TAKES[lobe] != 0;
            if takes && frames < denoiser.settings.fix_frames { frames } else { 1_000_000 }
        };
        short(0).min(short(1))
    });
    let mut shortened = 0;
    for lobe in 0..2 {
        let (light, frames) = reference::recover(&view, lobe, &gpu_known[lobe], &shortest);
        let wrong = outliers(&recovered[lobe], &light, 4.0);
        assert!(wrong < 60, "lobe {lobe}: {wrong} values");
        let found = corrected.iter().map(|n| (n >> (16 * lobe)) & 0xffff);
        let differ = found.zip(frames.texels()).filter(|(a, b)| a != *b).count();
        // A share that ends between two counts may round either way.
        assert!(differ < 8, "lobe {lobe}: {differ} counts");
        let pairs = frames.texels().iter().zip(gpu_known[lobe].frames.texels());
        shortened += pairs.filter(|(now, before)| now < before).count();
    }
    assert!(shortened > 20, "only {shortened} histories were shortened at all");
}

fn mean(clean: &Clean) -> f64 {
    clean.diffuse.iter().map(|t| t[0].to_f64()).sum::<f64>() / clean.diffuse.len() as f64
}

fn variance(clean: &Clean) -> f64 {
    let mean = mean(clean);
    clean.diffuse.iter().map(|t| (t[0].to_f64() - mean).powi(2)).sum::<f64>() / clean.diffuse.len() as f64
}

#[test]
fn a_wall_gets_quiet_and_keeps_its_energy() {
    let (gpu, size) = (gpu(), [96, 80]);
    let mut denoiser = Recurrent::new(&gpu).unwrap();
    denoiser.resize(&gpu, size, true).unwrap();
    let still = Shot::wall(size, 1.0);
    let mut left = Vec::new();
    for index in 0..32 {
        let mut shot = still.sequel(index);
        shot.noisy.diffuse = noise(size, index);
        let (clean, log) = shot.next(&gpu, &mut denoiser);
        left.push(variance(&clean));
        if index == 31 {
            // 30 frames of 7,680 draws with a deviation of 58 % of the mean: 0.12 %; three deviations, and what half
            // floats round.
            assert!((mean(&clean) - 1.0).abs() < 0.005, "mean {}", mean(&clean));
            let frames = read::<u32>(&gpu, &log, "denoise/recurrent/frames");
            let long = frames.iter().filter(|n| (*n & 0xffff) > 25).count();
            assert!(long > 7680 * 95 / 100, "noise alone shortened {} histories", 7680 - long);
        }
    }
    // Time alone would leave a / (2 - a) of 1/3 with a = 1/30; the blurs take off at least as much again as eight pixels
    // do, and one frame of them leaves less than a hundredth.
    let time = 1.0 / 59.0 / 3.0;
    assert!(left[0] < 0.01 / 3.0 && left[31] < time / 8.0, "{} at first, {} at last", left[0], left[31]);
}

#[test]
fn light_that_goes_out_is_forgotten_sooner_than_its_frames_tell() {
    let (gpu, size) = (gpu(), [48, 40]);
    let lag = |sigma: &str| {
        let mut denoiser = Recurrent::new(&gpu).unwrap();
        set_knob(&mut denoiser.knobs(), "lag_sigma", sigma).unwrap();
        denoiser.resize(&gpu, size, true).unwrap();
        let still = Shot::wall(size, 1.0);
        (0..40)
            .map(|index| {
                let mut shot = still.sequel(index);
                let dim = if index < 32 { 1.0 } else { 0.125 };
                shot.noisy.diffuse = noise(size, index).map(|light| light.map(|v| dim * v));
                mean(&shot.next(&gpu, &mut denoiser).0)
            })
            .collect::<Vec<_>>()
    };
    let (quick, slow) = (lag("2"), lag("1000"));
    // Eight frames later thirty frames of history still hold (29/30)^8 = 76 % of what is gone.
    assert!(slow[39] > 0.125 + 0.6 * 0.875, "without the test {}", slow[39]);
    // The fast one itself still holds (5/6)^8 = 23 %; half of what is gone is a bound with room for its noise.
    assert!(quick[39] < 0.125 + 0.5 * 0.875, "with it {}", quick[39]);
}
