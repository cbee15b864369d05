//! `gridlight compare --suite hard`: every tracer and denoiser on scenes that break renderers.
//!
//! In: lists of stages. Out: a folder with `rows.csv`, `rows.json` and `report.md`: per scene ([`scene::built_in::hard`])
//! and combination the error against a closed form (or, where there is none, against converged triangles), the energy
//! lost, what of any stage's output is no radiance, and how much a still picture changes from frame to frame.
//!
//! **Energy lost** is `1 - mean(test) / mean(truth)`, negative where light was made; none where the truth is black.
//! **Temporal error** is that of the data contract for a camera that stands still: the references do not change, so it
//! is `sqrt(mean((x_k - x_(k-1))^2))` over pixel-channels and frames.
//! **Strange values** are counted by [`strange`] over every texture that a frame makes, at every frame.

mod row;
pub mod strange;

pub use row::{Report, Row, TruthKind};

use crate::compare::Lists;
use crate::pipeline::Pipeline;
use crate::reference::{self, Goal};
use crate::report::Shard;
use crate::settings::View;
use crate::{Error, Progress, RenderSettings, metrics, output};
use frame::Gpu;
use frame::cpu::Image;
use scene::built_in::hard::{self, HardScene, Truth};
use std::path::PathBuf;
use strange::Strange;
use tracer::Search;

/// Linear radiance.
type Color = Image<[f32; 3]>;

/// What is run, and where it goes.
#[derive(Clone, Debug)]
pub struct Suite {
    /// Sizes, knobs and all that the combinations share; scene, view, sky and sun are the cases'.
    pub base: RenderSettings,
    /// What is combined.
    pub lists: Lists,
    /// Frames of each, at least two.
    pub frames: u32,
    /// When references are good enough, for scenes without a closed form.
    pub goal: Goal,
    /// Where references are kept between runs.
    pub cache: PathBuf,
    /// Where everything is written.
    pub out: PathBuf,
    /// The command line, for the report.
    pub command: String,
}

/// What the suite asks for where nobody says: small pictures, any number of bounces, without which closed forms do not
/// hold.
pub fn base() -> RenderSettings {
    RenderSettings {
        trace_size: [64, 48],
        display_size: [64, 48],
        view: View::Camera(0),
        bounces: None,
        ..Default::default()
    }
}

/// Renders and measures every combination on every scene.
///
/// # Errors
/// A setting or adapter that will not do, or a file that cannot be written.
pub fn run(suite: &Suite, gpu: &Gpu, progress: &Progress) -> Result<Report, Error> {
    output::folder(&suite.out)?;
    let mut rows = Vec::new();
    for (k, case) in hard::all().iter().enumerate() {
        progress.report(case.name, k as f32 / hard::all().len() as f32);
        let base = RenderSettings { scene: case.name.into(), view: View::Camera(0), ..suite.base.clone() };
        let combinations = suite.lists.combinations(&base, Shard::default());
        let Some(first) = combinations.first() else { continue };
        let mut pipeline = Pipeline::of_scene(gpu.clone(), (case.build)(), first, Progress::default())?;
        let truth = truth(case, &mut pipeline, suite)?;
        for settings in &combinations {
            pipeline.change(settings)?;
            rows.push(measure(case, &mut pipeline, &truth, suite.frames)?);
        }
    }
    let adapter = format!("{} ({} {})", gpu.info.name, gpu.info.driver, gpu.info.driver_info);
    let report = Report { command: suite.command.clone(), adapter, rows };
    report.write(&suite.out)?;
    Ok(report)
}

/// The picture that a case should make.
fn truth(case: &HardScene, pipeline: &mut Pipeline, suite: &Suite) -> Result<Color, Error> {
    match case.truth {
        Truth::Everywhere(radiance) => Ok(Image::filled(suite.base.display_size, [radiance; 3])),
        Truth::Converged => {
            let folder = suite.cache.join(reference::key_name(&reference::key(pipeline, Search::Cwbvh)));
            Ok(reference::run(pipeline, Search::Cwbvh, suite.goal, &folder)?.mean)
        }
    }
}

/// Renders `frames` frames of what the pipeline is set to and measures them.
///
/// # Errors
/// The device was lost or is out of memory.
pub fn measure(
    case: &HardScene,
    pipeline: &mut Pipeline,
    truth: &Image<[f32; 3]>,
    frames: u32,
) -> Result<Row, Error> {
    let mut strange = Strange::default();
    let (mut cut_rays, mut squares, mut steps) = (0.0, 0.0, 0_u32);
    let mut last: Option<Color> = None;
    for _ in 0..frames.max(2) {
        let rendered = pipeline.render()?;
        strange += strange::of(pipeline.gpu(), &rendered)?;
        cut_rays += rendered.log.counts.get("cut_rays").copied().unwrap_or(0.0);
        let color = output::color(pipeline.gpu(), &rendered.color, rendered.frame.radiance_scale)?;
        if let Some(last) = &last {
            squares += mean_square_change(last, &color);
            steps += 1;
        }
        last = Some(color);
    }
    let Some(last) = last else { unreachable!("at least two frames were rendered") };
    let settings = pipeline.settings();
    let (is, should) = (mean(&last), mean(truth));
    Ok(Row {
        scene: case.name.into(),
        tracer: settings.tracer.clone(),
        denoiser: settings.denoiser.clone(),
        upsampler: settings.upsampler.clone(),
        spp: settings.spp,
        grid: settings.tracer.starts_with("voxel").then_some(settings.grid),
        truth: TruthKind::of(case.truth),
        rel_mse: metrics::rel_mse(truth, &last).ok().filter(|e| e.is_finite()),
        energy_lost: (should > 0.0).then(|| 1.0 - is / should).filter(|e| e.is_finite()),
        strange,
        cut_rays,
        temporal: Some((squares / f64::from(steps.max(1))).sqrt()).filter(|e| e.is_finite()),
    })
}

fn mean_square_change(last: &Color, this: &Color) -> f64 {
    let channels = last.texels().as_flattened().iter().zip(this.texels().as_flattened());
    let sum: f64 = channels.map(|(a, b)| (f64::from(*b) - f64::from(*a)).powi(2)).sum();
    sum / this.texels().as_flattened().len().max(1) as f64
}

/// Over all channels.
fn mean(picture: &Color) -> f64 {
    let channels = picture.texels().as_flattened();
    channels.iter().map(|v| f64::from(*v)).sum::<f64>() / channels.len().max(1) as f64
}
