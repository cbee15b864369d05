//! Follows orders: one world, one or two streets through it, frames, then the reference.
//!
//! Each step is one short piece of work: a frame of each side, one pass's output, one sample of the reference.

use super::judge::Judge;
use super::{Event, Order, Post, outputs};
use frame::cpu::Image;
use frame::{Gpu, Room};
use gridlight::pipeline::{Pipeline, Rendered, Street};
use gridlight::settings::{Preset, View};
use gridlight::{Error, Progress, RenderSettings, metrics, output, stages};
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

/// What a step was.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Did {
    /// Part of what was asked for.
    Asked,
    /// A sample of the reference.
    Reference,
    /// There was nothing to do.
    Nothing,
}

/// Failed steps in a row after which no other device is tried.
const MOST_FAILURES: u32 = 2;

/// What is rendered with, from order to order.
pub struct Renderer {
    adapter: Option<String>,
    post: Post,
    gpu: Option<Gpu>,
    world: Option<World>,
    order: Option<Order>,
    /// The order's part that is not done.
    due: Due,
    /// Steps in a row that failed.
    failures: u32,
}

/// The loaded scene with its streets.
struct World {
    pipeline: Pipeline,
    second: Option<Street>,
    /// The last frame of each side, whose textures the next one overwrites.
    last: Vec<Rendered>,
    pictures: Vec<Arc<Image<[f32; 3]>>>,
    frames_done: u32,
    judge: Option<Judge>,
}

#[derive(Default)]
struct Due {
    output: bool,
    values: bool,
    flip: bool,
}

impl Renderer {
    /// Opens nothing yet.
    pub fn new(adapter: Option<String>, post: Post) -> Self {
        Self { adapter, post, gpu: None, world: None, order: None, due: Due::default(), failures: 0 }
    }

    /// Takes over another order. Where it cannot be followed, that is said and the one before stands.
    pub fn take(&mut self, order: Order) {
        if let Err(e) = self.follow(&order) {
            let standing = self.world.as_ref().and(self.order.as_ref()).map(|order| order.sides.clone());
            self.post.send(Event::Failed(e.to_string(), standing));
            return;
        }
        let before = self.order.replace(order);
        let Some(order) = &self.order else { return };
        let changed =
            |part: fn(&Order) -> (&Option<String>, usize)| before.as_ref().map(part) != Some(part(order));
        self.due.output |= changed(|o| (&o.watched, o.watched_side)) && order.watched.is_some();
        self.due.values |=
            before.as_ref().map(|o| o.inspected) != Some(order.inspected) && order.inspected.is_some();
        self.due.flip |= order.wants_flip && before.as_ref().is_none_or(|o| !o.wants_flip);
    }

    /// One piece of work.
    pub fn step(&mut self) -> Did {
        match self.try_step() {
            Ok(did) => {
                self.failures = 0;
                did
            }
            Err(e) => {
                self.post.send(Event::Failed(e.to_string(), None));
                self.failures += 1;
                self.recover()
            }
        }
    }

    /// Takes the device away, as a driver may.
    #[cfg(test)]
    pub fn lose_device(&mut self) {
        if let Some(gpu) = &self.gpu {
            gpu.device.destroy();
        }
    }

    fn follow(&mut self, order: &Order) -> Result<(), Error> {
        let Some(first) = order.sides.first() else { return Ok(()) };
        if self.gpu.is_none() {
            let gpu = open(self.adapter.as_deref())?;
            self.post.send(Event::Adapter(gpu.info.name.clone()));
            self.post.send(Event::Knobs(stages::knobs(gpu.clone())?));
            self.gpu = Some(gpu);
        }
        let restarts = self.order.as_ref().is_some_and(|before| {
            before.restarts != order.restarts || (before.is_moving && !order.is_moving)
        });
        match &mut self.world {
            Some(world) if !needs_another_world(world.pipeline.settings(), first) => {
                let done = world.follow(order, restarts);
                if done.is_err() {
                    // Half changed: what stands is made anew for the order before.
                    self.world = None;
                    self.reload()?;
                }
                done
            }
            _ => {
                let Some(gpu) = self.gpu.clone() else { return Ok(()) };
                let mut world = World::load(gpu, first, &self.post)?;
                world.follow(order, false)?;
                self.post.send(Event::Scene(Box::new(world.facts())));
                self.world = Some(world);
                Ok(())
            }
        }
    }

    /// Loads what the order in force says.
    fn reload(&mut self) -> Result<(), Error> {
        let (Some(order), Some(gpu)) = (self.order.clone(), self.gpu.clone()) else { return Ok(()) };
        let Some(first) = order.sides.first() else { return Ok(()) };
        let mut world = World::load(gpu, first, &self.post)?;
        world.follow(&order, false)?;
        self.world = Some(world);
        Ok(())
    }

    /// After a failure in the middle of a frame: the device is most likely lost, so another is opened.
    fn recover(&mut self) -> Did {
        self.world = None;
        self.gpu = None;
        if self.failures > MOST_FAILURES {
            let message = "it fails again and again; change something to try once more".into();
            self.post.send(Event::Failed(message, None));
            return Did::Nothing;
        }
        let again = open(self.adapter.as_deref()).map_err(Error::from).and_then(|gpu| {
            self.gpu = Some(gpu);
            self.reload()
        });
        if let Err(e) = again {
            self.post.send(Event::Failed(format!("the device could not be opened again: {e}"), None));
            return Did::Nothing;
        }
        Did::Asked
    }

    fn try_step(&mut self) -> Result<Did, Error> {
        let (Some(world), Some(order)) = (&mut self.world, &self.order) else { return Ok(Did::Nothing) };
        let is_path = matches!(world.pipeline.settings().view, View::Path(_));
        // A moving scene rests at its first frame: the reference knows one moment only.
        let at_rest = if world.has_motion() && !is_path { 1 } else { order.frames_at_rest };
        if order.is_playing || order.is_moving || world.frames_done < at_rest {
            if world.judge.take().is_some() {
                world.restart();
            }
            for side in 0..order.sides.len() {
                let frame = world.render(side)?;
                self.post.send(Event::Frame(Box::new(frame)));
            }
            world.frames_done += 1;
            self.due.output |= order.watched.is_some();
            self.due.values |= order.inspected.is_some();
            self.due.flip |= order.wants_flip;
            // A moving camera cannot wait for what takes longer than its frames.
            if !order.is_moving {
                return Ok(Did::Asked);
            }
        }
        if std::mem::take(&mut self.due.output) {
            if let (Some(name), Some(last)) = (&order.watched, world.last.get(order.watched_side)) {
                let output = outputs::read(world.pipeline.gpu(), last, name)?;
                self.post.send(Event::Output(Box::new(output)));
            }
            return Ok(Did::Asked);
        }
        if std::mem::take(&mut self.due.values) {
            if let (Some(at), Some(last)) = (order.inspected, world.last.get(order.watched_side)) {
                self.post.send(Event::Values(outputs::values(world.pipeline.gpu(), last, at)?));
            }
            return Ok(Did::Asked);
        }
        if std::mem::take(&mut self.due.flip) {
            if let [a, b] = world.pictures.as_slice() {
                // Pictures with numbers that are none have no FLIP; their frames show them.
                if let Ok(map) = metrics::flip::flip_map(a, b, 0.0, metrics::flip::PIXELS_PER_DEGREE) {
                    let mean =
                        map.texels().iter().map(|v| f64::from(*v)).sum::<f64>() / map.texels().len() as f64;
                    self.post.send(Event::Flip(map, mean));
                }
            }
            return Ok(Did::Asked);
        }
        if order.is_moving {
            return Ok(Did::Asked);
        }
        if order.is_judging && !is_path && !world.pictures.is_empty() {
            return world.judge(&self.post);
        }
        Ok(Did::Nothing)
    }
}

impl World {
    fn load(gpu: Gpu, settings: &RenderSettings, post: &Post) -> Result<Self, Error> {
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

    fn facts(&self) -> SceneFacts {
        let scene = self.pipeline.scene();
        SceneFacts {
            settings: self.pipeline.settings().clone(),
            cameras: scene.cameras.clone(),
            bounds: scene.bounds(),
            duration: scene.duration(),
            has_motion: self.has_motion(),
            sun: scene.sun,
            triangle_count: scene.rest().triangles.len(),
            warnings: self.pipeline.warnings().to_vec(),
        }
    }

    /// Whether a picture of another moment is another picture.
    fn has_motion(&self) -> bool {
        let scene = self.pipeline.scene();
        scene.needs().motion || scene.duration() > 0.0
    }

    /// Brings both streets to what the order says.
    fn follow(&mut self, order: &Order, restarts: bool) -> Result<(), Error> {
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

    fn restart(&mut self) {
        self.frames_done = 0;
        self.pipeline.restart();
        if let Some(street) = &mut self.second {
            self.pipeline.exchange(street);
            self.pipeline.restart();
            self.pipeline.exchange(street);
        }
    }

    fn render(&mut self, side: usize) -> Result<Frame, Error> {
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

    fn judge(&mut self, post: &Post) -> Result<Did, Error> {
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
fn needs_another_world(stands: &RenderSettings, wanted: &RenderSettings) -> bool {
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

/// A device whose errors are told, not panicked about: the frame they fall into fails to read back.
fn open(adapter: Option<&str>) -> Result<Gpu, frame::GpuError> {
    let gpu = Gpu::new(adapter)?;
    gpu.device.on_uncaptured_error(Arc::new(|e| eprintln!("warning: {e}")));
    Ok(gpu)
}
