//! Makes `table.bin`: `cargo test -p frame --lib integrate -- --ignored`.

use super::*;
use crate::brdf::facets::{sample_normal, shadowing};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Facets that integrate one node: a rank-1 lattice, in which each has a height of its own.
const FACETS: usize = 4096;
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

#[test]
#[ignore = "writes the table that the program carries"]
fn integrate() {
    let least = DELTA_ALPHA.sqrt();
    let alphas = |count: usize| {
        let alpha = move |i: usize| (least + (1.0 - least) * i as f64 / (count - 1) as f64).powi(2);
        (0..count).flat_map(move |high| (0..=high).map(move |low| DVec2::new(alpha(low), alpha(high))))
    };
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
    values.resize(VALUES, 0.0);
    let mut table = BrdfTable { values: values.into_iter().map(f16::from_f64).collect() };
    // Of the interpolated values, so that what is put back is what they say is lost.
    let first = PAIRS * HEIGHTS * NODE;
    for (i, alpha) in alphas(MEAN_ROUGHNESSES).enumerate() {
        let (rows, columns) = (96, 64);
        let mut sum = [0.0; 2];
        for (row, column) in (0..rows).flat_map(|r| (0..columns).map(move |c| (r, c))) {
            let z = ((f64::from(row) + 0.5) / f64::from(rows)).sqrt();
            let (sin, cos) = (TAU * (f64::from(column) + 0.5) / f64::from(columns)).sin_cos();
            let radius = (1.0 - z * z).sqrt();
            let [e, b] = table.energy(DVec3::new(radius * cos, radius * sin, z), alpha);
            sum = [sum[0] + (1.0 - e).max(0.0), sum[1] + b];
        }
        let [lost, grazing] = sum.map(|s| s / f64::from(rows * columns));
        table.values[first + MEAN * i] = f16::from_f64(lost.powf(0.25));
        table.values[first + MEAN * i + 1] = f16::from_f64(grazing);
    }
    let bytes: Vec<u8> = table.values.iter().flat_map(|v| v.to_le_bytes()).collect();
    std::fs::write(concat!(env!("CARGO_MANIFEST_DIR"), "/src/brdf/energy/table.bin"), bytes)
        .expect("the folder of the sources is there");
}
