//! `gridlight denoise`: filters a picture that another renderer wrote, or a numbered sequence of them.

use super::args::DenoiseArgs;
use super::{json, print, values};
use crate::foreign::{Bench, DepthKind, Light, Picture, View, view};
use crate::input::read_exr_layers_within;
use crate::{Error, output, pipeline};
use frame::{FrameInfo, Gpu};
use scene::LoadBudget;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

#[derive(Serialize)]
struct Report {
    denoiser: String,
    adapter: String,
    frames: Vec<Frame>,
}

#[derive(Serialize)]
struct Frame {
    input: PathBuf,
    output: PathBuf,
    size: [u32; 2],
    /// Median of warm runs; a sequence has one each.
    wall_ms: f64,
    /// Of the passes alone, as the device times them.
    gpu_ms: Option<f64>,
    radiance_scale: f32,
    counts: BTreeMap<String, f64>,
}

/// Filters what the arguments say.
pub fn run(args: &DenoiseArgs) -> Result<(), Error> {
    let gpu = Gpu::new(args.adapter.as_deref())?;
    let adapter = gpu.info.name.clone();
    let count = args.frames.unwrap_or(1);
    let budget = LoadBudget { bytes: values::bytes(args.load_mb) };
    let mut denoiser = pipeline::denoiser(&gpu, &args.denoiser)?;
    pipeline::set_knobs(denoiser.name(), &mut denoiser.knobs(), &args.set)?;

    let (name, guides) = (denoiser.name(), denoiser.guides());
    let mut waiting = Some(denoiser);
    let mut bench: Option<Bench> = None;
    let mut frames: Vec<Frame> = Vec::new();
    for index in 0..count {
        let (input, out) = (nth(&args.input, index)?, nth(&args.out, index)?);
        let layers = read_exr_layers_within(&input, budget)?;
        if let Some(first) = frames.first().filter(|first| first.size != layers.size()) {
            let ([w, h], [v, g]) = (layers.size(), first.size);
            let message = format!("is {w}x{h}, the sequence began with {v}x{g}");
            return Err(Error::Read { path: input, message });
        }
        let size = layers.size();
        let picture = Picture::of(&input, &layers, name, guides, count > 1)?;
        let kind = if picture.depth_is_distance { DepthKind::Ray } else { args.depth };
        let light = Light::of(&picture);
        let frame = FrameInfo {
            frame_index: index,
            restart: index == 0,
            radiance_scale: light.scale(),
            ..FrameInfo::still(view::camera(args.vfov), size)
        };
        let has_specular = light.has_specular();
        let bench = match (&mut bench, waiting.take()) {
            (Some(bench), _) => bench,
            (none, Some(denoiser)) => none.insert(Bench::new(gpu.clone(), denoiser, size, has_specular)?),
            (None, None) => break,
        };
        if bench.has_specular() != has_specular {
            let message = "its roughness layer, or lack of one, is not the first file's".into();
            return Err(Error::Read { path: input, message });
        }
        let view = View::of(picture.depth.as_ref(), kind, &frame);
        bench.upload(&picture, &view, &light);
        // A sequence goes on from frame to frame: no frame is run twice, and only the first one compiles.
        let (warm, runs) = if count > 1 { (0, 1) } else { (1, args.runs) };
        for _ in 0..warm {
            bench.run(&frame)?;
        }
        let mut timed = (0..runs).map(|_| bench.run(&frame)).collect::<Result<Vec<_>, _>>()?;
        timed.sort_by(|a, b| a.wall_ms.total_cmp(&b.wall_ms));
        let middle = timed.len() / 2;
        let Some(median) = timed.get(middle) else { break };
        write(&out, &bench.picture(median, &picture, &view, &light)?, picture.lobes.is_some())?;
        frames.push(Frame {
            input,
            output: out,
            size,
            wall_ms: median.wall_ms,
            gpu_ms: median.log.total_ms(),
            radiance_scale: light.scale(),
            counts: median.log.counts.clone(),
        });
    }
    if args.json {
        return print(&json(&Report { denoiser: args.denoiser.clone(), adapter, frames })?);
    }
    if !args.quiet {
        for frame in &frames {
            let of_passes = frame.gpu_ms.map_or(String::new(), |ms| format!(", passes {ms:.2} ms"));
            let path = frame.output.display();
            print(&format!("{path}: {} {:.2} ms{of_passes}\n", args.denoiser, frame.wall_ms))?;
        }
    }
    Ok(())
}

/// One picture, or both lobes where the file had both.
fn write(path: &Path, lobes: &[frame::cpu::Image<[f32; 3]>; 2], are_apart: bool) -> Result<(), Error> {
    if let Some(folder) = path.parent().filter(|folder| !folder.as_os_str().is_empty()) {
        output::folder(folder)?;
    }
    match are_apart {
        true => output::lobes_exr(path, lobes),
        false => output::color_exr(path, &lobes[0]),
    }
}

/// The file `index` numbers after this one: the last digits of the name are counted up, as wide as they are.
fn nth(path: &Path, index: u32) -> Result<PathBuf, Error> {
    if index == 0 {
        return Ok(path.into());
    }
    let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    let end = name.rfind(|c: char| c.is_ascii_digit()).map_or(0, |last| last + 1);
    let begin = name[..end].rfind(|c: char| !c.is_ascii_digit()).map_or(0, |before| before + 1);
    let digits = &name[begin..end];
    let number: u32 = digits.parse().map_err(|_| Error::Read {
        path: path.into(),
        message: "--frames needs a number in the file's name, like in.0001.exr".into(),
    })?;
    let width = digits.len();
    let name = format!("{}{:0width$}{}", &name[..begin], number.saturating_add(index), &name[end..]);
    Ok(path.with_file_name(name))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn a_sequence_counts_the_last_number_up() {
        let nth = |path: &str, index| nth(Path::new(path), index).unwrap();
        assert_eq!(nth("a/in.0009.exr", 1), Path::new("a/in.0010.exr"));
        assert_eq!(nth("shot2_099_beauty.exr", 2), Path::new("shot2_101_beauty.exr"));
        assert_eq!(nth("any.exr", 0), Path::new("any.exr"));
        assert!(super::nth(Path::new("any.exr"), 1).unwrap_err().to_string().contains("in.0001.exr"));
    }
}
