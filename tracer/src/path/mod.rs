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

mod cache;
pub(crate) mod camera;
mod kernels;
mod params;
#[cfg(test)]
pub(crate) mod reference;
mod segments;
mod settings;
#[cfg(test)]
mod tests;
mod variance;

pub use cache::RadianceCache;
pub use settings::{Conventions, PathBuild, PathChoices, PathSettings, SampleRule};

use crate::lights::LightList;
use crate::noise;
use frame::scene_gpu::GpuScene;
use frame::{Bind, Buffer, GBuffer, Gpu, GpuError, Kernel, RadianceImage, Recorder, Room, Texture, Uniform};
use kernels::Workshop;
pub(crate) use params::PathParams;
use params::params;
use scene::SceneNeeds;
use segments::{Segments, rounds};
use variance::Variance;

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

/// What a search structure brings: its snippets and what they bind.
pub(crate) struct Structure {
    /// Path of its passes: `trace/voxel`.
    pub(crate) pass: &'static str,
    /// WGSL that defines `Hit`, `hit_trace`, `hit_blocked`, `hit_start`, `hit_starts_from`, `hit_leave`, `hit_leaves`, `hit_pass`,
    /// `hit_is_emitter`.
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
    /// What its voxels keep.
    pub(crate) cache: Option<&'a RadianceCache>,
}

/// Buffers of one trace size.
struct Sized {
    paths: Buffer,
    pixels: Buffer,
    counters: Buffer,
    light: RadianceImage,
    mask: Buffer,
    variance: Option<Variance>,
    /// Bound in place of an absent specular lobe; one texel, stores outside of it go nowhere.
    no_specular: Texture,
    size: [u32; 2],
}

struct Kernels {
    start: Kernel,
    segment: Kernel,
    resolve: Kernel,
    feeding: Option<Feeding>,
}

/// What renews the radiance kept in voxels.
struct Feeding {
    feed: Kernel,
    segment: Kernel,
    store: Kernel,
    regions: Kernel,
}

/// What kernels are built for.
type Built = (SceneNeeds, PathBuild, bool);

/// The kernels and buffers of paths through one kind of structure.
pub(crate) struct Paths {
    pub(crate) structure: Structure,
    kernels: Option<(Built, Kernels)>,
    /// Most segments of a dispatch; tests lower it.
    pub(crate) most_segments: u32,
    sized: Option<Sized>,
}

/// Bytes of the counters: five of 64 bits, the word that says whether a path lives, and one more of 64.
const COUNTERS_BYTES: u64 = 56;
/// Byte of the counter of rays that renew voxels.
const FEED_RAYS: u64 = 48;
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
        let built = (scene.needs, settings.build, settings.build.next_event && scene.has_areas());
        let workshop =
            Workshop { gpu, structure: &self.structure, scene, build: settings.build, camera: false };
        // Constants of the triangles are the scene's own: another scene, other kernels.
        if self.structure.of_triangles || self.kernels.as_ref().is_none_or(|(b, _)| *b != built) {
            let kernels = Kernels {
                start: workshop.start()?,
                segment: workshop.segment()?,
                resolve: kernels::resolve(gpu)?,
                feeding: workshop
                    .has_cache()
                    .then(|| {
                        let [feed, segment] = [workshop.feed()?, workshop.feed_segment()?];
                        let [store, regions] = [workshop.store()?, workshop.regions()?];
                        Ok::<_, GpuError>(Feeding { feed, segment, store, regions })
                    })
                    .transpose()?,
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
            mask: noise::upload_mask(gpu)?,
            variance: (settings.samples == SampleRule::Variance)
                .then(|| Variance::new(gpu, &workshop, size))
                .transpose()?,
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
        let most = settings.most_samples();
        params.first_sample = frame.frame_index.wrapping_mul(most);
        params.samples = most;
        params.rows = sized.size[1];
        let groups = [sized.size[0].div_ceil(8), sized.size[1].div_ceil(8), 1];
        let [start, resolve] = ["start", "resolve"].map(|part| format!("{}/{part}", self.structure.pass));
        let textures = [&gbuffer.surface, &gbuffer.distance, &gbuffer.face_normal, &gbuffer.motion_id]
            .map(|t| wgpu::BindingResource::TextureView(t.view()));
        let buffers = [&sized.paths, &sized.pixels, &sized.counters].map(|b| b.as_entire_binding());
        let mut of_segment = buffers.to_vec();
        let kept = kernels.feeding.as_ref().zip(structure.cache);
        assert_eq!(
            kept.is_some(),
            kernels.feeding.is_some(),
            "the pipeline makes the cache that kernels were built for"
        );
        if let Some((_, cache)) = kept {
            of_segment.push(cache.entries.as_entire_binding());
            if frame.restart {
                recorder.clear(&cache.entries);
            }
        }
        if kept.is_some() && params.bounces > 1 {
            params.bounces = params.bounces.max(cache::BOUNCES);
        }
        if params.bounces > 0 {
            // A second run through all pixels for the few that see smooth glass: the others end at once.
            let branches: &[u32] =
                if settings.both_branches && scene.needs.transmission { &[1, 2] } else { &[0] };
            for (sample, branch) in (0..most).flat_map(|s| branches.iter().map(move |b| (s, *b))) {
                params.sample = sample;
                params.branch = branch;
                params.feed_share =
                    if sample == 0 { (cache::FEED_SHARE * most as f32).min(1.0) } else { 0.0 };
                let of_dispatch = recorder.uniform(&[params; 2]);
                let mut resources =
                    vec![uniform.binding(), of_dispatch.binding(), sized.mask.as_entire_binding()];
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
                segments.record(recorder, scene, &structure, &of_segment, &sized.counters);
                if let (Some((feeding, _)), 0, true) = (kept, sample, params.bounces > 1) {
                    self.feed(recorder, uniform, scene, &structure, &params, feeding, &of_segment, groups);
                }
                if let (Some(variance), true) = (&sized.variance, branches.last() == Some(&branch)) {
                    let uniforms = [uniform, &of_dispatch];
                    variance.record(recorder, self.structure.pass, uniforms, &sized.pixels, &params, groups);
                }
                recorder.progress((sample + 1) as f32 / most as f32);
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
        if kernels.feeding.is_some() {
            recorder.counter("cache_rays", &sized.counters, FEED_RAYS);
        }
        sized.light.clone()
    }

    /// Records what the paths that ended at voxels do for them. `buffers` are paths, pixels, counters, cache.
    fn feed(
        &self,
        recorder: &mut Recorder<'_>,
        uniform: &Uniform,
        scene: &GpuScene,
        structure: &Searched<'_>,
        of_sample: &PathParams,
        feeding: &Feeding,
        buffers: &[wgpu::BindingResource<'_>],
        groups: [u32; 3],
    ) {
        let params = PathParams { bounces: cache::FEED_BOUNCES, feed_share: 0.0, ..*of_sample };
        let params = recorder.uniform(&[params; 2]);
        let mut resources = vec![uniform.binding(), params.binding()];
        resources.extend(of_scene(scene, structure.lights));
        resources.extend_from_slice(structure.resources);
        resources.extend_from_slice(buffers);
        let pass = |part: &str| format!("{}/cache/{part}", self.structure.pass);
        recorder.compute(&pass("feed"), &feeding.feed, &resources, groups);
        for _ in 0..cache::FEED_SEGMENTS.div_ceil(of_sample.segments) {
            recorder.compute(&pass("segment"), &feeding.segment, &resources, groups);
        }
        let [paths, pixels, _, cache] = buffers else {
            unreachable!("a cache is bound behind the counters");
        };
        let resources = [uniform.binding(), params.binding(), paths.clone(), pixels.clone(), cache.clone()];
        recorder.compute(&pass("store"), &feeding.store, &resources, groups);
        recorder.compute(
            &pass("regions"),
            &feeding.regions,
            std::slice::from_ref(cache),
            cache::REGION_GROUPS,
        );
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
