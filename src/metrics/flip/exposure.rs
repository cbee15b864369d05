//! The sweep of exposures of HDR-FLIP, and the tone mapper it looks through.
//!
//! From the reference (Eurographics 2021, section 3): the darkest exposure brings its largest luminance, the brightest its
//! median to the shoulder, 85 % of white; between them about one exposure per stop, evenly spaced.

use frame::cpu::{Image, luminance};

/// Narkowicz' fit of the ACES curve, `(a x^2 + b x) / (c x^2 + d x + e)`, without its own exposure of 0.6.
const A: f32 = 0.6 * 0.6 * 2.51;
const B: f32 = 0.6 * 0.03;
const C: f32 = 0.6 * 0.6 * 2.43;
const D: f32 = 0.6 * 0.59;
const E: f32 = 0.14;

/// Where the shoulder begins, as a share of white.
const SHOULDER: f32 = 0.85;

/// Beyond this all is white, and squares stay finite.
const WHITE: f32 = 1e6;

/// Exposures in stops, evenly spaced, both ends included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exposures {
    /// Darkest.
    pub start_stops: f32,
    /// Brightest.
    pub stop_stops: f32,
    /// At least 1.
    pub count: usize,
}

impl Exposures {
    /// Those that show everything in this reference.
    pub fn of(reference: &Image<[f32; 3]>) -> Self {
        let mut luminances: Vec<f32> =
            reference.texels().iter().map(|texel| luminance(texel.map(|v| v.max(0.0)))).collect();
        luminances.sort_by(f32::total_cmp);
        let (Some(&largest), Some(&median)) = (luminances.last(), luminances.get(luminances.len() / 2))
        else {
            return Self::as_it_is();
        };
        let lit = luminances.partition_point(|l| *l <= 0.0);
        let Some(&median_lit) = luminances[lit..].get((luminances.len() - lit) / 2) else {
            return Self::as_it_is();
        };
        let median = if median > 0.0 { median } else { median_lit };
        let [start_stops, stop_stops] = [largest, median].map(|l| shoulder().log2() - l.log2());
        Self { start_stops, stop_stops, count: (stop_stops - start_stops).ceil().max(2.0) as usize }
    }

    /// For a picture that is black.
    fn as_it_is() -> Self {
        Self { start_stops: 0.0, stop_stops: 0.0, count: 1 }
    }

    /// Each of them.
    pub fn stops(self) -> impl Iterator<Item = f32> {
        let step = (self.stop_stops - self.start_stops) / self.count.saturating_sub(1).max(1) as f32;
        (0..self.count).map(move |index| self.start_stops + index as f32 * step)
    }
}

/// What the curve takes to [`SHOULDER`]: the larger root.
fn shoulder() -> f32 {
    let [a, b, c] = [A - SHOULDER * C, B - SHOULDER * D, -SHOULDER * E];
    let half = -0.5 * b / a;
    half + (half * half - c / a).sqrt()
}

/// What a display shows at this exposure, 0..1, linear.
pub(super) fn tone_mapped(picture: &Image<[f32; 3]>, stops: f32) -> Image<[f32; 3]> {
    let exposure = stops.exp2();
    picture.map(|texel| texel.map(|radiance| aces((radiance * exposure).clamp(0.0, WHITE))))
}

fn aces(x: f32) -> f32 {
    ((A * x * x + B * x) / (C * x * x + D * x + E)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gray(values: &[f32]) -> Image<[f32; 3]> {
        Image::from_fn([values.len() as u32, 1], |x, _| [values[x as usize]; 3])
    }

    #[test]
    fn the_ends_put_the_largest_and_the_median_on_the_shoulder() {
        let exposures = Exposures::of(&gray(&[0.01, 0.5, 0.25, 8.0, 0.0]));
        for (stops, luminance) in [(exposures.start_stops, 8.0), (exposures.stop_stops, 0.25)] {
            let shown = aces(luminance * stops.exp2());
            assert!((shown - SHOULDER).abs() < 1e-5, "{luminance} is shown as {shown}");
        }
        // Five stops between them.
        assert_eq!(exposures.count, 5);
        let stops: Vec<f32> = exposures.stops().collect();
        assert_eq!((stops.len(), stops[0], stops[4]), (5, exposures.start_stops, exposures.stop_stops));
    }

    #[test]
    fn pictures_without_range_or_light_have_exposures_too() {
        assert_eq!(
            Exposures::of(&gray(&[0.0, 0.0])),
            Exposures { start_stops: 0.0, stop_stops: 0.0, count: 1 }
        );
        let constant = Exposures::of(&gray(&[2.0; 4]));
        assert_eq!((constant.count, constant.start_stops), (2, constant.stop_stops));
        // The median is black: that of what is lit, 4.
        let lamp = Exposures::of(&gray(&[0.0, 0.0, -1.0, 0.0, 4.0, 16.0, 2.0]));
        assert!((lamp.stop_stops - lamp.start_stops - 2.0).abs() < 1e-5, "{lamp:?}");
    }

    #[test]
    fn the_curve_ends_in_white_even_for_the_absurd() {
        let shown = tone_mapped(&gray(&[0.0, -5.0, 1e30, f32::MAX]), 10.0);
        assert_eq!(shown.texels().iter().map(|t| t[0]).collect::<Vec<_>>(), [0.0, 0.0, 1.0, 1.0]);
    }
}
