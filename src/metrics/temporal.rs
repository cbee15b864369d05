//! Flicker: how differently the error sits from one frame to the next, along motion.
//!
//! `sqrt(mean((dx - dr1)(dx - dr2)))` over pixel-channels and frames, where `d` is a pixel's radiance in this frame minus
//! that of the same surface point in the last one, and r1, r2 are two independent references of the sequence. Their
//! noises are independent, so they cancel in the mean of the product instead of adding up as in a square. A surface
//! point that was hidden or outside in the last frame is left out.
//!
//! The last frame is looked up at the nearest pixel: a blend of four would smooth the very noise that is measured. Test
//! and references are looked up alike, so what this shifts cancels too.

use super::{MetricError, comparable};
use frame::cpu::Image;

/// Two frames in a row of one sequence.
#[derive(Clone, Copy, Debug)]
pub struct Consecutive<'a> {
    /// One frame ago.
    pub last: &'a Image<[f32; 3]>,
    /// Now.
    pub this: &'a Image<[f32; 3]>,
}

impl Consecutive<'_> {
    /// Change from where a point was to where it is, if it was in the picture.
    fn change(&self, [x, y]: [i32; 2], [was_x, was_y]: [i32; 2]) -> Option<[f64; 3]> {
        let (now, before) = (self.this.get(x, y)?, self.last.get(was_x, was_y)?);
        Some([0, 1, 2].map(|c| f64::from(now[c]) - f64::from(before[c])))
    }
}

/// The pixel of the last frame in which a surface point lay: `motion` is as the G-buffer has it, the pixel now minus where
/// the same point was, in pixels. What came from behind the camera is outside of any picture, for a cast saturates.
pub fn origin(at: [i32; 2], motion: [f32; 2]) -> [i32; 2] {
    [0, 1].map(|axis| (at[axis] as f32 - motion[axis]).round() as i32)
}

/// The temporal error of a sequence, frame by frame.
#[derive(Clone, Copy, Debug, Default)]
pub struct Temporal {
    sum: f64,
    count: u64,
}

impl Temporal {
    /// Adds one step. `was` is the pixel of the last frame that showed what this one shows, where one did ([`origin`]).
    ///
    /// # Errors
    /// Sizes differ, or there are no pixels.
    pub fn add(
        &mut self,
        references: [Consecutive; 2],
        test: Consecutive,
        was: &Image<Option<[i32; 2]>>,
    ) -> Result<(), MetricError> {
        let size = references[0].this;
        for picture in [references[0].last, references[1].last, references[1].this, test.last, test.this] {
            comparable(size, picture)?;
        }
        comparable(size, was)?;
        let width = size.size()[0];
        for (index, was) in was.texels().iter().enumerate() {
            let &Some(was) = was else { continue };
            let at = [index as u32 % width, index as u32 / width].map(|side| side as i32);
            let changes = [references[0], references[1], test].map(|frames| frames.change(at, was));
            if let [Some(r1), Some(r2), Some(x)] = changes {
                self.sum += (0..3).map(|c| (x[c] - r1[c]) * (x[c] - r2[c])).sum::<f64>();
                self.count += 3;
            }
        }
        Ok(())
    }

    /// The error so far, W / (sr m^2); none before the first pixel that could be followed. A mean that the references'
    /// noise has pulled below 0 is 0.
    pub fn error(&self) -> Option<f64> {
        (self.count > 0).then(|| (self.sum / self.count as f64).max(0.0).sqrt())
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    type Picture = Image<[f32; 3]>;
    const SIZE: [u32; 2] = [8, 4];

    fn gray(value: impl Fn(i32, i32) -> f32) -> Picture {
        Image::from_fn(SIZE, |x, y| [value(x as i32, y as i32); 3])
    }

    fn was(motion: [f32; 2], valid: &Image<bool>) -> Image<Option<[i32; 2]>> {
        Image::from_fn(SIZE, |x, y| {
            let at = [x as i32, y as i32];
            valid.get(at[0], at[1]).unwrap().then_some(origin(at, motion))
        })
    }

    fn error(r: [&Picture; 2], x: [&Picture; 2], motion: [f32; 2], valid: &Image<bool>) -> Option<f64> {
        let [reference, test] = [r, x].map(|[last, this]| Consecutive { last, this });
        let mut temporal = Temporal::default();
        temporal.add([reference, reference], test, &was(motion, valid)).unwrap();
        temporal.error()
    }

    #[test]
    fn a_picture_that_moves_with_its_surface_does_not_flicker() {
        // Everything slides two columns to the right; what enters on the left was not seen.
        let [last, this] = [0, 2].map(|by| gray(|x, y| ((x - by) * (x - by) + 5 * y) as f32));
        let valid = Image::filled(SIZE, true);
        let still = gray(|_, _| 1.0);
        // A bias that stays is no flicker either.
        let [biased_last, biased] = [&last, &this].map(|p| p.map(|t| t.map(|v| v + 3.0)));
        assert_eq!(error([&last, &this], [&biased_last, &biased], [2.0, 0.0], &valid), Some(0.0));
        assert_eq!(error([&still, &still], [&still, &still], [0.0, 0.0], &valid), Some(0.0));
        // Against the motion, changes would be large.
        assert!(error([&still, &still], [&last, &this], [-2.0, 0.0], &valid) > Some(1.0));
    }

    #[test]
    fn a_step_of_known_height_is_the_error_and_hidden_pixels_do_not_count() {
        let [dark, bright] = [1.0, 1.5].map(|v| gray(|_, _| v));
        let all = Image::filled(SIZE, true);
        assert_eq!(error([&dark, &dark], [&dark, &bright], [0.0, 0.0], &all), Some(0.5));
        let half_bright = gray(|x, _| if x < 4 { 1.0 } else { 1.5 });
        let seen = Image::from_fn(SIZE, |x, _| x < 4);
        assert_eq!(error([&dark, &dark], [&dark, &half_bright], [0.0, 0.0], &seen), Some(0.0));
        for motion in [[65504.0, 65504.0], [f32::NAN, -8.0]] {
            assert_eq!(error([&dark, &dark], [&dark, &bright], motion, &all), None, "{motion:?}");
        }
    }

    #[test]
    fn noise_of_the_references_cancels() {
        // Independent signs: a product of Walsh functions is 0 in the mean.
        let truth = gray(|_, _| 1.0);
        let noise = |bit: i32| gray(move |x, y| 1.0 + if (x >> bit) & 1 == y & 1 { 0.25 } else { -0.25 });
        let [r1, r2] = [noise(0), noise(1)];
        let step = |this| Consecutive { last: &truth, this };
        let mut temporal = Temporal::default();
        let here = was([0.0; 2], &Image::filled(SIZE, true));
        temporal.add([step(&r1), step(&r2)], step(&truth), &here).unwrap();
        assert_eq!(temporal.error(), Some(0.0));
        let small = Image::filled([2, 2], None);
        assert!(temporal.add([step(&r1), step(&r2)], step(&truth), &small).is_err());
    }
}
