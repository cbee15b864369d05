//! What a dispatch is told.

use super::variance::Division;
use super::{ENDLESS, PASSES, PathSettings, Searched};
use frame::scene_gpu::GpuScene;
use frame::{Gpu, gpu_struct};

gpu_struct! {
    /// Of one dispatch.
    pub struct PathParams {
        /// Which of the frame's samples.
        pub sample: u32,
        /// How many the frame has.
        pub samples: u32,
        /// Index over all frames of the frame's first sample.
        pub first_sample: u32,
        /// Most scatterings.
        pub bounces: u32,
        /// Number of lights that are no surfaces.
        pub lights: u32,
        /// [`SampleRule`].
        pub rule: u32,
        /// Scatterings before roulette.
        pub roulette_from: u32,
        /// Segments this dispatch may advance.
        pub segments: u32,
        /// Of the picture, that is the first of the buffers'.
        pub first_row: u32,
        /// Rows in the buffers.
        pub rows: u32,
        /// 1: vertices sample emitters or the sky.
        pub has_areas: u32,
        /// Emitters in the list.
        pub emitter_count: u32,
        /// Lights before them; at least one is stored.
        pub lights_stored: u32,
        /// Share of these samples that goes to emitters.
        pub emitter_share: f32,
        /// Sum of the emitters' weights.
        pub emitter_total: f32,
        /// Share that goes to the sky: the rest, or none.
        pub sky_share: f32,
        /// Of smooth glass at the first hit: 0 chosen at random, 1 what it reflects, 2 what goes through.
        pub branch: u32,
        /// Share of the pixels whose paths may renew a voxel.
        pub feed_share: f32,
        /// By variance: samples that every pixel gets.
        pub even: u32,
        /// By variance: samples that a pixel gets beside those in the mean.
        pub rest: u32,
    }
}

/// What every dispatch of a frame is told alike; one path of one sample, all rows to be filled in.
pub(super) fn params(
    gpu: &Gpu,
    scene: &GpuScene,
    settings: &PathSettings,
    structure: &Searched<'_>,
    most_segments: u32,
) -> PathParams {
    let (worst_case, lights) = (structure.worst_case, structure.lights);
    // By the light each gives off: a lamp in a room or the sky around it. Neither is ever left out for the other.
    let sphere = 0.25 * scene.bounds.diagonal().powi(2) * std::f32::consts::PI;
    let (of_emitters, of_sky) = (std::f32::consts::PI * lights.emitter_total, sphere * scene.sky_power);
    let emitter_share = match (lights.emitter_count > 0, scene.has_sky_map()) {
        (true, true) => (of_emitters / (of_emitters + of_sky).max(f32::MIN_POSITIVE)).clamp(0.1, 0.9),
        (has_emitters, _) => f32::from(has_emitters),
    };
    let has_areas = settings.build.next_event && (lights.emitter_count > 0 || scene.has_sky_map());
    // A segment is one straight line, however many sheets it passes; each sheet's light samples are others.
    let light_count = if settings.shadow_rays { scene.light_count } else { 0 };
    let samples = u32::from(light_count > 0) + u32::from(has_areas);
    let lines = 1 + samples * if scene.needs.transmission { PASSES } else { 1 };
    let segments = match gpu.loop_cap() {
        Some(cap) => (cap / (lines * (worst_case + PASSES))).clamp(1, most_segments),
        None => most_segments,
    };
    let division = Division::of(settings.spp);
    PathParams {
        samples: 1,
        bounces: settings.bounces.unwrap_or(ENDLESS),
        lights: light_count,
        rule: settings.samples as u32,
        even: division.even,
        rest: division.rest,
        // With a bounce limit nothing is left to chance.
        roulette_from: if settings.bounces.is_some() { u32::MAX } else { settings.roulette_from },
        segments,
        has_areas: u32::from(has_areas),
        emitter_count: lights.emitter_count,
        lights_stored: scene.light_count.max(1),
        emitter_share: if has_areas { emitter_share } else { 0.0 },
        emitter_total: lights.emitter_total.max(f32::MIN_POSITIVE),
        sky_share: if has_areas && scene.has_sky_map() { 1.0 - emitter_share } else { 0.0 },
        ..Default::default()
    }
}
