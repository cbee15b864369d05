//! Gives every decision of every path its own random number, without state.
//!
//! Paper: "A 512x512 random texture covers the space skewed along the z-axis" (section 2).
//!
//! In: pixel, index of the sample over all frames, block (one per bounce and purpose), the frame's seed. Out: numbers in
//! [0, 1) on a grid of 2^-24.
//!
//! Formula: `pcg4d(pixel, sample, block, seed) >> 8`. The direction of the first bounce is stratified over the samples:
//! `fract(rotation(pixel) + sample * (1/rho, 1/rho^2))`, rho = 1.32471796 (R2).
//!
//! Departs from the paper: its texture gives neighbouring pixels one number where a texel covers them, which costs 3.8
//! times the error after a blur (measured in the design, F7); the texture itself comes with the issue about light. R2
//! is applied to the first bounce alone: rotated copies of one sequence in later dimensions would be correlated with
//! it, and a pixel of many samples would converge to a wrong value.

/// Functions `noise_at` and `noise_stratified`.
pub const WGSL: &str = include_str!("noise.inc.wgsl");

/// The shader's hash.
pub fn pcg4d(input: [u32; 4]) -> [u32; 4] {
    let mut v = input.map(|x| x.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
    let round = |v: &mut [u32; 4]| {
        v[0] = v[0].wrapping_add(v[1].wrapping_mul(v[3]));
        v[1] = v[1].wrapping_add(v[2].wrapping_mul(v[0]));
        v[2] = v[2].wrapping_add(v[0].wrapping_mul(v[1]));
        v[3] = v[3].wrapping_add(v[1].wrapping_mul(v[2]));
    };
    round(&mut v);
    v = v.map(|x| x ^ (x >> 16));
    round(&mut v);
    v
}

/// Four independent numbers in [0, 1).
pub fn at(pixel: [u32; 2], sample: u32, block: u32, seed: u32) -> [f32; 4] {
    pcg4d([pixel[0] | (pixel[1] << 16), sample, block, seed]).map(unit)
}

/// The first two numbers of a pixel's sample.
pub fn stratified(pixel: [u32; 2], sample: u32, seed: u32) -> [f32; 2] {
    let rotation = pcg4d([pixel[0] | (pixel[1] << 16), u32::MAX, 0, seed]);
    // 2^32 / rho and 2^32 / rho^2.
    [(rotation[0], 3_242_174_889), (rotation[1], 2_447_445_414)]
        .map(|(r, step): (u32, u32)| unit(r.wrapping_add(sample.wrapping_mul(step))))
}

fn unit(bits: u32) -> f32 {
    (bits >> 8) as f32 * (1.0 / 16_777_216.0)
}

#[cfg(test)]
mod tests {
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
}
