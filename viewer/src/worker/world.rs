//! The loaded scene with one or two streets through it, and what of them goes to the panels.

use super::judge::Judge;
use super::renderer::Did;
use super::{Event, Order, Post};
use frame::cpu::Image;
use frame::{Gpu, Room};
use gridlight::pipeline::{Pipeline, Rendered, Street};
use gridlight::settings::Preset;
use gridlight::{Error, Progress, RenderSettings, output};
use scene::{Aabb, Camera};
use std::sync::Arc;
use std::time::Instant;

/// What panels say about a scene.
#[derive(Clone, Debug)]
pub struct SceneFacts {
    /// The settings it was loaded for.
    pub settings: RenderSettings,
    /// Its cameras at time 0.
    pub cameras: Vec<Camera>,
    /// Around every pose, m.
    pub bounds: Aabb,
    /// Of its animation, s.
    pub duration: f32,
    /// Whether anything moves.
    pub has_motion: bool,
    /// Its sun, if it has one.
    pub sun: Option<scene::Sun>,
    /// Triangles.
    pub triangle_count: usize,
    /// What could not be honoured.
    pub warnings: Vec<String>,
}

/// A pass in a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Pass {
    /// Its path.
    pub name: String,
    /// Milliseconds; none without timestamps.
    pub gpu_ms: Option<f64>,
    /// How often it ran.
    pub runs: u32,
}

/// One frame of one side.
pub struct Frame {
    /// A (0) or B (1).
    pub side: usize,
    /// Linear radiance at display size.
    pub radiance: Arc<Image<[f32; 3]>>,
    /// From 1: what `--frames` has to say for the last frame to be this one.
    pub number: u32,
    /// Moment of the animation, s.
    pub time: f32,
    /// In the order they ran.
    pub passes: Vec<Pass>,
    /// Rays, voxels and the like.
    pub counts: Vec<(String, f64)>,
    /// Bytes per room.
    pub memory: Vec<(&'static str, u64)>,
    /// From the first command to the last byte that came back.
    pub wall_ms: f64,
}

/// Rooms as panels list them.
const ROOMS: [(&str, Room); 6] = [
    ("scene", Room::Scene),
    ("voxels", Room::Voxels),
    ("G-buffers", Room::GBuffer),
    ("radiance", Room::Radiance),
    ("history", Room::History),
    ("BVH", Room::Bvh),
];

/// The loaded scene with its streets.
pub struct World {
    /// The first street, and what both share.
    pub pipeline: Pipeline,
    second: Option<Street>,
    /// The last frame of each side, whose textures the next one overwrites.
    pub last: Vec<Rendered>,
    /// What they show.
    pub pictures: Vec<Arc<Image<[f32; 3]>>>,
    /// Since the last restart.
    pub frames_done: u32,
    /// The reference, once one is wanted.
    pub judge: Option<Judge>,
}

impl World {
    /// Loads a scene; nothing is rendered yet.
    pub fn load(gpu: Gpu, settings: &RenderSettings, post: &Post) -> Result<Self, Error> {
        let to = post.clone();
        let progress = Progress::new(move |what, done| to.send(Event::Progress(what.into(), done)));
        let pipeline = Pipeline::new(gpu, settings, progress)?;
        Ok(Self {
            pipeline,
            second: None,
            last: Vec::new(),
            pictures: Vec::new(),
            frames_done: 0,
            judge: None,
        })
    }

    /// What panels say about it.
    pub fn facts(&self) -> SceneFacts {
        let scene = self.pipeline.scene();
        // Views are said in the file's own world.
        let (origin, mut bounds, mut cameras) = (scene.origin(), scene.bounds(), scene.cameras.clone());
        (bounds.min, bounds.max) = (bounds.min + origin, bounds.max + origin);
        for camera in &mut cameras {
            (camera.eye, camera.target) = (camera.eye + origin, camera.target + origin);
        }
        SceneFacts {
            settings: self.pipeline.settings().clone(),
            cameras,
            bounds,
            duration: scene.duration(),
            has_motion: self.has_motion(),
            sun: scene.sun,
            triangle_count: scene.rest().triangles.len(),
            warnings: self.pipeline.warnings().to_vec(),
        }
    }

    /// Whether a picture of another moment is another picture.
    pub fn has_motion(&self) -> bool {
        let scene = self.pipeline.scene();
        scene.needs().motion || scene.duration() > 0.0
    }

    /// Brings both streets to what the order says.
    pub fn follow(&mut self, order: &Order, restarts: bool) -> Result<(), Error> {
        let mut changed = restarts;
        if let Some(first) = order.sides.first() {
            changed |= bring(&mut self.pipeline, first, order.is_moving)?;
        }
        match (order.sides.get(1), self.second.take()) {
            (None, None) => {}
            (None, Some(_)) => changed = true,
            (Some(settings), None) => {
                self.second = Some(self.pipeline.street(settings)?);
                changed = true;
            }
            (Some(settings), Some(mut street)) => {
                self.pipeline.exchange(&mut street);
                let brought = bring(&mut self.pipeline, settings, order.is_moving);
                self.pipeline.exchange(&mut street);
                changed |= brought?;
                self.second = Some(street);
            }
        }
        if changed && !order.is_moving {
            self.restart();
        }
        if changed || order.is_moving {
            self.judge = None;
        }
        Ok(())
    }

    /// Begins both streets at their first frame.
    pub fn restart(&mut self) {
        self.frames_done = 0;
        self.pipeline.restart();
        if let Some(street) = &mut self.second {
            self.pipeline.exchange(street);
            self.pipeline.restart();
            self.pipeline.exchange(street);
        }
    }

    /// The next frame of a side.
    pub fn render(&mut self, side: usize) -> Result<Frame, Error> {
        let begun = Instant::now();
        let mut second = if side == 1 { self.second.take() } else { None };
        if let Some(street) = &mut second {
            self.pipeline.exchange(street);
        }
        let rendered = self.pipeline.render();
        if let Some(mut street) = second {
            self.pipeline.exchange(&mut street);
            self.second = Some(street);
        }
        let rendered = rendered?;
        let gpu = self.pipeline.gpu();
        let radiance = Arc::new(output::color(gpu, &rendered.color, rendered.frame.radiance_scale)?);
        let passes = &rendered.log.passes;
        let frame = Frame {
            side,
            radiance: radiance.clone(),
            number: rendered.frame.frame_index + 1,
            time: rendered.frame.time,
            passes: passes
                .iter()
                .map(|p| Pass { name: p.name.clone(), gpu_ms: p.gpu_ms, runs: p.runs })
                .collect(),
            counts: rendered.log.counts.iter().map(|(name, count)| (name.clone(), *count)).collect(),
            memory: ROOMS.iter().map(|(name, room)| (*name, gpu.memory(*room).live)).collect(),
            wall_ms: begun.elapsed().as_secs_f64() * 1e3,
        };
        self.last.truncate(side);
        self.last.push(rendered);
        self.pictures.truncate(side);
        self.pictures.push(radiance);
        Ok(frame)
    }

    /// One more sample of the reference, if it is worth it.
    pub fn judge(&mut self, post: &Post) -> Result<Did, Error> {
        if self.judge.is_none() {
            post.send(Event::Progress("preparing the reference".into(), 0.0));
            // Frames that follow begin anew, and the reference is of the first frame's moment.
            self.pipeline.restart();
            self.judge = Some(Judge::new(&self.pipeline)?);
        }
        let Some(judge) = &mut self.judge else { return Ok(Did::Nothing) };
        if judge.is_done() {
            return Ok(Did::Nothing);
        }
        let judgement = judge.sample(&mut self.pipeline, &self.pictures)?;
        if let Some(judgement) = judgement {
            post.send(Event::Judged(Box::new(judgement)));
        }
        Ok(Did::Reference)
    }
}

/// Makes the pipeline's settings these; true if what stands on the screen is no longer what they mean.
fn bring(pipeline: &mut Pipeline, settings: &RenderSettings, is_moving: bool) -> Result<bool, Error> {
    let settings = RenderSettings { frames: pipeline.settings().frames, ..settings.clone() };
    if *pipeline.settings() == settings {
        return Ok(false);
    }
    let same_but_view = RenderSettings { view: settings.view.clone(), ..pipeline.settings().clone() };
    match is_moving && same_but_view == settings {
        true => pipeline.look(settings.view),
        false => {
            // A camera that is not there leaves the pipeline as it is.
            gridlight::settings::open::camera(&settings, pipeline.scene(), settings.time)?;
            pipeline.change(&settings)?;
        }
    }
    Ok(true)
}

/// Whether another pipeline has to be made: [`Pipeline::change`] keeps the scene, its reading and the sizes.
pub fn needs_another_world(stands: &RenderSettings, wanted: &RenderSettings) -> bool {
    let reading = |preset: Preset| preset == Preset::Gltf;
    let kept = RenderSettings {
        scene: wanted.scene.clone(),
        model: wanted.model,
        trace_size: wanted.trace_size,
        display_size: wanted.display_size,
        sky: wanted.sky.clone(),
        sun: wanted.sun,
        sun_angle: wanted.sun_angle,
        emit: wanted.emit.clone(),
        moving_share: wanted.moving_share,
        texture_budget_bytes: wanted.texture_budget_bytes,
        ..stands.clone()
    };
    kept != *stands || reading(stands.preset) != reading(wanted.preset)
}
