//! The window: shows the pipeline's picture of a scene, and again whenever something moved or the size changed.
//!
//! `gridlight-viewer [SCENE]` takes the flags of `gridlight render` that decide a picture. Camera, sliders and pass
//! views come with their own issue.

mod blit;
mod window;

use clap::Parser;
use gridlight::cli::StreetArgs;
use gridlight::settings::{RenderSettings, View};
use std::process::ExitCode;

/// Anything that ends the viewer early; there is nobody to tell the kinds apart.
type Failure = Box<dyn std::error::Error>;

/// Pixels that a software adapter traces fast enough to look at.
const TRACE_SIZE: [u32; 2] = [320, 240];
/// Pixels of the picture; the window begins at this size.
const DISPLAY_SIZE: [u32; 2] = [640, 480];

/// The picture of a scene in a window.
#[derive(Debug, Parser)]
#[command(name = "gridlight-viewer", version)]
struct Args {
    #[command(flatten)]
    street: StreetArgs,
    /// Closes after this many frames.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    frames: Option<u32>,
}

fn main() -> ExitCode {
    let args = Args::parse();
    match settings(&args.street)
        .map_err(Failure::from)
        .and_then(|settings| window::run(settings, args.street.view.adapter, args.frames))
    {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => {
            eprintln!("error: {e}");
            ExitCode::FAILURE
        }
    }
}

/// Smaller pictures than the command line's, and the courtyard where no scene is named.
fn settings(street: &StreetArgs) -> Result<RenderSettings, gridlight::Error> {
    let courtyard = RenderSettings { view: View::Camera(0), ..Default::default() };
    let fixed_by_case = street.view.case.is_some();
    let mut settings = street.settings()?.unwrap_or(courtyard);
    if street.view.trace_size.is_none() && !fixed_by_case {
        settings.trace_size = TRACE_SIZE;
    }
    if street.view.display_size.is_none() && !fixed_by_case {
        settings.display_size = DISPLAY_SIZE;
    }
    Ok(settings)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn parsed(line: &str) -> RenderSettings {
        let args = Args::try_parse_from(["viewer"].into_iter().chain(line.split_whitespace())).unwrap();
        settings(&args.street).unwrap()
    }

    #[test]
    fn the_courtyard_through_its_own_camera_is_the_default() {
        let settings = parsed("--frames 3");
        assert_eq!((settings.scene.as_str(), settings.view), ("courtyard", View::Camera(0)));
        assert_eq!((settings.trace_size, settings.display_size), (TRACE_SIZE, DISPLAY_SIZE));
    }

    #[test]
    fn what_is_said_stands() {
        let settings = parsed("cornell --trace-size 16x9 --spp 1");
        assert_eq!((settings.scene.as_str(), settings.trace_size, settings.spp), ("cornell", [16, 9], 1));
        assert_eq!(settings.display_size, DISPLAY_SIZE);
    }
}
