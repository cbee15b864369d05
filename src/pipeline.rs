//! The frame as one function: read [`Pipeline::render`] top to bottom and you have read section 2 of the paper.
//!
//! Everything that can be refused is refused in [`Pipeline::new`]: adapter, scene, names, knobs, memory. A frame then
//! records every stage, submits, and returns what each of them made.

use crate::reference::Moments;
use crate::settings::{KnobSetting, Model, Preset, RenderSettings, View, open};
use crate::world::{Searches, Site};
use crate::{Error, Progress};
use denoise::Denoiser;
use frame::scene_gpu::{self, GpuScene, SceneOptions};
use frame::surface;
use frame::{ColorImage, FrameInfo, FrameLog, GBuffer, Gpu, Knob, RadianceImage, Recorder};
use scene::{Camera, Geometry, Scene};
use std::collections::BTreeMap;
use std::ops::Range;
use tessellate::Tessellator;
use tracer::{Converger, Gather, PathSettings, Search, Tracer, World};
use upsample::Upsampler;
use voxel::VoxelGrid;
use voxel::grid::Layout;

/// What one frame made. Images stay valid until the next frame.
pub struct Rendered {
    /// The picture, display size, radiance times `radiance_scale`.
    pub color: ColorImage,
    /// What the camera sees at trace size.
    pub trace: GBuffer,
    /// What the camera sees at display size.
    pub display: GBuffer,
    /// Light as traced.
    pub noisy: RadianceImage,
    /// Light as filtered.
    pub denoised: RadianceImage,
    /// Passes, times, counts.
    pub log: FrameLog,
    /// What it was rendered with.
    pub frame: FrameInfo,
}

/// The world, the chosen stages, and what they keep from frame to frame.
pub struct Pipeline {
    gpu: Gpu,
    settings: RenderSettings,
    progress: Progress,
    scene: Scene,
    geometry: Geometry,
    world: GpuScene,
    searches: Searches,
    voxel_size: f32,
    tessellator: Box<dyn Tessellator>,
    gather: Gather,
    tracer: Box<dyn Tracer>,
    denoiser: Box<dyn Denoiser>,
    upsampler: Box<dyn Upsampler>,
    paths: PathSettings,
    trace: GBuffer,
    /// None where both sizes are equal: one G-buffer serves both.
    display: Option<GBuffer>,
    previous: Option<FrameInfo>,
    frame_index: u32,
    /// The moment that the geometry is at, and whether it stood still there.
    posed: (f32, bool),
    /// Every knob as its stage came, by the stage's id.
    knob_defaults: BTreeMap<(&'static str, &'static str), String>,
    warnings: Vec<String>,
}

/// The stages that find, filter and lift light, and what they remember. Two of them can take turns with one pipeline's
/// world: a split screen builds nothing twice.
pub struct Street {
    settings: RenderSettings,
    tracer: Box<dyn Tracer>,
    denoiser: Box<dyn Denoiser>,
    upsampler: Box<dyn Upsampler>,
    paths: PathSettings,
    previous: Option<FrameInfo>,
    frame_index: u32,
}

impl Pipeline {
    /// Loads the scene, makes the stages, allocates for both sizes.
    ///
    /// # Errors
    /// A scene, name, knob or size that cannot be had; the message says which and why.
    pub fn new(gpu: Gpu, settings: &RenderSettings, progress: Progress) -> Result<Self, Error> {
        progress.report("loading", 0.0);
        let scene = open::scene(settings)?;
        Self::of_scene(gpu, scene, settings, progress)
    }

    /// The same for a scene that is there already; what the settings say about scene, sky and sun is left aside.
    ///
    /// # Errors
    /// As [`Pipeline::new`].
    pub fn of_scene(
        gpu: Gpu,
        scene: Scene,
        settings: &RenderSettings,
        progress: Progress,
    ) -> Result<Self, Error> {
        open::camera(settings, &scene, settings.time)?;
        let mut geometry = scene.rest().clone();
        scene.pose(settings.time, &mut geometry);
        progress.report("uploading", 0.0);
        let options = SceneOptions {
            model: match settings.model {
                Model::Gltf => scene_gpu::Model::Gltf,
                Model::Lambert => scene_gpu::Model::Lambert,
            },
            texture_budget_bytes: settings.texture_budget_bytes,
            as_references: settings.preset == Preset::Gltf,
        };
        let (world, upload_warnings) = GpuScene::new(&gpu, &scene, &geometry, &options)?;
        let mut warnings = scene.warnings.clone();
        warnings.extend(upload_warnings);

        let most = gpu.device.limits().max_texture_dimension_2d;
        progress.report("building kernels", 0.0);
        let tessellator = find("tessellator", &settings.tessellator, tessellate::all())?(&gpu)?;
        let voxel_size = Layout::fit(tessellator.bounds(&world), settings.grid, most)?.voxel_size;
        let tracer = find("tracer", &settings.tracer, tracer::all())?(&gpu)?;
        let denoiser = find("denoiser", &settings.denoiser, denoise::all())?(&gpu)?;
        let upsampler = find("upsampler", &settings.upsampler, upsample::all())?(&gpu)?;
        let mut pipeline = Self {
            searches: Searches::new(&gpu, &world)?,
            gather: Gather::new(&gpu, &world)?,
            trace: GBuffer::new(&gpu, settings.trace_size)?,
            display: (settings.trace_size != settings.display_size)
                .then(|| GBuffer::new(&gpu, settings.display_size))
                .transpose()?,
            paths: PathSettings { spp: settings.spp, bounces: settings.bounces, ..Default::default() },
            gpu,
            settings: settings.clone(),
            progress,
            scene,
            geometry,
            world,
            voxel_size,
            tessellator,
            tracer,
            denoiser,
            upsampler,
            previous: None,
            frame_index: 0,
            posed: (settings.time, true),
            knob_defaults: BTreeMap::new(),
            warnings,
        };
        pipeline.note_defaults();
        pipeline.apply_knobs()?;
        let specular = pipeline.world.needs.specular;
        pipeline.gather.resize(&pipeline.gpu, &[settings.trace_size, settings.display_size])?;
        pipeline.tracer.resize(&pipeline.gpu, &pipeline.world, settings.trace_size, &pipeline.paths)?;
        pipeline.denoiser.resize(&pipeline.gpu, settings.trace_size, specular)?;
        pipeline.upsampler.resize(&pipeline.gpu, settings.trace_size, settings.display_size, specular)?;
        Ok(pipeline)
    }

    /// Swaps stages, knobs, samples, bounces, seed, view, time or grid for what `settings` say, and restarts. What stays
    /// the same is kept, the scene, its reading and the sizes among it: about those, `settings` must repeat what the
    /// pipeline was made with.
    ///
    /// # Errors
    /// A name that is not in its list, a kernel the driver refuses, or memory is out. The pipeline may then be half
    /// changed: make another.
    pub fn change(&mut self, settings: &RenderSettings) -> Result<(), Error> {
        let before = std::mem::replace(&mut self.settings, settings.clone());
        let another = [
            before.tracer != settings.tracer,
            before.denoiser != settings.denoiser,
            before.upsampler != settings.upsampler,
        ];
        let knobs_before = self.knob_values();
        let gpu = &self.gpu;
        if before.tessellator != settings.tessellator {
            self.tessellator = find("tessellator", &settings.tessellator, tessellate::all())?(gpu)?;
        }
        if another[0] {
            self.tracer = find("tracer", &settings.tracer, tracer::all())?(gpu)?;
        }
        if another[1] {
            self.denoiser = find("denoiser", &settings.denoiser, denoise::all())?(gpu)?;
        }
        if another[2] {
            self.upsampler = find("upsampler", &settings.upsampler, upsample::all())?(gpu)?;
        }
        self.note_defaults();
        self.paths.spp = settings.spp;
        self.paths.bounces = settings.bounces;
        self.apply_knobs()?;
        let knobs = self.knob_values();
        let turned = |id: &str| {
            let of = |values: &KnobValues| {
                values.iter().filter(|((i, _), _)| *i == id).cloned().collect::<Vec<_>>()
            };
            of(&knobs_before) != of(&knobs)
        };
        if before.grid != settings.grid
            || before.tessellator != settings.tessellator
            || turned("voxel")
            || turned(self.tessellator.name())
        {
            let most = self.gpu.device.limits().max_texture_dimension_2d;
            let bounds = self.tessellator.bounds(&self.world);
            self.voxel_size = Layout::fit(bounds, settings.grid, most)?.voxel_size;
            self.searches.forget_grid();
        }
        if turned(self.tessellator.name()) {
            self.searches.moved();
        }
        let specular = self.world.needs.specular;
        if turned("gather") {
            self.gather.resize(&self.gpu, &[settings.trace_size, settings.display_size])?;
        }
        if another[0] || turned("tracer") || turned(self.tracer.name()) {
            self.tracer.resize(&self.gpu, &self.world, settings.trace_size, &self.paths)?;
        }
        if another[1] || turned(self.denoiser.name()) {
            self.denoiser.resize(&self.gpu, settings.trace_size, specular)?;
        }
        if another[2] || turned(self.upsampler.name()) {
            self.upsampler.resize(&self.gpu, settings.trace_size, settings.display_size, specular)?;
        }
        self.restart();
        Ok(())
    }

    /// Looks from elsewhere from the next frame on, and remembers what was seen: a camera that is moved by hand.
    pub fn look(&mut self, view: View) {
        self.settings.view = view;
    }

    /// Makes a second street through the same world, for [`Pipeline::exchange`]; about everything but tracer, denoiser,
    /// upsampler, their knobs, samples, bounces and seed, `settings` must repeat what the pipeline shows.
    ///
    /// # Errors
    /// As [`Pipeline::change`].
    pub fn street(&mut self, settings: &RenderSettings) -> Result<Street, Error> {
        let specular = self.world.needs.specular;
        let mut street = Street {
            settings: settings.clone(),
            tracer: find("tracer", &settings.tracer, tracer::all())?(&self.gpu)?,
            denoiser: find("denoiser", &settings.denoiser, denoise::all())?(&self.gpu)?,
            upsampler: find("upsampler", &settings.upsampler, upsample::all())?(&self.gpu)?,
            paths: PathSettings { spp: settings.spp, bounces: settings.bounces, ..Default::default() },
            previous: None,
            frame_index: 0,
        };
        self.exchange(&mut street);
        self.note_defaults();
        let applied = self.apply_knobs();
        self.exchange(&mut street);
        applied?;
        street.tracer.resize(&self.gpu, &self.world, settings.trace_size, &street.paths)?;
        street.denoiser.resize(&self.gpu, settings.trace_size, specular)?;
        street.upsampler.resize(&self.gpu, settings.trace_size, settings.display_size, specular)?;
        Ok(street)
    }

    /// Puts another street's stages in place; `street` then holds those that were there.
    pub fn exchange(&mut self, street: &mut Street) {
        std::mem::swap(&mut self.settings, &mut street.settings);
        std::mem::swap(&mut self.tracer, &mut street.tracer);
        std::mem::swap(&mut self.denoiser, &mut street.denoiser);
        std::mem::swap(&mut self.upsampler, &mut street.upsampler);
        std::mem::swap(&mut self.paths, &mut street.paths);
        std::mem::swap(&mut self.previous, &mut street.previous);
        std::mem::swap(&mut self.frame_index, &mut street.frame_index);
    }

    /// Forgets all history: the next frame is the first.
    pub fn restart(&mut self) {
        self.previous = None;
        self.frame_index = 0;
    }

    /// Renders the next frame.
    ///
    /// # Errors
    /// The device was lost or ran out of memory, or a moving scene no longer fits its grid.
    pub fn render(&mut self) -> Result<Rendered, Error> {
        let frame = self.next_frame()?;
        // A second street finds the moment of the first one's frame.
        let moved = self.posed != (frame.time, frame.restart)
            && self.geometry.static_object_count() < self.geometry.objects.len();
        if moved {
            self.scene.pose(frame.time, &mut self.geometry);
            self.world.update(&self.gpu, &self.geometry);
            if frame.restart {
                // Before the first frame nothing moved.
                self.world.update(&self.gpu, &self.geometry);
            }
            self.posed = (frame.time, frame.restart);
        }
        let mut recorder = Recorder::new(&self.gpu);
        let progress = self.progress.clone();
        recorder.on_progress(move |done| progress.report("tracing", done));
        let uniform = recorder.uniform(&frame.uniform());

        let mesh = self.tessellator.tessellate(&mut recorder, &frame, self.voxel_size, &self.world);
        if moved {
            self.searches.moved();
        }
        self.progress.report("building the structure", 0.0);
        let (search, bounds) = (self.tracer.search(), self.tessellator.bounds(&self.world));
        let site = Site {
            scene: &self.world,
            mesh: &mesh,
            bounds,
            grid: self.settings.grid,
            cache: self.paths.build.cache,
        };
        self.searches.find_moving(&mut recorder, search, site)?;

        self.gather.gather(&mut recorder, "gather/trace", &uniform, &self.world, &mesh, &self.trace);
        let display = self.display.as_ref().unwrap_or(&self.trace);
        if self.display.is_some() {
            // Jitter belongs to the trace pixels; what is shown stands still.
            let still = FrameInfo { jitter: [0.0; 2], previous_jitter: [0.0; 2], ..frame.clone() };
            let still = recorder.uniform(&still.uniform());
            self.gather.gather(&mut recorder, "gather/display", &still, &self.world, &mesh, display);
        }
        // Gathering keeps the device busy while the number of moving bricks comes back.
        let mut build_log = self.searches.build(&mut recorder, search, site)?;
        let world = self.searches.world(&self.world, &mesh);
        let noisy = self.tracer.trace(&mut recorder, &frame, &uniform, world, &self.trace, &self.paths);
        let denoised = self.denoiser.denoise(&mut recorder, &frame, &uniform, &self.trace, &noisy);
        let color = self.upsampler.upsample(
            &mut recorder,
            &frame,
            &uniform,
            &self.world,
            &self.trace,
            &denoised,
            display,
            None,
        );

        build_log.append(recorder.finish()?);
        let mut log = build_log;
        self.searches.settle(&mut log);
        self.count(&mut log);
        let rendered = Rendered {
            color,
            trace: self.trace.clone(),
            display: display.clone(),
            noisy,
            denoised,
            log,
            frame: frame.clone(),
        };
        self.previous = Some(frame);
        self.frame_index += 1;
        Ok(rendered)
    }

    /// Builds `searches` for the next frame and lends them out with what it would be rendered with.
    ///
    /// # Errors
    /// They do not fit the adapter, or `visit`'s own.
    pub fn with_world<R>(
        &mut self,
        searches: &[Search],
        visit: impl FnOnce(&Gpu, &FrameInfo, World<'_>) -> Result<R, Error>,
    ) -> Result<R, Error> {
        let frame = self.next_frame()?;
        let mut recorder = Recorder::new(&self.gpu);
        let mesh = self.tessellator.tessellate(&mut recorder, &frame, self.voxel_size, &self.world);
        let site = Site {
            scene: &self.world,
            mesh: &mesh,
            bounds: self.tessellator.bounds(&self.world),
            grid: self.settings.grid,
            cache: self.paths.build.cache,
        };
        for search in searches {
            self.searches.build(&mut recorder, *search, site)?;
        }
        let mut log = recorder.finish()?;
        self.searches.settle(&mut log);
        visit(&self.gpu, &frame, self.searches.world(&self.world, &mesh))
    }

    /// Makes what [`Pipeline::sample`] needs: paths through one structure, at display size.
    ///
    /// # Errors
    /// The driver refuses a kernel, the size is too large for the adapter, or memory is out.
    pub fn sampler(&self, search: Search) -> Result<Converger, Error> {
        let size = self.settings.display_size;
        Ok(Converger::new(&self.gpu, &self.world, search, size, &self.paths)?)
    }

    /// Adds samples number `samples` of the converged image to `moments`: one batch, or what is left of it.
    ///
    /// # Errors
    /// The device was lost or ran out of memory.
    pub fn sample(
        &mut self,
        sampler: &mut Converger,
        samples: Range<u32>,
        moments: &mut Moments,
    ) -> Result<(), Error> {
        let mut frame = self.next_frame()?;
        frame.trace_size = self.settings.display_size;
        frame.jitter = [0.0; 2];
        frame.previous_jitter = [0.0; 2];
        // Not the numbers of a render with this seed, and other ones in every batch: their stratification starts anew.
        let batch = crate::reference::batch_end(samples.start);
        frame.seed = surface::hash(surface::hash(frame.seed ^ 0x7265_6673) ^ batch);
        for band in sampler.bands() {
            let mut recorder = Recorder::new(&self.gpu);
            let uniform = recorder.uniform(&frame.uniform());
            let mesh = self.tessellator.tessellate(&mut recorder, &frame, self.voxel_size, &self.world);
            let site = Site {
                scene: &self.world,
                mesh: &mesh,
                bounds: self.tessellator.bounds(&self.world),
                grid: self.settings.grid,
                cache: false,
            };
            for search in sampler.searches() {
                self.searches.build(&mut recorder, search, site)?;
            }
            let world = self.searches.world(&self.world, &mesh);
            sampler.record(&mut recorder, &uniform, world, &self.paths, &band, samples.clone());
            recorder.finish()?;
            moments.add(&band, &sampler.moments(&self.gpu, &band)?, self.world.radiance_scale);
        }
        moments.counted(samples.end - samples.start);
        Ok(())
    }

    /// What was asked for.
    pub fn settings(&self) -> &RenderSettings {
        &self.settings
    }

    /// Who is told how far things have come.
    pub fn progress(&self) -> &Progress {
        &self.progress
    }

    /// The device.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// The scene as loaded.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The scene as uploaded.
    pub fn world(&self) -> &GpuScene {
        &self.world
    }

    /// The voxels, once a frame needed them.
    pub fn grid(&self) -> Option<&VoxelGrid> {
        self.searches.grid()
    }

    /// What the file or the upload could not honour, one line each.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Every knob of the chosen stages, by the id that `--set` takes.
    pub fn with_knobs<R>(&mut self, visit: impl FnOnce(Vec<(&'static str, Vec<Knob<'_>>)>) -> R) -> R {
        let mut choices = self.paths.choices();
        let of_tracer = self.paths.knobs(&mut choices);
        let (tessellator, tracer) = (self.tessellator.name(), self.tracer.name());
        let (denoiser, upsampler) = (self.denoiser.name(), self.upsampler.name());
        let mut all = vec![
            ("voxel", self.searches.knobs()),
            ("gather", self.gather.knobs()),
            ("tracer", of_tracer),
            (tessellator, self.tessellator.knobs()),
            (tracer, self.tracer.knobs()),
            (denoiser, self.denoiser.knobs()),
            (upsampler, self.upsampler.knobs()),
        ];
        // The tracer `voxel` and the stage `voxel` share an id: one list.
        let mut merged: Vec<(&'static str, Vec<Knob<'_>>)> = Vec::new();
        for (id, knobs) in all.drain(..) {
            match merged.iter_mut().find(|(known, _)| *known == id) {
                Some((_, list)) => list.extend(knobs),
                None => merged.push((id, knobs)),
            }
        }
        let result = visit(merged);
        self.paths.choose(choices);
        result
    }

    /// Notes the values of stages that were just made.
    fn note_defaults(&mut self) {
        for (knob, value) in self.knob_values() {
            self.knob_defaults.entry(knob).or_insert(value);
        }
    }

    fn knob_values(&mut self) -> KnobValues {
        let of = |(id, knobs): &(&'static str, Vec<Knob<'_>>)| {
            knobs.iter().map(|knob| ((*id, knob.name), knob.to_string())).collect::<Vec<_>>()
        };
        self.with_knobs(|stages| stages.iter().flat_map(of).collect())
    }

    /// Every knob as it came, then as the preset, then as the settings say.
    fn apply_knobs(&mut self) -> Result<(), Error> {
        let settings = self.settings.clone();
        let defaults = std::mem::take(&mut self.knob_defaults);
        let reset: Result<(), Error> = self.with_knobs(|mut stages| {
            for (id, knobs) in &mut stages {
                for knob in knobs.iter_mut() {
                    if let Some(value) = defaults.get(&(*id, knob.name)) {
                        knob.set(value).map_err(|source| Error::Knob { id: (*id).into(), source })?;
                    }
                }
            }
            Ok(())
        });
        self.knob_defaults = defaults;
        reset?;
        let preset = settings.preset.knobs();
        self.with_knobs(|stages| {
            let known = stages.iter().map(|(id, _)| *id).collect::<Vec<_>>().join(", ");
            let mut stages: Vec<_> = stages;
            for (id, name, value) in preset {
                // A preset speaks of every stage; those not chosen have nothing to set.
                if let Some((_, knobs)) = stages.iter_mut().find(|(known, _)| known == id) {
                    set(id, knobs, name, value)?;
                }
            }
            for wanted in &settings.sets {
                let Some((_, knobs)) = stages.iter_mut().find(|(id, _)| *id == wanted.id) else {
                    return Err(Error::NoSuchStage {
                        id: wanted.id.clone(),
                        knob: wanted.knob.clone(),
                        known,
                    });
                };
                set(&wanted.id, knobs, &wanted.knob, &wanted.value)?;
            }
            Ok(())
        })
    }

    fn next_frame(&self) -> Result<FrameInfo, Error> {
        let time = self.settings.frame_time(self.frame_index);
        let camera: Camera = open::camera(&self.settings, &self.scene, time)?;
        let jitter = self.upsampler.jitter(self.frame_index);
        let previous = self.previous.as_ref();
        Ok(FrameInfo {
            previous_camera: previous.map_or_else(|| camera.clone(), |p| p.camera.clone()),
            previous_jitter: previous.map_or(jitter, |p| p.jitter),
            camera,
            trace_size: self.settings.trace_size,
            display_size: self.settings.display_size,
            jitter,
            frame_index: self.frame_index,
            seed: self.settings.seed,
            time,
            dt: previous.map_or(0.0, |p| time - p.time),
            radiance_scale: self.world.radiance_scale,
            diagonal: self.scene.bounds().diagonal(),
            restart: previous.is_none(),
            sun_elsewhere: false,
        })
    }

    fn count(&self, log: &mut FrameLog) {
        if let (Some(grid), Search::Grid) = (self.searches.grid(), self.tracer.search()) {
            log.counts.insert("voxels".into(), f64::from(grid.voxel_count));
            log.counts.insert("bricks".into(), f64::from(grid.brick_count));
        }
        let pixels = f64::from(self.settings.trace_size[0]) * f64::from(self.settings.trace_size[1]);
        let paths = log.counts.get("paths").copied().unwrap_or(0.0);
        log.counts.insert("mean_spp".into(), paths / pixels);
    }
}

/// A denoiser by its name.
///
/// # Errors
/// No such name, or the driver refuses a kernel.
pub fn denoiser(gpu: &Gpu, name: &str) -> Result<Box<dyn Denoiser>, Error> {
    Ok(find("denoiser", name, denoise::all())?(gpu)?)
}

/// Sets knobs of one stage, the only one that `wanted` may name.
///
/// # Errors
/// Another stage is named, or a knob refuses its value.
pub fn set_knobs(id: &str, knobs: &mut [Knob<'_>], wanted: &[KnobSetting]) -> Result<(), Error> {
    wanted.iter().try_for_each(|wanted| match wanted.id == id {
        true => set(id, knobs, &wanted.knob, &wanted.value),
        false => {
            Err(Error::NoSuchStage { id: wanted.id.clone(), knob: wanted.knob.clone(), known: id.into() })
        }
    })
}

/// Stage, name, value.
type KnobValues = Vec<((&'static str, &'static str), String)>;

fn set(id: &str, knobs: &mut [Knob<'_>], name: &str, value: &str) -> Result<(), Error> {
    frame::set_knob(knobs, name, value).map_err(|source| Error::Knob { id: id.into(), source })
}

/// Looks a stage up in its list.
fn find<C: Copy>(kind: &'static str, name: &str, all: &[(&'static str, C)]) -> Result<C, Error> {
    all.iter().find(|(known, _)| *known == name).map(|(_, make)| *make).ok_or_else(|| Error::NoSuchName {
        kind,
        name: name.into(),
        known: all.iter().map(|(known, _)| *known).collect::<Vec<_>>().join(", "),
    })
}
