//! GPU against CPU, pass by pass.

use super::super::{Svgf, reference};
use crate::Denoiser;
use crate::edge::{self, EdgeParams};
use crate::fixture::{Shot, gpu};
use crate::temporal::reference as temporal;
use frame::cpu::Image;
use frame::{Gpu, Texture, set_knob};
use glam::Vec3;
use half::f16;

/// Values that differ by more than rounding: half floats in three passes, or powers and exponentials of f32.
fn outliers<'a>(gpu: impl Iterator<Item = f32>, cpu: impl Iterator<Item = &'a f32>, steps: f32) -> usize {
    let tolerance = |value: f32| steps * (2f32.powi(-10) * value.abs() + 2f32.powi(-22));
    let far = |gpu: f32, cpu: f32| !gpu.is_finite() || (gpu - cpu).abs() > tolerance(cpu);
    gpu.zip(cpu).filter(|(gpu, cpu)| far(*gpu, **cpu)).count()
}

fn flat(image: &Image<[f32; 4]>) -> impl Iterator<Item = &f32> {
    image.texels().as_flattened().iter()
}

fn read_light(gpu: &Gpu, texture: &Texture) -> Vec<f32> {
    gpu.read_texture::<[f16; 4]>(texture).unwrap().as_flattened().iter().map(|x| x.to_f32()).collect()
}

/// Two frames on both sides, pass by pass: each pass of the twin starts from what the GPU's pass before it left.
fn compare(variant: &[(&str, &str)], seed: u32, gpu: &Gpu) {
    let mut denoiser = Svgf::new(gpu).unwrap();
    for (name, value) in variant {
        set_knob(&mut denoiser.knobs(), name, value).unwrap();
    }
    let settings = denoiser.settings;
    let size = [45, 33];
    let mut first = Shot::random(size, seed);
    first.break_pixels(6);
    let mut second = first.sequel(1);
    second.frame.camera.eye += Vec3::new(0.05, -0.02, 0.01);
    second.frame.previous_jitter = first.frame.jitter;
    second.frame.jitter = [-0.1, 0.4];
    second.noisy = Shot::random(size, seed + 100).noisy;
    second.noisy.specular.as_mut().unwrap().get_mut(20, 20).unwrap()[2] = f32::NAN;

    let edges = |shot: &Shot| {
        let others = shot.others.map(|[face_normal, _, object]| [face_normal, object]);
        let params = EdgeParams::new(settings.roughness_min, true, true);
        let frame = shot.frame.uniform();
        edge::reference::pack(&params, &frame, &shot.surface, &shot.distance, &others, &shot.noisy)
    };
    first.denoise(gpu, &mut denoiser);
    let before = remembered(gpu, &denoiser, size);
    // Depths differ in the last bits; all else is integers.
    let exact = |edge: &Image<[u32; 4]>| edge.map(|[_, y, z, w]| [y, z, w]);
    assert!(exact(&before.edge) == exact(&edges(&first)), "{variant:?}: packed edges");
    let depths = |edge: &Image<[u32; 4]>| edge.map(|t| f32::from_bits(t[0])).texels().to_vec();
    let wrong = outliers(depths(&before.edge).into_iter(), depths(&edges(&first)).iter(), 0.01);
    assert_eq!(wrong, 0, "{variant:?}: depths");

    let (clean, _) = second.next(gpu, &mut denoiser);
    assert!(clean.is_finite(), "{variant:?}");
    let after = remembered(gpu, &denoiser, size);
    let (frame, scale) = (second.frame.uniform(), second.frame.columns_per_row());
    let motion = second.others.map(|[_, motion, _]| motion);
    let reproject = settings.temporal.params(&second.frame);
    let known =
        temporal::accumulate_frame(&reproject, &frame, &after.edge, &motion, &second.noisy, &before, None);
    let result = [&clean.diffuse, clean.specular.as_ref().unwrap()];
    let mut followed = 0;
    for lobe in 0..2 {
        let (gpu_lobe, cpu_lobe) = (&after.lobes[lobe], &known[lobe]);
        // A tap exactly as far off as is allowed may count on one side only: at most two pixels.
        let pairs = gpu_lobe.frames.texels().iter().zip(cpu_lobe.frames.texels());
        let differ = pairs.filter(|(gpu, cpu)| gpu != cpu).count();
        assert!(differ <= 2, "{variant:?}, lobe {lobe}: {differ} frame counts");
        followed += cpu_lobe.frames.texels().iter().filter(|n| **n > 1).count();
        let moments = |lobe: &temporal::Lobe| lobe.moments.texels().as_flattened().to_vec();
        let wrong = outliers(moments(gpu_lobe).into_iter(), moments(cpu_lobe).iter(), 1.0);
        assert!(wrong <= 4, "{variant:?}, lobe {lobe}: {wrong} moments");

        let params = settings.level_params(0, scale);
        let mut variance = reference::variance(&params, &frame, &after.edge, lobe, gpu_lobe);
        let mut light = cpu_lobe.light.clone();
        for level in 0..settings.levels {
            let params = settings.level_params(level, scale);
            (light, variance) = reference::level(&params, &frame, &after.edge, lobe, &light, &variance);
            if level == 0 {
                let wrong = outliers(flat(&gpu_lobe.light).copied(), flat(&light), 3.0);
                assert!(wrong <= 8, "{variant:?}, lobe {lobe}: {wrong} values of the first level");
            }
        }
        // One step of a half float a pass; a weight turns on such steps in the next pass. The pixels that found another
        // history reach a few neighbours.
        let found = result[lobe].as_flattened().iter().map(|x| x.to_f32());
        let wrong = outliers(found, flat(&light), 8.0);
        assert!(wrong <= 60, "{variant:?}, lobe {lobe}: {wrong} values at the end");
        let changed = outliers(flat(&cpu_lobe.light).copied(), flat(&light), 8.0);
        assert!(changed > 300, "{variant:?}, lobe {lobe}: only {changed} values were filtered at all");
    }
    assert!(followed > 300, "{variant:?}: only {followed} pixels were followed");
}

/// What the last frame left.
fn remembered(gpu: &Gpu, denoiser: &Svgf, size: [u32; 2]) -> temporal::History {
    // The frame has ended, and turned.
    let past = &denoiser.temporal;
    let edge = gpu.read_texture::<[u32; 4]>(past.edge_before()).unwrap();
    let moments = gpu.read_texture::<[f32; 4]>(past.moments_before()).unwrap();
    let frames = gpu.read_texture::<u32>(past.frames_before()).unwrap();
    let lobe = |lobe: usize| {
        let light = read_light(gpu, &denoiser.history[lobe]);
        let light = light.chunks(4).map(|c| [c[0], c[1], c[2], c[3]]).collect();
        let moments = moments.iter().map(|m| [m[2 * lobe], m[2 * lobe + 1]]).collect();
        let frames = frames.iter().map(|n| (n >> (16 * lobe)) & 0xffff).collect();
        temporal::Lobe {
            light: Image::from_texels(size, light).unwrap(),
            moments: Image::from_texels(size, moments).unwrap(),
            frames: Image::from_texels(size, frames).unwrap(),
        }
    };
    temporal::History { edge: Image::from_texels(size, edge).unwrap(), lobes: [lobe(0), lobe(1)] }
}

#[test]
fn the_gpu_does_what_the_twin_does() {
    let gpu = gpu();
    let wide = [("sigma_n", "1"), ("sigma_z", "100"), ("lobe_spread", "10"), ("roughness_fraction", "10")];
    // Random normals and depths hardly ever agree: the first two let nearly all of them count as the same surface.
    let same = [("history_plane", "1"), ("history_normal", "-1")];
    compare(&[&wide[..], &same[..]].concat(), 20, &gpu);
    compare(
        &[&wide[..], &same[..], &[("alpha_color", "0"), ("sigma_l", "1"), ("levels", "2"), ("taps", "3x3")]]
            .concat(),
        21,
        &gpu,
    );
    compare(&[&wide[..2], &[("history_plane", "0.2"), ("history_normal", "0")]].concat(), 22, &gpu);
}
