//! `gridlight compare`: every combination of stages, timed and measured against what it should converge to.
//!
//! In: a scene and lists of stages. Out: a folder with rows, pictures and the report ([`crate::report`]).
//!
//! **Time.** One frame to warm up (drivers compile at the first dispatch), then a restart and `frames` frames, their
//! passes timed by the adapter; medians, 95th percentiles and the spread between quartiles per stage.
//! **Error.** The last of these frames, against two converged references at display size: triangles (the true error)
//! and the same voxels (what sampling and filtering did). References are cached by the content of the scene and of
//! every setting that decides them.
//! **Flicker.** All of these frames, along motion (`sequence.rs`). Where the view or the scene moves, each frame has two
//! further references by the row's own tracer.
//! **Alone.** Voxels race BVHs over single rays ([`crate::race`]), and are asked what they get wrong ([`crate::defects`]).
//! **Equal time.** Beside every filtered row stands plain path tracing by the same tracer, given as many samples as fit
//! that row's time.

mod frames;
mod plan;
mod references;
mod sequence;

pub use plan::Lists;

use crate::metrics::{self, MetricError};
use crate::output::log::MemoryBytes;
use crate::pipeline::{Pipeline, Rendered};
use crate::reference::Goal;
use crate::report::{Errors, Facts, Picture, Reference, Report, Row, Shard, StageTimes, Timing, heat_map};
use crate::{Error, Progress, RenderSettings, defects, output, race};
use frame::cpu::Image;
use frame::{FrameLog, Gpu};
use plan::traces_voxels;
use references::References;
use sequence::Sequence;
use std::collections::{BTreeMap, HashSet};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Linear radiance.
type Color = Image<[f32; 3]>;

/// What is compared, and where it goes.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// Scene, view, sizes, and all that the combinations share.
    pub base: RenderSettings,
    /// What is combined.
    pub lists: Lists,
    /// Which of the combinations.
    pub shard: Shard,
    /// Timed frames of each.
    pub frames: u32,
    /// Samples of the two references of each frame of what moves; 0 = none.
    pub temporal_spp: u32,
    /// When references are good enough.
    pub goal: Goal,
    /// Where references are kept between runs.
    pub cache: PathBuf,
    /// Where everything is written.
    pub out: PathBuf,
    /// The command line, for the report.
    pub command: String,
    /// Stops added to the pictures' brightness.
    pub exposure: f32,
}

/// Frames of one configuration.
struct Measured {
    color: Color,
    temporal: Option<f64>,
    uncovered: Option<f64>,
    logs: Vec<FrameLog>,
    seconds: Vec<f64>,
    /// Of the structures, when they were built.
    build: FrameLog,
    memory: MemoryBytes,
}

/// Renders, measures and reports.
///
/// # Errors
/// A setting, scene or adapter that will not do, or a file that cannot be written; nothing is left half-written.
pub fn run(comparison: &Comparison, gpu: Gpu, progress: &Progress) -> Result<Report, Error> {
    if let Some(set) = comparison.lists.unused_sets(&comparison.base) {
        return Err(Error::NoSuchStage {
            id: set.id.clone(),
            knob: set.knob.clone(),
            known: "voxel, gather, tracer and the stages that are compared".into(),
        });
    }
    let combinations = comparison.lists.combinations(&comparison.base, comparison.shard);
    let adapter = format!("{} ({} {})", gpu.info.name, gpu.info.driver, gpu.info.driver_info);
    let Some(first) = combinations.first() else {
        return Err(Error::NothingToCompare { index: comparison.shard.index, count: comparison.shard.count });
    };
    let mut pipeline = Pipeline::new(gpu, first, Progress::default())?;
    // A wrong knob of a later combination is told now, not after references have converged.
    let mut tried = HashSet::new();
    for settings in &combinations {
        if settings.sets.iter().any(|set| tried.insert(&set.id)) {
            pipeline.change(settings)?;
        }
    }
    output::folder(&comparison.out)?;
    let references = References::converge(comparison, &combinations, &mut pipeline, progress)?;

    let mut rows = Vec::new();
    let mut pictures = references.pictures.clone();
    for (k, settings) in combinations.iter().enumerate() {
        progress.report("comparing", k as f32 / combinations.len() as f32);
        let measured = measure(&mut pipeline, settings, comparison.frames, &references)?;
        let row = row(comparison, settings, &measured, None);
        add(comparison, &references, &row, &measured, &mut rows, &mut pictures)?;
        if settings.denoiser == "identity" {
            continue;
        }
        let Some(plain) = equal_time(settings, &measured) else { continue };
        let measured = measure(&mut pipeline, &plain, comparison.frames, &references)?;
        let row = self::row(comparison, &plain, &measured, Some(row.configuration()));
        add(comparison, &references, &row, &measured, &mut rows, &mut pictures)?;
    }
    let facts = Facts {
        commands: vec![comparison.command.clone()],
        adapter,
        scene: comparison.base.scene.clone(),
        trace_size: comparison.base.trace_size,
        display_size: comparison.base.display_size,
    };
    let mut report = Report::new(facts, references.infos, rows, pictures);
    alone(&combinations, &mut pipeline, &mut report)?;
    report.write(&comparison.out)?;
    Ok(report)
}

/// Adds what is measured without whole frames, for every grid that was compared: its defects, and of the first of them the
/// race over single rays.
fn alone(combinations: &[RenderSettings], pipeline: &mut Pipeline, report: &mut Report) -> Result<(), Error> {
    let grids: BTreeMap<u32, &RenderSettings> =
        combinations.iter().filter(|s| traces_voxels(&s.tracer)).map(|s| (s.grid, s)).rev().collect();
    for settings in grids.into_values() {
        pipeline.change(settings)?;
        if report.race.is_none() {
            report.race = Some(race::run(pipeline)?);
        }
        report.defects.push(defects::run(pipeline)?);
    }
    Ok(())
}

/// One frame to warm up, then a restart and the frames that count.
fn measure(
    pipeline: &mut Pipeline,
    settings: &RenderSettings,
    frames: u32,
    references: &References,
) -> Result<Measured, Error> {
    pipeline.change(settings)?;
    let build = pipeline.render()?.log;
    pipeline.restart();
    let (mut logs, mut seconds) = (Vec::new(), Vec::new());
    let mut last: Option<Rendered> = None;
    let mut sequence = references.of_frames(settings).map(Sequence::new);
    for _ in 0..frames.max(1) {
        let begun = Instant::now();
        let rendered = pipeline.render()?;
        seconds.push(begun.elapsed().as_secs_f64());
        logs.push(rendered.log.clone());
        if let Some(sequence) = &mut sequence {
            sequence.add(pipeline.gpu(), &rendered)?;
        }
        last = Some(rendered);
    }
    let Some(last) = last else { unreachable!("at least one frame was rendered") };
    let color = output::color(pipeline.gpu(), &last.color, last.frame.radiance_scale)?;
    Ok(Measured {
        color,
        temporal: sequence.as_ref().and_then(Sequence::temporal),
        uncovered: sequence.as_ref().and_then(Sequence::uncovered),
        logs,
        seconds,
        build,
        memory: MemoryBytes::of(pipeline.gpu()),
    })
}

/// The same without a filter, with the samples that fit into its time; none where times are not known.
fn equal_time(settings: &RenderSettings, measured: &Measured) -> Option<RenderSettings> {
    let median = |stage: &str| timing(&measured.logs, |log| log.stage_ms(stage)).map(|t| t.median);
    let per_sample = median("trace")? / f64::from(settings.spp);
    let more = if per_sample > 0.0 { median("denoise")? / per_sample } else { 0.0 };
    let spp = (f64::from(settings.spp) + more).round().clamp(1.0, 65_535.0) as u32;
    let sets = settings.sets.iter().filter(|set| set.id != settings.denoiser).cloned().collect();
    Some(RenderSettings { denoiser: "identity".into(), spp, sets, ..settings.clone() })
}

fn timing(logs: &[FrameLog], of: impl Fn(&FrameLog) -> Option<f64>) -> Option<Timing> {
    Timing::of(&logs.iter().map(of).collect::<Option<Vec<f64>>>()?)
}

/// All but the errors.
fn row(
    comparison: &Comparison,
    settings: &RenderSettings,
    measured: &Measured,
    equal_time: Option<String>,
) -> Row {
    let stage = |name: &str| timing(&measured.logs, |log| log.stage_ms(name));
    // A structure that stands still is built in the frame that warms up.
    let build = |name: &str| measured.build.stage_ms(name).filter(|ms| *ms > 0.0);
    let at_once = |name: &str| {
        let ms = build(name)?;
        Some(Timing { median: ms, p95: ms, spread: 0.0 })
    };
    let memory = serde_json::to_value(&measured.memory).unwrap_or_default();
    let memory_bytes: BTreeMap<String, u64> = memory
        .as_object()
        .into_iter()
        .flatten()
        .filter_map(|(name, bytes)| Some((name.clone(), bytes.as_u64()?)))
        .collect();
    let moving = comparison.base.moving_share.is_some();
    Row {
        scene: settings.scene.clone(),
        tracer: settings.tracer.clone(),
        denoiser: settings.denoiser.clone(),
        upsampler: settings.upsampler.clone(),
        spp: settings.spp,
        grid: traces_voxels(&settings.tracer).then_some(settings.grid),
        knobs: settings.sets.iter().map(|s| (format!("{}.{}", s.id, s.knob), s.value.clone())).collect(),
        equal_time,
        stages_ms: StageTimes {
            tessellate: stage("tessellate"),
            voxel: if moving { stage("voxel") } else { at_once("voxel") },
            bvh: if moving { stage("bvh") } else { at_once("bvh") },
            gather: stage("gather"),
            trace: stage("trace"),
            denoise: stage("denoise"),
            upsample: stage("upsample"),
        },
        total_ms: timing(&measured.logs, FrameLog::total_ms),
        cpu_ms: Timing::of(&measured.seconds.iter().map(|s| 1e3 * s).collect::<Vec<_>>()).map(|t| t.median),
        build_ms: measured.build.counts.get("bvh_build_cpu_ms").copied(),
        bytes: Some(memory_bytes.iter().filter(|(name, _)| *name != "voxels_peak").map(|(_, b)| b).sum()),
        memory_bytes,
        ..Row::default()
    }
}

/// Writes the picture and adds a row per reference.
fn add(
    comparison: &Comparison,
    references: &References,
    row: &Row,
    measured: &Measured,
    rows: &mut Vec<Row>,
    pictures: &mut Vec<Picture>,
) -> Result<(), Error> {
    let mut id = row.configuration();
    if let Some(other) = &row.equal_time {
        id = format!("{id}, in the time of [{other}]");
    }
    let stem = file_stem(&id);
    let file = format!("{stem}.png");
    output::color_png(&comparison.out.join(&file), &measured.color, comparison.exposure)?;
    output::color_exr(&comparison.out.join(format!("{stem}.exr")), &measured.color)?;
    let heat = match heat_map(&measured.color, &references.bvh) {
        Some(map) => {
            let heat = format!("{stem}.error.png");
            output::color_png(&comparison.out.join(&heat), &map, 0.0)?;
            Some(heat)
        }
        None => None,
    };
    pictures.push(Picture { id, reference: false, file: file.clone(), heat });
    let voxel = row.grid.and_then(|grid| references.voxel.get(&grid));
    let all = [(Reference::Bvh, Some(&references.bvh)), (Reference::Voxel, voxel)];
    for (reference, image) in all.into_iter().filter_map(|(kind, image)| Some((kind, image?))) {
        rows.push(Row {
            reference,
            errors: errors(image, measured),
            image: Some(file.clone()),
            ..row.clone()
        });
    }
    Ok(())
}

/// Every figure; of a picture that holds what is no number, only how much of it.
fn errors(reference: &Color, measured: &Measured) -> Errors {
    match metrics::Errors::between(reference, &measured.color) {
        Ok(e) => Errors {
            rmse: Some(e.rmse),
            rel_mse: Some(e.rel_mse),
            smape: Some(e.smape),
            psnr: e.psnr,
            ssim: e.ssim,
            flip: Some(e.flip),
            hdr_flip: Some(e.hdr_flip),
            bias: match e.bias {
                [Some(r), Some(g), Some(b)] => Some([r, g, b]),
                _ => None,
            },
            nan_count: Some(0),
            temporal: measured.temporal,
            uncovered: measured.uncovered,
        },
        Err(MetricError::NotFinite { counts, .. }) => {
            Errors { nan_count: Some(counts.nan_count + counts.inf_count), ..Errors::default() }
        }
        Err(_) => Errors::default(),
    }
}

/// Letters and digits of a configuration, the rest as one underscore each; a long one ends in a name for all of it, for
/// file systems take 255 bytes.
fn file_stem(id: &str) -> String {
    let mut stem = String::new();
    for c in id.chars() {
        match c.is_ascii_alphanumeric() {
            true => stem.push(c),
            false if !stem.ends_with('_') => stem.push('_'),
            false => {}
        }
    }
    let stem = stem.trim_matches('_');
    match stem.get(..MOST_STEM) {
        Some(head) if stem.len() > MOST_STEM => {
            format!("{head}_{:016x}", xxhash_rust::xxh3::xxh3_64(id.as_bytes()))
        }
        _ => stem.to_owned(),
    }
}

/// Letters of a file name before it is cut.
const MOST_STEM: usize = 120;

/// Where references are kept when nobody says: the user's cache folder, else the system's scratch.
pub fn default_cache() -> PathBuf {
    let home = std::env::var_os("HOME").map(|home| Path::new(&home).join(".cache"));
    let cache = std::env::var_os("XDG_CACHE_HOME").map(PathBuf::from).or(home);
    cache.unwrap_or_else(std::env::temp_dir).join("gridlight/references")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn file_names_hold_letters_and_digits() {
        assert_eq!(
            file_stem("voxel + five_phase + nearest, 4 spp, grid 256"),
            "voxel_five_phase_nearest_4_spp_grid_256"
        );
        let [a, b] = ["1", "2"].map(|end| file_stem(&("x".repeat(300) + end)));
        assert!(a.len() < 200 && a != b, "{a} {b}");
    }
}
