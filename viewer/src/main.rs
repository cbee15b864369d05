//! The window: walk around a scene, swap any stage, see what each pass costs and what the picture gets wrong.
//!
//! `gridlight-viewer [SCENE]` takes the flags of `gridlight render` that decide a picture. [`session`] is what the user
//! asked for, [`shown`] what came back, [`panels`] are functions over both; the [`worker`] renders on a thread and a device
//! of its own, the [`painter`] draws on another; the [`window`] only passes things on. [`mod@script`] plays a user, for tests and for pictures of the window.

mod canvas;
mod painter;
mod panels;
mod picture;
mod script;
mod session;
mod shown;
mod store;
mod widgets;
mod window;
mod worker;

use clap::Parser;
use gridlight::cli::StreetArgs;
use gridlight::settings::{RenderSettings, View};
use script::Script;
use std::path::PathBuf;
use std::process::ExitCode;

/// Anything that ends the viewer early; there is nobody to tell the kinds apart.
type Failure = Box<dyn std::error::Error>;

/// Of the window.
const TITLE: &str = "gridlight";

/// The folder whose shaders are built in. Elsewhere it is not there, and nothing is followed.
const BUILT_IN: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");

/// Pixels that a software adapter traces fast enough to look at.
const TRACE_SIZE: [u32; 2] = [320, 240];
/// Pixels of the picture.
const DISPLAY_SIZE: [u32; 2] = [640, 480];

/// A scene in a window, with everything that decides its picture.
#[derive(Debug, Parser)]
#[command(name = "gridlight-viewer", version)]
struct Args {
    #[command(flatten)]
    street: StreetArgs,
    /// A resting view stands after this many frames [default: 1]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    frames: Option<u32>,
    /// Saves the window as PNG once --after-frames are there, and closes.
    #[arg(long, value_name = "FILE")]
    screenshot: Option<PathBuf>,
    /// Closes after this many frames [default with --screenshot: 1]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    after_frames: Option<u64>,
    /// Does the steps in this file, as src/script.rs lists them.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["screenshot", "after_frames"])]
    script: Option<PathBuf>,
    /// Shaders in this folder and below are followed when they are edited [default: where the program was built]
    #[arg(long, value_name = "DIR")]
    shaders: Option<PathBuf>,
    /// Pixels of the window [default: 1440x900]
    #[arg(long, value_name = "WxH", value_parser = size)]
    window_size: Option<[u32; 2]>,
}

fn size(text: &str) -> Result<[u32; 2], String> {
    let sides = text.split_once('x').and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    sides.filter(|sides| !sides.contains(&0)).ok_or_else(|| "a size is WIDTHxHEIGHT, like 1440x900".into())
}

fn main() -> ExitCode {
    match run(&Args::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => {
            eprintln!("error: {e}");
            ExitCode::FAILURE
        }
    }
}

fn run(args: &Args) -> Result<(), Failure> {
    window::run(window::Options {
        settings: settings(args)?,
        adapter: args.street.view.adapter.clone(),
        script: script(args)?,
        size: args.window_size,
        shaders: args.shaders.clone().unwrap_or_else(|| BUILT_IN.into()),
    })
}

/// Smaller pictures than the command line's, and the courtyard where no scene is named.
fn settings(args: &Args) -> Result<RenderSettings, gridlight::Error> {
    let street = &args.street;
    let courtyard = RenderSettings { view: View::Camera(0), ..Default::default() };
    let fixed_by_case = street.view.case.is_some();
    let mut settings = street.settings()?.unwrap_or(courtyard);
    if street.view.trace_size.is_none() && !fixed_by_case {
        settings.trace_size = TRACE_SIZE;
    }
    if street.view.display_size.is_none() && !fixed_by_case {
        settings.display_size = DISPLAY_SIZE;
    }
    settings.frames = args.frames.unwrap_or(settings.frames);
    Ok(settings)
}

/// The script of the file, or the two steps that a screenshot takes.
fn script(args: &Args) -> Result<Option<Script>, Failure> {
    if let Some(path) = &args.script {
        let text = std::fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))?;
        return Ok(Some(Script::parse(&text).map_err(|e| format!("{}: {e}", path.display()))?));
    }
    let mut steps = match (args.after_frames, &args.screenshot) {
        (None, None) => return Ok(None),
        (frames, _) => format!("frames {}\n", frames.unwrap_or(1)),
    };
    if let Some(file) = &args.screenshot {
        steps += &format!("screenshot {}\n", file.display());
    }
    Ok(Some(Script::parse(&(steps + "quit"))?))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn parsed(line: &str) -> RenderSettings {
        let args = Args::try_parse_from(["viewer"].into_iter().chain(line.split_whitespace())).unwrap();
        settings(&args).unwrap()
    }

    #[test]
    fn the_courtyard_through_its_own_camera_is_the_default() {
        let settings = parsed("--after-frames 3");
        assert_eq!((settings.scene.as_str(), settings.view), ("courtyard", View::Camera(0)));
        assert_eq!((settings.trace_size, settings.display_size), (TRACE_SIZE, DISPLAY_SIZE));
    }

    #[test]
    fn what_is_said_stands() {
        let settings = parsed("cornell --trace-size 16x9 --spp 1 --frames 2");
        assert_eq!((settings.scene.as_str(), settings.trace_size, settings.spp), ("cornell", [16, 9], 1));
        assert_eq!((settings.display_size, settings.frames), (DISPLAY_SIZE, 2));
    }
}
