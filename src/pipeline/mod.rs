//! The frame as one function: read [`Pipeline::render`] top to bottom and you have read section 2 of the paper.
//!
//! Everything that can be refused is refused in [`Pipeline::new`]: adapter, scene, names, knobs, memory. A frame then
//! records every stage, submits, and returns what each of them made. Beside the frame: stages taking turns (`street`), their
//! knobs (`knobs`), and images that converge through the same world (`converge`).

mod converge;
mod knobs;
mod street;

pub use knobs::set_knobs;
pub use street::Street;

use crate::settings::{Model, Preset, RenderSettings, View, open};
use crate::world::{Searches, Site};
use crate::{Error, Progress};
use denoise::Denoiser;
use frame::scene_gpu::{self, GpuScene, SceneOptions};
use frame::{ColorImage, FrameInfo, FrameLog, GBuffer, Gpu, RadianceImage, Recorder};
use scene::{Camera, Geometry, Scene};
use std::collections::BTreeMap;
use tessellate::Tessellator;
use tracer::{Gather, Search};
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
    progress: Progress,
    scene: Scene,
    geometry: Geometry,
    world: GpuScene,
    searches: Searches,
    voxel_size: f32,
    tessellator: Box<dyn Tessellator>,
    gather: Gather,
    trace: GBuffer,
    /// None where both sizes are equal: one G-buffer serves both.
    display: Option<GBuffer>,
    street: Street,
    /// The moment that the geometry is at, and whether it stood still there.
    posed: (f32, bool),
    /// Every knob as its stage came, by the stage's id.
    knob_defaults: BTreeMap<(&'static str, &'static str), String>,
    warnings: Vec<String>,
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
        let street = Street::new(&gpu, settings)?;
        let mut pipeline = Self {
            searches: Searches::new(&gpu, &world)?,
            gather: Gather::new(&gpu, &world)?,
            trace: GBuffer::new(&gpu, settings.trace_size)?,
            display: (settings.trace_size != settings.display_size)
                .then(|| GBuffer::new(&gpu, settings.display_size))
                .transpose()?,
            gpu,
            progress,
            scene,
            geometry,
            world,
            voxel_size,
            tessellator,
            street,
            posed: (settings.time, true),
            knob_defaults: BTreeMap::new(),
            warnings,
        };
        pipeline.note_defaults();
        pipeline.apply_knobs()?;
        pipeline.gather.resize(&pipeline.gpu, &[settings.trace_size, settings.display_size])?;
        pipeline.street.resize(&pipeline.gpu, &pipeline.world)?;
        Ok(pipeline)
    }

    /// Looks from elsewhere from the next frame on, and remembers what was seen: a camera that is moved by hand.
    pub fn look(&mut self, view: View) {
        self.street.settings.view = view;
    }

    /// Forgets all history: the next frame is the first.
    pub fn restart(&mut self) {
        self.street.previous = None;
        self.street.frame_index = 0;
    }

    /// Renders the next frame.
    ///
    /// # Errors
    /// The device was lost or ran out of memory, or a moving scene no longer fits its grid.
    pub fn render(&mut self) -> Result<Rendered, Error> {
        let frame = self.next_frame()?;
        let moved = self.pose(&frame);
        let mut recorder = Recorder::of_frame(&self.gpu);
        let progress = self.progress.clone();
        recorder.on_progress(move |done| progress.report("tracing", done));
        let uniform = recorder.uniform(&frame.uniform());

        let mesh = self.tessellator.tessellate(&mut recorder, &frame, self.voxel_size, &self.world);
        if moved {
            self.searches.moved();
        }
        self.progress.report("building the structure", 0.0);
        let (search, bounds) = (self.street.tracer.search(), self.tessellator.bounds(&self.world));
        let site = Site {
            scene: &self.world,
            mesh: &mesh,
            bounds,
            grid: self.street.settings.grid,
            eye: frame.camera.eye,
            cache: self.street.paths.build.cache,
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
        let noisy =
            self.street.tracer.trace(&mut recorder, &frame, &uniform, world, &self.trace, &self.street.paths);
        let denoised = self.street.denoiser.denoise(&mut recorder, &frame, &uniform, &self.trace, &noisy);
        let color = self.street.upsampler.upsample(
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
        self.street.previous = Some(frame);
        self.street.frame_index += 1;
        Ok(rendered)
    }

    /// Whether anything of the scene moves.
    fn moves(&self) -> bool {
        self.geometry.static_object_count() < self.geometry.objects.len()
    }

    /// Puts what moves where it is at the frame's moment; false where it is there already.
    fn pose(&mut self, frame: &FrameInfo) -> bool {
        // A second street finds the moment of the first one's frame.
        let moved = self.posed != (frame.time, frame.restart) && self.moves();
        if moved {
            self.scene.pose(frame.time, &mut self.geometry);
            self.world.update(&self.gpu, &self.geometry);
            if frame.restart {
                // Before the first frame nothing moved.
                self.world.update(&self.gpu, &self.geometry);
            }
            self.posed = (frame.time, frame.restart);
        }
        moved
    }

    /// What was asked for.
    pub fn settings(&self) -> &RenderSettings {
        &self.street.settings
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

    fn next_frame(&self) -> Result<FrameInfo, Error> {
        let time = self.street.settings.frame_time(self.street.frame_index);
        let camera: Camera = open::camera(&self.street.settings, &self.scene, time)?;
        let jitter = self.street.upsampler.jitter(self.street.frame_index);
        let previous = self.street.previous.as_ref();
        Ok(FrameInfo {
            previous_camera: previous.map_or_else(|| camera.clone(), |p| p.camera.clone()),
            previous_jitter: previous.map_or(jitter, |p| p.jitter),
            camera,
            trace_size: self.street.settings.trace_size,
            display_size: self.street.settings.display_size,
            jitter,
            frame_index: self.street.frame_index,
            seed: self.street.settings.seed,
            time,
            dt: previous.map_or(0.0, |p| time - p.time),
            radiance_scale: self.world.radiance_scale,
            diagonal: self.scene.bounds().diagonal(),
            restart: previous.is_none(),
            sun_elsewhere: false,
        })
    }

    fn count(&self, log: &mut FrameLog) {
        if let (Some(grid), Search::Grid) = (self.searches.grid(), self.street.tracer.search()) {
            log.counts.insert("voxels".into(), f64::from(grid.voxel_count));
            log.counts.insert("bricks".into(), f64::from(grid.brick_count));
        }
        let pixels =
            f64::from(self.street.settings.trace_size[0]) * f64::from(self.street.settings.trace_size[1]);
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

/// Looks a stage up in its list.
fn find<C: Copy>(kind: &'static str, name: &str, all: &[(&'static str, C)]) -> Result<C, Error> {
    all.iter().find(|(known, _)| *known == name).map(|(_, make)| *make).ok_or_else(|| Error::NoSuchName {
        kind,
        name: name.into(),
        known: all.iter().map(|(known, _)| *known).collect::<Vec<_>>().join(", "),
    })
}
