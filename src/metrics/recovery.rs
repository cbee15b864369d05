//! How well pixels that were just uncovered have come up to the others: what a filter over time owes after a few frames.
//!
//! In: a sequence's pictures, two independent references of each, and where each pixel's surface was one frame ago. A pixel
//! that shows what was hidden or outside is 0 frames old; one whose surface was seen is a frame older than it was there. The
//! squared relative error of a picture x against references r1, r2 whose noises are independent,
//!
//! ```text
//! e = mean((x - r1)(x - r2) / (((r1 + r2) / 2)^2 + 0.01))
//! ```
//!
//! is taken apart: over pixels exactly [`AGE`] frames old, and over those followed since the first frame, in the same
//! frames. The references' noise cancels from the product; in the divisor it shifts both alike.

use super::{MetricError, comparable};
use frame::cpu::Image;

/// Frames after which a pixel is asked.
pub const AGE: u32 = 8;

/// Followed since the first frame.
const ALWAYS: u32 = u32::MAX;

/// Sum and count of what is averaged.
#[derive(Clone, Copy, Debug, Default)]
struct Mean {
    sum: f64,
    count: u64,
}

impl Mean {
    fn value(&self) -> Option<f64> {
        (self.count > 0).then(|| (self.sum / self.count as f64).max(0.0))
    }
}

/// The errors of a sequence's young and old pixels, frame by frame.
#[derive(Clone, Debug, Default)]
pub struct Recovery {
    /// Frames that each pixel's surface has been seen.
    ages: Option<Image<u32>>,
    frames: u32,
    uncovered: Mean,
    undisturbed: Mean,
}

impl Recovery {
    /// Adds a frame. `was` is the pixel of the last frame that showed the same surface, where one did; it is not looked at
    /// in the first frame. Pixels that are not `hit` do not count.
    ///
    /// # Errors
    /// Sizes differ, or there are no pixels.
    pub fn add(
        &mut self,
        references: [&Image<[f32; 3]>; 2],
        test: &Image<[f32; 3]>,
        hit: &Image<bool>,
        was: &Image<Option<[i32; 2]>>,
    ) -> Result<(), MetricError> {
        comparable(references[0], references[1])?;
        comparable(references[0], test)?;
        comparable(references[0], hit)?;
        comparable(references[0], was)?;
        let age = |ages: &Image<u32>, [x, y]: [i32; 2]| ages.get(x, y).map_or(0, |a| a.saturating_add(1));
        let ages = match &self.ages {
            Some(ages) => was.map(|was| was.map_or(0, |was| age(ages, was))),
            None => Image::filled(test.size(), ALWAYS),
        };
        if self.frames > AGE {
            for (index, (hit, age)) in hit.texels().iter().zip(ages.texels()).enumerate() {
                let mean = match (hit, *age) {
                    (true, AGE) => &mut self.uncovered,
                    (true, ALWAYS) => &mut self.undisturbed,
                    _ => continue,
                };
                let [r1, r2, x] = [references[0], references[1], test].map(|p| p.texels()[index]);
                mean.sum += (0..3).map(|c| squared_error(r1[c], r2[c], x[c])).sum::<f64>();
                mean.count += 3;
            }
        }
        self.ages = Some(ages);
        self.frames += 1;
        Ok(())
    }

    /// Root of the relative squared error of pixels [`AGE`] frames after they were uncovered, over that of pixels seen
    /// since the first frame; none where either kind was not seen, or the latter have no error.
    pub fn ratio(&self) -> Option<f64> {
        let (uncovered, undisturbed) = (self.uncovered.value()?, self.undisturbed.value()?);
        (undisturbed > 0.0).then(|| (uncovered / undisturbed).sqrt())
    }
}

fn squared_error(r1: f32, r2: f32, x: f32) -> f64 {
    let [r1, r2, x] = [r1, r2, x].map(f64::from);
    let r = 0.5 * (r1 + r2);
    (x - r1) * (x - r2) / (r * r + 0.01)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    const SIZE: [u32; 2] = [4, 2];

    fn gray(value: impl Fn(u32) -> f32) -> Image<[f32; 3]> {
        Image::from_fn(SIZE, |x, _| [value(x); 3])
    }

    #[test]
    fn a_pixel_is_asked_once_at_its_age_and_compared_with_those_never_lost() {
        let truth = gray(|_| 1.0);
        let hit = Image::filled(SIZE, true);
        let mut recovery = Recovery::default();
        for frame in 0..20 {
            // Column 0 is uncovered in frame 3; eight frames later it is off by 0.6, all others by 0.2. What it is off by
            // at any other time does not count.
            let off = |x: u32| match (x, frame) {
                (0, 11) => 1.6,
                (0, _) => 9.0,
                _ => 1.2,
            };
            let was = Image::from_fn(SIZE, |x, y| (x > 0 || frame != 3).then_some([x as i32, y as i32]));
            recovery.add([&truth, &truth], &gray(off), &hit, &was).unwrap();
        }
        // 0.6 / 0.2, of f32 pictures.
        assert!((recovery.ratio().unwrap() - 3.0).abs() < 1e-5, "{:?}", recovery.ratio());
    }

    #[test]
    fn nothing_uncovered_is_no_ratio_and_noise_of_the_references_cancels() {
        let truth = gray(|_| 1.0);
        let hit = Image::filled(SIZE, true);
        let still = Image::from_fn(SIZE, |x, y| Some([x as i32, y as i32]));
        let mut recovery = Recovery::default();
        for _ in 0..20 {
            recovery.add([&truth, &truth], &gray(|_| 1.5), &hit, &still).unwrap();
        }
        assert_eq!(recovery.ratio(), None);
        // (1 - r1)(1 - r2) over +-0.25 of independent signs.
        let signs = [(1.25, 1.25), (1.25, 0.75), (0.75, 1.25), (0.75, 0.75)];
        let sum: f64 = signs
            .map(|(r1, r2)| squared_error(r1, r2, 1.0) * (0.25 * f64::from(r1 + r2).powi(2) + 0.01))
            .iter()
            .sum();
        assert!(sum.abs() < 1e-12, "{sum}");
        assert!(recovery.add([&truth, &truth], &Image::filled([2, 2], [1.0; 3]), &hit, &still).is_err());
    }
}
