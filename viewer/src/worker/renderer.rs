//! Follows orders: one world, one or two streets through it, frames, then the reference.
//!
//! Each step is one short piece of work: a frame of each side, one pass's output, one sample of the reference.

use super::shaders::{Change, Shaders};
use super::world::{World, needs_another_world};
use super::{Event, Order, Post, outputs};
use frame::Gpu;
use gridlight::settings::View;
use gridlight::{Error, metrics, stages};
use std::path::Path;
use std::sync::Arc;

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
    shaders: Shaders,
    /// An edit that no frame was rendered with yet.
    untried: Option<Change>,
    post: Post,
    gpu: Option<Gpu>,
    world: Option<World>,
    order: Option<Order>,
    /// The order's part that is not done.
    due: Due,
    /// Steps in a row that failed.
    failures: u32,
}

#[derive(Default)]
struct Due {
    output: bool,
    values: bool,
    flip: bool,
}

impl Renderer {
    /// Opens nothing yet.
    pub fn new(adapter: Option<String>, shaders: Shaders, post: Post) -> Self {
        Self {
            adapter,
            shaders,
            untried: None,
            post,
            gpu: None,
            world: None,
            order: None,
            due: Due::default(),
            failures: 0,
        }
    }

    /// A shader file was written: everything is made anew of what it says now. Where that is wrong it is said, and the
    /// last one that was right stays.
    pub fn shader_changed(&mut self, path: &Path) {
        let Some(change) = self.shaders.read(path) else { return };
        let Some(gpu) = self.gpu.clone() else { return };
        gpu.edit_shader(&change.built, &change.now);
        match self.reload() {
            Err(e) => self.refuse(&change, &e),
            Ok(()) => self.untried = Some(change),
        }
    }

    fn refuse(&mut self, change: &Change, error: &Error) {
        self.shaders.refuse(change);
        if let Some(gpu) = &self.gpu {
            gpu.edit_shader(&change.built, &change.before);
        }
        let message = format!("{}: {error}; what it was before stays", change.path.display());
        self.post.send(Event::Failed(message, None));
    }

    /// A frame came out of the newest edit, if it is in any kernel.
    fn tried(&mut self) {
        let (Some(change), Some(gpu)) = (self.untried.take(), &self.gpu) else { return };
        if change.built != change.now && !gpu.edited_shader_is_met(&change.built) {
            let message = format!(
                "{}: no kernel in use is made of it, or it was edited after the program was built",
                change.path.display()
            );
            self.post.send(Event::Failed(message, None));
        }
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
                if did == Did::Asked {
                    self.tried();
                }
                did
            }
            Err(e) => {
                if let Some(change) = self.untried.take() {
                    self.refuse(&change, &e);
                    return match self.reload() {
                        Ok(()) => Did::Asked,
                        Err(_) => self.recover(),
                    };
                }
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
            let gpu = open(self.adapter.as_deref(), &self.shaders)?;
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
        let again = open(self.adapter.as_deref(), &self.shaders).map_err(Error::from).and_then(|gpu| {
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

/// A device whose errors are told, not panicked about: the frame they fall into fails to read back.
fn open(adapter: Option<&str>, shaders: &Shaders) -> Result<Gpu, frame::GpuError> {
    let gpu = Gpu::new(adapter)?;
    for (built, now) in shaders.edits() {
        gpu.edit_shader(built, now);
    }
    gpu.device.on_uncaptured_error(Arc::new(|e| eprintln!("warning: {e}")));
    Ok(gpu)
}
