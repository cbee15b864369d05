//! `gridlight render`: the whole street, and files of what came out.

use super::args::RenderArgs;
use super::bar::Bar;
use super::{json, print, table};
use crate::output::{self, log, numbered};
use crate::pipeline::{Pipeline, Rendered};
use crate::{Error, RenderSettings};
use frame::Gpu;
use std::path::Path;

/// Renders what the arguments say.
pub fn run(args: &RenderArgs) -> Result<(), Error> {
    let settings = args.settings()?;
    let gpu = Gpu::new(args.street.view.adapter.as_deref())?;
    let (bar, progress) = Bar::new(args.quiet);
    let mut pipeline = Pipeline::new(gpu, &settings, progress)?;
    pipeline.warnings().iter().for_each(|warning| bar.note(&format!("warning: {warning}")));
    // Before the work, so that a folder that cannot be made does not cost it.
    output::folder(&args.out)?;
    // Numbered if frames were asked for, even a single one: scripts can then count on the names.
    let numbers = args.frames.is_some() || settings.frames > 1;
    let mut frames = Vec::new();
    for index in 0..settings.frames {
        bar.frame(index, settings.frames);
        let rendered = pipeline.render()?;
        write(&args.out, numbers.then_some(index + 1), args.exposure, pipeline.gpu(), &rendered)?;
        frames.push(log::Frame::of(&rendered.log));
    }
    drop(bar);
    report(args, settings, pipeline.gpu(), frames)
}

/// The files of one frame.
fn write(
    folder: &Path,
    number: Option<u32>,
    exposure_stops: f32,
    gpu: &Gpu,
    rendered: &Rendered,
) -> Result<(), Error> {
    let radiance_scale = rendered.frame.radiance_scale;
    let color = output::color(gpu, &rendered.color, radiance_scale)?;
    output::color_png(&numbered(folder, "display", number, "png"), &color, exposure_stops)?;
    output::color_exr(&numbered(folder, "display", number, "exr"), &color)?;
    let light = numbered(folder, "light", number, "exr");
    output::light_exr(&light, gpu, &rendered.trace, &rendered.noisy, &rendered.denoised, radiance_scale)
}

/// The log as a file, and a table or JSON on stdout.
fn report(
    args: &RenderArgs,
    settings: RenderSettings,
    gpu: &Gpu,
    frames: Vec<log::Frame>,
) -> Result<(), Error> {
    let log = log::Log {
        adapter: log::Adapter::of(gpu),
        settings,
        frames,
        memory_bytes: log::MemoryBytes::of(gpu),
    };
    let text = json(&log)?;
    output::write(&args.out.join("log.json"), text.as_bytes())?;
    match (args.json, args.quiet) {
        (true, _) => print(&text),
        (false, true) => Ok(()),
        (false, false) => {
            print(&format!("{}wrote {}\n", table::milliseconds(&log.frames), args.out.display()))
        }
    }
}
