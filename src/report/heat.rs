//! A picture of where the error is: each pixel's relative error on a log scale, dark to bright.
//!
//! A pixel's error is sqrt(mean over channels of (x - r)^2 / (r^2 + 0.01)), the root of its share in relMSE. 1 % is
//! black, 1,000 % is pale yellow, and each factor of ten takes a third of the scale ("magma" of matplotlib, which keeps
//! its order in grey and for colour-blind eyes). A pixel that is no number is green, a colour the scale does not have.

use crate::metrics::magma_color;
use frame::cpu::Image;

/// log10 of the errors at the two ends of the scale.
pub const HEAT_DECADES: [f32; 2] = [-2.0, 1.0];

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

fn color(error: f32) -> [f32; 3] {
    if !error.is_finite() {
        return [0.0, 1.0, 0.0];
    }
    let [low, high] = HEAT_DECADES;
    magma_color(((error.log10() - low) / (high - low)).clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_of_the_scale_and_what_is_no_number() {
        assert_eq!(color(0.0), magma_color(0.0));
        assert_eq!(color(0.01), magma_color(0.0));
        assert_eq!(color(1e6), magma_color(1.0));
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
