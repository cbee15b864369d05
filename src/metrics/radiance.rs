//! Errors of linear radiance, as it is: no exposure, no clamp.

use super::{MetricError, comparable};
use frame::cpu::Image;

/// What keeps relative errors finite where the reference is black: (0.1 W / (sr m^2))^2 in squared errors.
const EPSILON: f64 = 0.01;

/// Pixels along a tile's side.
const TILE: u32 = 16;

/// Share of tiles that `worst_tile` leaves below it.
const TILE_SHARE: f64 = 0.99;

/// Mean over pixels and channels of something about (r, t).
fn mean(
    reference: &Image<[f32; 3]>,
    test: &Image<[f32; 3]>,
    of: impl Fn(f64, f64) -> f64,
) -> Result<f64, MetricError> {
    comparable(reference, test)?;
    let values = reference.texels().as_flattened().iter().zip(test.texels().as_flattened());
    let sum: f64 = values.map(|(r, t)| of(f64::from(*r), f64::from(*t))).sum();
    Ok(sum / (3 * reference.texels().len()) as f64)
}

/// `(t - r)^2 / (r^2 + epsilon)`.
fn squared_relative(r: f64, t: f64) -> f64 {
    (t - r).powi(2) / (r * r + EPSILON)
}

/// `sqrt(mean((t - r)^2))`.
///
/// # Errors
/// Sizes differ, or there are no pixels.
pub fn rmse(reference: &Image<[f32; 3]>, test: &Image<[f32; 3]>) -> Result<f64, MetricError> {
    mean(reference, test, |r, t| (t - r).powi(2)).map(f64::sqrt)
}

/// `mean((t - r)^2 / (r^2 + 0.01))`.
///
/// # Errors
/// Sizes differ, or there are no pixels.
pub fn rel_mse(reference: &Image<[f32; 3]>, test: &Image<[f32; 3]>) -> Result<f64, MetricError> {
    mean(reference, test, squared_relative)
}

/// `mean(2 |t - r| / (|t| + |r| + 0.01))`.
///
/// # Errors
/// Sizes differ, or there are no pixels.
pub fn smape(reference: &Image<[f32; 3]>, test: &Image<[f32; 3]>) -> Result<f64, MetricError> {
    mean(reference, test, |r, t| 2.0 * (t - r).abs() / (t.abs() + r.abs() + EPSILON))
}

/// Mean of the test over mean of the reference, per channel; none where the reference's mean is 0.
///
/// # Errors
/// Sizes differ, or there are no pixels.
pub fn bias(reference: &Image<[f32; 3]>, test: &Image<[f32; 3]>) -> Result<[Option<f64>; 3], MetricError> {
    comparable(reference, test)?;
    let sum =
        |picture: &Image<[f32; 3]>, c: usize| picture.texels().iter().map(|p| f64::from(p[c])).sum::<f64>();
    Ok([0, 1, 2].map(|c| {
        let of_reference = sum(reference, c);
        (of_reference != 0.0).then(|| sum(test, c) / of_reference)
    }))
}

/// Relative squared error beyond what noise explains: `mean(((t - r)^2 - s_t^2 - s_r^2) / (r^2 + 0.01))`, with the
/// standard errors of both pictures per pixel and channel. Around 0 for two estimates of one picture, so it may be
/// below 0.
///
/// # Errors
/// Sizes differ, or there are no pixels.
pub fn excess_rel_mse(
    reference: &Image<[f32; 3]>,
    test: &Image<[f32; 3]>,
    stderr_reference: &Image<[f32; 3]>,
    stderr_test: &Image<[f32; 3]>,
) -> Result<f64, MetricError> {
    let total = rel_mse(reference, test)?;
    let noise = |stderr| mean(reference, stderr, |r, s| s * s / (r * r + EPSILON));
    Ok(total - noise(stderr_reference)? - noise(stderr_test)?)
}

/// `rel_mse` of each tile of 16x16 pixels (at the right and lower border of what is left of one), and of these the 99th
/// percentile: the smallest that at least 99 % of the tiles do not exceed. Finds a broken corner that a mean hides.
///
/// # Errors
/// Sizes differ, or there are no pixels.
pub fn worst_tile(reference: &Image<[f32; 3]>, test: &Image<[f32; 3]>) -> Result<f64, MetricError> {
    comparable(reference, test)?;
    let [width, height] = reference.size();
    let columns = width.div_ceil(TILE);
    // Sum and number of pixel-channels of each tile.
    let mut tiles = vec![(0.0, 0u32); (columns * height.div_ceil(TILE)) as usize];
    for (index, (r, t)) in reference.texels().iter().zip(test.texels()).enumerate() {
        let [x, y] = [index as u32 % width, index as u32 / width];
        let (sum, count) = &mut tiles[(y / TILE * columns + x / TILE) as usize];
        *sum += (0..3).map(|c| squared_relative(f64::from(r[c]), f64::from(t[c]))).sum::<f64>();
        *count += 3;
    }
    let mut means: Vec<f64> = tiles.into_iter().map(|(sum, count)| sum / f64::from(count)).collect();
    means.sort_by(f64::total_cmp);
    let rank = (TILE_SHARE * means.len() as f64).ceil() as usize;
    Ok(means[rank.clamp(1, means.len()) - 1])
}
