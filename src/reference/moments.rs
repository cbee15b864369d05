//! Sums over samples per pixel and channel, in f64, and what they say: the mean, and how sure it is.
//!
//! Paths stratify their first direction over the samples, so that the spread of single samples says too little good of
//! their mean (in the Cornell box by a quarter). Samples are therefore taken in batches of independent rotation, and the
//! standard error comes from the spread between batches: with sums S_b over n_b samples, N samples in B batches,
//! `sigma^2 = (sum S_b^2 / n_b - (sum S_b)^2 / N) / (B - 1)` and the mean's variance is `sigma^2 / N`, unbiased for
//! batches of any lengths where the samples are independent, and for equal lengths where only the batches are.

use frame::cpu::Image;
use std::ops::Range;
use tracer::Moment;

/// Sums of the radiance of all samples, and of the squares of its batches.
#[derive(Clone, Debug, PartialEq)]
pub struct Moments {
    /// Pixels.
    pub size: [u32; 2],
    /// Samples of every pixel.
    pub count: u64,
    /// Independent batches that they came in.
    pub batches: u64,
    pub(super) sums: Vec<[f64; 3]>,
    /// Of `S_b^2 / n_b`.
    pub(super) squares: Vec<[f64; 3]>,
}

impl Moments {
    /// No samples yet.
    pub fn new(size: [u32; 2]) -> Self {
        let pixels = size[0] as usize * size[1] as usize;
        Self { size, count: 0, batches: 0, sums: vec![[0.0; 3]; pixels], squares: vec![[0.0; 3]; pixels] }
    }

    /// Adds what a band of rows got from one batch; [`Moments::counted`] follows once all rows have it.
    pub fn add(&mut self, band: &Range<u32>, moments: &[Moment], radiance_scale: f32) {
        let first = self.size[0] as usize * band.start as usize;
        let per = 1.0 / f64::from(radiance_scale);
        let own = self.sums.iter_mut().zip(&mut self.squares).skip(first);
        for ((sum, square), moment) in own.zip(moments) {
            for c in 0..3 {
                let of_batch = f64::from(moment.sum[c]) * per;
                sum[c] += of_batch;
                square[c] += of_batch * of_batch / f64::from(moment.count).max(1.0);
            }
        }
    }

    /// Every pixel has another batch of so many samples.
    pub fn counted(&mut self, samples: u32) {
        self.count += u64::from(samples);
        self.batches += 1;
    }

    /// Mean radiance.
    pub fn mean(&self) -> Image<[f32; 3]> {
        let n = self.count.max(1) as f64;
        self.image(|sum, _| sum / n)
    }

    /// Standard error of the mean; 0 before the second batch.
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
        let (n, batches) = (self.count as f64, self.batches as f64);
        if self.batches < 2 {
            return 0.0;
        }
        // Rounding of the sums may leave a constant pixel a little below 0.
        ((square - sum * sum / n) / (n * (batches - 1.0))).max(0.0)
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

    fn batch(sum: f32, count: f32) -> Moment {
        Moment { sum: [sum; 3], count }
    }

    #[test]
    fn mean_and_standard_error_of_known_numbers() {
        let mut moments = Moments::new([1, 2]);
        // Batches of one: 1, 2, 3, 6: mean 3, variance 14 / 3, of the mean 14 / 12. Stored four times as bright.
        for value in [1.0, 2.0, 3.0, 6.0] {
            moments.add(&(1..2), &[batch(4.0 * value, 1.0)], 4.0);
            moments.counted(1);
        }
        assert_eq!(moments.mean().texels(), [[0.0; 3], [3.0; 3]]);
        let expected = (14.0f64 / 12.0).sqrt() as f32;
        assert_eq!(moments.standard_error().texels(), [[0.0; 3], [expected; 3]]);
        assert!((moments.noise_rel_mse() - 0.5 * (14.0 / 12.0) / 9.01).abs() < 1e-12);
        assert_eq!(moments.strange(), 0);
    }

    #[test]
    fn batches_of_any_length_say_how_sure_independent_samples_are() {
        // Flat in [0, 1): variance 1 / 12. Averaged over 1,000 pixels, the estimate from 11 batches has a spread of
        // sqrt(2 / 10 / 1,000) = 1.4 %: 6 % is four of them.
        let lengths = [1, 1, 2, 4, 8, 8, 8, 8, 8, 8, 3u32];
        let pixels = 1_000;
        let mut moments = Moments::new([pixels, 1]);
        let mut first = 0;
        for length in lengths {
            let sums: Vec<Moment> = (0..pixels)
                .map(|pixel| {
                    let values = (first..first + length).map(|s| tracer::noise::at([pixel, 0], s, 0, 1)[0]);
                    batch(values.sum(), length as f32)
                })
                .collect();
            moments.add(&(0..1), &sums, 1.0);
            moments.counted(length);
            first += length;
        }
        let errors = moments.standard_error();
        let variance =
            errors.texels().iter().map(|e| f64::from(e[0]).powi(2)).sum::<f64>() / f64::from(pixels);
        let expected = 1.0 / 12.0 / f64::from(first);
        assert!((variance / expected - 1.0).abs() < 0.06, "{}", variance / expected);
    }

    #[test]
    fn one_batch_has_no_standard_error() {
        let mut moments = Moments::new([1, 1]);
        moments.add(&(0..1), &[batch(2.0, 1.0)], 1.0);
        moments.counted(1);
        assert_eq!((moments.mean().texels()[0], moments.standard_error().texels()[0]), ([2.0; 3], [0.0; 3]));
    }
}
