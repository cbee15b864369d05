//! Live error: the reference of a resting view, one sample per pixel at a time, and how far the pictures are from it.

use frame::cpu::Image;
use gridlight::Error;
use gridlight::metrics;
use gridlight::pipeline::Pipeline;
use gridlight::reference::Moments;
use std::sync::Arc;
use std::time::{Duration, Instant};
use tracer::{Converger, Search};

/// Samples per pixel after which the reference is left as it is.
const ENOUGH: u32 = 4096;

/// Figures are told at most this often: they take time that the reference then lacks.
const BETWEEN: Duration = Duration::from_millis(500);

/// A reference on its way.
pub struct Judge {
    sampler: Converger,
    moments: Moments,
    begun: Instant,
    told: Option<Instant>,
}

/// What it says of the pictures.
pub struct Judgement {
    /// Samples per pixel of the reference.
    pub spp: u64,
    /// Since it began, s.
    pub seconds: f64,
    /// relMSE that the reference's own noise gives it.
    pub noise_rel_mse: f64,
    /// relMSE of each side beyond that noise; none where a picture holds numbers that are none.
    pub rel_mse: Vec<Option<f64>>,
    /// Relative squared error of each pixel, mean over channels, per side.
    pub maps: Vec<Image<f32>>,
}

impl Judge {
    /// Paths through triangles: the true image.
    pub fn new(pipeline: &Pipeline) -> Result<Self, Error> {
        Ok(Self {
            sampler: pipeline.sampler(Search::Cwbvh)?,
            moments: Moments::new(pipeline.settings().display_size),
            begun: Instant::now(),
            told: None,
        })
    }

    /// Whether more samples are not worth it.
    pub fn is_done(&self) -> bool {
        self.moments.count >= u64::from(ENOUGH)
    }

    /// One more sample of every pixel; now and then what it says of the pictures.
    pub fn sample(
        &mut self,
        pipeline: &mut Pipeline,
        pictures: &[Arc<Image<[f32; 3]>>],
    ) -> Result<Option<Judgement>, Error> {
        let first = self.moments.count as u32;
        pipeline.sample(&mut self.sampler, first..first + 1, &mut self.moments)?;
        // Two samples, for one has no error of its own.
        let is_due = self.moments.count >= 2 && self.told.is_none_or(|told| told.elapsed() >= BETWEEN);
        if !is_due {
            return Ok(None);
        }
        let judgement = self.judgement(pictures);
        self.told = Some(Instant::now());
        Ok(Some(judgement))
    }

    fn judgement(&self, pictures: &[Arc<Image<[f32; 3]>>]) -> Judgement {
        let mean = self.moments.mean();
        let deviation = self.moments.standard_error();
        // The picture's own noise is part of its error.
        let none = Image::filled(self.moments.size, [0.0; 3]);
        let excess =
            |test: &Arc<Image<[f32; 3]>>| metrics::excess_rel_mse(&mean, test, &deviation, &none).ok();
        Judgement {
            spp: self.moments.count,
            seconds: self.begun.elapsed().as_secs_f64(),
            noise_rel_mse: self.moments.noise_rel_mse(),
            rel_mse: pictures.iter().map(excess).collect(),
            maps: pictures.iter().map(|test| map(&mean, test)).collect(),
        }
    }
}

/// `(t - r)^2 / (r^2 + 0.01)` per pixel, mean over channels: what relMSE is the mean of.
fn map(reference: &Image<[f32; 3]>, test: &Image<[f32; 3]>) -> Image<f32> {
    let mut test = test.texels().iter();
    reference.map(|r| {
        let Some(t) = test.next() else { return 0.0 };
        let squared = |(r, t): (&f32, &f32)| (t - r) * (t - r) / (r * r + 0.01);
        r.iter().zip(t).map(squared).sum::<f32>() / 3.0
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_map_is_what_rel_mse_is_the_mean_of() {
        let reference = Image::from_fn([3, 2], |x, y| [x as f32, y as f32, 0.5]);
        let test = reference.map(|[r, g, b]| [r + 0.25, 2.0 * g, b]);
        let map = map(&reference, &test);
        let mean = map.texels().iter().map(|v| f64::from(*v)).sum::<f64>() / 6.0;
        // f32 per pixel against f64 throughout.
        assert!((mean - metrics::rel_mse(&reference, &test).unwrap_or(0.0)).abs() < 1e-5);
    }
}
