//! What a display shows of radiance, and the oldest measure on it.

use super::{MetricError, comparable};
use frame::cpu::Image;
use frame::surface::srgb_from_linear;

/// Radiance times 2^`exposure_stops`, clamped to 0..1: linear, as the display emits it.
pub(super) fn emitted(picture: &Image<[f32; 3]>, exposure_stops: f32) -> Image<[f32; 3]> {
    let exposure = exposure_stops.exp2();
    picture.map(|texel| texel.map(|radiance| (radiance * exposure).clamp(0.0, 1.0)))
}

/// The same through the sRGB curve, as files hold it.
pub(super) fn coded(picture: &Image<[f32; 3]>, exposure_stops: f32) -> Image<[f32; 3]> {
    emitted(picture, exposure_stops).map(|texel| texel.map(srgb_from_linear))
}

/// Peak signal to noise of the display picture through the sRGB curve: `10 log10(1 / mean((t - r)^2))` decibels; none
/// where there is no difference.
///
/// # Errors
/// Sizes differ, or there are no pixels.
pub fn psnr(
    reference: &Image<[f32; 3]>,
    test: &Image<[f32; 3]>,
    exposure_stops: f32,
) -> Result<Option<f64>, MetricError> {
    comparable(reference, test)?;
    let root = super::rmse(&coded(reference, exposure_stops), &coded(test, exposure_stops))?;
    Ok((root > 0.0).then(|| -20.0 * root.log10()))
}
