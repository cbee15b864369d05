#![allow(clippy::unwrap_used, clippy::panic)]

mod gpu;

mod furnace;

use super::facets::{fresnel, ggx, ior};
use super::*;
use crate::surface::{self, Surface, hash};
use glam::{DVec2, DVec3, Vec2, Vec3};
use std::f64::consts::{PI, TAU};
use std::sync::LazyLock;

const BELOW_ONE: f64 = 1.0 - 1.0 / 16_777_216.0;

static TABLE: LazyLock<BrdfTable> = LazyLock::new(BrdfTable::new);

/// The default rules, those of the references, the paper's.
fn all_rules() -> [Brdf<'static>; 3] {
    let paper = Rules { lobe: Lobe::Paper, fresnel: Fresnel::Schlick, ..Rules::default() };
    let lossy = Rules { lossy: true, ..Rules::default() };
    [Rules::default(), lossy, paper].map(|rules| Brdf { table: &TABLE, rules })
}

fn sample_diffuse(s: &Surface, wo: DVec3, u: DVec2) -> Sample {
    Brdf::new(&TABLE).sample_diffuse(s, wo, u)
}

fn sample_specular(s: &Surface, wo: DVec3, u: DVec3, inside: bool) -> Sample {
    Brdf::new(&TABLE).sample_specular(s, wo, u, inside)
}

fn eval(s: &Surface, wo: DVec3, wi: DVec3) -> Value {
    Brdf::new(&TABLE).eval(s, wo, wi)
}

fn eval_side(s: &Surface, wo: DVec3, wi: DVec3, inside: bool) -> Value {
    Brdf::new(&TABLE).eval_side(s, wo, wi, inside)
}

/// A stream of numbers in [0, 1) with the 24 bits that a shader's have.
struct Random(u32);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 += 1;
        f64::from(hash(self.0) >> 8) / 16_777_216.0
    }

    fn three(&mut self) -> DVec3 {
        DVec3::new(self.next(), self.next(), self.next())
    }

    /// Any surface in any orientation, a third of its numbers at the ends of their ranges.
    fn surface(&mut self) -> Surface {
        let n = direction(2.0 * self.next() - 1.0, TAU * self.next());
        let t = n.cross(direction(2.0 * self.next() - 1.0, TAU * self.next())).normalize();
        let mut number = || match (self.next() * 6.0) as u32 {
            0 => 0.0,
            1 => 1.0,
            _ => self.next() as f32,
        };
        Surface {
            normal: n.as_vec3(),
            tangent: t.as_vec3(),
            handedness: if number() < 0.5 { 1.0 } else { -1.0 },
            base: Vec3::new(number(), number(), number()),
            metalness: number(),
            roughness: Vec2::new(number(), number()),
            f0: number(),
            transmission: number(),
            thin: number() < 0.3,
            ..Surface::default()
        }
    }
}

fn direction(cosine: f64, azimuth: f64) -> DVec3 {
    let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
    DVec3::new(sine * azimuth.cos(), sine * azimuth.sin(), cosine)
}

fn rough(alpha_t: f64, alpha_b: f64) -> Surface {
    Surface { roughness: DVec2::new(alpha_t, alpha_b).map(f64::sqrt).as_vec2(), ..Surface::default() }
}

fn metal(alpha_t: f64, alpha_b: f64) -> Surface {
    Surface { metalness: 1.0, ..rough(alpha_t, alpha_b) }
}

/// Glass of index 1.5.
fn glass(alpha: f64) -> Surface {
    Surface { f0: 0.04, transmission: 1.0, ..rough(alpha, alpha) }
}

/// E of a lobe of white facets: the mean of G2 / G1, with what masking keeps left out.
fn energy(alpha: DVec2, wo: DVec3) -> [f64; 2] {
    energy::integrate::energy(wo, alpha)
}

#[test]
fn fresnel_has_its_closed_forms() {
    for eta in [1.0 / 1.5, 1.5, 1.0 / 2.4] {
        assert!((fresnel(1.0, eta) - ((eta - 1.0) / (eta + 1.0)).powi(2)).abs() < 1e-12);
        // At Brewster's angle tan = 1 / eta only s is left: ((1 - eta^2) / (1 + eta^2))^2 / 2 (Born and Wolf).
        let brewster = (1.0 / (1.0 + 1.0 / (eta * eta))).sqrt();
        let s = (1.0 - eta * eta) / (1.0 + eta * eta);
        assert!((fresnel(brewster, eta) - 0.5 * s * s).abs() < 1e-12);
    }
    assert_eq!(fresnel(1e-9, 1.0 / 1.5).min(0.999_999), 0.999_999, "grazing");
    assert_eq!(fresnel(0.7, 1.5), 1.0, "total reflection: the critical cosine is sqrt(5)/3 = 0.745");
    assert!(fresnel(0.75, 1.5) < 1.0);
    // Diffuse light inside glass: 0.596 (algorithms 5.3, three digits).
    let mean = (0..10_000).map(|i| fresnel(((f64::from(i) + 0.5) / 1e4).sqrt(), 1.5)).sum::<f64>() / 1e4;
    assert!((mean - 0.596).abs() < 5e-4, "{mean}");
    assert!((ior(0.04) - 1.5).abs() < 1e-12);
}

#[test]
fn white_metal_reflects_what_the_furnace_table_says() {
    let mus = [0.05, 0.2, 0.5, 1.0];
    let along = [0.0, 0.25];
    // alpha_t, alpha_b, turn of wo from the tangent, E at the four mu.
    let rows: [(f64, f64, f64, [f64; 4]); 8] = [
        (0.05, 0.05, along[0], [0.890, 0.963, 0.993, 0.997]),
        (0.25, 0.25, along[0], [0.933, 0.848, 0.858, 0.916]),
        (0.5, 0.5, along[0], [0.913, 0.790, 0.698, 0.689]),
        (1.0, 1.0, along[0], [0.849, 0.642, 0.451, 0.307]),
        (0.1, 0.5, along[0], [0.805, 0.759, 0.804, 0.818]),
        (0.1, 0.5, along[1], [0.948, 0.866, 0.806, 0.818]),
        (0.05, 1.0, along[0], [0.539, 0.525, 0.531, 0.531]),
        (0.05, 1.0, along[1], [0.915, 0.786, 0.651, 0.531]),
    ];
    for (alpha_t, alpha_b, turn, expected) in rows {
        for (mu, expected) in mus.into_iter().zip(expected) {
            let [e, _] = energy(DVec2::new(alpha_t, alpha_b), direction(mu, TAU * turn));
            // Half of the table's last digit, and its own sampling noise.
            assert!((e - expected).abs() < 0.0015, "({alpha_t}, {alpha_b}) {turn} {mu}: {e} {expected}");
        }
    }
}

#[test]
fn facets_cover_the_plane_once() {
    // The projected area of all facets is 1: the definition of D.
    for alpha in [DVec2::new(0.05, 0.05), DVec2::new(0.2, 0.7), DVec2::ONE] {
        let (n, mut sum) = (1000, 0.0);
        for i in 0..n * n {
            // Uniform in the unit disk of (hx, hy), where the projected solid angle is the area.
            // x^4 puts the rows where a narrow lobe is.
            let x = (f64::from(i % n) + 0.5) / f64::from(n);
            let h = direction((1.0 - x.powi(4)).sqrt(), TAU * (f64::from(i / n) + 0.5) / f64::from(n));
            sum += ggx(h, alpha) * PI * 4.0 * x.powi(3) / f64::from(n * n);
        }
        // Midpoints, a thousand either way.
        assert!((sum - 1.0).abs() < 1e-4, "{alpha}: {sum}");
    }
}

#[test]
fn modulators_are_the_contract() {
    let table = BrdfTable::new();
    let base = Vec3::new(0.8, 0.5, 0.2);
    let lambert = modulators(&Surface { base, ..Surface::default() }, 0.5, &table);
    assert_eq!(lambert.diffuse, base.as_dvec3());
    assert_eq!(lambert.specular, DVec3::splat(2f64.powi(-10)));
    assert!(!has_specular(&Surface::default()));
    for alpha in [0.0, 0.3] {
        let clear = modulators(&glass(alpha), 0.3, &table);
        assert_eq!(clear.diffuse, DVec3::ZERO);
        assert!((clear.specular - 1.0).abs().max_element() < 1e-12, "clear glass leaves light as it is");
    }
    let gold = modulators(&Surface { base, ..metal(0.0, 0.0) }, 1.0, &table);
    // Half floats in the table.
    assert!((gold.specular - base.as_dvec3()).abs().max_element() < 1e-3);
    let half = Surface { base, metalness: 0.5, transmission: 0.5, ..Surface::default() };
    assert_eq!(modulators(&half, 0.5, &table).diffuse, base.as_dvec3() * 0.25);
}

#[test]
fn weights_are_value_times_cosine_over_density() {
    for brdf in all_rules() {
        let mut random = Random(12);
        let mut compared = [0; 3];
        for i in 0..100_000 {
            let mut s = random.surface();
            // Frames that f32 holds exactly, so that only the formulas are compared.
            s.normal = Vec3::AXES[i % 3] * if i & 8 == 0 { 1.0 } else { -1.0 };
            s.tangent = Vec3::AXES[(i + 1 + i / 3 % 2) % 3] * if i & 16 == 0 { 1.0 } else { -1.0 };
            let wo = direction(2.0 * random.next() - 1.0, TAU * random.next());
            let inside = random.next() < 0.5;
            let n = s.normal.as_dvec3();
            let d = brdf.sample_diffuse(&s, wo, random.three().truncate());
            if d.valid {
                let value = brdf.eval_side(&s, wo, d.wi, inside);
                let error = (value.diffuse * d.wi.dot(n) / d.pdf - d.weight).abs().max_element();
                assert!(error < 1e-6 && (value.pdf_diffuse / d.pdf - 1.0).abs() < 1e-6, "{s:?}");
                compared[0] += 1;
            }
            let r = brdf.sample_specular(&s, wo, random.three(), inside);
            let cosine = r.wi.dot(n).abs();
            // A density above 1e8 is a mirror to f64's rounding of the half vector.
            if r.valid && !r.delta && r.pdf < 1e8 && cosine > 1e-4 {
                let value = brdf.eval_side(&s, wo, r.wi, inside);
                // The tip of a direction may round out of the paper's parallelogram.
                if brdf.rules.lobe == Lobe::Paper && value.pdf_specular == 0.0 {
                    continue;
                }
                let error = (value.specular * cosine / r.pdf - r.weight).abs().max_element();
                assert!(error <= 2e-6 * r.weight.max_element().max(1.0), "{error} {s:?} {r:?} {value:?}");
                assert!((value.pdf_specular / r.pdf - 1.0).abs() < 2e-6, "{s:?} {r:?} {value:?}");
                compared[1 + usize::from(r.transmitted)] += 1;
            }
        }
        println!("{:?}: compared {compared:?}", brdf.rules);
        assert!(compared.iter().all(|&c| c > 1000), "{compared:?}");
    }
}

#[test]
fn light_may_travel_either_way() {
    let mut random = Random(13);
    let mut passed = 0;
    for _ in 0..50_000 {
        let mut s = random.surface();
        s.normal = Vec3::Z;
        s.tangent = Vec3::X;
        let (wo, wi) =
            (direction(random.next(), TAU * random.next()), direction(random.next(), TAU * random.next()));
        let (there, back) = (eval(&s, wo, wi), eval(&s, wi, wo));
        let close = |a: DVec3, b: DVec3| (a - b).abs().max_element() <= 1e-9 * a.max_element().max(1.0);
        assert!(close(there.diffuse, back.diffuse) && close(there.specular, back.specular), "{s:?}");
        // Refraction: radiance over the squared index is what travels either way. From inside, the normal is turned.
        let below = DVec3::new(wi.x, wi.y, -wi.z);
        let turned = Surface { normal: Vec3::NEG_Z, handedness: -s.handedness, ..s };
        let there = eval(&s, wo, below).specular * ior(f64::from(s.f0)).powi(2);
        let back = eval_side(&turned, below, wo, true).specular;
        assert!(close(there, back), "{there} {back} {s:?}");
        passed += u32::from(there.x > 1e-3);
    }
    assert!(passed > 1000, "{passed}");
}

/// Chi-square of samples against the integral of the density over 16 x 32 bins of the whole sphere; bins with fewer
/// than 8 expected are joined.
fn assert_distribution(name: &str, draw: impl Fn(DVec3) -> Sample, density: impl Fn(DVec3) -> f64) {
    const BINS: [usize; 2] = [16, 32];
    const SAMPLES: u32 = 200_000;
    const FINE: usize = 24;
    let mut seen = vec![0.0; BINS[0] * BINS[1] + 1];
    let mut random = Random(hash(name.len() as u32));
    for _ in 0..SAMPLES {
        let sample = draw(random.three());
        let row = ((0.5 - 0.5 * sample.wi.z) * BINS[0] as f64) as usize;
        let turn = sample.wi.y.atan2(sample.wi.x) / TAU + 0.5;
        let bin = row.min(BINS[0] - 1) * BINS[1] + ((turn * BINS[1] as f64) as usize).min(BINS[1] - 1);
        seen[if sample.valid && !sample.delta { bin } else { BINS[0] * BINS[1] }] += 1.0;
    }
    let mut expected = vec![0.0; BINS[0] * BINS[1] + 1];
    let rows = BINS[0] * FINE;
    let columns = BINS[1] * FINE;
    for i in 0..rows * columns {
        let cosine = 1.0 - 2.0 * ((i / columns) as f64 + 0.5) / rows as f64;
        let azimuth = (((i % columns) as f64 + 0.5) / columns as f64 - 0.5) * TAU;
        let bin = i / columns / FINE * BINS[1] + i % columns / FINE;
        expected[bin] += density(direction(cosine, azimuth)) * 2.0 * TAU / (rows * columns) as f64;
    }
    let whole: f64 = expected.iter().sum();
    // Below the horizon no density is left: that share of the draws is not valid, or passes as a delta.
    expected[BINS[0] * BINS[1]] = (1.0 - whole).max(0.0);
    let (mut chi, mut freedom, mut joined) = (0.0, -1.0f64, (0.0, 0.0));
    for (seen, expected) in seen.iter().zip(&expected) {
        joined = (joined.0 + seen, joined.1 + expected * f64::from(SAMPLES));
        if joined.1 >= 8.0 {
            chi += (joined.0 - joined.1).powi(2) / joined.1;
            freedom += 1.0;
            joined = (0.0, 0.0);
        }
    }
    println!("{name}: density sums to {whole:.4}, chi-square {chi:.0} for {freedom}");
    assert!(whole < 1.0 + 1e-3, "{name}: {whole}");
    // Mean and five standard deviations of the distribution: one chance in a million.
    assert!(chi < freedom + 5.0 * (2.0 * freedom).sqrt(), "{name}: {chi} for {freedom}");
}

#[test]
fn samples_follow_their_density() {
    let wo = direction(0.6, 0.4);
    let plastic = Surface { f0: 0.04, ..rough(0.3, 0.6) };
    assert_distribution(
        "cosine",
        |u| sample_diffuse(&plastic, wo, u.truncate()),
        |wi| eval(&plastic, wo, wi).pdf_diffuse,
    );
    let tinted = Surface { base: Vec3::new(0.9, 0.6, 0.3), transmission: 0.7, metalness: 0.2, ..glass(0.4) };
    let half_smooth = Surface { metalness: 1.0, roughness: Vec2::new(0.35, 1.0), ..Surface::default() };
    for (name, s, inside) in [
        ("brushed metal", metal(0.2, 0.6), false),
        ("the roughest metal", metal(1.0, 1.0), false),
        ("metal, rough one way", half_smooth, false),
        ("rough plastic", plastic, false),
        ("frosted glass, entering", glass(0.3), false),
        ("frosted glass, leaving it", glass(0.3), true),
        ("the roughest glass", glass(1.0), false),
        ("a bit of everything there is", tinted, false),
    ] {
        for cosine in [0.6, 0.05] {
            let wo = direction(cosine, 0.4);
            // Bins a facet's width across, so that the midpoints see the lobe.
            assert_distribution(
                &format!("{name} at {cosine}"),
                |u| sample_specular(&s, wo, u, inside),
                |wi| eval_side(&s, wo, wi, inside).pdf_specular,
            );
        }
    }
}

#[test]
fn the_papers_lobe_is_even_over_its_parallelogram() {
    // Its bins are too narrow for the sphere's: the place of the tip, which the density makes even, is counted.
    let [.., brdf] = all_rules();
    for (s, inside, is_through) in [
        (metal(0.3, 1.0), false, false),
        (metal(0.0, 1.0), false, false),
        (glass(0.4), false, true),
        (glass(0.4), true, true),
    ] {
        for cosine in [0.9, 0.3] {
            let wo = direction(cosine, 0.4);
            let (mut random, mut counts, mut area) = (Random(77), [0u32; 64], 0.0);
            let middle = brdf.sample_specular(
                &Surface { roughness: Vec2::ZERO, ..s },
                wo,
                DVec3::new(0.5, 0.5, if is_through { BELOW_ONE } else { 0.0 }),
                inside,
            );
            if middle.transmitted != is_through {
                continue; // Total reflection.
            }
            let half = 0.1 * s.roughness.as_dvec2().max(DVec2::splat(0.01));
            let mut drawn = 0;
            for _ in 0..40_000 {
                let mut u = random.three();
                u.z = if is_through { BELOW_ONE } else { 0.0 };
                let sample = brdf.sample_specular(&s, wo, u, inside);
                if !sample.valid || sample.transmitted != is_through {
                    continue;
                }
                let tip = sample.wi * (middle.wi.z / sample.wi.z);
                let place = ((tip - middle.wi).truncate() / half * 0.5 + 0.5) * 8.0;
                counts[place.y.clamp(0.0, 7.0) as usize * 8 + place.x.clamp(0.0, 7.0) as usize] += 1;
                // The integral of 1 over the samples' solid angle, by their density.
                area += sample.branch / sample.pdf;
                drawn += 1;
            }
            let expected = f64::from(drawn) / 64.0;
            let chi: f64 = counts.iter().map(|c| (f64::from(*c) - expected).powi(2) / expected).sum();
            // Five standard deviations of a chi-square of 63.
            assert!(chi < 63.0 + 5.0 * 126f64.sqrt(), "{s:?} {cosine}: {chi}");
            // The solid angle of a small patch of the plane z = c.z is its area times c.z / 1.
            let wanted = 4.0 * half.x * half.y * middle.wi.z.abs();
            let found = area / f64::from(drawn);
            // The patch is not that small: second order in its width, over the cosine.
            assert!((found / wanted - 1.0).abs() < 0.05, "{s:?} {cosine}: {found} for {wanted}");
        }
    }
}

#[test]
fn smooth_glass_loses_nothing() {
    for (inside, scale) in [(false, 2.25), (true, 1.0 / 2.25)] {
        for i in 1..=50 {
            let wo = direction(f64::from(i) / 50.0, 1.0);
            let r = sample_specular(&glass(0.0), wo, DVec3::ZERO, inside);
            let t = sample_specular(&glass(0.0), wo, DVec3::splat(BELOW_ONE), inside);
            let reflected = r.weight.x * r.branch;
            assert!(r.valid && r.delta && t.valid && t.delta && r.pdf == 0.0);
            assert!((r.weight.x - 1.0).abs() < 1e-6, "drawn exactly by Fresnel");
            if t.transmitted {
                let passed = t.weight.x * t.branch * scale;
                assert!((reflected + passed - 1.0).abs() < 1e-6, "{reflected} {passed}");
                // Snell: the tangential part times the index is kept.
                let eta = if inside { 1.5 } else { 1.0 / 1.5 };
                assert!((t.wi.truncate() + wo.truncate() * eta).length() < 1e-6);
            } else {
                assert!(inside && reflected == 1.0, "total reflection");
            }
        }
    }
}

#[test]
fn thin_glass_goes_straight_on() {
    let wo = direction(0.7, 0.3);
    for s in [Surface { thin: true, ..glass(0.0) }, Surface { thin: true, ..glass(0.2) }] {
        let t = sample_specular(&s, wo, DVec3::splat(BELOW_ONE), true);
        // The frame is f32.
        assert!(t.valid && t.delta && t.transmitted && (t.wi + wo).length() < 1e-6);
    }
    let pane = Surface { thin: true, ..glass(0.0) };
    let r = sample_specular(&pane, wo, DVec3::ZERO, false);
    let f = fresnel(0.7, 1.0 / ior(f64::from(pane.f0)));
    assert!((r.branch - 2.0 * f / (1.0 + f)).abs() < 1e-12 && r.weight.x > 0.999_999);
    let nothing = Surface { transmission: 1.0, ..rough(0.5, 0.5) };
    let t = sample_specular(&nothing, wo, DVec3::splat(0.5), false);
    assert!(
        t.valid && t.delta && (t.wi + wo).length() < 1e-6 && (t.weight - 1.0).length() < 1e-12,
        "index 1"
    );
}

#[test]
fn no_single_sample_makes_light() {
    // With what facets keep put back, that holds of means alone: see furnace.rs.
    let [_, lossy, _] = all_rules();
    let mut random = Random(14);
    for _ in 0..100_000 {
        let s = random.surface();
        let wo = direction(2.0 * random.next() - 1.0, TAU * random.next());
        let inside = random.next() < 0.5;
        let sample = lossy.sample_specular(&s, wo, random.three(), inside);
        let bent = sample.transmitted && !s.thin && s.f0 > 0.0;
        let ior = ior(f64::from(s.f0));
        // Refraction squeezes radiance into a smaller solid angle; energy is what is left without that.
        let squeeze = if !bent {
            1.0
        } else if inside {
            ior * ior
        } else {
            1.0 / (ior * ior)
        };
        // A branch is drawn by luminance, so that is what no single sample can raise; 1e-6 for f32 surfaces.
        let energy = sample.weight.dot(DVec3::new(0.2126, 0.7152, 0.0722)) / squeeze;
        assert!(energy <= 1.0 + 1e-6, "{energy} {s:?}");
        assert!(lossy.sample_diffuse(&s, wo, random.three().truncate()).weight.max_element() <= 1.0);
    }
}

#[test]
fn nothing_is_ever_nan_or_negative() {
    let good = |v: DVec3| v.is_finite() && v.min_element() >= 0.0;
    // GRIDLIGHT_RANDOM_INPUTS=10000000 is the whole measure; a share of it here.
    let count = std::env::var("GRIDLIGHT_RANDOM_INPUTS").ok().and_then(|n| n.parse().ok()).unwrap_or(150_000);
    for brdf in all_rules() {
        let mut random = Random(15);
        for i in 0..count / 3 {
            let s = random.surface();
            let n = s.normal.as_dvec3();
            let t = s.tangent.as_dvec3();
            let free = direction(2.0 * random.next() - 1.0, TAU * random.next());
            let wo = match i % 8 {
                0 => n,
                1 => -n,
                2 => t,
                3 => (t + n * 1e-6).normalize(),
                4 => (t + n * 1e-3).normalize(),
                _ => free,
            };
            let mut u = random.three();
            if i % 5 == 0 {
                u = u.map(|x| if x < 0.5 { 0.0 } else { BELOW_ONE });
            }
            let inside = random.next() < 0.5;
            for sample in [brdf.sample_diffuse(&s, wo, u.truncate()), brdf.sample_specular(&s, wo, u, inside)]
            {
                let is_sound = good(sample.weight) && sample.pdf.is_finite() && sample.pdf >= 0.0;
                assert!(is_sound, "{s:?} {wo} {sample:?}");
                assert!((sample.wi.length() - 1.0).abs() < 1e-5);
                if sample.valid && !(sample.transmitted && sample.delta) {
                    // The frame's f32 rounding tilts the horizon by 1e-7.
                    assert!(
                        (sample.wi.dot(n) > -1e-6) != sample.transmitted || sample.wi.dot(n).abs() < 1e-6
                    );
                }
                let value = brdf.eval_side(&s, wo, sample.wi, inside);
                assert!(good(value.diffuse) && good(value.specular), "{s:?} {wo} {sample:?} {value:?}");
                assert!(value.pdf_diffuse.is_finite() && value.pdf_specular.is_finite());
            }
            if wo.dot(n) < 0.0 {
                assert!(!brdf.sample_specular(&s, wo, u, inside).valid, "no light below the horizon");
                assert_eq!(brdf.eval(&s, wo, free), Value::default());
            }
        }
    }
}
