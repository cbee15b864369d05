//! Settings as the `gridlight render` line that means them, and back.
//!
//! A line that was written reads back to the same settings, bit for bit: numbers are printed so that parsing gives the
//! same float, angles so that the conversion from degrees does. What is as by default is left out.

use super::args::{Cli, Command};
use crate::RenderSettings;
use crate::settings::{SkySetting, View, exact_degrees, nearest};
use clap::Parser;
use std::fmt::{Display, Formatter};
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// What a line says.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderLine {
    /// Everything but files' names.
    pub settings: RenderSettings,
    /// The file that a view along a path comes from.
    pub path_file: Option<PathBuf>,
}

impl Display for RenderLine {
    /// The line, into the folder `out`.
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        f.write_str(&render_line(&self.settings, self.path_file.as_deref()))
    }
}

impl FromStr for RenderLine {
    type Err = String;

    /// The words before the flags and `--out` may be left out; what is wrong is said as the command line says it.
    fn from_str(line: &str) -> Result<Self, String> {
        let words = words(line)?;
        let mut rest = words.as_slice();
        // A line from a shell may begin with a path to the program, or with cargo.
        if let Some(at) = rest.iter().position(|word| word == "render") {
            rest = &rest[at + 1..];
        }
        let mut all: Vec<&str> = vec!["gridlight", "render"];
        all.extend(rest.iter().map(String::as_str));
        if !rest.iter().any(|word| word == "--out" || word.starts_with("--out=")) {
            all.extend(["--out", "out"]);
        }
        match Cli::try_parse_from(all).map_err(|e| e.render().to_string())?.command {
            Command::Render(args) => Ok(Self {
                settings: args.settings().map_err(|e| e.to_string())?,
                path_file: args.street.view.path.clone(),
            }),
            _ => Err("the line is not one of gridlight render".into()),
        }
    }
}

fn render_line(settings: &RenderSettings, path_file: Option<&Path>) -> String {
    let plain = RenderSettings::default();
    let mut line = Line(vec!["gridlight".into(), "render".into(), settings.scene.clone()]);
    match &settings.view {
        View::Framing => {}
        View::Camera(index) => line.flag("--camera", index),
        View::LookAt(look) => {
            line.flag("--eye", joined(&look.eye));
            line.flag("--target", joined(&look.target));
            line.flag("--up", joined(&look.up));
            line.flag("--vfov", look.vfov_degrees());
        }
        View::Path(_) => line.flag("--path", path_file.unwrap_or(Path::new("path.json")).display()),
    }
    line.flag("--trace-size", sized(settings.trace_size));
    line.flag("--display-size", sized(settings.display_size));
    line.unless(&plain.grid, "--grid", &settings.grid);
    line.flag("--tracer", &settings.tracer);
    line.flag("--denoiser", &settings.denoiser);
    line.flag("--upsampler", &settings.upsampler);
    line.unless(&plain.tessellator, "--tessellator", &settings.tessellator);
    line.flag("--spp", settings.spp);
    match settings.bounces {
        None => line.flag("--bounces", "inf"),
        Some(bounces) => line.flag("--bounces", bounces),
    }
    line.flag("--seed", settings.seed);
    line.unless(&value_name(&plain.preset), "--preset", &value_name(&settings.preset));
    line.unless(&value_name(&plain.model), "--model", &value_name(&settings.model));
    for set in &settings.sets {
        line.flag("--set", format_args!("{}.{}={}", set.id, set.knob, set.value));
    }
    match &settings.sky {
        None => {}
        Some(SkySetting::Constant(radiance)) => line.flag("--sky", joined(radiance)),
        Some(SkySetting::File(path)) => line.flag("--sky", path.display()),
    }
    if let Some(sun) = settings.sun {
        line.flag("--sun", format_args!("{},{}", joined(&sun.direction), joined(&sun.irradiance)));
    }
    if let Some(angle) = settings.sun_angle {
        line.flag("--sun-angle", exact_degrees(angle));
    }
    for emit in &settings.emit {
        line.flag("--emit", format_args!("{}={}", emit.material, joined(&emit.radiance)));
    }
    if let Some(share) = settings.moving_share {
        line.flag("--move", share);
    }
    if let Some(bytes) = settings.texture_budget_bytes {
        line.flag("--budget-mb", megabytes(bytes));
    }
    line.unless(&megabytes(plain.load_budget_bytes), "--load-mb", &megabytes(settings.load_budget_bytes));
    line.unless(&plain.time, "--time", &settings.time);
    line.unless(&plain.fps, "--fps", &settings.fps);
    match settings.view {
        // Without a number a path is walked to its end.
        View::Path(_) => line.flag("--frames", settings.frames),
        _ => line.unless(&plain.frames, "--frames", &settings.frames),
    }
    line.flag("--out", "out");
    line.0.iter().map(|word| quoted(word)).collect::<Vec<_>>().join(" ")
}

struct Line(Vec<String>);

impl Line {
    fn flag(&mut self, flag: &str, value: impl Display) {
        self.0.push(flag.into());
        self.0.push(value.to_string());
    }

    fn unless<T: PartialEq + Display>(&mut self, default: &T, flag: &str, value: &T) {
        if value != default {
            self.flag(flag, value);
        }
    }
}

fn joined(numbers: &[f32; 3]) -> String {
    let [x, y, z] = numbers;
    format!("{x},{y},{z}")
}

fn sized([width, height]: [u32; 2]) -> String {
    format!("{width}x{height}")
}

fn value_name(value: &impl clap::ValueEnum) -> String {
    value.to_possible_value().map(|v| v.get_name().to_owned()).unwrap_or_default()
}

/// Megabytes that convert to exactly these bytes, where there are such.
fn megabytes(bytes: u64) -> f32 {
    nearest((bytes as f64 * 1e-6) as f32, |mb| (f64::from(mb) * 1e6) as u64 == bytes)
}

/// A word as a POSIX shell takes it.
fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "_-+.,/=:@%".contains(c);
    match !word.is_empty() && word.chars().all(is_plain) {
        true => word.into(),
        false => format!("'{}'", word.replace('\'', r"'\''")),
    }
}

/// Splits as a POSIX shell does: blanks, both quotes, backslashes.
fn words(line: &str) -> Result<Vec<String>, String> {
    let (mut words, mut word) = (Vec::new(), None::<String>);
    let mut quote = None;
    let mut characters = line.chars();
    while let Some(c) = characters.next() {
        match (quote, c) {
            (Some(q), c) if c == q => quote = None,
            (None, '\'' | '"') => {
                quote = Some(c);
                word.get_or_insert_default();
            }
            (None | Some('"'), '\\') => {
                // A line that was broken for the page goes on.
                if let Some(escaped) = characters.next().filter(|c| *c != '\n') {
                    word.get_or_insert_default().push(escaped);
                }
            }
            (None, c) if c.is_whitespace() => words.extend(word.take()),
            (_, c) => word.get_or_insert_default().push(c),
        }
    }
    words.extend(word);
    match quote {
        Some(q) => Err(format!("a {q} is not closed")),
        None => Ok(words),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::settings::{CameraKey, CameraPath, Emit, KnobSetting, LookAt, Model, Preset, SunSetting};

    #[test]
    fn everything_comes_back() {
        let settings = RenderSettings {
            scene: "my scenes/a's \"b\".glb".into(),
            model: Model::Lambert,
            view: View::LookAt(LookAt {
                eye: [-11.1, 2.2, -0.4],
                target: [1e-7, 3.0, 0.3],
                up: [0.0, 0.0, 1.0],
                vfov: 41.3f32.to_radians(),
            }),
            trace_size: [16, 9],
            display_size: [32, 18],
            grid: 64,
            tracer: "bvh_lbvh".into(),
            denoiser: "identity".into(),
            upsampler: "nearest".into(),
            tessellator: "identity".into(),
            spp: 2,
            bounces: None,
            seed: 9,
            preset: Preset::Paper,
            sets: vec![KnobSetting { id: "five_phase".into(), knob: "k0".into(), value: "2".into() }],
            sky: Some(SkySetting::File("sky maps/noon.hdr".into())),
            sun: Some(SunSetting { direction: [-0.1, -1.0, 0.2], irradiance: [4.0, 5.0, 6.0] }),
            sun_angle: Some(0.53f32.to_radians()),
            emit: vec![Emit { material: "the lamp".into(), radiance: [1.0, 2.0, 0.1] }],
            moving_share: Some(0.1),
            time: 1.5,
            frames: 7,
            fps: 25.0,
            texture_budget_bytes: Some(1_234_567),
            load_budget_bytes: 7_654_321,
        };
        let said = RenderLine { settings, path_file: None };
        let line = said.to_string();
        assert_eq!(line.parse::<RenderLine>().unwrap(), said, "{line}");
        for plain in [
            RenderSettings::default(),
            RenderSettings { view: View::Camera(2), ..Default::default() },
            RenderSettings { sky: Some(SkySetting::Constant([-0.0, 0.5, 1e9])), ..Default::default() },
        ] {
            let plain = RenderLine { settings: plain, path_file: None };
            assert_eq!(plain.to_string().parse::<RenderLine>().unwrap(), plain);
        }
    }

    #[test]
    fn a_path_comes_back_by_its_file() {
        let key = |time| CameraKey {
            time,
            eye: [1.0, 2.0, 3.0],
            target: [0.0; 3],
            up: [0.0, 1.0, 0.0],
            vfov: 50.0,
        };
        let path = CameraPath::new(vec![key(0.0), key(2.0)]).unwrap();
        let file = std::env::temp_dir().join(format!("gridlight-line-{}.json", std::process::id()));
        std::fs::write(&file, serde_json::to_string(&path).unwrap()).unwrap();
        let settings = RenderSettings { view: View::Path(path), ..Default::default() };
        let said = RenderLine { settings, path_file: Some(file.clone()) };
        let read = said.to_string().parse::<RenderLine>();
        std::fs::remove_file(&file).unwrap();
        assert_eq!(read.unwrap(), said, "one frame, not to the path's end");
    }

    #[test]
    fn every_angle_that_came_from_degrees_comes_back() {
        for tenth in 1..1800u32 {
            let radians = (tenth as f32 / 10.0).to_radians();
            assert_eq!(exact_degrees(radians).to_radians(), radians, "{tenth}");
        }
    }

    #[test]
    fn lines_from_elsewhere_are_read_or_refused() {
        let read = |line: &str| line.parse::<RenderLine>().map(|line| line.settings);
        let short = read("./target/release/gridlight render cornell \\\n --spp 2").unwrap();
        assert_eq!((short.scene.as_str(), short.spp), ("cornell", 2));
        assert_eq!(read("cornell --seed 3").unwrap().seed, 3);
        assert!(read("cornell --spp 0").unwrap_err().contains("1..=65535"));
        assert!(read("render 'cornell").unwrap_err().contains("not closed"));
        assert!(read("").unwrap_err().contains("scene"));
    }
}
