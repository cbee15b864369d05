//! Every stage that can be chosen by name, from the explicit list in each stage's crate, and its knobs.

use crate::pipeline::Pipeline;
use crate::{Error, Progress, RenderSettings};
use frame::{Gpu, GpuError, Knob, KnobValue};
use serde::Serialize;

/// What can be chosen by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// Refines meshes.
    Tessellator,
    /// Traces light.
    Tracer,
    /// Removes noise.
    Denoiser,
    /// Lifts light to display size.
    Upsampler,
}

/// What a setting holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum KnobKind {
    /// A real number, least and most.
    Float(f32, f32),
    /// A whole number, least and most.
    Int(u32, u32),
    /// `on` or `off`.
    Bool,
    /// One of these names.
    Choice(&'static [&'static str]),
}

/// A setting, described.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct KnobInfo {
    /// Within its stage.
    pub name: &'static str,
    /// Empty for a plain number.
    pub unit: &'static str,
    /// Range or list of what it takes.
    pub allowed: String,
    /// The same for who draws a slider.
    #[serde(skip)]
    pub kind: KnobKind,
    /// In the default preset.
    pub default: String,
    /// What it does.
    pub doc: &'static str,
}

impl Kind {
    /// In the order of the street.
    pub const ALL: [Self; 4] = [Self::Tessellator, Self::Tracer, Self::Denoiser, Self::Upsampler];

    /// `tracer` and so on.
    pub fn name(self) -> &'static str {
        match self {
            Self::Tessellator => "tessellator",
            Self::Tracer => "tracer",
            Self::Denoiser => "denoiser",
            Self::Upsampler => "upsampler",
        }
    }

    /// Ids, as logs print them.
    pub fn ids(self) -> Vec<&'static str> {
        match self {
            Self::Tessellator => tessellate::all().iter().map(|(id, _)| *id).collect(),
            Self::Tracer => tracer::all().iter().map(|(id, _)| *id).collect(),
            Self::Denoiser => denoise::all().iter().map(|(id, _)| *id).collect(),
            Self::Upsampler => upsample::all().iter().map(|(id, _)| *id).collect(),
        }
    }
}

/// The knobs of every id that `--set` takes, at their defaults: parts of the street first (`voxel`, `gather`, `tracer`),
/// then everything that can be chosen.
///
/// # Errors
/// A stage cannot be made on this adapter.
pub fn knobs(gpu: Gpu) -> Result<Vec<(&'static str, Vec<KnobInfo>)>, Error> {
    // Knobs are lent out by living stages, so a small street is built.
    let settings = RenderSettings {
        scene: "cornell".into(),
        trace_size: [8, 8],
        display_size: [8, 8],
        grid: 8,
        ..Default::default()
    };
    let mut pipeline = Pipeline::new(gpu, &settings, Progress::default())?;
    let mut all = pipeline
        .with_knobs(|stages| stages.iter().map(|(id, knobs)| (*id, describe(knobs))).collect::<Vec<_>>());
    for kind in Kind::ALL {
        for id in kind.ids() {
            if !all.iter().any(|(known, _)| *known == id) {
                all.push((id, of(pipeline.gpu(), kind, id)?));
            }
        }
    }
    Ok(all)
}

/// The knobs of one implementation.
fn of(gpu: &Gpu, kind: Kind, id: &str) -> Result<Vec<KnobInfo>, GpuError> {
    fn made<C: Copy>(all: &[(&'static str, C)], id: &str) -> Option<C> {
        all.iter().find(|(known, _)| *known == id).map(|(_, make)| *make)
    }
    let described = match kind {
        Kind::Tessellator => made(tessellate::all(), id).map(|make| Ok(describe(&make(gpu)?.knobs()))),
        Kind::Tracer => made(tracer::all(), id).map(|make| Ok(describe(&make(gpu)?.knobs()))),
        Kind::Denoiser => made(denoise::all(), id).map(|make| Ok(describe(&make(gpu)?.knobs()))),
        Kind::Upsampler => made(upsample::all(), id).map(|make| Ok(describe(&make(gpu)?.knobs()))),
    };
    described.unwrap_or(Ok(Vec::new()))
}

fn describe(knobs: &[Knob<'_>]) -> Vec<KnobInfo> {
    let info = |knob: &Knob<'_>| KnobInfo {
        name: knob.name,
        unit: knob.unit,
        allowed: knob.allowed(),
        kind: match &knob.value {
            KnobValue::Float { min, max, .. } => KnobKind::Float(*min, *max),
            KnobValue::Int { min, max, .. } => KnobKind::Int(*min, *max),
            KnobValue::Bool(_) => KnobKind::Bool,
            KnobValue::Choice { names, .. } => KnobKind::Choice(names),
        },
        default: knob.to_string(),
        doc: knob.doc,
    };
    knobs.iter().map(info).collect()
}
