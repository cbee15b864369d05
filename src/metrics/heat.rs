//! Maps of error as pictures to look at.

use frame::cpu::Image;
use frame::surface::linear_from_srgb;

/// An error map of 0..1 (outside: clamped) in the colours of `magma` (van der Walt and Smith, 2015), black over red to
/// pale yellow, the map FLIP's authors use. The colours are linear, like every picture here: the PNG writer's sRGB curve
/// brings the map's own codes back.
pub fn magma(errors: &Image<f32>) -> Image<[f32; 3]> {
    errors.map(magma_color)
}

/// One value of [`magma`].
pub fn magma_color(error: f32) -> [f32; 3] {
    let color = colorous::MAGMA.eval_continuous(f64::from(error));
    [color.r, color.g, color.b].map(|code| linear_from_srgb(f32::from(code) / 255.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use frame::surface::srgb_from_linear;

    #[test]
    fn the_ends_are_those_of_the_map_and_brightness_grows() {
        let map = magma(&Image::from_fn([101, 1], |x, _| x as f32 / 100.0));
        let codes = |texel: [f32; 3]| texel.map(|v| (255.0 * srgb_from_linear(v)).round());
        assert_eq!(codes(map.texels()[0]), [0.0, 0.0, 4.0]);
        assert_eq!(codes(map.texels()[100]), [252.0, 253.0, 191.0]);
        let luminances: Vec<f32> = map.texels().iter().map(|t| frame::cpu::luminance(*t)).collect();
        assert!(luminances.is_sorted(), "{luminances:?}");
        let outside = magma(&Image::filled([1, 1], 7.0));
        assert_eq!(outside.texels()[0], map.texels()[100]);
    }
}
