//! What two sides of a comparison share, and how a knob's setting is written.

use gridlight::RenderSettings;
use gridlight::settings::KnobSetting;
use gridlight::stages::Kind;

/// Whether a side has the knobs of this stage for itself: those of the world are shared.
fn is_own(id: &str) -> bool {
    let own = [Kind::Tracer, Kind::Denoiser, Kind::Upsampler];
    // The voxelizer's knobs go by the id of a tracer.
    id != "voxel" && (id == "tracer" || own.into_iter().any(|kind| kind.ids().contains(&id)))
}

/// Takes over into `other` all that it has to share with `from`.
pub fn share(from: &RenderSettings, other: &mut RenderSettings) {
    let shared = from.sets.iter().filter(|set| !is_own(&set.id)).cloned();
    let own = other.sets.iter().filter(|set| is_own(&set.id)).cloned();
    *other = RenderSettings {
        tracer: std::mem::take(&mut other.tracer),
        denoiser: std::mem::take(&mut other.denoiser),
        upsampler: std::mem::take(&mut other.upsampler),
        spp: other.spp,
        bounces: other.bounces,
        seed: other.seed,
        sets: shared.chain(own).collect(),
        ..from.clone()
    };
}

/// Sets one knob, or with no value leaves it as the preset has it.
pub fn set_knob(settings: &mut RenderSettings, id: &str, knob: &str, value: Option<String>) {
    settings.sets.retain(|set| set.id != id || set.knob != knob);
    if let Some(value) = value {
        settings.sets.push(KnobSetting { id: id.into(), knob: knob.into(), value });
    }
}
