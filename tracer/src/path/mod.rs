//! Traces paths from a G-buffer through whatever answers `hit_trace`, and sums what they find per lobe.
//!
//! Paper: "uni-directional path tracing begins as a post-process at one voxel above the surface" (section 2).
//!
//! In: a trace-size [`GBuffer`]; sky, lights, materials in radiance times `radiance_scale`; positions in metres. Out: a
//! [`RadianceImage`]: demodulated radiance of the diffuse and of the specular lobe.
//!
//! Formula (contract, "two lobes"): `X_l = 1/N sum f_l cos L / (q_l p_l M_l)` over the pixel's N paths, each starting in one
//! lobe with probability `q_l`; a first-hit light sample adds `f_l cos L w_l / (p_light M_l)` to both. One dispatch
//! starts a path per pixel, further dispatches advance all of them by a few segments, one resolve makes the images: no
//! dispatch runs longer than the software driver's loop cap allows, whatever the number of samples and bounces.
//! Worst case per dispatch and invocation: `segments * lines * (3 R + 16)` iterations for a grid of R cells, kept under
//! the measured cap; lines is 1, 2 where there are lights, 17 where these meet thin sheets.
//!
//! Known: Mesa's software driver (22.3) compiles the segment kernel anew at every dispatch: 0.6 s, or 9 to 20 ms out of
//! its disk cache, whatever the pixel count. It does so with one bound texture or two; with a loop bound in the
//! kernel that depends on the invocation instead of a uniform, it crashes. The start kernel is compiled once. Not
//! understood; several segments per dispatch keep the cost down.
//!
//! Departs from the paper: two demodulated lobes instead of one light image, so that a filter treats gloss and matte by
//! their own roughness; both sun and punctual lights are shadow rays (the paper has neither).

#[cfg(test)]
pub(crate) mod reference;
#[cfg(test)]
mod tests;

use crate::{lights, noise};
use frame::scene_gpu::{self, GpuScene};
use frame::{
    Bind, Buffer, GBuffer, Gpu, GpuError, Kernel, KernelDesc, Knob, RadianceImage, Recorder, Room, Texture,
    Uniform, brdf, gpu_struct, info, surface,
};
use scene::SceneNeeds;
use wgpu::TextureFormat;

/// Panes, cut-outs, blends and cells of the surface left that a ray may pass before it counts as blocked.
const PASSES: u32 = 16;
/// Segments per dispatch where no loop cap is known: bounds the time of one dispatch.
const MOST_SEGMENTS: u32 = 8;
/// With no bounce limit, roulette ends paths; this many scatterings end them all. At throughput 0.95 a path gets so far
/// once in 10^11.
pub(crate) const ENDLESS: u32 = 512;
/// Bytes of `Path` in WGSL.
const PATH_BYTES: u64 = 64;

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
}

impl Default for PathSettings {
    fn default() -> Self {
        Self { spp: 1, bounces: Some(3), samples: SampleRule::Fixed, roulette_from: 8 }
    }
}

impl PathSettings {
    /// What `--set tracer.…` reaches, beside `--spp` and `--bounces`.
    pub fn knobs<'a>(samples: &'a mut u32, roulette_from: &'a mut u32) -> Vec<Knob<'a>> {
        vec![
            Knob::choice(
                "samples",
                samples,
                &["fixed", "roughness"],
                "paths per pixel: the same everywhere, or 1 to 6 by roughness as in the paper (at most --spp)",
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
    }
}

const PARAMS_WGSL: &str = "
struct PathParams {
    sample: u32, samples: u32, first_sample: u32, bounces: u32,
    lights: u32, by_roughness: u32, roulette_from: u32, segments: u32,
}";

/// What a search structure brings: its snippets and what they bind.
pub(crate) struct Structure {
    /// Path of its passes: `trace/voxel`.
    pub(crate) pass: &'static str,
    /// WGSL that defines `Hit`, `hit_trace`, `hit_start`, `hit_leave`, `hit_pass`.
    pub(crate) sources: &'static [&'static str],
    /// What those use, group 1.
    pub(crate) binds: &'static [Bind],
}

/// Buffers of one trace size.
struct Sized {
    paths: Buffer,
    sums: Buffer,
    sample_counts: Buffer,
    counters: Buffer,
    /// One word: 0 where the last dispatch left no path alive.
    any_alive: Buffer,
    light: RadianceImage,
    /// Bound in place of an absent specular lobe; one texel, stores outside of it go nowhere.
    no_specular: Texture,
    size: [u32; 2],
}

/// The kernels of a scene: what it does not have is not in them.
struct Kernels {
    start: Kernel,
    segment: Kernel,
    resolve: Kernel,
}

impl Kernels {
    fn new(gpu: &Gpu, structure: &Structure, needs: &SceneNeeds) -> Result<Self, GpuError> {
        let shared = [
            info::WGSL,
            surface::WGSL,
            brdf::WGSL,
            noise::WGSL,
            scene_gpu::LIGHT_WGSL,
            lights::WGSL,
            scene_gpu::SKY_WGSL,
            PARAMS_WGSL,
        ];
        let sources = |last: &[&'static str]| -> Vec<&str> {
            shared.iter().chain(structure.sources).chain(last).copied().collect()
        };
        let constants = [
            ("path_lights", f64::from(needs.shadow_rays)),
            ("path_specular", f64::from(needs.specular)),
            ("path_transmission", f64::from(needs.transmission)),
            ("path_coverage", f64::from(needs.coverage)),
            ("path_passes", f64::from(PASSES)),
        ];
        let of_frame =
            [Bind::uniform::<info::Frame>(0, 0, "frame"), Bind::uniform::<PathParams>(0, 1, "params")];
        let (table, lights) = (scene_gpu::BRDF_TABLE_BIND, scene_gpu::LIGHTS_BIND);
        let paths = Bind::storage(1, 30, "paths");
        let sums = Bind::storage(1, 31, "sums");
        let sample_counts = Bind::storage(1, 32, "sample_counts");
        let counters = Bind::storage(1, 33, "counters");
        let kernel = |entry, sources: &[&str], bindings: &[Bind], constants: &[(&str, f64)]| {
            let workgroup = [8, 8, 1];
            Kernel::new(gpu, &KernelDesc { name: entry, sources, entry, workgroup, bindings, constants })
        };

        let mut bindings = of_frame.to_vec();
        bindings.extend([table, lights]);
        bindings.extend(structure.binds);
        bindings.extend([paths, sums, sample_counts, counters]);
        bindings.extend([
            Bind::texture_uint(2, 0, "in_surface"),
            Bind::texture(2, 1, "in_distance"),
            Bind::texture_uint(2, 2, "in_face_normal"),
            Bind::texture_uint(2, 3, "in_motion_id"),
        ]);
        let start = kernel("path_start", &sources(&[PATH_WGSL, START_WGSL]), &bindings, &constants)?;

        let mut bindings = of_frame.to_vec();
        bindings.extend([scene_gpu::SKY_BIND, table, lights]);
        bindings.extend(structure.binds);
        bindings.extend([paths, sums, counters, Bind::storage(1, 34, "any_alive")]);
        let segment = kernel("path_segment", &sources(&[PATH_WGSL, SEGMENT_WGSL]), &bindings, &constants)?;

        let bindings = [
            of_frame[0],
            Bind::storage_read(1, 31, "sums"),
            Bind::storage_read(1, 32, "sample_counts"),
            counters,
            Bind::storage_texture(3, 0, "out_diffuse", RadianceImage::FORMAT),
            Bind::storage_texture(3, 1, "out_specular", RadianceImage::FORMAT),
            Bind::storage_texture(3, 2, "out_samples", TextureFormat::R32Uint),
        ];
        let resolve = kernel("path_resolve", &[info::WGSL, frame::HALF_WGSL, RESOLVE_WGSL], &bindings, &[])?;
        Ok(Self { start, segment, resolve })
    }
}

/// The kernels and buffers of paths through one kind of structure.
pub(crate) struct Paths {
    structure: Structure,
    kernels: Option<(SceneNeeds, Kernels)>,
    /// Most segments of a dispatch; tests lower it.
    pub(crate) most_segments: u32,
    sized: Option<Sized>,
}

impl Paths {
    pub(crate) fn new(structure: Structure) -> Self {
        Self { structure, kernels: None, most_segments: MOST_SEGMENTS, sized: None }
    }

    pub(crate) fn resize(&mut self, gpu: &Gpu, scene: &GpuScene, size: [u32; 2]) -> Result<(), GpuError> {
        if self.kernels.as_ref().is_none_or(|(needs, _)| *needs != scene.needs) {
            self.kernels = Some((scene.needs, Kernels::new(gpu, &self.structure, &scene.needs)?));
        }
        let pixels = u64::from(size[0]) * u64::from(size[1]);
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC;
        // What was there goes first, so that the two sizes never stand side by side.
        self.sized = None;
        self.sized = Some(Sized {
            paths: gpu.buffer(Room::Radiance, "Paths::paths", PATH_BYTES * pixels, usage)?,
            sums: gpu.buffer(Room::Radiance, "Paths::sums", 32 * pixels, usage)?,
            sample_counts: gpu.buffer(Room::Radiance, "Paths::sample_counts", 4 * pixels, usage)?,
            counters: gpu.buffer(Room::Radiance, "Paths::counters", 40, usage)?,
            any_alive: gpu.buffer(Room::Radiance, "Paths::any_alive", 4, usage)?,
            light: RadianceImage::new(gpu, size, scene.needs.specular)?,
            no_specular: RadianceImage::lobe(gpu, "Paths::no_specular", [1, 1])?,
            size,
        });
        Ok(())
    }

    /// `structure` are the resources behind [`Structure::binds`]; `worst_case` the iterations of one ray.
    ///
    /// # Panics
    /// Before the first [`Paths::resize`].
    pub(crate) fn trace(
        &self,
        recorder: &mut Recorder<'_>,
        uniform: &Uniform,
        scene: &GpuScene,
        structure: &[wgpu::BindingResource<'_>],
        worst_case: u32,
        frame: &frame::FrameInfo,
        gbuffer: &GBuffer,
        settings: &PathSettings,
    ) -> RadianceImage {
        let (Some((_, kernels)), Some(sized)) = (&self.kernels, &self.sized) else {
            unreachable!("{}: resize comes before trace", self.structure.pass);
        };
        for buffer in [&sized.sums, &sized.sample_counts, &sized.counters] {
            recorder.clear(buffer);
        }
        let bounces = settings.bounces.unwrap_or(ENDLESS);
        // A segment is one straight line, however many sheets it passes; each sheet's light sample is another.
        let lines = match (scene.light_count > 0, scene.needs.transmission) {
            (false, _) => 1,
            (true, false) => 2,
            (true, true) => 1 + PASSES,
        };
        let segments = match recorder.gpu().loop_cap() {
            Some(cap) => (cap / (lines * (worst_case + PASSES))).clamp(1, self.most_segments),
            None => self.most_segments,
        };
        let groups = [sized.size[0].div_ceil(8), sized.size[1].div_ceil(8), 1];
        let mut params = PathParams {
            sample: 0,
            samples: settings.spp,
            first_sample: frame.frame_index.wrapping_mul(settings.spp),
            bounces,
            lights: scene.light_count,
            by_roughness: u32::from(settings.samples == SampleRule::Roughness),
            // With a bounce limit nothing is left to chance.
            roulette_from: if settings.bounces.is_some() { u32::MAX } else { settings.roulette_from },
            segments,
        };
        let [start, segment, resolve] =
            ["start", "segment", "resolve"].map(|part| format!("{}/{part}", self.structure.pass));
        if bounces > 0 {
            for sample in 0..settings.spp {
                params.sample = sample;
                let of_dispatch = recorder.uniform(&params);
                let mut resources = vec![
                    uniform.binding(),
                    of_dispatch.binding(),
                    scene.brdf_table.as_entire_binding(),
                    scene.lights.as_entire_binding(),
                ];
                resources.extend_from_slice(structure);
                resources.extend([
                    sized.paths.as_entire_binding(),
                    sized.sums.as_entire_binding(),
                    sized.sample_counts.as_entire_binding(),
                    sized.counters.as_entire_binding(),
                ]);
                resources.extend(
                    [&gbuffer.surface, &gbuffer.distance, &gbuffer.face_normal, &gbuffer.motion_id]
                        .map(|t| wgpu::BindingResource::TextureView(t.view())),
                );
                recorder.compute(&start, &kernels.start, &resources, groups);

                let mut resources = vec![
                    uniform.binding(),
                    of_dispatch.binding(),
                    wgpu::BindingResource::TextureView(scene.sky.view()),
                    scene.brdf_table.as_entire_binding(),
                    scene.lights.as_entire_binding(),
                ];
                resources.extend_from_slice(structure);
                resources.extend([
                    sized.paths.as_entire_binding(),
                    sized.sums.as_entire_binding(),
                    sized.counters.as_entire_binding(),
                ]);
                // A sheet passed at the first hit uses up no bounce: such a path has one segment more.
                let most = bounces + u32::from(scene.needs.transmission);
                resources.push(sized.any_alive.as_entire_binding());
                for round in 0..most.div_ceil(segments) {
                    recorder.clear(&sized.any_alive);
                    recorder.compute(&segment, &kernels.segment, &resources, groups);
                    if settings.bounces.is_none() && round > 0 && none_alive(recorder, &sized.any_alive) {
                        break;
                    }
                }
                recorder.progress((sample + 1) as f32 / settings.spp as f32);
            }
        }
        let specular = sized.light.specular.as_ref().unwrap_or(&sized.no_specular);
        let resources = [
            uniform.binding(),
            sized.sums.as_entire_binding(),
            sized.sample_counts.as_entire_binding(),
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
        for (slot, name) in (0u64..).zip(["rays", "cut_rays", "iterations", "paths", "clamped"]) {
            recorder.counter(name, &sized.counters, 8 * slot);
        }
        sized.light.clone()
    }
}

/// Whether the last dispatch left no path alive. Only asked where paths have no limit: it waits for the dispatch.
fn none_alive(recorder: &mut Recorder<'_>, any_alive: &Buffer) -> bool {
    recorder.flush();
    // Should reading fail, the device is gone, and the frame's end will say so.
    recorder.gpu().read_buffer::<u32>(any_alive).is_ok_and(|words| words == [0])
}

const PATH_WGSL: &str = include_str!("path.inc.wgsl");
const START_WGSL: &str = include_str!("start.wgsl");
const SEGMENT_WGSL: &str = include_str!("segment.wgsl");
const RESOLVE_WGSL: &str = include_str!("resolve.wgsl");
