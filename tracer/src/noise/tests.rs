#![allow(clippy::unwrap_used, clippy::panic)]

mod gpu;
mod mask;

use super::*;

/// Chi-square of a histogram against a flat one, in standard deviations of the statistic (2 * degrees, normal
/// approximation).
fn deviation(counts: &[u32]) -> f64 {
    let total: u32 = counts.iter().sum();
    let expected = f64::from(total) / counts.len() as f64;
    let statistic: f64 = counts.iter().map(|c| (f64::from(*c) - expected).powi(2) / expected).sum();
    let degrees = counts.len() as f64 - 1.0;
    (statistic - degrees) / (2.0 * degrees).sqrt()
}

/// Five deviations: once in some three million runs of a right generator; the inputs are fixed, so it never flips.
const LIMIT: f64 = 5.0;

#[test]
fn neighbours_in_every_input_are_independent_and_flat() {
    // Pairs of numbers at keys that differ by one in one input: a 16x16 histogram sees both marginals and the
    // correlation.
    for varied in 0..4 {
        let mut counts = [0u32; 256];
        for i in 0..65_536u32 {
            let mut key = [i % 256, i / 256, 7, 3];
            let a = at([key[0], key[1]], key[2], key[3], 1)[0];
            key[varied] += 1;
            let b = at([key[0], key[1]], key[2], key[3], 1)[0];
            counts[(a * 16.0) as usize * 16 + (b * 16.0) as usize] += 1;
        }
        let deviation = deviation(&counts);
        assert!(deviation.abs() < LIMIT, "input {varied}: {deviation} deviations from flat");
    }
}

#[test]
fn stratified_samples_fill_the_square() {
    // 256 samples of one pixel leave no cell of an 8x8 grid with fewer than 3 or more than 5 of its 4: R2's
    // discrepancy; independent numbers would leave some cell empty.
    for pixel in [[0, 0], [17, 5], [639, 479]] {
        let mut counts = [0u32; 64];
        for sample in 0..256 {
            let [x, y] = stratified(pixel, sample, 1);
            counts[(x * 8.0) as usize * 8 + (y * 8.0) as usize] += 1;
        }
        let (least, most) = (counts.iter().min(), counts.iter().max());
        assert!(least >= Some(&2) && most <= Some(&6), "{pixel:?}: {least:?}..{most:?} of 4 expected");
    }
}
