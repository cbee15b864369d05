//! Sums over samples per pixel and channel, in f64, and what they say: the mean, and how sure it is.
//!
//! The standard error is that of independent samples. Paths stratify their first direction over the samples, which their
//! spread does not show: the mean is at least as sure as is said (in the Cornell box the true error is 0.8 of it).

use frame::cpu::Image;
use std::ops::Range;
use tracer::Moment;

/// Sum and sum of squares of the radiance of all samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Moments {
    /// Pixels.
    pub size: [u32; 2],
    /// Samples of every pixel.
    pub count: u64,
    pub(super) sums: Vec<[f64; 3]>,
    pub(super) squares: Vec<[f64; 3]>,
}

impl Moments {
    /// No samples yet.
    pub fn new(size: [u32; 2]) -> Self {
        let pixels = size[0] as usize * size[1] as usize;
        Self { size, count: 0, sums: vec![[0.0; 3]; pixels], squares: vec![[0.0; 3]; pixels] }
    }

    /// Adds what a band of rows got; [`Moments::count`] is the caller's to raise once all rows have it.
    pub fn add(&mut self, band: &Range<u32>, moments: &[Moment], radiance_scale: f32) {
        let first = self.size[0] as usize * band.start as usize;
        let per = 1.0 / f64::from(radiance_scale);
        let own = self.sums.iter_mut().zip(&mut self.squares).skip(first);
        for ((sum, square), moment) in own.zip(moments) {
            for c in 0..3 {
                sum[c] += f64::from(moment.sum[c]) * per;
                square[c] += f64::from(moment.sum_of_squares[c]) * per * per;
            }
        }
    }

    /// Mean radiance.
    pub fn mean(&self) -> Image<[f32; 3]> {
        let n = self.count.max(1) as f64;
        self.image(|sum, _| sum / n)
    }

    /// Standard error of the mean; 0 before the second sample.
    pub fn standard_error(&self) -> Image<[f32; 3]> {
        self.image(|sum, square| self.variance_of_mean(sum, square).sqrt())
    }

    /// Mean over pixels and channels of `s^2 / (r^2 + 0.01)`: the relMSE that its own noise gives the image, below which
    /// nothing can be measured with it.
    pub fn noise_rel_mse(&self) -> f64 {
        let n = self.count.max(1) as f64;
        let each = self.sums.iter().flatten().zip(self.squares.iter().flatten()).map(|(sum, square)| {
            let mean = sum / n;
            self.variance_of_mean(*sum, *square) / (mean * mean + 0.01)
        });
        each.sum::<f64>() / (3.0 * self.sums.len().max(1) as f64)
    }

    /// Values that are no numbers, or negative: there should be none.
    pub fn strange(&self) -> usize {
        self.sums.iter().flatten().filter(|sum| !sum.is_finite() || **sum < 0.0).count()
    }

    fn variance_of_mean(&self, sum: f64, square: f64) -> f64 {
        let n = self.count as f64;
        if self.count < 2 {
            return 0.0;
        }
        // Rounding of the sums may leave a constant pixel a little below 0.
        ((square - sum * sum / n) / (n * (n - 1.0))).max(0.0)
    }

    fn image(&self, of: impl Fn(f64, f64) -> f64) -> Image<[f32; 3]> {
        let width = self.size[0];
        Image::from_fn(self.size, |x, y| {
            let at = (y * width + x) as usize;
            [0, 1, 2].map(|c| of(self.sums[at][c], self.squares[at][c]) as f32)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_and_standard_error_of_known_numbers() {
        let mut moments = Moments::new([1, 2]);
        // Samples 1, 2, 3, 6: mean 3, variance 14 / 3, of the mean 14 / 12. Stored four times as bright.
        let moment = |scale: f32| Moment {
            sum: [12.0 * scale; 3],
            count: 4.0,
            sum_of_squares: [50.0 * scale * scale; 3],
            ..Moment::default()
        };
        moments.add(&(1..2), &[moment(4.0)], 4.0);
        moments.count = 4;
        assert_eq!(moments.mean().texels(), [[0.0; 3], [3.0; 3]]);
        let expected = (14.0f64 / 12.0).sqrt() as f32;
        assert_eq!(moments.standard_error().texels(), [[0.0; 3], [expected; 3]]);
        assert!((moments.noise_rel_mse() - 0.5 * (14.0 / 12.0) / 9.01).abs() < 1e-12);
        assert_eq!(moments.strange(), 0);
    }

    #[test]
    fn one_sample_has_no_standard_error() {
        let mut moments = Moments::new([1, 1]);
        let one = Moment { sum: [2.0; 3], count: 1.0, sum_of_squares: [4.0; 3], ..Moment::default() };
        moments.add(&(0..1), &[one], 1.0);
        moments.count = 1;
        assert_eq!((moments.mean().texels()[0], moments.standard_error().texels()[0]), ([2.0; 3], [0.0; 3]));
    }
}
