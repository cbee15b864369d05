//! Structural similarity of the display picture (Wang, Bovik, Sheikh, Simoncelli 2004).
//!
//! `(2 m_r m_t + C1)(2 s_rt + C2) / ((m_r^2 + m_t^2 + C1)(s_r^2 + s_t^2 + C2))` per pixel and channel, with means m,
//! variances s^2 and covariance s_rt under a Gaussian of standard deviation 1.5 pixels over 11x11, C1 = 0.01^2,
//! C2 = 0.03^2; the mean over channels and all pixels whose window lies inside. As scikit-image's
//! `structural_similarity(gaussian_weights=True, sigma=1.5, use_sample_covariance=False, data_range=1)`. Departs from
//! the paper, which looks at luma only.

use super::display::coded;
use super::separable::both;
use super::{MetricError, comparable};
use frame::cpu::Image;

/// Pixels.
const SIGMA: f32 = 1.5;
/// Pixels; the window is twice this and one.
const RADIUS: usize = 5;
/// Keep the quotient defined in black and in flat regions.
const STABILIZERS: [f64; 2] = [0.01 * 0.01, 0.03 * 0.03];

/// Mean structural similarity through the sRGB curve; none for pictures smaller than the window of 11x11.
///
/// # Errors
/// Sizes differ, or there are no pixels.
pub fn ssim(
    reference: &Image<[f32; 3]>,
    test: &Image<[f32; 3]>,
    exposure_stops: f32,
) -> Result<Option<f64>, MetricError> {
    comparable(reference, test)?;
    let [width, height] = reference.size().map(|side| side as usize);
    if width.min(height) <= 2 * RADIUS {
        return Ok(None);
    }
    let [reference, test] = [reference, test].map(|picture| coded(picture, exposure_stops));
    let taps = gaussian();
    let blurred = |value: &dyn Fn([f32; 3], [f32; 3]) -> f32| {
        let plane: Vec<f32> =
            reference.texels().iter().zip(test.texels()).map(|(r, t)| value(*r, *t)).collect();
        both(&plane, width, &taps)
    };
    let mut sum = 0.0;
    for c in 0..3 {
        let moments = [
            blurred(&|r, _| r[c]),
            blurred(&|_, t| t[c]),
            blurred(&|r, _| r[c] * r[c]),
            blurred(&|_, t| t[c] * t[c]),
            blurred(&|r, t| r[c] * t[c]),
        ];
        let at = |index: usize| similarity(moments.each_ref().map(|plane| f64::from(plane[index])));
        for y in RADIUS..height - RADIUS {
            sum += (y * width + RADIUS..(y + 1) * width - RADIUS).map(at).sum::<f64>();
        }
    }
    let windows = 3 * (width - 2 * RADIUS) * (height - 2 * RADIUS);
    Ok(Some(sum / windows as f64))
}

/// From means of r, t, r^2, t^2 and rt.
fn similarity([r, t, rr, tt, rt]: [f64; 5]) -> f64 {
    let [c1, c2] = STABILIZERS;
    let (variances, covariance) = (rr - r * r + tt - t * t, rt - r * t);
    (2.0 * r * t + c1) * (2.0 * covariance + c2) / ((r * r + t * t + c1) * (variances + c2))
}

/// Weights that sum to 1.
fn gaussian() -> [f32; 2 * RADIUS + 1] {
    let raw: [f32; 2 * RADIUS + 1] =
        std::array::from_fn(|i| (-0.5 * ((i as f32 - RADIUS as f32) / SIGMA).powi(2)).exp());
    let sum: f32 = raw.iter().sum();
    raw.map(|weight| weight / sum)
}
