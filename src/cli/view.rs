//! What is seen and by which stages: defaults, then the case, then what was said explicitly.

use super::values::{self, Bounces};
use crate::Error;
use crate::settings::{
    CameraPath, Case, Emit, KnobSetting, LookAt, Model, Preset, RenderSettings, SkySetting, SunSetting, View,
};
use crate::stages::Kind;
use clap::Args;
use std::path::PathBuf;

/// Flags that decide a picture.
#[derive(Debug, Default, Args)]
pub struct StreetArgs {
    /// What is seen, and what all stages share.
    #[command(flatten)]
    pub view: ViewArgs,
    /// Cells on the longest axis [default: 256]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(8..=4096))]
    pub grid: Option<u32>,
    /// Who traces the light [default: voxel]
    #[arg(long, value_name = "ID", value_parser = stage_id(Kind::Tracer))]
    pub tracer: Option<String>,
    /// Who removes the noise [default: five_phase]
    #[arg(long, value_name = "ID", value_parser = stage_id(Kind::Denoiser))]
    pub denoiser: Option<String>,
    /// Who lifts the light to display size [default: best_candidate]
    #[arg(long, value_name = "ID", value_parser = stage_id(Kind::Upsampler))]
    pub upsampler: Option<String>,
    /// Paths per trace pixel [default: 4]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=65535))]
    pub spp: Option<u32>,
}

/// Flags that say what is seen, from where, and what all stages share.
#[derive(Debug, Default, Args)]
pub struct ViewArgs {
    /// A built-in scene (see `gridlight list`), or a .gltf or .glb file.
    pub scene: Option<String>,
    /// A view of the shared references: a row of cases.json, found in $GRIDLIGHT_TRUTH or ../shared/truth.
    #[arg(long, value_name = "NAME", conflicts_with = "scene")]
    pub case: Option<String>,
    /// Pixels before upsampling [default: 640x480]
    #[arg(long, value_name = "WxH", value_parser = values::size)]
    pub trace_size: Option<[u32; 2]>,
    /// Pixels after upsampling [default: 1920x1080]
    #[arg(long, value_name = "WxH", value_parser = values::size)]
    pub display_size: Option<[u32; 2]>,
    /// Who refines the meshes [default: identity]
    #[arg(long, value_name = "ID", value_parser = stage_id(Kind::Tessellator))]
    pub tessellator: Option<String>,
    /// At most this many surface scatterings, or inf [default: 3]
    #[arg(long, value_name = "N", value_parser = values::bounces)]
    pub bounces: Option<Bounces>,
    /// Of all random numbers [default: 1]
    #[arg(long, value_name = "N")]
    pub seed: Option<u32>,
    /// Which reading of every knob to start from [default: default]
    #[arg(long)]
    pub preset: Option<Preset>,
    /// Sets a knob; repeatable.
    #[arg(long, value_name = "ID.KNOB=VALUE", value_parser = values::knob)]
    pub set: Vec<KnobSetting>,
    /// How materials are read [default: gltf]
    #[arg(long)]
    pub model: Option<Model>,
    /// Most megabytes (10^6 bytes) that textures may take; larger ones are scaled down.
    #[arg(long, value_name = "MB", value_parser = values::positive)]
    pub budget_mb: Option<f32>,
    /// Most megabytes (10^6 bytes) that loading the scene or its sky may take; what asks for more is refused [default: 2000]
    #[arg(long, value_name = "MB", value_parser = values::positive)]
    pub load_mb: Option<f32>,
    /// Makes a material glow; repeatable.
    #[arg(long, value_name = "MATERIAL=R,G,B", value_parser = values::emit)]
    pub emit: Vec<Emit>,
    /// Makes this share of the connected parts circle.
    #[arg(long = "move", value_name = "SHARE", value_parser = values::share)]
    pub moving_share: Option<f32>,
    /// Where from, metres.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, requires = "target", value_parser = values::point)]
    pub eye: Option<[f32; 3]>,
    /// A point looked at, metres.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, requires = "eye", value_parser = values::point)]
    pub target: Option<[f32; 3]>,
    /// Roughly up [default: 0,1,0]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, requires = "eye", value_parser = values::point)]
    pub up: Option<[f32; 3]>,
    /// Vertical field of view, degrees [default: 45]
    #[arg(long, value_name = "DEG", requires = "eye", value_parser = values::field_of_view)]
    pub vfov: Option<f32>,
    /// The file's N-th camera, from 0.
    #[arg(long, value_name = "N", conflicts_with = "eye")]
    pub camera: Option<usize>,
    /// A camera that moves with the animation time: a JSON file of keys.
    #[arg(long, value_name = "CAMERA_PATH", conflicts_with_all = ["eye", "camera"])]
    pub path: Option<PathBuf>,
    /// Sky: one radiance, or an equirectangular map.
    #[arg(long, value_name = "R,G,B|FILE", allow_hyphen_values = true, value_parser = values::sky)]
    pub sky: Option<SkySetting>,
    /// Sun: direction of travel, and irradiance on a perpendicular plane.
    #[arg(long, value_name = "DX,DY,DZ,R,G,B", allow_hyphen_values = true, value_parser = values::sun)]
    pub sun: Option<SunSetting>,
    /// Angle across the sun's disc.
    #[arg(long, value_name = "DEG", value_parser = values::disc)]
    pub sun_angle: Option<f32>,
    /// Animation time [default: 0]
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true, value_parser = values::not_negative)]
    pub time: Option<f32>,
    /// Graphics adapter whose name contains this.
    #[arg(long, value_name = "NAME")]
    pub adapter: Option<String>,
}

/// What the id `bvh` stands for: fewer node visits per ray than the other, on every scene measured.
pub(super) const BEST_BVH: &str = "bvh_cwbvh";

/// Reads an id and looks it up among those there are.
pub(super) fn stage_id(kind: Kind) -> impl Fn(&str) -> Result<String, String> + Clone + Send + Sync {
    move |text| {
        let (id, known) = (values::id_of(text), kind.ids());
        let id = if kind == Kind::Tracer && id == "bvh" { BEST_BVH.into() } else { id };
        match known.contains(&id.as_str()) {
            true => Ok(id),
            false => Err(format!("there are: {}", known.join(", "))),
        }
    }
}

/// Writes what was said over a setting.
fn set<T: Clone>(given: &Option<T>, setting: &mut T) {
    if let Some(value) = given {
        *setting = value.clone();
    }
}

impl StreetArgs {
    /// Defaults, then the case, then what was said explicitly; none where neither a scene nor a case is named.
    ///
    /// # Errors
    /// A case or a camera path that is not there.
    pub fn settings(&self) -> Result<Option<RenderSettings>, Error> {
        let Some(mut settings) = self.view.settings()? else { return Ok(None) };
        set(&self.grid, &mut settings.grid);
        set(&self.tracer, &mut settings.tracer);
        set(&self.denoiser, &mut settings.denoiser);
        set(&self.upsampler, &mut settings.upsampler);
        set(&self.spp, &mut settings.spp);
        Ok(Some(settings))
    }
}

impl ViewArgs {
    /// Defaults, then the case, then what was said explicitly; none where neither a scene nor a case is named.
    ///
    /// # Errors
    /// A case or a camera path that is not there.
    pub fn settings(&self) -> Result<Option<RenderSettings>, Error> {
        let mut settings = RenderSettings::default();
        match (&self.scene, &self.case) {
            (Some(scene), _) => settings.scene = scene.clone(),
            (None, Some(case)) => Case::find(case)?.apply(&mut settings),
            (None, None) => return Ok(None),
        }
        self.apply(&mut settings);
        if let Some(path) = &self.path {
            settings.view = View::Path(CameraPath::load(path)?);
        }
        match settings.view {
            View::LookAt(view) if view.eye == view.target => Err(Error::LooksNowhere { at: view.eye }),
            _ => Ok(Some(settings)),
        }
    }

    /// Writes what was said explicitly over `settings`.
    pub(super) fn apply(&self, settings: &mut RenderSettings) {
        set(&self.trace_size, &mut settings.trace_size);
        set(&self.display_size, &mut settings.display_size);
        set(&self.tessellator, &mut settings.tessellator);
        set(&self.bounces.map(|b| b.0), &mut settings.bounces);
        set(&self.seed, &mut settings.seed);
        set(&self.preset, &mut settings.preset);
        set(&self.model, &mut settings.model);
        set(&self.time, &mut settings.time);
        set(&self.sky.clone().map(Some), &mut settings.sky);
        set(&self.sun.map(Some), &mut settings.sun);
        set(&self.sun_angle.map(Some), &mut settings.sun_angle);
        set(&self.moving_share.map(Some), &mut settings.moving_share);
        set(&self.budget_mb.map(|mb| Some(values::bytes(mb))), &mut settings.texture_budget_bytes);
        set(&self.load_mb.map(values::bytes), &mut settings.load_budget_bytes);
        settings.sets.clone_from(&self.set);
        settings.emit.clone_from(&self.emit);
        if let Some(index) = self.camera {
            settings.view = View::Camera(index);
        }
        if let (Some(eye), Some(target)) = (self.eye, self.target) {
            let up = self.up.unwrap_or([0.0, 1.0, 0.0]);
            let vfov = self.vfov.unwrap_or(std::f32::consts::FRAC_PI_4);
            settings.view = View::LookAt(LookAt { eye, target, up, vfov });
        }
    }
}
