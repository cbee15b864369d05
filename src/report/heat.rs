//! A picture of where the error is: each pixel's relative error on a log scale, dark to bright.
//!
//! A pixel's error is sqrt(mean over channels of (x - r)^2 / (r^2 + 0.01)), the root of its share in relMSE. 1 % is
//! black, 1,000 % is pale yellow, and each factor of ten takes a third of the scale ("magma" of matplotlib, which keeps
//! its order in grey and for colour-blind eyes). A pixel that is no number is green, a colour the scale does not have.

use frame::cpu::Image;
use frame::surface::linear_from_srgb;

/// log10 of the errors at the two ends of the scale.
pub const HEAT_DECADES: [f32; 2] = [-2.0, 1.0];

/// Nine stops of magma, 8-bit sRGB; the page's legend has the same.
const MAGMA: [[u8; 3]; 9] = [
    [0, 0, 4],
    [28, 16, 68],
    [79, 18, 123],
    [129, 37, 129],
    [181, 54, 122],
    [229, 80, 100],
    [251, 135, 97],
    [254, 194, 135],
    [252, 253, 191],
];

/// Error of linear radiance against a reference of the same size; none where the sizes differ. The colours are linear,
/// for [`crate::output::color_png`] to write at exposure 0.
pub fn heat_map(picture: &Image<[f32; 3]>, reference: &Image<[f32; 3]>) -> Option<Image<[f32; 3]>> {
    let colors = picture.texels().iter().zip(reference.texels()).map(|(x, r)| color(error(*x, *r)));
    (picture.size() == reference.size())
        .then(|| Image::from_texels(picture.size(), colors.collect()))
        .flatten()
}

fn error(picture: [f32; 3], reference: [f32; 3]) -> f32 {
    let squares = picture.into_iter().zip(reference).map(|(x, r)| (x - r).powi(2) / (r * r + 0.01));
    (squares.sum::<f32>() / 3.0).sqrt()
}

/// Straight between the stops in sRGB, as the legend's gradient is.
fn color(error: f32) -> [f32; 3] {
    if !error.is_finite() {
        return [0.0, 1.0, 0.0];
    }
    let [low, high] = HEAT_DECADES;
    let at = ((error.log10() - low) / (high - low)).clamp(0.0, 1.0) * (MAGMA.len() - 1) as f32;
    let stop = |i: f32| MAGMA.get(i as usize).copied().unwrap_or_default();
    let (below, above) = (stop(at.floor()), stop(at.ceil()));
    let mix = |a: u8, b: u8| f32::from(a) + (f32::from(b) - f32::from(a)) * at.fract();
    [0, 1, 2].map(|c| linear_from_srgb(mix(below[c], above[c]) / 255.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_of_the_scale_and_what_is_no_number() {
        let srgb = |bytes: [u8; 3]| bytes.map(|b| linear_from_srgb(f32::from(b) / 255.0));
        assert_eq!(color(0.0), srgb(MAGMA[0]));
        assert_eq!(color(0.01), srgb(MAGMA[0]));
        assert_eq!(color(1e6), srgb(MAGMA[8]));
        assert_eq!(color(f32::NAN), [0.0, 1.0, 0.0]);
    }

    #[test]
    fn the_error_of_a_pixel_is_its_share_in_rel_mse() {
        // (0.7 - 0.2)^2 / (0.2^2 + 0.01) = 5 in one of three channels.
        let expected = (5.0f32 / 3.0).sqrt();
        let error = error([0.7, 0.3, 0.5], [0.2, 0.3, 0.5]);
        // A few roundings in f32.
        assert!((error - expected).abs() < 1e-5, "{error} {expected}");
    }

    #[test]
    fn sizes_must_agree() {
        let image = |size| Image::filled(size, [1.0f32; 3]);
        assert!(heat_map(&image([2, 3]), &image([3, 2])).is_none());
        assert_eq!(heat_map(&image([2, 3]), &image([2, 3])).map(|h| h.size()), Some([2, 3]));
    }
}
