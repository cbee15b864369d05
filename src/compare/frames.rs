//! References of every frame of what moves, for the error of the change from frame to frame: found in the cache or rendered.
//!
//! In: a configuration. Out: of each of its frames two pictures by its tracer alone, with many samples, nothing filtered and
//! nothing lifted, whose noises are independent of each other and of any row's. They see the surfaces that the rows see, at
//! pixels' centres: edges that crawl because a pixel is one point of a surface are in both and cancel, so that what is left
//! is what light does.

use super::sequence::Pair;
use super::{Color, Comparison};
use crate::input::read_exr;
use crate::pipeline::Pipeline;
use crate::{Error, Progress, RenderSettings, output, reference};
use serde_json::json;
use std::path::PathBuf;

/// Of the seeds of the two; a row's own is another.
const SALTS: [u32; 2] = [0x7465_6d70, 0x6f72_616c];

/// Both references of every frame of `settings`.
///
/// # Errors
/// A frame cannot be rendered, or a file not written.
pub fn converge(
    comparison: &Comparison,
    settings: &RenderSettings,
    pipeline: &mut Pipeline,
    progress: &Progress,
) -> Result<Vec<Pair>, Error> {
    let plain = plain(settings, comparison.temporal_spp);
    let mut own = None;
    let mut sequence = |salt: u32| {
        let seeded = RenderSettings { seed: plain.seed ^ salt, ..plain.clone() };
        one(comparison, &seeded, pipeline, &mut own, progress)
    };
    let [first, second] = [sequence(SALTS[0])?, sequence(SALTS[1])?];
    Ok(first.into_iter().zip(second).map(|(a, b)| [a, b]).collect())
}

/// The same frames by paths alone.
fn plain(settings: &RenderSettings, spp: u32) -> RenderSettings {
    let sets = settings.sets.iter();
    let sets = sets.filter(|set| ![&settings.denoiser, &settings.upsampler].contains(&&set.id)).cloned();
    RenderSettings {
        trace_size: settings.display_size,
        denoiser: "identity".into(),
        upsampler: "nearest".into(),
        spp,
        sets: sets.collect(),
        ..settings.clone()
    }
}

/// One sequence; a pipeline of another trace size cannot render it, then one is made and kept in `own`.
fn one(
    comparison: &Comparison,
    settings: &RenderSettings,
    pipeline: &mut Pipeline,
    own: &mut Option<Pipeline>,
    progress: &Progress,
) -> Result<Vec<Color>, Error> {
    let files = files(comparison, settings, pipeline);
    if let Some(found) = files.iter().map(|file| read_exr(file).ok()).collect() {
        return Ok(found);
    }
    let pipeline = match (settings.trace_size == pipeline.settings().trace_size, own) {
        (true, _) => pipeline,
        (false, Some(own)) => own,
        (false, none) => none.insert(Pipeline::new(pipeline.gpu().clone(), settings, Progress::default())?),
    };
    pipeline.change(settings)?;
    let mut frames = Vec::new();
    for (index, file) in files.iter().enumerate() {
        progress.report("rendering every frame's references", index as f32 / files.len() as f32);
        let rendered = pipeline.render()?;
        let color = output::color(pipeline.gpu(), &rendered.color, rendered.frame.radiance_scale)?;
        if let Some(folder) = file.parent() {
            output::folder(folder)?;
        }
        output::color_exr(file, &color)?;
        frames.push(color);
    }
    Ok(frames)
}

/// Where the frames are kept: named by all that decides them.
fn files(comparison: &Comparison, settings: &RenderSettings, pipeline: &Pipeline) -> Vec<PathBuf> {
    let content = reference::content_hash(pipeline.scene(), settings.time);
    // The file is known by what is in it.
    let key = json!([content, RenderSettings { scene: String::new(), frames: 0, ..settings.clone() }]);
    let folder = comparison.cache.join(reference::key_name(&key));
    (1..=comparison.frames).map(|number| output::numbered(&folder, "frame", Some(number), "exr")).collect()
}
