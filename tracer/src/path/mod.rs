//! Traces paths from a G-buffer through whatever answers `hit_trace`, and sums what they find per lobe.
//!
//! Paper: "uni-directional path tracing begins as a post-process at one voxel above the surface" (section 2).
//!
//! In: a trace-size [`GBuffer`] (or camera rays of its own, [`camera`]); sky, lights, materials in radiance times
//! `radiance_scale`; positions in metres. Out: a [`RadianceImage`]: demodulated radiance of the diffuse and of the
//! specular lobe.
//!
//! Formula (contract, "two lobes"): `X_l = 1/N sum f_l cos L / (q_l p_l M_l)` over the pixel's N paths, each starting in one
//! lobe with probability `q_l`; a first-hit light sample adds `f_l cos L w_l / (p_light M_l)` to both. One dispatch
//! starts a path per pixel, further dispatches advance all of them by a few segments, one resolve makes the images: no
//! dispatch runs longer than the software driver's loop cap allows, whatever the number of samples and bounces.
//! Worst case per dispatch and invocation: `segments * lines * (3 R + 16)` iterations for a grid of R cells, kept under
//! the measured cap; lines is 1, 2 where there are lights, 17 where these meet thin sheets.
//!
//! Departs from the paper: two demodulated lobes instead of one light image, so that a filter treats gloss and matte by
//! their own roughness; both sun and punctual lights are shadow rays (the paper has neither).

pub(crate) mod camera;
mod kernels;
#[cfg(test)]
pub(crate) mod reference;
#[cfg(test)]
mod tests;

use crate::lights::LightList;
use frame::scene_gpu::GpuScene;
use frame::{
    Bind, Buffer, GBuffer, Gpu, GpuError, Kernel, Knob, RadianceImage, Recorder, Room, Texture, Uniform,
    gpu_struct,
};
use kernels::Workshop;
use scene::SceneNeeds;

/// Panes, cut-outs, blends and cells of the surface left that a ray may pass before it counts as blocked.
const PASSES: u32 = 16;
/// Segments per dispatch where no loop cap is known: bounds the time of one dispatch.
const MOST_SEGMENTS: u32 = 8;
/// With no bounce limit, roulette ends paths; this many scatterings end them all. At throughput 0.95 a path gets so far
/// once in 10^11.
pub(crate) const ENDLESS: u32 = 512;
/// Bytes of `Path` in WGSL.
const PATH_BYTES: u64 = 80;
/// Bytes of `Pixel` in `pixel.inc.wgsl`.
const PIXEL_BYTES: u64 = 48;
/// Word of the counters that stays 0 where no path is left alive.
const ANY_ALIVE: u64 = 10;

/// Which pixels get how many of the frame's samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[repr(u32)]
pub enum SampleRule {
    /// All the same.
    #[default]
    Fixed,
    /// The paper's: `1 + floor(5 R + 1/2)` by the larger roughness R, at most `spp`.
    Roughness,
}

/// Whose rules are followed where the field has more than one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[repr(u32)]
pub enum Conventions {
    /// Height-correlated masking; what a triangle reflects lies above the triangle, and normal maps are bent towards the
    /// viewer.
    #[default]
    Gridlight,
    /// Those of the shared reference images: separable masking, and the interpolated normal in place of the triangle's.
    Reference,
}

impl Conventions {
    /// Constants of `bvh_hit.inc.wgsl`.
    fn of_triangles(self) -> [(&'static str, f64); 2] {
        let reference = f64::from(self == Self::Reference);
        [("bvh_bend", 1.0 - reference), ("bvh_smooth_horizon", reference)]
    }
}

/// How long paths are and how many.
#[derive(Clone, Debug, PartialEq)]
pub struct PathSettings {
    /// Paths per trace pixel in this frame, 1 to 65,535.
    pub spp: u32,
    /// At most so many scatterings: 0 emitters only, 1 direct light; none means roulette alone.
    pub bounces: Option<u32>,
    /// Who gets them.
    pub samples: SampleRule,
    /// Scatterings before roulette begins; 8 is the references' rule (contract, "Words for measuring").
    pub roulette_from: u32,
    /// Read when kernels are built.
    pub conventions: Conventions,
    /// A sample of smooth glass at the first hit follows what is reflected and what goes through, instead of one of both.
    pub both_branches: bool,
    /// Each vertex samples emitters and a sky that is a map, instead of finding them by chance alone. Read when kernels are
    /// built.
    pub next_event: bool,
}

impl Default for PathSettings {
    fn default() -> Self {
        Self {
            spp: 1,
            bounces: Some(3),
            samples: SampleRule::Fixed,
            roulette_from: 8,
            conventions: Conventions::default(),
            both_branches: true,
            next_event: true,
        }
    }
}

impl PathSettings {
    /// What `--set tracer.…` reaches, beside `--spp` and `--bounces`.
    pub fn knobs<'a>(
        samples: &'a mut u32,
        conventions: &'a mut u32,
        both_branches: &'a mut bool,
        next_event: &'a mut bool,
        roulette_from: &'a mut u32,
    ) -> Vec<Knob<'a>> {
        vec![
            Knob::choice(
                "conventions",
                conventions,
                &["gridlight", "reference"],
                "whose rules of masking and of normal maps: ours, or those the shared reference images were made with",
            ),
            Knob::choice(
                "samples",
                samples,
                &["fixed", "roughness"],
                "paths per pixel: the same everywhere, or 1 to 6 by roughness as in the paper (at most --spp)",
            ),
            Knob::bool(
                "both_branches",
                both_branches,
                "smooth glass seen directly shows its reflection and what lies behind it in every sample; off flips a coin",
            ),
            Knob::bool(
                "next_event",
                next_event,
                "each vertex sends a ray to an emitter or to a bright part of the sky, weighted against finding it by \
                 chance; off is the paper's way: more noise, less time a path",
            ),
            Knob::int(
                "roulette_from",
                roulette_from,
                1..=512,
                "scatterings",
                "with --bounces inf, paths may be ended at random from here on; lower is faster and noisier; \
                 8 is what the reference images use",
            ),
        ]
    }
}

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
        /// 1: fewer samples on smoother pixels.
        pub by_roughness: u32,
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
        /// WGSL rounds the size up to a multiple of 16.
        pub _pad: [u32; 3],
    }
}

/// What a search structure brings: its snippets and what they bind.
pub(crate) struct Structure {
    /// Path of its passes: `trace/voxel`.
    pub(crate) pass: &'static str,
    /// WGSL that defines `Hit`, `hit_trace`, `hit_blocked`, `hit_start`, `hit_starts_from`, `hit_leave`, `hit_leaves`, `hit_pass`.
    pub(crate) sources: Vec<&'static str>,
    /// What those use, group 1.
    pub(crate) binds: Vec<Bind>,
    /// It reads triangles and materials, so that its kernels take their constants.
    pub(crate) of_triangles: bool,
}

/// A structure that stands, as paths bind it.
pub(crate) struct Searched<'a> {
    /// Behind [`Structure::binds`].
    pub(crate) resources: &'a [wgpu::BindingResource<'a>],
    /// Most iterations of one ray.
    pub(crate) worst_case: u32,
    /// What finds light in it.
    pub(crate) lights: &'a LightList,
}

/// Buffers of one trace size.
struct Sized {
    paths: Buffer,
    pixels: Buffer,
    counters: Buffer,
    light: RadianceImage,
    /// Bound in place of an absent specular lobe; one texel, stores outside of it go nowhere.
    no_specular: Texture,
    size: [u32; 2],
}

struct Kernels {
    start: Kernel,
    segment: Kernel,
    resolve: Kernel,
}

/// What kernels are built for.
type Built = (SceneNeeds, Conventions, bool);

/// The kernels and buffers of paths through one kind of structure.
pub(crate) struct Paths {
    pub(crate) structure: Structure,
    kernels: Option<(Built, Kernels)>,
    /// Most segments of a dispatch; tests lower it.
    pub(crate) most_segments: u32,
    sized: Option<Sized>,
}

/// Bytes of the counters: five of 64 bits, and the word that says whether a path lives.
const COUNTERS_BYTES: u64 = 48;
/// Their names, in the order of the tally and of what resolve adds.
const COUNTER_NAMES: [&str; 5] = ["rays", "cut_rays", "iterations", "paths", "clamped"];

impl Paths {
    pub(crate) fn new(structure: Structure) -> Self {
        Self { structure, kernels: None, most_segments: MOST_SEGMENTS, sized: None }
    }

    pub(crate) fn resize(
        &mut self,
        gpu: &Gpu,
        scene: &GpuScene,
        size: [u32; 2],
        settings: &PathSettings,
    ) -> Result<(), GpuError> {
        let built = (scene.needs, settings.conventions, settings.next_event && scene.has_areas());
        // Constants of the triangles are the scene's own: another scene, other kernels.
        if self.structure.of_triangles || self.kernels.as_ref().is_none_or(|(b, _)| *b != built) {
            let workshop = Workshop {
                gpu,
                structure: &self.structure,
                scene,
                conventions: settings.conventions,
                areas: settings.next_event,
                camera: false,
            };
            let kernels = Kernels {
                start: workshop.start()?,
                segment: workshop.segment()?,
                resolve: kernels::resolve(gpu)?,
            };
            self.kernels = Some((built, kernels));
        }
        let pixels = u64::from(size[0]) * u64::from(size[1]);
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC;
        // What was there goes first, so that the two sizes never stand side by side.
        self.sized = None;
        self.sized = Some(Sized {
            paths: gpu.buffer(Room::Radiance, "Paths::paths", PATH_BYTES * pixels, usage)?,
            pixels: gpu.buffer(Room::Radiance, "Paths::pixels", PIXEL_BYTES * pixels, usage)?,
            counters: gpu.buffer(Room::Radiance, "Paths::counters", COUNTERS_BYTES, usage)?,
            light: RadianceImage::new(gpu, size, scene.needs.specular)?,
            no_specular: RadianceImage::lobe(gpu, "Paths::no_specular", [1, 1])?,
            size,
        });
        Ok(())
    }

    /// Records one frame's paths.
    ///
    /// # Panics
    /// Before the first [`Paths::resize`].
    pub(crate) fn trace(
        &self,
        recorder: &mut Recorder<'_>,
        uniform: &Uniform,
        scene: &GpuScene,
        structure: Searched<'_>,
        frame: &frame::FrameInfo,
        gbuffer: &GBuffer,
        settings: &PathSettings,
    ) -> RadianceImage {
        let (Some((_, kernels)), Some(sized)) = (&self.kernels, &self.sized) else {
            unreachable!("{}: resize comes before trace", self.structure.pass);
        };
        for buffer in [&sized.pixels, &sized.counters] {
            recorder.clear(buffer);
        }
        let mut params = params(recorder.gpu(), scene, settings, &structure, self.most_segments);
        params.first_sample = frame.frame_index.wrapping_mul(settings.spp);
        params.samples = settings.spp;
        params.rows = sized.size[1];
        let groups = [sized.size[0].div_ceil(8), sized.size[1].div_ceil(8), 1];
        let [start, resolve] = ["start", "resolve"].map(|part| format!("{}/{part}", self.structure.pass));
        let textures = [&gbuffer.surface, &gbuffer.distance, &gbuffer.face_normal, &gbuffer.motion_id]
            .map(|t| wgpu::BindingResource::TextureView(t.view()));
        let buffers = [&sized.paths, &sized.pixels, &sized.counters].map(|b| b.as_entire_binding());
        if params.bounces > 0 {
            // A second run through all pixels for the few that see smooth glass: the others end at once.
            let branches: &[u32] =
                if settings.both_branches && scene.needs.transmission { &[1, 2] } else { &[0] };
            for (sample, branch) in (0..settings.spp).flat_map(|s| branches.iter().map(move |b| (s, *b))) {
                params.sample = sample;
                params.branch = branch;
                let of_dispatch = recorder.uniform(&[params; 2]);
                let mut resources = vec![uniform.binding(), of_dispatch.binding()];
                resources.extend(of_scene(scene, structure.lights));
                resources.extend_from_slice(structure.resources);
                resources.extend_from_slice(&buffers);
                resources.extend_from_slice(&textures);
                recorder.compute(&start, &kernels.start, &resources, groups);
                let segments = Segments {
                    pass: self.structure.pass,
                    kernel: &kernels.segment,
                    uniform,
                    params: &of_dispatch,
                    rounds: rounds(&params, scene),
                    endless: settings.bounces.is_none(),
                    groups,
                };
                segments.record(recorder, scene, &structure, &buffers, &sized.counters);
                recorder.progress((sample + 1) as f32 / settings.spp as f32);
            }
        }
        let specular = sized.light.specular.as_ref().unwrap_or(&sized.no_specular);
        let resources = [
            uniform.binding(),
            sized.pixels.as_entire_binding(),
            sized.counters.as_entire_binding(),
            wgpu::BindingResource::TextureView(sized.light.diffuse.view()),
            wgpu::BindingResource::TextureView(specular.view()),
            wgpu::BindingResource::TextureView(sized.light.samples.view()),
        ];
        recorder.compute(&resolve, &kernels.resolve, &resources, groups);
        recorder.output(&format!("{resolve}/diffuse"), &sized.light.diffuse);
        if let Some(specular) = &sized.light.specular {
            recorder.output(&format!("{resolve}/specular"), specular);
        }
        for (slot, name) in (0u64..).zip(COUNTER_NAMES) {
            recorder.counter(name, &sized.counters, 8 * slot);
        }
        sized.light.clone()
    }
}

/// What every dispatch of a frame is told alike; one path of one sample, all rows to be filled in.
fn params(
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
    let has_areas = settings.next_event && (lights.emitter_count > 0 || scene.has_sky_map());
    // A segment is one straight line, however many sheets it passes; each sheet's light samples are others.
    let samples = u32::from(scene.light_count > 0) + u32::from(has_areas);
    let lines = 1 + samples * if scene.needs.transmission { PASSES } else { 1 };
    let segments = match gpu.loop_cap() {
        Some(cap) => (cap / (lines * (worst_case + PASSES))).clamp(1, most_segments),
        None => most_segments,
    };
    PathParams {
        samples: 1,
        bounces: settings.bounces.unwrap_or(ENDLESS),
        lights: scene.light_count,
        by_roughness: u32::from(settings.samples == SampleRule::Roughness),
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

/// What every vertex reads, in the order of the kernels' bindings.
fn of_scene<'a>(scene: &'a GpuScene, lights: &'a LightList) -> [wgpu::BindingResource<'a>; 4] {
    [
        wgpu::BindingResource::TextureView(scene.sky.view()),
        wgpu::BindingResource::TextureView(scene.sky_table.view()),
        scene.brdf_table.as_entire_binding(),
        lights.buffer.as_entire_binding(),
    ]
}

/// Dispatches that take every path to its end. A sheet passed at the first hit uses up no bounce: such a path has one
/// segment more.
fn rounds(params: &PathParams, scene: &GpuScene) -> u32 {
    (params.bounces + u32::from(scene.needs.transmission)).div_ceil(params.segments)
}

/// The dispatches that advance one path per pixel.
struct Segments<'a> {
    pass: &'static str,
    kernel: &'a Kernel,
    uniform: &'a Uniform,
    params: &'a Uniform,
    rounds: u32,
    endless: bool,
    groups: [u32; 3],
}

impl Segments<'_> {
    /// `buffers` are paths, pixels, counters.
    fn record(
        &self,
        recorder: &mut Recorder<'_>,
        scene: &GpuScene,
        structure: &Searched<'_>,
        buffers: &[wgpu::BindingResource<'_>; 3],
        counters: &Buffer,
    ) {
        let pass = format!("{}/segment", self.pass);
        let mut resources = vec![self.uniform.binding(), self.params.binding()];
        resources.extend(of_scene(scene, structure.lights));
        resources.extend_from_slice(structure.resources);
        resources.extend_from_slice(buffers);
        for round in 0..self.rounds {
            recorder.clear_words(counters, ANY_ALIVE..ANY_ALIVE + 1);
            recorder.compute(&pass, self.kernel, &resources, self.groups);
            if self.endless && round > 0 && none_alive(recorder, counters) {
                break;
            }
        }
    }
}

/// Whether the last dispatch left no path alive. Only asked where paths have no limit: it waits for the dispatch.
fn none_alive(recorder: &mut Recorder<'_>, counters: &Buffer) -> bool {
    recorder.flush();
    // Should reading fail, the device is gone, and the frame's end will say so.
    let words = recorder.gpu().read_buffer::<u32>(counters);
    words.is_ok_and(|words| words.get(ANY_ALIVE as usize) == Some(&0))
}
