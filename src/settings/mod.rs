//! What a render is asked for: one plain struct that the command line fills, the pipeline reads and logs repeat.
//!
//! Units: pixels, metres, seconds, radians, linear Rec. 709 radiance. Nothing here touches a GPU; [`open`] turns the
//! parts about the scene into a loaded [`scene::Scene`] and a camera.

pub mod camera_path;
pub mod case;
pub mod open;

pub use camera_path::{CameraKey, CameraPath};
pub use case::Case;

use serde::{Serialize, Serializer};
use std::path::PathBuf;

/// Everything that decides a picture.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RenderSettings {
    /// A built-in name, or the path of a `.gltf` or `.glb` file.
    pub scene: String,
    /// How materials are read.
    pub model: Model,
    /// Where from.
    pub view: View,
    /// Pixels before upsampling.
    pub trace_size: [u32; 2],
    /// Pixels after upsampling; its aspect is the frustum's.
    pub display_size: [u32; 2],
    /// Cells on the longest axis.
    pub grid: u32,
    /// Id of the tracer.
    pub tracer: String,
    /// Id of the denoiser.
    pub denoiser: String,
    /// Id of the upsampler.
    pub upsampler: String,
    /// Id of the tessellator.
    pub tessellator: String,
    /// Paths per trace pixel in a frame's mean.
    pub spp: u32,
    /// At most this many surface scatterings; none = no limit.
    #[serde(serialize_with = "number_or_inf")]
    pub bounces: Option<u32>,
    /// Of all random numbers.
    pub seed: u32,
    /// Which reading of every knob to start from.
    pub preset: Preset,
    /// Knobs set on top of the preset, in order.
    pub sets: Vec<KnobSetting>,
    /// Instead of the scene's own sky.
    pub sky: Option<SkySetting>,
    /// Instead of the scene's own sun.
    pub sun: Option<SunSetting>,
    /// Angle across the sun's disc in radians, whoever gave the sun.
    pub sun_angle: Option<f32>,
    /// Materials made to glow.
    pub emit: Vec<Emit>,
    /// Share of the connected parts that circles.
    pub moving_share: Option<f32>,
    /// Animation time of the first frame, s.
    pub time: f32,
    /// Frames in a row.
    pub frames: u32,
    /// Frames per second of animation.
    pub fps: f32,
    /// Most bytes that textures may take; none = all that is needed.
    pub texture_budget_bytes: Option<u64>,
    /// Most bytes that loading the scene, or its sky, may take.
    pub load_budget_bytes: u64,
}

impl Default for RenderSettings {
    /// The command line's defaults, with `courtyard`.
    fn default() -> Self {
        Self {
            scene: "courtyard".into(),
            model: Model::Gltf,
            view: View::Framing,
            trace_size: [640, 480],
            display_size: [1920, 1080],
            grid: 256,
            tracer: "voxel".into(),
            denoiser: "five_phase".into(),
            upsampler: "best_candidate".into(),
            tessellator: "identity".into(),
            // Below the paper's "maximum of six"; also what the noisy inputs of the shared references use.
            spp: 4,
            bounces: Some(3),
            seed: 1,
            preset: Preset::Default,
            sets: Vec::new(),
            sky: None,
            sun: None,
            sun_angle: None,
            emit: Vec::new(),
            moving_share: None,
            time: 0.0,
            frames: 1,
            fps: 30.0,
            texture_budget_bytes: None,
            load_budget_bytes: scene::LoadBudget::default().bytes,
        }
    }
}

/// How materials are read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Model {
    /// The glTF 2.0 reflection model.
    #[default]
    Gltf,
    /// Every surface Lambert with its base colour: no normal map, masks kept.
    Lambert,
}

/// A reading of every knob at once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Preset {
    /// Whatever measures best.
    #[default]
    Default,
    /// The paper's reading.
    Paper,
    /// The conventions of the shared references.
    Gltf,
}

impl Preset {
    /// What it sets, as (stage, knob, value); the rest stays as the stages have it.
    pub fn knobs(self) -> &'static [(&'static str, &'static str, &'static str)] {
        match self {
            Self::Default => &[],
            Self::Paper => &[
                ("voxel", "elevation", "voxel"),
                ("voxel", "axes", "dominant"),
                ("tracer", "samples", "roughness"),
                ("tracer", "lobe", "paper"),
                ("tracer", "fresnel", "schlick"),
                ("tracer", "noise", "paper"),
                ("tracer", "one_lobe", "on"),
                ("tracer", "shadow_rays", "off"),
                ("tracer", "next_event", "off"),
                ("tracer", "both_branches", "off"),
                ("best_candidate", "plane_test", "off"),
            ],
            Self::Gltf => &[
                ("gather", "mips", "off"),
                ("gather", "bend", "off"),
                ("tracer", "conventions", "reference"),
            ],
        }
    }
}

/// Where the camera comes from.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum View {
    /// The centre of the bounds, from (0.4, 0.3, 1) times the diagonal, at 45 degrees.
    Framing,
    /// A camera of the file, by number.
    Camera(usize),
    /// Given in full.
    LookAt(LookAt),
    /// Moves with the animation time.
    Path(CameraPath),
}

/// A camera in numbers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LookAt {
    /// Metres.
    pub eye: [f32; 3],
    /// A point looked at, metres.
    pub target: [f32; 3],
    /// Roughly up.
    pub up: [f32; 3],
    /// Vertical field of view, radians.
    pub vfov: f32,
}

impl LookAt {
    /// The field of view in degrees that convert to exactly its radians, where there are such.
    pub fn vfov_degrees(&self) -> f32 {
        exact_degrees(self.vfov)
    }
}

/// Degrees that convert to exactly these radians, where there are such.
pub(crate) fn exact_degrees(radians: f32) -> f32 {
    nearest(radians.to_degrees(), |degrees| degrees.to_radians() == radians)
}

/// The float nearest to a guess, up or down, that is right; the guess where none near it is.
pub(crate) fn nearest(guess: f32, is_right: impl Fn(f32) -> bool) -> f32 {
    let (mut up, mut down) = (guess, guess);
    // The conversion there and back rounds twice: a few steps reach what rounds alike.
    for _ in 0..16 {
        match [up, down].into_iter().find(|value| is_right(*value)) {
            Some(value) => return value,
            None => [up, down] = [up.next_up(), down.next_down()],
        }
    }
    guess
}

/// One `--set ID.knob=value`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct KnobSetting {
    /// Id of an implementation (`five_phase`) or of a stage (`voxel`, `gather`, `tracer`).
    pub id: String,
    /// Name within it.
    pub knob: String,
    /// As text; the knob knows what it takes.
    pub value: String,
}

/// A sky from the command line.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum SkySetting {
    /// The same radiance from everywhere.
    Constant([f32; 3]),
    /// An equirectangular `.hdr` or `.exr`.
    File(PathBuf),
}

/// A sun from the command line.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SunSetting {
    /// Direction the light travels along, any length but 0.
    pub direction: [f32; 3],
    /// Irradiance on a perpendicular plane.
    pub irradiance: [f32; 3],
}

/// One `--emit MATERIAL=r,g,b`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Emit {
    /// Name of the material.
    pub material: String,
    /// Emitted radiance.
    pub radiance: [f32; 3],
}

impl RenderSettings {
    /// Animation time of frame number `index`, s.
    pub fn frame_time(&self, index: u32) -> f32 {
        self.time + index as f32 / self.fps
    }

    /// The same at the moment of frame number `index`, and its view standing there: what a reference of that frame is
    /// converged with.
    pub fn at_frame(&self, index: u32) -> Self {
        let time = self.frame_time(index);
        let view = match &self.view {
            View::Path(path) => View::LookAt(path.at(time)),
            view => view.clone(),
        };
        Self { time, view, ..self.clone() }
    }

    /// Frames from this moment to the end of the camera's path; one where it has none.
    pub fn frames_of_path(&self) -> u32 {
        match &self.view {
            View::Path(path) => ((path.end() - self.time) * self.fps).round().max(0.0) as u32 + 1,
            _ => 1,
        }
    }

    /// The knobs set for this id, as (name, value).
    pub fn sets_for<'a>(&'a self, id: &'a str) -> impl Iterator<Item = (&'a str, &'a str)> {
        self.sets.iter().filter(move |s| s.id == id).map(|s| (s.knob.as_str(), s.value.as_str()))
    }
}

/// Infinity is no JSON number.
fn number_or_inf<S: Serializer>(bounces: &Option<u32>, serializer: S) -> Result<S::Ok, S::Error> {
    match bounces {
        Some(n) => serializer.serialize_u32(*n),
        None => serializer.serialize_str("inf"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unlimited_bounces_are_written_as_inf() {
        let written = |bounces| serde_json::to_value(RenderSettings { bounces, ..Default::default() });
        assert_eq!(written(Some(3)).ok().map(|v| v["bounces"].clone()), Some(3.into()));
        assert_eq!(written(None).ok().map(|v| v["bounces"].clone()), Some("inf".into()));
    }

    #[test]
    fn frames_are_spaced_by_fps_from_the_first_time_on() {
        let settings = RenderSettings { time: 2.0, fps: 25.0, ..Default::default() };
        assert_eq!([0, 1, 50].map(|k| settings.frame_time(k)), [2.0, 2.04, 4.0]);
    }
}
