//! Converged images: what every error is measured against.
//!
//! In: a [`Pipeline`] and which structure its paths search. Out: mean radiance per pixel of the display (linear,
//! unscaled), its standard error, and a state from which a later run goes on. Each sample is one path through a random
//! point of the pixel (box filter), with f32 materials and sums: nothing quantised, filtered or lifted.
//!
//! Samples are taken in batches ([`batch_end`]), always the same ones together, so that a run that was interrupted and
//! resumed gives the bits of one that was not. Their random numbers are others than a render's of the same seed: an
//! image must not share its noise with what it is compared with.

mod content;
mod moments;
mod state;

pub use content::content_hash;
pub use moments::Moments;

use crate::output::log::{Adapter, MemoryBytes};
use crate::pipeline::Pipeline;
use crate::{Error, RenderSettings, output};
use frame::cpu::Image;
use serde::Serialize;
use serde_json::{Value, json};
use std::path::Path;
use std::time::{Duration, Instant};
use tracer::Search;

/// Samples of a batch. Longer ones stratify better, shorter ones say more surely how sure the image is: 1,024 samples
/// are 258 batches, whose standard error is known to 4 %.
const BATCH: u32 = 4;

/// Where the batch ends that sample number `first` begins or belongs to: at 1, 2, 4 and then every 4, so that even two
/// samples say something about their error.
pub fn batch_end(first: u32) -> u32 {
    match first {
        0 => 1,
        _ if first < BATCH => first.saturating_add(1).next_power_of_two(),
        _ => (first / BATCH + 1).saturating_mul(BATCH),
    }
}

/// A run writes its state and pictures this often.
const CHECKPOINT: Duration = Duration::from_secs(20);

/// Fewer samples say little about their own error.
const LEAST_FOR_UNTIL: u64 = 16;

/// When a run is done.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Goal {
    /// Samples per pixel, at most.
    pub spp: u32,
    /// Or after so long, as good as it is then.
    pub within: Option<Duration>,
    /// Or as soon as the root of [`Moments::noise_rel_mse`] is at most this.
    pub until: Option<f64>,
}

impl Goal {
    fn is_reached(&self, moments: &Moments, begun: Instant) -> bool {
        let is_sure = |until| moments.count >= LEAST_FOR_UNTIL && moments.noise_rel_mse().sqrt() <= until;
        // Two samples, for one has no standard error.
        let is_late = |within| moments.count >= 2 && begun.elapsed() >= within;
        moments.count >= u64::from(self.spp)
            || self.until.is_some_and(is_sure)
            || self.within.is_some_and(is_late)
    }
}

/// `log.json` of a reference.
#[derive(Debug, Serialize)]
struct Log<'a> {
    adapter: Adapter,
    settings: &'a RenderSettings,
    reference: Summary,
    memory_bytes: MemoryBytes,
}

/// What a run came to.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// Samples per pixel.
    pub spp: u64,
    /// Of these, from an earlier run.
    pub resumed_spp: u64,
    /// Mean of `s^2 / (r^2 + 0.01)`.
    pub noise_rel_mse: f64,
    /// Its root.
    pub rel_error: f64,
    /// Of this run, s.
    pub seconds: f64,
    /// Values that are negative or no numbers; none.
    pub strange: usize,
}

/// A converged image.
#[derive(Clone, Debug)]
pub struct Reference {
    /// Mean radiance.
    pub mean: Image<[f32; 3]>,
    /// Its standard error.
    pub standard_error: Image<[f32; 3]>,
    /// How it was come by.
    pub summary: Summary,
}

/// What decides a reference's pixels, and nothing else: two with equal keys are the same image.
pub fn key(pipeline: &Pipeline, search: Search) -> Value {
    let settings = pipeline.settings();
    let mut all = serde_json::to_value(settings).unwrap_or_default();
    if let Some(fields) = all.as_object_mut() {
        // Stages and sizes that only a render has.
        for name in [
            "trace_size",
            "denoiser",
            "upsampler",
            "spp",
            "frames",
            "fps",
            "tracer",
            "scene",
            "sets",
            "load_budget_bytes",
        ] {
            fields.remove(name);
        }
        if search != Search::Grid {
            fields.remove("grid");
        }
        let takes_part = |id: &str| {
            id == "tracer" || id == settings.tessellator || (id == "voxel" && search == Search::Grid)
        };
        let sets: Vec<String> = settings
            .sets
            .iter()
            .filter(|set| takes_part(&set.id))
            .map(|set| format!("{}.{}={}", set.id, set.knob, set.value))
            .collect();
        fields.insert("sets".into(), json!(sets));
        fields.insert("content".into(), json!(content_hash(pipeline.scene(), settings.time)));
        fields.insert("structure".into(), json!(if search == Search::Grid { "voxel" } else { "bvh" }));
    }
    all
}

/// A file name for a key: 32 hexadecimal digits.
pub fn key_name(key: &Value) -> String {
    format!("{:032x}", xxhash_rust::xxh3::xxh3_128(key.to_string().as_bytes()))
}

/// Converges in `folder`, going on from what an earlier run of the same settings left there. Leaves `reference.exr`,
/// `stderr.exr`, `log.json` and `reference.state`, each whole at every moment; where the goal is reached already, nothing
/// is written.
///
/// # Errors
/// What lies there belongs to something else or is broken, the device fails, or a file cannot be written.
pub fn run(pipeline: &mut Pipeline, search: Search, goal: Goal, folder: &Path) -> Result<Reference, Error> {
    let key = key(pipeline, search);
    let size = pipeline.settings().display_size;
    output::folder(folder)?;
    let state_path = folder.join("reference.state");
    let mut moments = state::read(&state_path, &key, size)?.unwrap_or_else(|| Moments::new(size));
    let resumed_spp = moments.count;
    let begun = Instant::now();
    let summary = |moments: &Moments| {
        let noise_rel_mse = moments.noise_rel_mse();
        Summary {
            spp: moments.count,
            resumed_spp,
            noise_rel_mse,
            rel_error: noise_rel_mse.sqrt(),
            seconds: begun.elapsed().as_secs_f64(),
            strange: moments.strange(),
        }
    };
    let reference = |moments: &Moments| Reference {
        mean: moments.mean(),
        standard_error: moments.standard_error(),
        summary: summary(moments),
    };
    if resumed_spp > 0 && goal.is_reached(&moments, begun) {
        return Ok(reference(&moments));
    }
    let save = |pipeline: &Pipeline, moments: &Moments| -> Result<Reference, Error> {
        let reference = reference(moments);
        let log = Log {
            adapter: Adapter::of(pipeline.gpu()),
            settings: pipeline.settings(),
            reference: reference.summary.clone(),
            memory_bytes: MemoryBytes::of(pipeline.gpu()),
        };
        let text = serde_json::to_string_pretty(&log)
            .map_err(|e| Error::Write { path: folder.join("log.json"), message: e.to_string() })?;
        output::color_exr(&folder.join("reference.exr"), &reference.mean)?;
        output::color_exr(&folder.join("stderr.exr"), &reference.standard_error)?;
        output::write(&folder.join("log.json"), (text + "\n").as_bytes())?;
        // Last: a state that has reached a goal stands beside pictures that have.
        state::write(&state_path, &key, moments)?;
        Ok(reference)
    };

    let mut sampler = pipeline.sampler(search)?;
    let mut saved = Instant::now();
    while !goal.is_reached(&moments, begun) {
        let first = u32::try_from(moments.count).unwrap_or(u32::MAX);
        let end = batch_end(first).min(goal.spp);
        pipeline.sample(&mut sampler, first..end, &mut moments)?;
        if saved.elapsed() >= CHECKPOINT {
            save(pipeline, &moments)?;
            saved = Instant::now();
        }
        pipeline.progress().report("converging", end as f32 / goal.spp as f32);
    }
    save(pipeline, &moments)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn batches_end_where_they_always_end() {
        let ends: Vec<u32> = [0, 1, 2, 3, 4, 7, 8, 15, 16, 1_023].map(batch_end).to_vec();
        assert_eq!(ends, [1, 2, 4, 4, 8, 8, 12, 16, 20, 1_024]);
    }
}
