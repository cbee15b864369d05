//! From numbers to something to look at: exposure, one channel, false colour, marks for what is no radiance.
//!
//! In: linear radiance or errors on the CPU. Out: sRGB codes for the screen. Codes come from a table over the upper bits of
//! a float (10 of its mantissa, what a stored half float has), within half a code of the curve.

use crate::session::{Channel, Development};
use crate::worker::{Meaning, Output};
use egui::{Color32, ColorImage};
use frame::cpu::{Image, luminance};
use frame::surface::srgb_from_linear;
use gridlight::metrics::magma_color;
use std::sync::LazyLock;

/// Below this the code is 0: 2^-13 is 0.4 of a code on the curve's straight part.
const LEAST: f32 = 1.0 / 8192.0;

/// Mantissa bits that do not matter.
const DROPPED_BITS: u32 = 13;

/// Stops that false colour spans, middle at 0.18.
const STOPS: f32 = 8.0;

/// NaN.
const NOT_A_NUMBER: Color32 = Color32::from_rgb(255, 0, 255);
/// Infinite.
const INFINITE: Color32 = Color32::from_rgb(0, 255, 255);
/// Below 0.
const NEGATIVE: Color32 = Color32::from_rgb(0, 255, 0);

static CODES: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let first = LEAST.to_bits() >> DROPPED_BITS;
    let last = 1f32.to_bits() >> DROPPED_BITS;
    let half_a_step = 1 << (DROPPED_BITS - 1);
    let code = |bits: u32| {
        let linear = f32::from_bits((bits << DROPPED_BITS) + half_a_step).min(1.0);
        (255.0 * srgb_from_linear(linear)).round() as u8
    };
    (first..=last).map(code).collect()
});

static MAGMA: LazyLock<[Color32; 256]> = LazyLock::new(|| {
    std::array::from_fn(|i| {
        let [r, g, b] = magma_color(i as f32 / 255.0).map(code);
        Color32::from_rgb(r, g, b)
    })
});

/// The sRGB code of a linear value.
fn code(linear: f32) -> u8 {
    if linear >= 1.0 {
        return 255;
    }
    let index = (linear.max(LEAST).to_bits() - LEAST.to_bits()) >> DROPPED_BITS;
    if linear < LEAST { 0 } else { CODES.get(index as usize).copied().unwrap_or(255) }
}

fn magma(share: f32) -> Color32 {
    MAGMA[(255.0 * share.clamp(0.0, 1.0)) as usize]
}

fn grey(value: f32) -> Color32 {
    Color32::from_gray(code(value))
}

/// A picture of radiance.
pub fn develop(radiance: &Image<[f32; 3]>, development: &Development) -> ColorImage {
    let exposure = development.exposure_stops.exp2();
    color_image(radiance, |texel| {
        if development.mark_strange
            && let Some(mark) = strange(texel)
        {
            return mark;
        }
        let [r, g, b] = texel.map(|v| if v.is_nan() { 0.0 } else { v * exposure });
        if development.false_color {
            let stops = (luminance([r, g, b]).max(1e-12) / 0.18).log2();
            return magma(0.5 + stops / STOPS);
        }
        match development.channel {
            Channel::Color => Color32::from_rgb(code(r), code(g), code(b)),
            Channel::Red => grey(r),
            Channel::Green => grey(g),
            Channel::Blue => grey(b),
            Channel::Luminance => grey(luminance([r, g, b])),
        }
    })
}

/// A mark for what is no radiance.
fn strange(texel: [f32; 3]) -> Option<Color32> {
    if texel.iter().any(|v| v.is_nan()) {
        Some(NOT_A_NUMBER)
    } else if texel.iter().any(|v| v.is_infinite()) {
        Some(INFINITE)
    } else if texel.iter().any(|v| *v < 0.0) {
        Some(NEGATIVE)
    } else {
        None
    }
}

/// What a pass wrote, if it has a place on the screen.
pub fn develop_output(output: &Output, development: &Development) -> Option<ColorImage> {
    let texels = output.texels.as_ref()?;
    Some(match output.meaning {
        Meaning::Radiance => develop(texels, development),
        // What a share is does not depend on the light.
        Meaning::Share => {
            develop(texels, &Development { exposure_stops: 0.0, false_color: false, ..*development })
        }
        Meaning::Amount => {
            let largest =
                texels.texels().iter().map(|t| t[0]).filter(|v| v.is_finite()).fold(1e-12, f32::max);
            color_image(texels, |[v, ..]| if v.is_finite() { magma(v / largest) } else { NOT_A_NUMBER })
        }
    })
}

/// A map of error, `full` in the brightest colour.
pub fn heat(errors: &Image<f32>, full: f32) -> ColorImage {
    color_image(errors, |error| if error.is_finite() { magma(error / full) } else { NOT_A_NUMBER })
}

/// How far b is from a, per channel.
pub fn difference(a: &Image<[f32; 3]>, b: &Image<[f32; 3]>) -> Image<[f32; 3]> {
    let mut others = b.texels().iter();
    a.map(|a| {
        let b = others.next().copied().unwrap_or(a);
        [0, 1, 2].map(|c| (a[c] - b[c]).abs())
    })
}

fn color_image<T: Copy>(image: &Image<T>, color: impl FnMut(T) -> Color32) -> ColorImage {
    let size = image.size().map(|side| side as usize);
    ColorImage::new(size, image.texels().iter().copied().map(color).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one(texel: [f32; 3], development: Development) -> Color32 {
        develop(&Image::filled([1, 1], texel), &development).pixels[0]
    }

    #[test]
    fn codes_are_those_of_the_curve() {
        for step in 0..=1000 {
            let linear = step as f32 / 1000.0;
            let exact = 255.0 * srgb_from_linear(linear);
            // Half a code of rounding, and half a step of the table: 2^-11 of the value, 0.1 of a code.
            assert!((f32::from(code(linear)) - exact).abs() <= 0.61, "{linear}");
        }
        assert_eq!([code(-1.0), code(0.0), code(7.0), code(f32::INFINITY)], [0, 0, 255, 255]);
    }

    #[test]
    fn a_stop_doubles_and_a_channel_stands_alone() {
        let brighter = Development { exposure_stops: 1.0, ..Default::default() };
        assert_eq!(one([0.25, 0.1, 0.0], brighter), one([0.5, 0.2, 0.0], Development::default()));
        let green = Development { channel: Channel::Green, ..Default::default() };
        assert_eq!(one([0.9, 0.2158605, 0.0], green), Color32::from_gray(128));
    }

    #[test]
    fn what_is_no_radiance_is_painted() {
        let of = |value: f32| one([0.5, value, 0.5], Development::default());
        assert_eq!([of(f32::NAN), of(f32::INFINITY), of(-0.1)], [NOT_A_NUMBER, INFINITE, NEGATIVE]);
        let unmarked = Development { mark_strange: false, ..Default::default() };
        assert_eq!(one([f32::NAN, 0.0, 0.0], unmarked), Color32::BLACK);
    }

    #[test]
    fn false_colour_grows_with_the_light() {
        let development = Development { false_color: true, ..Default::default() };
        let sums = [0.01, 0.18, 1.0].map(|v| {
            let [r, g, b, _] = one([v; 3], development).to_array();
            u32::from(r) + u32::from(g) + u32::from(b)
        });
        assert!(sums.is_sorted_by(|a, b| a < b), "{sums:?}");
    }
}
