//! GPU against CPU, closed forms, and what must not change.
#![allow(clippy::unwrap_used, clippy::panic)]

use super::{Atrous, Settings, reference};
use crate::Denoiser;
use crate::edge::{self, EdgeParams};
use crate::fixture::{Clean, Shot, gpu, halves, outliers, random};
use crate::light::reference::Light;
use frame::cpu::Image;
use frame::surface::Surface;
use frame::{Gpu, set_knob};
use glam::{Vec2, Vec3};
use half::f16;

fn run(gpu: &Gpu, shot: &Shot) -> Clean {
    let mut denoiser = Atrous::new(gpu).unwrap();
    // The source's kernel, of which closed forms are known.
    set_knob(&mut denoiser.knobs(), "taps", "5x5").unwrap();
    shot.denoise(gpu, &mut denoiser).0
}

fn twin(settings: &Settings, shot: &Shot) -> Light {
    let (frame, scale) = (shot.frame.uniform(), shot.frame.columns_per_row());
    let params = EdgeParams::new(settings.roughness_min, shot.noisy.specular.is_some(), false);
    let others = shot.others.map(|[face_normal, _, object]| [face_normal, object]);
    let edges = edge::reference::pack(&params, &frame, &shot.surface, &shot.distance, &others, &shot.noisy);
    reference::denoise(settings, &frame, scale, &edges, &shot.noisy)
}

/// Of each of the five levels, one step of a half float: the two may round a value between codes differently, and the next
/// level's colour weight may turn on it.
const STEPS: f32 = 6.0;

#[test]
fn the_gpu_does_what_the_twin_does() {
    let gpu = gpu();
    let mut denoiser = Atrous::new(&gpu).unwrap();
    // One level alone, then all of them, then wide weights, which let nearly every tap in.
    let variants: [&[(&str, &str)]; 4] = [
        &[("levels", "1")],
        &[],
        &[("sigma_normal", "2"), ("sigma_plane", "100"), ("lobe_spread", "10"), ("roughness_fraction", "10")],
        &[
            ("sigma_normal", "1"),
            ("sigma_plane", "50"),
            ("sigma_color", "0.5"),
            ("roughness_min", "0.5"),
            ("taps", "5x5"),
        ],
    ];
    for (seed, variant) in (10..).zip(variants) {
        denoiser.settings = Settings::default();
        for (name, value) in variant {
            set_knob(&mut denoiser.knobs(), name, value).unwrap();
        }
        let mut shot = Shot::random([45, 33], seed);
        shot.break_pixels(6);
        let (clean, log) = shot.denoise(&gpu, &mut denoiser);
        let cpu = twin(&denoiser.settings, &shot);
        assert!(clean.is_finite(), "{variant:?}");
        assert_eq!(log.counts["denoise_invalid"], 6.0, "{variant:?}");
        let found = outliers(&clean.diffuse, &cpu.diffuse, STEPS)
            + outliers(clean.specular.as_ref().unwrap(), cpu.specular.as_ref().unwrap(), STEPS);
        assert_eq!(found, 0, "{variant:?}: values differ");
        let changed = outliers(&halves(&shot.noisy.diffuse), &cpu.diffuse, STEPS);
        assert!(changed > 45 * 33 / 2, "{variant:?}: only {changed} values were filtered at all");
    }
}

/// A white wall, uniform light between 0 and 2 on it.
fn noisy_wall(size: [u32; 2]) -> Shot {
    let mut shot = Shot::wall(size, 1.0);
    shot.noisy.diffuse = Image::from_fn(size, |x, y| {
        [f16::from_f32(2.0 * random(7, size[0] * y + x)).to_f32(), 0.0, 0.0, 1.0]
    });
    shot
}

/// Mean and variance of red over the pixels at least `border` from the edge.
fn inner_moments(size: [u32; 2], border: u32, red: impl Fn(usize) -> f64) -> [f64; 2] {
    let inside = |x: u32, extent: u32| (border..extent - border).contains(&x);
    let values: Vec<f64> = (0..size[0] * size[1])
        .filter(|i| inside(i % size[0], size[0]) && inside(i / size[0], size[1]))
        .map(|i| red(i as usize))
        .collect();
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    [mean, values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64]
}

#[test]
fn a_noisy_wall_keeps_its_energy_and_loses_its_noise() {
    let size = [160, 128];
    let shot = noisy_wall(size);
    let clean = run(&gpu(), &shot);
    let [before, noise] = inner_moments(size, 0, |i| f64::from(shot.noisy.diffuse.texels()[i][0]));
    let [after, left] = inner_moments(size, 0, |i| clean.diffuse[i][0].to_f64());
    // Taps outside the picture are left out, so a pixel near the border counts more than one inside. The noise is 58 % of
    // the mean, 20,480 pixels average it (0.4 %), and the border changes the weights of a part of them: 0.5 %.
    assert!((after / before - 1.0).abs() < 0.005, "energy ratio {}", after / before);
    // Five levels of the spline have a variance of 341 px^2 per axis: 1 / (4 pi 341) of a white noise's is left. Ten times
    // that is the room for the colour weights.
    assert!(left / noise < 10.0 / 4285.0, "{} of the variance is left", left / noise);
}

#[test]
fn an_impulse_spreads_as_the_spline() {
    let mut shot = Shot::wall([32, 32], 1.0);
    shot.noisy.diffuse = Image::filled([32, 32], [1.0, 1.0, 1.0, 0.0]);
    *shot.noisy.diffuse.get_mut(16, 16).unwrap() = [2.0, 1.0, 1.0, 0.0];
    let gpu = gpu();
    let mut denoiser = Atrous::new(&gpu).unwrap();
    denoiser.settings =
        Settings { levels: 1, taps: 0, sigma_color: 100.0, sigma_plane: 100.0, ..Settings::default() };
    let (clean, _) = shot.denoise(&gpu, &mut denoiser);
    let weight = |offset: i32| [0.375f32, 0.25, 0.0625, 0.0][offset.unsigned_abs().min(3) as usize];
    for (i, texel) in (0..).zip(&clean.diffuse) {
        let expected = 1.0 + weight(i % 32 - 16) * weight(i / 32 - 16);
        // Half a step of a half float near 1, and 1e-4 for a colour weight that is not quite 1.
        assert!((texel[0].to_f32() - expected).abs() < 2f32.powi(-11) + 1e-4, "pixel {i}: {}", texel[0]);
    }
}

#[test]
fn taps_are_square_on_the_display() {
    // 0.75 columns per row: 1, 2 become 1, 2 (1.5 rounds up); 4, 8 become 3, 6; 16, 32 become 12, 24.
    assert_eq!(edge::taps(0, 0.75), [[1, 1], [2, 2]]);
    assert_eq!(edge::taps(2, 0.75), [[3, 4], [6, 8]]);
    assert_eq!(edge::taps(4, 0.75), [[12, 16], [24, 32]]);
    assert_eq!(edge::taps(4, 1.0), [[16, 16], [32, 32]]);
    let mut shot = Shot::wall([128, 128], 1.0);
    shot.frame.display_size = [512, 384];
    shot.noisy.diffuse = Image::filled([128, 128], [0.0, 0.0, 0.0, 0.0]);
    *shot.noisy.diffuse.get_mut(64, 64).unwrap() = [50_000.0; 4];
    let gpu = gpu();
    let mut denoiser = Atrous::new(&gpu).unwrap();
    denoiser.settings = Settings { levels: 3, taps: 0, sigma_color: 100.0, ..Settings::default() };
    let (clean, _) = shot.denoise(&gpu, &mut denoiser);
    let lit = |step: i32| {
        (-63..63).filter(|j| clean.diffuse[(64 * 128 + 64 + j * step) as usize][0] > f16::ZERO).count()
    };
    // Along a column 2 * (2 + 4 + 8) + 1; along a row 2 * (2 + 3 + 6) + 1.
    assert_eq!((lit(128), lit(1)), (29, 23));
}

/// Light on the left half, none on the right.
fn half_lit(size: [u32; 2]) -> Image<[f32; 4]> {
    Image::from_fn(size, |x, _| if x < size[0] / 2 { [1.0; 4] } else { [0.0, 0.0, 0.0, 8.0] })
}

#[test]
fn planes_at_a_right_angle_do_not_mix() {
    let mut shot = Shot::wall([32, 32], 1.0);
    let facing = |normal| Surface { normal, ..Surface::default() }.pack_gbuffer(0);
    shot.surface = Image::from_fn([32, 32], |x, _| facing(if x < 16 { Vec3::X } else { Vec3::Z }));
    shot.noisy.diffuse = half_lit([32, 32]);
    let clean = run(&gpu(), &shot).diffuse;
    // exp(-(1.414 / 0.4)^2) is 3.7e-6: over five levels, of lengths up to 8 m, less than 2e-4; and a step of a half float.
    let pairs = clean.as_flattened().iter().zip(shot.noisy.diffuse.texels().as_flattened());
    for (found, wanted) in pairs {
        assert!((found.to_f32() - wanted).abs() <= 2e-4 + 2f32.powi(-10) * wanted, "{found}, not {wanted}");
    }
}

#[test]
fn what_lies_behind_does_not_mix() {
    let mut shot = Shot::wall([32, 32], 1.0);
    // A row at 1 m spans 2 tan(0.4) / 32 = 26 mm; half a metre behind is 19 rows.
    shot.distance = Image::from_fn([32, 32], |x, y| {
        shot.distance.get(x as i32, y as i32).unwrap() * (1.0 + 0.5 * (x / 16) as f32)
    });
    shot.noisy.diffuse = half_lit([32, 32]);
    assert!(run(&gpu(), &shot).diffuse == halves(&shot.noisy.diffuse));
}

#[test]
fn a_wall_aslant_is_one_surface() {
    let size = [64, 64];
    let mut shot = noisy_wall(size);
    // A plane through (0, 0, -1) whose normal lies 80 degrees from the view direction.
    let (sin, cos) = 80f32.to_radians().sin_cos();
    let normal = Vec3::new(0.0, sin, cos);
    let tan = (0.5 * shot.frame.camera.vfov).tan();
    // Rays that look down meet it.
    shot.distance = Image::from_fn(size, |x, y| {
        let ndc = Vec2::new(x as f32 + 0.5, y as f32 + 0.5) / 32.0 - 1.0;
        let ray = Vec3::new(ndc.x * tan, -ndc.y * tan, -1.0);
        let along = normal.dot(Vec3::NEG_Z) / normal.dot(ray);
        if along > 0.0 { along * ray.length() } else { 0.0 }
    });
    shot.surface = Image::filled(size, Surface { normal, ..Surface::default() }.pack_gbuffer(0));
    shot.others = Image::filled(size, [frame::surface::face_normal_pack(normal), 0, 1]);
    let clean = run(&gpu(), &shot);
    let near = |i: usize| i / 64 >= 40 && shot.distance.texels()[i] > 0.0;
    let pixels: Vec<usize> = (0..64 * 64).filter(|i| near(*i)).collect();
    let mean = pixels.iter().map(|i| clean.diffuse[*i][0].to_f64()).sum::<f64>() / pixels.len() as f64;
    let left = pixels.iter().map(|i| (clean.diffuse[*i][0].to_f64() - mean).powi(2)).sum::<f64>();
    // Uniform light between 0 and 2 has a variance of 1/3; a filter that stopped at differences of depth would leave most
    // of it.
    assert!(left / (pixels.len() as f64) < 0.02 / 3.0, "{} left", 3.0 * left / pixels.len() as f64);
}

#[test]
fn the_specular_kernel_is_as_wide_as_the_lobe() {
    // What is left of the variance falls with roughness, down to the diffuse lobe's.
    let size = [64, 64];
    let gpu = gpu();
    let left = [0.1f32, 0.3, 1.0].map(|roughness| {
        let mut shot = noisy_wall(size);
        let surface = Surface { f0: 0.04, roughness: Vec2::splat(roughness), ..Surface::default() };
        shot.surface = Image::filled(size, surface.pack_gbuffer(0));
        shot.noisy.specular = Some(shot.noisy.diffuse.clone());
        let clean = run(&gpu, &shot).specular.unwrap();
        inner_moments(size, 0, |i| clean[i][0].to_f64())[1]
    });
    // r = 0.25 R^2 64 / (2 tan 0.4): 0.19, 1.7 and 19 rows. The first is hardly a pixel wide, and leaves nearly all.
    assert!(left[0] > 0.9 / 3.0 && left[1] < 0.3 * left[0] && left[2] < 0.2 * left[1], "{left:?}");
}

#[test]
fn untraced_pixels_are_filled_and_empty_samples_count() {
    let mut shot = Shot::wall([48, 48], 1.0);
    let is_even = |x: u32, y: u32| (x + y).is_multiple_of(2);
    shot.noisy.diffuse =
        Image::from_fn([48, 48], |x, y| if is_even(x, y) { [2.0, 2.0, 2.0, 5.0] } else { [0.0; 4] });
    shot.noisy.samples = Image::from_fn([48, 48], |x, y| if is_even(x, y) { 1 } else { 0x1_0000 });
    let gpu = gpu();
    for texel in run(&gpu, &shot).diffuse {
        // Half of the pixels drew the other lobe. The colour weight of the first level, exp(-1/16), favours a pixel's own
        // kind by 6 %; a filter that left zeros out would give 2.
        assert!((texel[0].to_f32() - 1.0).abs() < 0.06, "mean {}", texel[0]);
        assert_eq!(texel[3].to_f32(), 5.0, "the length of those that have one");
    }
    // The same zeros, now because nothing was traced there: they do not count.
    shot.noisy.samples = Image::from_fn([48, 48], |x, y| u32::from(is_even(x, y)));
    for texel in run(&gpu, &shot).diffuse {
        assert_eq!(texel.map(f16::to_f32), [2.0, 2.0, 2.0, 5.0]);
    }
}
