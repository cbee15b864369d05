//! GPU against CPU, closed forms, and what must not change.
#![allow(clippy::unwrap_used, clippy::panic)]

use super::{Axis, FivePhase, PHASES, Settings, reference};
use crate::Denoiser;
use crate::fixture::{Clean, Shot, gpu, halves, outliers, random};
use crate::light::reference::Light;
use frame::cpu::Image;
use frame::surface::Surface;
use frame::{Gpu, set_knob};
use glam::{Vec2, Vec3};
use half::f16;

fn run(gpu: &Gpu, shot: &Shot) -> Clean {
    shot.denoise(gpu, &mut FivePhase::new(gpu).unwrap()).0
}

fn twin(settings: &Settings, shot: &Shot) -> Light {
    reference::denoise(settings, &shot.frame, &shot.surface, &shot.distance, &shot.noisy)
}

/// Of each of the ten passes, one step of a half float: the two may round a value between codes differently. Means of
/// positive numbers do not enlarge a relative error.
const STEPS: f32 = 10.0;

#[test]
fn the_gpu_does_what_the_twin_does() {
    let gpu = gpu();
    let mut denoiser = FivePhase::new(&gpu).unwrap();
    let variants: [&[(&str, &str)]; 5] = [
        &[],
        &[("order", "axes"), ("falloff", "triangular"), ("border", "mirror"), ("scale", "height")],
        &[("order", "descending"), ("same_bracket", "off")],
        &[("tau0", "0"), ("tau4", "0.1"), ("k4", "20"), ("k_growth", "2.5"), ("rho_growth", "1")],
        &[("growth_step", "0.5"), ("rho0", "0"), ("k0", "0"), ("k_growth_max", "3"), ("cutoff", "distances")],
    ];
    let mut changed = 0;
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
        let specular = cpu.specular.as_ref().unwrap();
        let count = outliers(&clean.diffuse, &cpu.diffuse, STEPS)
            + outliers(clean.specular.as_ref().unwrap(), specular, STEPS);
        // A tap as far away as the cut-off, to rounding, may be in on one side only: three such pixels, eight values
        // each.
        assert!(count <= 24, "{variant:?}: {count} values differ");
        changed += outliers(&halves(&shot.noisy.diffuse), &cpu.diffuse, STEPS);
    }
    assert!(
        changed > 5 * 45 * 33,
        "the comparison must have something to compare: {changed} values filtered"
    );
}

/// Weights along an axis after all phases: boxes of these half widths, convolved.
fn convolved_boxes(radii: [usize; PHASES]) -> Vec<f64> {
    radii.iter().fold(vec![1.0], |before, radius| {
        let width = 2 * radius + 1;
        let mut after = vec![0.0; before.len() + width - 1];
        for (i, weight) in before.iter().enumerate() {
            after[i..i + width].iter_mut().for_each(|w| *w += weight / width as f64);
        }
        after
    })
}

#[test]
fn an_impulse_on_a_wall_spreads_as_the_boxes_convolve() {
    let (size, centre) = ([64, 64], 32);
    // Nearer than one growth step everywhere, so that the half widths are those of the knobs.
    let mut shot = Shot::wall(size, 0.9);
    *shot.noisy.diffuse.get_mut(centre, centre).unwrap() = [50_000.0, 0.0, 0.0, 0.0];
    let clean = run(&gpu(), &shot);
    let weights = convolved_boxes([1, 2, 3, 4, 6]);
    let reach = weights.len() as i32 / 2;
    let weight = |offset: i32| weights.get((offset + reach) as usize).copied().unwrap_or(0.0);
    let mut sum = 0.0;
    for (index, texel) in (0..).zip(&clean.diffuse) {
        let (x, y) = (index % 64 - centre, index / 64 - centre);
        let expected = 50_000.0 * weight(x) * weight(y);
        let found = texel[0].to_f64();
        // A step of a half float per pass, and near 0 the smallest one.
        let tolerance = 10.0 * (expected * 2f64.powi(-10) + 2f64.powi(-24));
        assert!((found - expected).abs() <= tolerance, "at {x}, {y}: {found} instead of {expected}");
        sum += found;
    }
    // Energy: away from the border a normalised blur keeps it. Roundings are random, so the bound is a single pass's.
    assert!((sum / 50_000.0 - 1.0).abs() < 2f64.powi(-10), "energy {}", sum / 50_000.0);
}

#[test]
fn radii_are_isotropic_on_the_display() {
    let mut shot = Shot::wall([64, 64], 0.9);
    shot.frame.display_size = [256, 192];
    *shot.noisy.diffuse.get_mut(32, 32).unwrap() = [50_000.0, 0.0, 0.0, 0.0];
    let clean = run(&gpu(), &shot);
    let lit = |reach: i32, step: i32| {
        (-reach..=reach).filter(|j| clean.diffuse[(32 * 64 + 32 + j * step) as usize][0] > f16::ZERO).count()
    };
    // Along columns 1 + 2 + 3 + 4 + 6; along rows three quarters of each, rounded: 1 + 2 + 2 + 3 + 5.
    assert_eq!((lit(31, 64), lit(31, 1)), (33, 27));
}

#[test]
fn a_noisy_wall_keeps_its_energy() {
    let mut shot = Shot::wall([64, 48], 1.0);
    shot.noisy.diffuse = Image::from_fn([64, 48], |x, y| [2.0 * random(7, 64 * y + x), 0.0, 0.0, 1.0]);
    let clean = run(&gpu(), &shot);
    let before: f64 = shot.noisy.diffuse.texels().iter().map(|t| f64::from(t[0])).sum();
    let after: f64 = clean.diffuse.iter().map(|t| t[0].to_f64()).sum();
    // Pixels near the border count for more than inner ones. About 40 % of the pixels lie there, noise is 58 % of the
    // mean and 3,072 pixels average it: 3 deviations are below 2 %.
    assert!((after / before - 1.0).abs() < 0.02, "energy ratio {}", after / before);
}

#[test]
fn planes_at_a_right_angle_do_not_mix() {
    let mut shot = Shot::wall([32, 32], 1.0);
    let facing = |normal| Surface { normal, ..Surface::default() }.pack_gbuffer(0);
    shot.surface = Image::from_fn([32, 32], |x, _| facing(if x < 16 { Vec3::X } else { Vec3::Z }));
    shot.noisy.diffuse =
        Image::from_fn([32, 32], |x, _| if x < 16 { [1.0; 4] } else { [0.0, 0.0, 0.0, 8.0] });
    assert!(run(&gpu(), &shot).diffuse == halves(&shot.noisy.diffuse));
}

#[test]
fn the_radial_cutoff_separates_what_lies_behind() {
    let mut shot = Shot::wall([32, 32], 1.0);
    // Three metres behind: more than any phase's cut-off with its growth at 4 m (0.5 + 3 * 0.05).
    shot.distance = Image::from_fn([32, 32], |x, y| {
        shot.distance.get(x as i32, y as i32).unwrap() + 3.0 * (x / 16) as f32
    });
    shot.noisy.diffuse =
        Image::from_fn([32, 32], |x, _| if x < 16 { [1.0; 4] } else { [0.0, 0.0, 0.0, 8.0] });
    assert!(run(&gpu(), &shot).diffuse == halves(&shot.noisy.diffuse));
}

#[test]
fn untraced_pixels_are_filled_and_empty_samples_count() {
    let mut shot = Shot::wall([48, 48], 1.0);
    // Half of the pixels drew the other lobe: theirs is a 0 that belongs to the mean, and has no length.
    shot.noisy.diffuse =
        Image::from_fn([48, 48], |x, y| if (x + y) % 2 == 0 { [2.0, 2.0, 2.0, 5.0] } else { [0.0; 4] });
    shot.noisy.samples = Image::from_fn([48, 48], |x, y| if (x + y) % 2 == 0 { 1 } else { 0x1_0000 });
    let gpu = gpu();
    for texel in run(&gpu, &shot).diffuse {
        // Odd kernels hold one pixel of a kind more than of the other: at most 5 of 9 after the first phase.
        assert!((texel[0].to_f32() - 1.0).abs() < 1.0 / 9.0, "mean {}", texel[0]);
        assert_eq!(texel[3].to_f32(), 5.0, "the length of those that have one");
    }
    // The same zeros, now because nothing was traced there: they do not count.
    shot.noisy.samples = Image::from_fn([48, 48], |x, y| if (x + y) % 2 == 0 { 1 } else { 0 });
    for texel in run(&gpu, &shot).diffuse {
        assert_eq!(texel.map(f16::to_f32), [2.0, 2.0, 2.0, 5.0]);
    }
}

#[test]
fn a_lobe_that_the_surface_lacks_is_left_alone() {
    let mut shot = Shot::wall([32, 32], 1.0);
    let glossy = Surface { f0: 0.04, roughness: Vec2::ONE, ..Surface::default() };
    let packed = [Surface::default(), glossy].map(|s| s.pack_gbuffer(0));
    shot.surface = Image::from_fn([32, 32], |x, _| packed[(x % 2) as usize]);
    let light = Image::from_fn([32, 32], |x, _| if x % 2 == 1 { [1.5, 1.0, 0.5, 2.0] } else { [0.0; 4] });
    shot.noisy.specular = Some(light.clone());
    assert!(
        run(&gpu(), &shot).specular == Some(halves(&light)),
        "no light leaks to Lambert or is lost to it"
    );
}

#[test]
fn every_order_runs_each_phase_once_along_each_axis() {
    let mut settings = Settings::default();
    for order in 0..3 {
        settings.order = order;
        let schedule = settings.schedule();
        for pass in (0..PHASES).flat_map(|phase| [(phase, Axis::Horizontal), (phase, Axis::Vertical)]) {
            assert_eq!(schedule.iter().filter(|p| **p == pass).count(), 1, "{pass:?} in order {order}");
        }
    }
    assert_eq!(schedule_start(0), [(0, Axis::Horizontal), (0, Axis::Vertical)]);
    assert_eq!(schedule_start(1), [(0, Axis::Horizontal), (1, Axis::Horizontal)]);
    assert_eq!(schedule_start(2), [(4, Axis::Horizontal), (4, Axis::Vertical)]);
}

fn schedule_start(order: u32) -> [(usize, Axis); 2] {
    let [first, second, ..] = Settings { order, ..Settings::default() }.schedule();
    [first, second]
}

#[test]
fn a_roughness_on_a_threshold_belongs_to_the_bracket() {
    // Codes of exactly 0.2, 0.4, 0.6, 0.8; of 0.02 the next one up.
    let params = Settings::default().guide_params(true);
    assert_eq!((params.thresholds, params.last_threshold), ([6, 51, 102, 153], 204));
}

#[test]
fn the_tuned_preset_is_narrower_and_what_was_moved_stays() {
    let mut settings = Settings { preset: 1, ..Settings::default() };
    let reach = |settings: &Settings| settings.effective().kernel_radius.iter().sum::<u32>();
    assert!(reach(&settings) < reach(&Settings::default()));
    assert_eq!(Settings::default().effective(), Settings::default());
    settings.kernel_radius[4] = 9;
    assert_eq!(settings.effective().kernel_radius, settings.kernel_radius);
}

#[test]
fn mirrored_borders_keep_a_corner_s_light() {
    let mut shot = Shot::wall([64, 48], 0.9);
    *shot.noisy.diffuse.get_mut(0, 0).unwrap() = [1e4, 0.0, 0.0, 0.0];
    let gpu = gpu();
    let mut denoiser = FivePhase::new(&gpu).unwrap();
    set_knob(&mut denoiser.knobs(), "preset", "tuned").unwrap();
    let (clean, _) = shot.denoise(&gpu, &mut denoiser);
    let sum: f64 = clean.diffuse.iter().map(|t| t[0].to_f64()).sum();
    // Ten roundings to half floats, mostly averaged out.
    assert!((sum / 1e4 - 1.0).abs() < 0.005, "{sum}");
}
