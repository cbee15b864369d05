//! Is energy kept, and does the table say so?

use super::*;

/// Roughnesses of the grid of pairs, both ends among them.
const ROUGHNESSES: [f64; 7] = [0.0, 0.1, 0.25, 0.4, 0.6, 0.8, 1.0];
const COSINES: [f64; 5] = [0.02, 0.1, 0.3, 0.6, 1.0];

fn of_roughness(t: f64, b: f64) -> Surface {
    Surface { roughness: DVec2::new(t, b).as_vec2(), ..Surface::default() }
}

/// Mean weight of both lobes under a sky of radiance 1, the specular one over n^3 strata in all. Refraction's squeeze is
/// taken out.
fn furnace(brdf: &Brdf<'_>, s: &Surface, wo: DVec3, inside: bool, n: u32) -> f64 {
    let mut random = Random(n);
    let (mut specular, mut diffuse) = (0.0, 0.0);
    let eta = if inside { ior(f64::from(s.f0)) } else { 1.0 / ior(f64::from(s.f0)) };
    for i in 0..n * n * n {
        let stratum = DVec3::new(f64::from(i % n), f64::from(i / n % n), f64::from(i / n / n));
        let u = (stratum + random.three()) / f64::from(n);
        let sample = brdf.sample_specular(s, wo, u.min(DVec3::splat(BELOW_ONE)), inside);
        if sample.valid {
            let bent = sample.transmitted && !s.thin && s.f0 > 0.0;
            specular += sample.weight.x / if bent { eta * eta } else { 1.0 };
        }
        if i < n * n {
            let sample = brdf.sample_diffuse(s, wo, u.truncate());
            diffuse += if sample.valid { sample.weight.x } else { 0.0 };
        }
    }
    specular / f64::from(n * n * n) + diffuse / f64::from(n * n)
}

/// The worst distance from 1 over all pairs, angles and three azimuths.
fn worst(make: impl Fn(f64, f64) -> Surface, inside: bool, n: u32) -> [(f64, String); 2] {
    let brdf = Brdf::new(&TABLE);
    // Of all; of those not seen edge-on with a fine roughness across a coarse one.
    let mut worst = [(0.0, String::new()), (0.0, String::new())];
    for (t, b) in ROUGHNESSES.iter().flat_map(|t| ROUGHNESSES.iter().map(move |b| (*t, *b))) {
        for (cosine, turn) in COSINES.iter().flat_map(|c| [0.0, 0.07, 0.25].map(|turn| (*c, turn))) {
            let mean = |n| furnace(&brdf, &make(t, b), direction(cosine, TAU * turn), inside, n);
            // What stands out is looked at again, with less noise.
            let once = mean(n);
            let found = if (once - 1.0).abs() > 0.004 { mean(2 * n + 1) } else { once };
            let error = (found - 1.0).abs();
            let is_odd = cosine < 0.2 && (t - b).abs() > 0.3;
            for (i, worst) in worst.iter_mut().enumerate() {
                if (i == 0 || !is_odd) && error > worst.0 {
                    *worst =
                        (error, format!("{found:.4} at roughness {t}, {b}, cosine {cosine}, turn {turn}"));
                }
            }
        }
    }
    worst
}

#[test]
fn white_metal_is_white_for_every_pair_of_roughnesses() {
    let [(error, place), _] = worst(|t, b| Surface { metalness: 1.0, ..of_roughness(t, b) }, false, 16);
    println!("white metal: {place}");
    // What is asked for: 0.004 is the table's own between its nodes; 36,000 strata leave less than 0.001.
    assert!(error < 0.005, "{place}");
}

#[test]
fn white_plastic_is_white_for_every_pair_of_roughnesses() {
    for f0 in [0.02, 0.04, 0.16] {
        let [(all, place), (most, place_of_most)] =
            worst(|t, b| Surface { f0, ..of_roughness(t, b) }, false, 16);
        println!("plastic of F0 {f0}: {place}; {place_of_most}");
        // B is off by up to 0.03 for scratches seen edge-on, and by less than 0.01 elsewhere.
        assert!(all < 0.03 && most < 0.012, "F0 {f0}: {place}; {place_of_most}");
    }
}

#[test]
fn clear_glass_is_clear_for_every_pair_of_roughnesses() {
    for inside in [false, true] {
        for thin in [false, true] {
            let make = |t, b| Surface { f0: 0.04, transmission: 1.0, thin, ..of_roughness(t, b) };
            let [(error, place), _] = worst(make, inside, 8);
            println!("glass, inside {inside}, thin {thin}: {place}");
            // By construction: a sample's weight is 1 whichever way it goes.
            assert!(error < 1e-9, "{place}");
        }
    }
}

#[test]
fn the_table_is_the_integral() {
    let mut random = Random(11);
    let mut errors = [const { Vec::new() }; 2];
    for i in 0..400 {
        let ends = |x: f64| if x < 0.1 { 0.0 } else { x.min(1.0) };
        let alpha = DVec2::new(ends(random.next() * 1.1), ends(random.next() * 1.1))
            .powf(2.0)
            .max(DVec2::splat(1e-3));
        let mu = if i % 3 == 0 { 0.1 * random.next() } else { random.next() }.max(0.01);
        let v = direction(mu, TAU * random.next());
        let (found, wanted) = (TABLE.energy(v, alpha), energy(alpha, v));
        for channel in 0..2 {
            errors[channel].push((found[channel] - wanted[channel]).abs());
        }
    }
    let mut at = |channel: usize, share: f64| {
        errors[channel].sort_by(f64::total_cmp);
        errors[channel][(share * 399.0) as usize]
    };
    println!("E: 90 % {:.4}, worst {:.4}", at(0, 0.9), at(0, 1.0));
    println!("B: 90 % {:.4}, worst {:.4}", at(1, 0.9), at(1, 1.0));
    // What the furnace may be off by, and what the folder's text says of B.
    assert!(at(0, 1.0) < 0.005 && at(1, 0.9) < 0.007 && at(1, 1.0) < 0.035);
    // The means are those of the values in between.
    for alpha in [DVec2::splat(0.3), DVec2::new(0.02, 0.7)] {
        let mut sum = 0.0;
        for i in 0..10_000 {
            let z = ((f64::from(i / 100) + 0.5) / 100.0).sqrt();
            sum += TABLE.energy(direction(z, TAU * f64::from(i % 100) / 100.0), alpha)[0] / 1e4;
        }
        let [mean, _] = TABLE.energy_mean(alpha);
        assert!((mean - sum).abs() < 0.002, "{alpha}: {mean} {sum}");
    }
}
