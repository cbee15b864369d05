//! Makes `table.bin`: `cargo test -p frame --lib integrate -- --ignored`.

use super::*;
use crate::brdf::facets::{sample_normal, shadowing};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Facets that integrate one node: a rank-1 lattice, in which each has a height of its own.
const FACETS: usize = 2048;
/// `1 / rho` of R2: the turn from one facet to the next.
const TURN: f64 = 0.754_877_666_246_692_7;

/// Every facet that v sees: its share of the light that is reflected at all, and its cosine to v.
fn facets(v: DVec3, alpha: DVec2) -> impl Iterator<Item = (f64, f64)> {
    (0..FACETS).map(move |i| {
        let at = i as f64 + 0.5;
        let h = sample_normal(v, alpha, DVec2::new((at * TURN).fract(), at / FACETS as f64));
        let cosine = v.dot(h).clamp(0.0, 1.0);
        let l = 2.0 * cosine * h - v;
        (if l.z > 1e-9 { shadowing(v, l, alpha) } else { 0.0 }, cosine)
    })
}

/// E and B.
pub(in crate::brdf) fn energy(v: DVec3, alpha: DVec2) -> [f64; 2] {
    let sum = facets(v, alpha).fold([0.0; 2], |[e, b], (g, c)| [e + g, b + g * (1.0 - c).powi(5)]);
    sum.map(|s| s / FACETS as f64)
}

/// E, m and j of a node.
fn node(w: DVec3, alpha: DVec2) -> [f64; 3] {
    let along = (w.truncate() / alpha).extend(w.z);
    let v = along.normalize();
    let [e, b] = energy(v, alpha);
    let cosine = facets(v, alpha).map(|(g, c)| g * c).sum::<f64>() / FACETS as f64 / e;
    // The spread that gives B, by halving: B rises with it.
    let (mut low, mut high) = (-0.2, 5.0);
    for _ in 0..40 {
        let j: f64 = 0.5 * (low + high);
        let value = e * (1.0 + 5.0 * j * cosine).max(1e-9).powf(-1.0 / j);
        if value < b { low = j } else { high = j }
    }
    [e, cosine * along.length(), 0.5 * (low + high)]
}

/// Places between the nodes that the table is fitted to, and how often.
const PLACES: usize = 200_000;
const ROUNDS: usize = 40;
/// Errors below this are hardly taken up, those above are.
const ENOUGH: f64 = 0.002;

/// What the table should say at one place.
struct Place {
    around: Around,
    wanted: [f64; 2],
    /// Neither roughness is above 0.3.
    is_fine: bool,
}

impl Place {
    /// Even over roughnesses and azimuths; half of them seen from near the plane, where the table bends most.
    fn new(index: usize) -> Self {
        let draw = |k: u32| f64::from(crate::surface::hash(4 * index as u32 + k)) / 4_294_967_296.0;
        let alpha = DVec2::new(draw(0), draw(1)).powf(2.0).max(DVec2::splat(DELTA_ALPHA));
        let z = if index % 2 == 0 { draw(2).max(0.01) } else { 0.01 + 0.24 * draw(2).powi(2) };
        // An eighth at either axis.
        let turn = (1.25 * draw(3) - 0.125).clamp(0.0, 1.0);
        let (sin, cos) = (FRAC_PI_2 * turn).sin_cos();
        let radius = (1.0 - z * z).sqrt();
        let v = DVec3::new(radius * cos, radius * sin, z);
        Self { around: Around::new(v, alpha), wanted: energy(v, alpha), is_fine: alpha.max_element() < 0.09 }
    }
}

/// Moves the nodes so that what lies between them is right: values that are exact at nodes are all on one side elsewhere.
/// Kaczmarz's steps, one place after the other, large errors first by weight.
fn fit(values: &mut [f64]) {
    let places: Vec<Place> = (0..PLACES).map(Place::new).collect();
    for round in 0..ROUNDS {
        let rate = 0.5 * (1.0 - round as f64 / ROUNDS as f64) + 0.01;
        let mut worst = [0.0f64; 2];
        let mut squares = [0.0; 2];
        for Place { around, wanted, is_fine } in &places {
            let found = |values: &[f64]| {
                let parts = around.parts.iter().map(|part| part.read(|i| values[i]));
                parts.fold([0.0; 3], |sum, part| [sum[0] + part[0], sum[1] + part[1], sum[2] + part[2]])
            };
            let at = found(values);
            let both = around.both(at);
            let errors = [wanted[0] - both[0], wanted[1] - both[1]];
            for i in 0..2 {
                worst[i] = worst[i].max(errors[i].abs());
                squares[i] += errors[i] * errors[i];
            }
            // Small errors stay, and so does E where nearly nothing is lost: what is put back hangs on how little.
            let mut step = errors.map(|e| rate * e / (1.0 + (ENOUGH / e.abs().max(1e-9)).powi(4)));
            if *is_fine {
                step[0] = 0.0;
            }
            let slope = |k: usize| {
                let (h, mut moved) = (1e-4, at);
                moved[k] += h;
                (around.both(moved)[1] - both[1]) / h
            };
            // m is worth ten times what j is, whose values are as much larger.
            let (of_mean, of_spread) = (slope(1), 10.0 * slope(2));
            let length = of_mean * of_mean + of_spread * of_spread;
            let (for_mean, for_spread) = if length > 1e-8 {
                (step[1] * of_mean / length, 10.0 * step[1] * of_spread / length)
            } else {
                (0.0, 0.0)
            };
            let shares: f64 = around.parts.iter().map(|p| p.weight * p.weight).sum();
            for part in &around.parts {
                let share = part.weight / shares;
                let (parabola, line) = (part.parabola(), part.line());
                let of_parabola: f64 = parabola.iter().map(|x| x * x).sum();
                let of_line: f64 = line.iter().map(|x| x * x).sum();
                for i in 0..3 {
                    values[part.at + i] += step[0] * share * parabola[i] / of_parabola;
                    values[part.at + 3 + i] += for_mean * share * parabola[i] / of_parabola;
                }
                for i in 0..2 {
                    values[part.at + 6 + i] += for_spread * share * line[i] / of_line;
                }
            }
        }
        if round % 10 == 0 || round + 1 == ROUNDS {
            let root = squares.map(|s| (s / PLACES as f64).sqrt());
            println!(
                "round {round}: E {:.5}, worst {:.4}; B {:.5}, worst {:.4}",
                root[0], worst[0], root[1], worst[1]
            );
        }
    }
}

/// Pairs of alphas of so many roughnesses, in the order of the table.
fn alphas(count: usize) -> impl Iterator<Item = DVec2> {
    let least = DELTA_ALPHA.sqrt();
    let alpha = move |i: usize| (least + (1.0 - least) * i as f64 / (count - 1) as f64).powi(2);
    (0..count).flat_map(move |high| (0..=high).map(move |low| DVec2::new(alpha(low), alpha(high))))
}

/// Means over the hemisphere of the interpolated values, so that what is put back is what they say is lost.
fn means(table: &mut BrdfTable) {
    let first = PAIRS * HEIGHTS * NODE;
    for (i, alpha) in alphas(MEAN_ROUGHNESSES).enumerate() {
        let (rows, columns) = (96, 64);
        let (mut sum, mut whole) = ([0.0; 2], 0.0);
        for (row, column) in (0..rows).flat_map(|r| (0..columns).map(move |c| (r, c))) {
            // Denser near the plane: fine facets lose light only there.
            let t = (f64::from(row) + 0.5) / f64::from(rows);
            let (z, weight) = (t * t, t.powi(3));
            let (sin, cos) = (TAU * (f64::from(column) + 0.5) / f64::from(columns)).sin_cos();
            let radius = (1.0 - z * z).sqrt();
            let [e, b] = table.energy(DVec3::new(radius * cos, radius * sin, z), alpha);
            sum = [sum[0] + weight * (1.0 - e).max(0.0), sum[1] + weight * b];
            whole += weight;
        }
        let [lost, grazing] = sum.map(|s| s / whole);
        table.values[first + MEAN * i] = f16::from_f64(lost.powf(0.25));
        table.values[first + MEAN * i + 1] = f16::from_f64(grazing);
    }
}

#[test]
#[ignore = "writes the table that the program carries"]
fn integrate() {
    let mut values = Vec::with_capacity(VALUES);
    for alpha in alphas(ROUGHNESSES) {
        for row in 0..HEIGHTS {
            let z = (FRAC_PI_2 * row as f64 / (HEIGHTS - 1) as f64).sin().powi(2).max(1e-4);
            let radius = (1.0 - z * z).sqrt();
            let nodes = [0.0, 0.5, 1.0]
                .map(|x: f64| node(DVec3::new(radius * x.sqrt(), radius * (1.0 - x).sqrt(), z), alpha));
            values.extend(nodes.map(|n| n[0]));
            values.extend(nodes.map(|n| n[1]));
            values.extend([nodes[0][2], nodes[2][2]]);
        }
    }
    fit(&mut values);
    values.resize(VALUES, 0.0);
    let mut table = BrdfTable { values: values.into_iter().map(f16::from_f64).collect() };
    means(&mut table);
    let bytes: Vec<u8> = table.values.iter().flat_map(|v| v.to_le_bytes()).collect();
    std::fs::write(concat!(env!("CARGO_MANIFEST_DIR"), "/src/brdf/energy/table.bin"), bytes)
        .expect("the folder of the sources is there");
}
