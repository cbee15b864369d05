//! The subcommands and their flags; what is seen and by which stages is said alike everywhere ([`super::view`]).

use super::values;
use super::view::{BEST_BVH, StreetArgs, ViewArgs, stage_id};
use crate::Error;
use crate::foreign::DepthKind;
use crate::report::Shard;
use crate::settings::{KnobSetting, RenderSettings};
use crate::stages::Kind;
use clap::{Args, Parser, Subcommand};
use std::path::PathBuf;

/// Global illumination by path tracing through a voxel grid.
#[derive(Debug, Parser)]
#[command(name = "gridlight", version, subcommand_required = true, arg_required_else_help = true)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// The subcommands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Renders a scene: the whole street once, or --frames in a row.
    Render(RenderArgs),
    /// Converges an image that others are measured against; interrupted, it goes on where it stopped.
    Reference(ReferenceArgs),
    /// Filters a multi-layer EXR, ours or another renderer's, or a numbered sequence of them.
    Denoise(DenoiseArgs),
    /// Prints every error metric between two pictures as JSON.
    Metrics(MetricsArgs),
    /// Renders every combination of stages, timed and measured against converged references.
    Compare(CompareArgs),
    /// Lists scenes, stages and their knobs with unit, range and default.
    List(ListArgs),
    /// Describes the adapter; with a scene, what it needs and the bytes each part takes.
    Info(InfoArgs),
    /// Works on what comparisons wrote.
    #[command(subcommand)]
    Report(ReportCommand),
}

/// `gridlight report`.
#[derive(Debug, Subcommand)]
pub enum ReportCommand {
    /// Joins the shards of a comparison into the report that one run would have written.
    Merge {
        /// Folder for the whole; made where it is missing.
        out: PathBuf,
        /// Folders that `compare --shard i/n` wrote.
        #[arg(required = true, value_name = "SHARD")]
        shards: Vec<PathBuf>,
    },
}

/// `gridlight render`.
#[derive(Debug, Args)]
pub struct RenderArgs {
    /// What to render and how.
    #[command(flatten)]
    pub street: StreetArgs,
    /// Folder for the pictures and log.json; made where it is missing.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Frames in a row; files are then numbered, display.0001.png. With --path: to its end.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub frames: Option<u32>,
    /// Frames per second of animation [default: 30]
    #[arg(long, value_name = "F", allow_negative_numbers = true, value_parser = values::positive)]
    pub fps: Option<f32>,
    /// Stops added to the PNG's brightness; EXRs stay as they are.
    #[arg(long, value_name = "STOPS", default_value = "0", allow_hyphen_values = true, value_parser = values::finite)]
    pub exposure: f32,
    /// No progress bar and no table.
    #[arg(long)]
    pub quiet: bool,
    /// Prints the log as JSON instead of the table.
    #[arg(long)]
    pub json: bool,
}

/// `gridlight reference`.
#[derive(Debug, Args)]
pub struct ReferenceArgs {
    /// What to converge: at display size; --tracer bvh (the true image, default) or voxel; --spp at most.
    #[command(flatten)]
    pub street: StreetArgs,
    /// Stops once the root of the image's own relative squared error is at most this.
    #[arg(long, value_name = "REL_ERROR", value_parser = values::positive)]
    pub until: Option<f32>,
    /// Folder for reference.exr, stderr.exr, log.json and the state to go on from.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// No progress bar and no words.
    #[arg(long)]
    pub quiet: bool,
    /// Prints the summary as JSON.
    #[arg(long)]
    pub json: bool,
}

/// `gridlight compare`.
#[derive(Debug, Args)]
pub struct CompareArgs {
    /// What is seen, and what all combinations share.
    #[command(flatten)]
    pub view: ViewArgs,
    /// Instead of a scene: a suite of scenes, each with its own view and truth; at 64x48 and any number of bounces where
    /// nothing else is said.
    #[arg(long, value_name = "NAME", conflicts_with_all = ["scene", "case", "shard"])]
    pub suite: Option<Suite>,
    /// Who traces the light; a list.
    #[arg(long, value_name = "IDS", value_delimiter = ',', default_values = ["voxel", "bvh_cwbvh"], value_parser = stage_id(Kind::Tracer))]
    pub tracers: Vec<String>,
    /// Who removes the noise; a list.
    #[arg(long, value_name = "IDS", value_delimiter = ',', default_values = ["identity", "five_phase"], value_parser = stage_id(Kind::Denoiser))]
    pub denoisers: Vec<String>,
    /// Who lifts the light to display size; a list.
    #[arg(long, value_name = "IDS", value_delimiter = ',', default_values = ["best_candidate"], value_parser = stage_id(Kind::Upsampler))]
    pub upsamplers: Vec<String>,
    /// Paths per trace pixel; a list.
    #[arg(long, value_name = "NS", value_delimiter = ',', default_values = ["1", "4"], value_parser = clap::value_parser!(u32).range(1..=65535))]
    pub spp: Vec<u32>,
    /// Cells on the longest axis; a list.
    #[arg(long, visible_alias = "grid", value_name = "NS", value_delimiter = ',', default_values = ["256"], value_parser = clap::value_parser!(u32).range(8..=4096))]
    pub grids: Vec<u32>,
    /// Timed frames of each combination, after one that warms up [default: 5; with --path: to its end]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub frames: Option<u32>,
    /// Samples per pixel of each frame's two references where the view or the scene moves, for the temporal error; 0 leaves
    /// it out. What stands still needs none.
    #[arg(long, value_name = "N", default_value = "128", value_parser = clap::value_parser!(u32).range(..=65535))]
    pub temporal_spp: u32,
    /// Samples per pixel of the references.
    #[arg(long, value_name = "N", default_value = "1024", value_parser = clap::value_parser!(u32).range(2..))]
    pub reference_spp: u32,
    /// Seconds after which a reference is left as good as it is; the report says how good [default: 600 on adapters that
    /// are software, else none]
    #[arg(long, value_name = "SECONDS", value_parser = values::positive)]
    pub reference_seconds: Option<f32>,
    /// Where references are kept between runs [default: gridlight/references in the user's cache folder]
    #[arg(long, value_name = "DIR")]
    pub cache: Option<PathBuf>,
    /// The I-th of N shares of the combinations; `gridlight report merge` joins them.
    #[arg(long, value_name = "I/N", default_value = "1/1")]
    pub shard: Shard,
    /// Stops added to the pictures' brightness; EXRs stay as they are.
    #[arg(long, value_name = "STOPS", default_value = "0", allow_hyphen_values = true, value_parser = values::finite)]
    pub exposure: f32,
    /// Folder for the report; made where it is missing.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// No progress bar and no words.
    #[arg(long)]
    pub quiet: bool,
    /// Prints the rows as JSON.
    #[arg(long)]
    pub json: bool,
}

/// Scenes that `gridlight compare` brings along.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Suite {
    /// Scenes that break renderers.
    Hard,
}

/// `gridlight denoise`.
#[derive(Debug, Args)]
pub struct DenoiseArgs {
    /// The noisy picture with layers for normals and depth, better also albedo: linear EXR.
    #[arg(value_name = "IN.exr")]
    pub input: PathBuf,
    /// Who removes the noise.
    #[arg(long, value_name = "ID", value_parser = stage_id(Kind::Denoiser))]
    pub denoiser: String,
    /// The file to write; with --frames, the first of them.
    #[arg(long, value_name = "OUT.exr")]
    pub out: PathBuf,
    /// Vertical field of view that the picture was taken with, degrees.
    #[arg(long, value_name = "DEG", default_value = "45", value_parser = values::field_of_view)]
    pub vfov: f32,
    /// How the depth layer is measured; one called `distance` is always taken along the ray.
    #[arg(long, default_value = "z")]
    pub depth: DepthKind,
    /// Most megabytes (10^6 bytes) that reading a file may take; what asks for more is refused.
    #[arg(long, value_name = "MB", default_value = "2000", value_parser = values::positive)]
    pub load_mb: f32,
    /// Sets a knob of the denoiser; repeatable.
    #[arg(long, value_name = "ID.KNOB=VALUE", value_parser = values::knob)]
    pub set: Vec<KnobSetting>,
    /// A sequence of so many files, from IN.exr on by the number in its name, with motion vectors.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub frames: Option<u32>,
    /// Timed runs of a single picture, after one that warms up; the median is told.
    #[arg(long, value_name = "N", default_value = "5", value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub runs: u32,
    /// Graphics adapter whose name contains this.
    #[arg(long, value_name = "NAME")]
    pub adapter: Option<String>,
    /// No words.
    #[arg(long)]
    pub quiet: bool,
    /// Prints times and counts as JSON.
    #[arg(long)]
    pub json: bool,
}

/// `gridlight metrics`.
#[derive(Debug, Args)]
pub struct MetricsArgs {
    /// The picture taken for the truth: linear EXR.
    #[arg(value_name = "REFERENCE.exr")]
    pub reference: PathBuf,
    /// The picture that is judged: linear EXR of the same size.
    #[arg(value_name = "TEST.exr")]
    pub test: PathBuf,
    /// Most megabytes (10^6 bytes) that reading a file may take; what asks for more is refused.
    #[arg(long, value_name = "MB", default_value = "2000", value_parser = values::positive)]
    pub load_mb: f32,
    /// Stops added before the display's metrics (psnr, ssim, flip).
    #[arg(long, value_name = "STOPS", default_value = "0", allow_hyphen_values = true, value_parser = values::finite)]
    pub exposure: f32,
}

/// `gridlight list`.
#[derive(Debug, Args)]
pub struct ListArgs {
    /// Graphics adapter whose name contains this.
    #[arg(long, value_name = "NAME")]
    pub adapter: Option<String>,
    /// Prints JSON.
    #[arg(long)]
    pub json: bool,
}

/// `gridlight info`.
#[derive(Debug, Args)]
pub struct InfoArgs {
    /// What to describe, and how it would be rendered.
    #[command(flatten)]
    pub street: StreetArgs,
    /// Prints JSON.
    #[arg(long)]
    pub json: bool,
}

impl ReferenceArgs {
    /// The settings of a reference: stages that only a render has are the plainest, and both sizes are the picture's.
    ///
    /// # Errors
    /// As [`RenderArgs::settings`].
    pub fn settings(&self) -> Result<RenderSettings, Error> {
        let mut settings = self.street.settings()?.ok_or(Error::NoScene)?;
        if self.street.tracer.is_none() {
            settings.tracer = BEST_BVH.into();
        }
        settings.trace_size = settings.display_size;
        settings.denoiser = "identity".into();
        settings.upsampler = "nearest".into();
        settings.spp = 1;
        Ok(settings)
    }
}

impl RenderArgs {
    /// The settings of a render.
    ///
    /// # Errors
    /// Neither a scene nor a case, a case that is not there, or a camera that looks nowhere.
    pub fn settings(&self) -> Result<RenderSettings, Error> {
        let mut settings = self.street.settings()?.ok_or(Error::NoScene)?;
        settings.fps = self.fps.unwrap_or(settings.fps);
        // A path is walked to its end unless it is said how far.
        settings.frames = self.frames.unwrap_or_else(|| settings.frames_of_path());
        Ok(settings)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::panic)]
mod tests {
    use super::*;
    use crate::settings::{Model, Preset, SkySetting, View};

    fn settings(line: &str) -> Result<RenderSettings, String> {
        let words = ["gridlight", "render", "--out", "out"].into_iter().chain(line.split_whitespace());
        let Command::Render(args) = Cli::try_parse_from(words).map_err(|e| e.to_string())?.command else {
            panic!("not a render");
        };
        args.settings().map_err(|e| e.to_string())
    }

    #[test]
    fn the_definition_holds_together() {
        use clap::CommandFactory;
        Cli::command().debug_assert();
    }

    #[test]
    fn nothing_said_is_the_default() {
        let expected = RenderSettings { scene: "cornell".into(), ..Default::default() };
        assert_eq!(settings("cornell"), Ok(expected));
    }

    #[test]
    fn the_defaults_in_the_help_are_the_defaults() {
        let d = RenderSettings::default();
        assert_eq!((d.trace_size, d.display_size, d.grid), ([640, 480], [1920, 1080], 256));
        assert_eq!([&d.tracer, &d.denoiser, &d.upsampler], ["voxel", "five_phase", "best_candidate"]);
        assert_eq!((d.spp, d.bounces, d.seed, d.tessellator.as_str()), (4, Some(3), 1, "identity"));
        assert_eq!((d.preset, d.model, d.time, d.fps), (Preset::Default, Model::Gltf, 0.0, 30.0));
    }

    #[test]
    fn everything_said_arrives() {
        let s = settings(
            "a.glb --trace-size 16x9 --display-size 32x18 --grid 64 --denoiser none --upsampler best-candidate \
             --spp 2 --bounces inf --seed 9 --preset paper --set five_phase.k0=2 --set gather.x=1 --model lambert \
             --budget-mb 0.5 --emit lamp=1,2,3 --move 0.25 --eye -11,2.2,-0.4 --target 6,3.5,0 --vfov 90 \
             --sky -0,1,1 --sun 0,-1,0,1,1,1 --sun-angle 90 --time 1.5 --frames 3 --fps 25",
        )
        .unwrap();
        assert_eq!((s.trace_size, s.display_size, s.grid), ([16, 9], [32, 18], 64));
        assert_eq!((s.denoiser.as_str(), s.upsampler.as_str()), ("identity", "best_candidate"));
        assert_eq!((s.spp, s.bounces, s.seed, s.preset), (2, None, 9, Preset::Paper));
        assert_eq!((s.sets.len(), s.emit.len(), s.moving_share), (2, 1, Some(0.25)));
        assert_eq!((s.model, s.texture_budget_bytes), (Model::Lambert, Some(500_000)));
        let View::LookAt(view) = s.view else { panic!("{:?}", s.view) };
        assert_eq!((view.eye, view.up), ([-11.0, 2.2, -0.4], [0.0, 1.0, 0.0]));
        assert_eq!(
            (view.vfov, s.sun_angle),
            (std::f32::consts::FRAC_PI_2, Some(std::f32::consts::FRAC_PI_2))
        );
        assert_eq!(
            (s.sky, s.time, s.frames, s.fps),
            (Some(SkySetting::Constant([0.0, 1.0, 1.0])), 1.5, 3, 25.0)
        );
    }

    #[test]
    fn a_path_is_walked_to_its_end_unless_it_is_said_how_far() {
        let file = std::env::temp_dir().join(format!("gridlight-walk-{}.json", std::process::id()));
        std::fs::write(
            &file,
            r#"{"keys":[{"time":0,"eye":[0,0,0],"target":[0,0,-1]},{"time":2,"eye":[1,0,0],"target":[0,0,-1]}]}"#,
        )
        .unwrap();
        let of = |more: &str| settings(&format!("cornell --path {} {more}", file.display())).unwrap();
        assert_eq!(of("").frames, 61);
        assert_eq!(of("--fps 10 --time 0.5").frames, 16);
        assert_eq!(of("--frames 3").frames, 3);
        assert!(matches!(of("").view, View::Path(path) if path.keys().len() == 2));
        std::fs::remove_file(&file).unwrap();
    }

    #[test]
    fn what_is_wrong_is_said() {
        for (line, part) in [
            ("", "a scene or --case"),
            ("cornell --trace-size 0x5", "WIDTHxHEIGHT"),
            ("cornell --grid 4", "8..=4096"),
            ("cornell --spp 0", "1..=65535"),
            ("cornell --tracer raster", "there are: voxel"),
            ("cornell --eye 1,2,3", "--target"),
            ("cornell --eye 1,2,3 --target 1,2,3", "looks nowhere"),
            ("cornell --camera 0 --eye 1,2,3 --target 0,0,0", "cannot be used with"),
            ("cornell --camera 0 --path walk.json", "cannot be used with"),
            ("cornell --path no_such_walk.json", "no_such_walk.json: "),
            ("cornell --case b", "cannot be used with"),
            ("cornell --fps 0", "above 0"),
            ("cornell --frames 0", "1.."),
            ("cornell --time -1", "0 or more"),
            ("cornell --bounces x", "or inf"),
            ("cornell --preset fast", "possible values"),
            ("cornell --set k0", "ID.knob=value"),
        ] {
            let message = settings(line).unwrap_err();
            assert!(message.contains(part), "{line}: {message}");
        }
    }
}
