//! `--case NAME`: a view of the shared references, by its row in `cases.json`.
//!
//! A row names a scene and the arguments its reference was made with. The reference's own sample count is left out:
//! how many samples we take is ours to say.

use super::{LookAt, Model, RenderSettings, SkySetting, SunSetting, View};
use crate::Error;
use serde::Deserialize;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// Names the folder with `cases.json`; without it, that folder is `../shared/truth`.
pub const TRUTH_VARIABLE: &str = "GRIDLIGHT_TRUTH";

/// What a case fixes.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// Path of its glTF file.
    pub scene: PathBuf,
    /// How its materials are read.
    pub model: Model,
    /// Pixels, before and after upsampling.
    pub size: [u32; 2],
    /// Where from.
    pub view: View,
    /// Its sky, if any.
    pub sky: Option<SkySetting>,
    /// Its sun, if any.
    pub sun: Option<SunSetting>,
    /// Most surface scatterings; none = no limit.
    pub bounces: Option<u32>,
}

#[derive(Deserialize)]
struct Row {
    name: String,
    scene: String,
    args: String,
}

impl Case {
    /// Finds a row in the folder named by [`TRUTH_VARIABLE`], else in `../shared/truth`.
    ///
    /// # Errors
    /// No such table, no such row, or a row with arguments that mean nothing here.
    pub fn find(name: &str) -> Result<Self, Error> {
        let folder = std::env::var_os(TRUTH_VARIABLE).map_or_else(|| "../shared/truth".into(), PathBuf::from);
        Self::find_in(&folder, name)
    }

    /// Finds a row in a folder; scenes lie in the folder `scenes` beside it.
    ///
    /// # Errors
    /// No such table, no such row, or a row with arguments that mean nothing here.
    pub fn find_in(truth: &Path, name: &str) -> Result<Self, Error> {
        let table = truth.join("cases.json");
        let fail = |message: String| Error::Case { name: name.into(), message };
        let text = std::fs::read_to_string(&table)
            .map_err(|e| fail(format!("{}: {e} ({TRUTH_VARIABLE} names its folder)", table.display())))?;
        let rows: Vec<Row> =
            serde_json::from_str(&text).map_err(|e| fail(format!("{}: {e}", table.display())))?;
        let Some(row) = rows.iter().find(|row| row.name == name) else {
            let known = rows.iter().map(|row| row.name.as_str()).collect::<Vec<_>>().join(", ");
            return Err(fail(format!("no such case in {}; there are: {known}", table.display())));
        };
        Self::parse(row, &truth.join("../scenes")).map_err(fail)
    }

    fn parse(row: &Row, scenes: &Path) -> Result<Self, String> {
        let mut case = Self {
            scene: scenes.join(&row.scene),
            model: Model::Gltf,
            size: [0, 0],
            view: View::Framing,
            sky: None,
            sun: None,
            bounces: None,
        };
        let (mut eye, mut target, mut up, mut vfov) = (None, None, [0.0, 1.0, 0.0], 45f32.to_radians());
        let words: Vec<_> = row.args.split_whitespace().collect();
        let mut rest = words.as_slice();
        while let [flag, after @ ..] = rest {
            // A value may begin with one dash: -1 is a number.
            let count = after.iter().take_while(|word| !word.starts_with("--")).count();
            let (values, others) = after.split_at(count);
            rest = others;
            match *flag {
                "--pos" => eye = Some(numbers(flag, values)?),
                "--target" => target = Some(numbers(flag, values)?),
                "--up" => up = numbers(flag, values)?,
                "--fov" => vfov = one::<f32>(flag, values)?.to_radians(),
                "--camera" => case.view = View::Camera(one(flag, values)?),
                "--size" => case.size = numbers(flag, values)?,
                "--sky" => case.sky = Some(SkySetting::Constant(numbers(flag, values)?)),
                "--env" => {
                    let path: String = one(flag, values)?;
                    let path = path.replace("@SCENES", &scenes.display().to_string());
                    case.sky = Some(SkySetting::File(path.into()));
                }
                "--sun" => {
                    let [dx, dy, dz, r, g, b] = numbers(flag, values)?;
                    case.sun = Some(SunSetting { direction: [dx, dy, dz], irradiance: [r, g, b] });
                }
                "--bounces" => case.bounces = Some(one(flag, values)?),
                "--model" => {
                    let text: String = one(flag, values)?;
                    case.model = <Model as clap::ValueEnum>::from_str(&text, true)?;
                }
                "--spp" => {}
                _ => return Err(format!("argument {flag} is not understood")),
            }
        }
        if let (Some(eye), Some(target)) = (eye, target) {
            case.view = View::LookAt(LookAt { eye, target, up, vfov });
        }
        match case.size.contains(&0) {
            true => Err("it has no --size, or one of 0".into()),
            false => Ok(case),
        }
    }

    /// Writes the case over settings; what the command line says explicitly goes on top afterwards.
    pub fn apply(self, settings: &mut RenderSettings) {
        settings.scene = self.scene.display().to_string();
        settings.model = self.model;
        settings.trace_size = self.size;
        settings.display_size = self.size;
        settings.view = self.view;
        settings.sky = self.sky;
        settings.sun = self.sun;
        settings.bounces = self.bounces;
    }
}

/// Exactly one value.
fn one<T: FromStr>(flag: &str, values: &[&str]) -> Result<T, String> {
    let [value] = values else { return Err(format!("{flag} has {} values instead of 1", values.len())) };
    value.parse().map_err(|_| format!("{flag} {value}: not a number"))
}

/// Exactly `N` values.
fn numbers<T: FromStr, const N: usize>(flag: &str, values: &[&str]) -> Result<[T; N], String> {
    let parsed: Vec<T> = values.iter().map(|value| one(flag, &[value])).collect::<Result<_, _>>()?;
    parsed.try_into().map_err(|v: Vec<T>| format!("{flag} has {} values instead of {N}", v.len()))
}

#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::panic)]
mod tests {
    use super::*;

    fn parse(args: &str) -> Result<Case, String> {
        let row = Row { name: "view".into(), scene: "a/b.gltf".into(), args: args.into() };
        Case::parse(&row, Path::new("scenes"))
    }

    #[test]
    fn a_row_with_everything() {
        let case = parse(
            "--model lambert --pos 8 1.6 -0.3 --target -8 3 -0.3 --up 0 0 1 --fov 60 --env @SCENES/hdri/a.hdr \
             --sun -0.15 -1 -0.2 20 18 15 --bounces 4 --size 160 120 --spp 2048",
        )
        .unwrap();
        let view = LookAt {
            eye: [8.0, 1.6, -0.3],
            target: [-8.0, 3.0, -0.3],
            up: [0.0, 0.0, 1.0],
            vfov: 60f32.to_radians(),
        };
        let sun = SunSetting { direction: [-0.15, -1.0, -0.2], irradiance: [20.0, 18.0, 15.0] };
        let expected = Case {
            scene: "scenes/a/b.gltf".into(),
            model: Model::Lambert,
            size: [160, 120],
            view: View::LookAt(view),
            sky: Some(SkySetting::File("scenes/hdri/a.hdr".into())),
            sun: Some(sun),
            bounces: Some(4),
        };
        assert_eq!(case, expected);
    }

    #[test]
    fn no_bounces_means_no_limit_and_cameras_go_by_number() {
        let case = parse("--camera 2 --size 64 64 --sky 1 2 3").unwrap();
        assert_eq!((case.bounces, case.view), (None, View::Camera(2)));
        assert_eq!(case.sky, Some(SkySetting::Constant([1.0, 2.0, 3.0])));
    }

    #[test]
    fn rows_that_mean_nothing_say_which_argument() {
        for (args, part) in [
            ("--size 64", "--size has 1 values instead of 2"),
            ("--size 64 a", "--size a: not a number"),
            ("--size 64 64 --wavelength 500", "--wavelength is not understood"),
            ("--camera 0", "no --size"),
            ("--size 64 64 --sun 0 -1 0 1 1", "--sun has 5 values instead of 6"),
        ] {
            assert!(parse(args).unwrap_err().contains(part), "{args}");
        }
    }

    #[test]
    fn every_shared_case_is_understood_and_its_files_exist() {
        let truth = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/truth"));
        let Ok(text) = std::fs::read_to_string(truth.join("cases.json")) else {
            return println!("skipped: no {}", truth.display());
        };
        let rows: Vec<Row> = serde_json::from_str(&text).unwrap();
        assert!(!rows.is_empty());
        for row in rows {
            let case = Case::find_in(truth, &row.name).unwrap();
            assert!(case.scene.is_file(), "{}", case.scene.display());
            if let Some(SkySetting::File(path)) = &case.sky {
                assert!(path.is_file(), "{}", path.display());
            }
        }
        let unknown = Case::find_in(truth, "moon").unwrap_err().to_string();
        assert!(unknown.contains("moon") && unknown.contains("sponza_day_lambert"), "{unknown}");
    }
}
