//! The thread that renders: takes the newest [`Order`], gives [`Event`]s, and never makes the window wait.
//!
//! It has a graphics device of its own, opened on an instance of its own. A queue is a line: behind a kernel that a
//! software driver compiles for seconds, or a slow pass, the window's few triangles would have to wait. Pictures come back
//! through memory, as files of `gridlight render` do, so that both are the same bits.

mod judge;
mod outputs;
mod renderer;
mod shaders;
mod world;

pub use judge::Judgement;
pub use outputs::{Meaning, Output, Part};
#[cfg(test)]
pub use world::Pass;
pub use world::{Frame, SceneFacts};

use gridlight::RenderSettings;
use gridlight::stages::KnobInfo;
use renderer::{Did, Renderer};
use shaders::Shaders;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};
use std::thread::JoinHandle;

/// All that the window wants; a newer one replaces an older one.
#[derive(Clone, Debug, PartialEq)]
pub struct Order {
    /// A, or A and B; both share one world.
    pub sides: Vec<RenderSettings>,
    /// The camera is being moved: views follow each other without a restart.
    pub is_moving: bool,
    /// Frames go on without end.
    pub is_playing: bool,
    /// Otherwise so many from restart.
    pub frames_at_rest: u32,
    /// Another number than before: begin at the first frame.
    pub restarts: u64,
    /// The pass whose output is wanted.
    pub watched: Option<String>,
    /// Of A (0) or B (1).
    pub watched_side: usize,
    /// The place whose values are wanted, as 0..1 of the picture.
    pub inspected: Option<[f32; 2]>,
    /// The reference is to converge once the frames are done.
    pub is_judging: bool,
    /// FLIP between A and B is wanted.
    pub wants_flip: bool,
}

/// What comes back.
pub enum Event {
    /// Something long is going on, 0..1 of it done.
    Progress(String, f32),
    /// The adapter's name.
    Adapter(String),
    /// Every knob there is.
    Knobs(Vec<(&'static str, Vec<KnobInfo>)>),
    /// Another scene stands.
    Scene(Box<SceneFacts>),
    /// One side's next frame.
    Frame(Box<Frame>),
    /// What a pass wrote.
    Output(Box<Output>),
    /// Every value at the inspected place.
    Values(Vec<(String, String)>),
    /// How far the pictures are from the reference.
    Judged(Box<Judgement>),
    /// FLIP of B against A: the map, and its mean.
    Flip(frame::cpu::Image<f32>, f64),
    /// Something went wrong: why, and what stands instead of what was asked for, where an order was refused.
    Failed(String, Option<Vec<RenderSettings>>),
    /// So many orders were taken, and what they asked for is done; the reference may still converge.
    Rests(u64),
}

/// What the worker is sent.
enum Message {
    Order(Box<Order>),
    /// A shader file changed.
    Shader(PathBuf),
    #[cfg(test)]
    LoseDevice,
    Stop,
}

/// Wakes whoever takes events.
pub type Waker = Box<dyn Fn() + Send + Sync>;

/// The window's end of it.
pub struct Worker {
    messages: Sender<Message>,
    ordered: u64,
    events: Receiver<Event>,
    thread: Option<JoinHandle<()>>,
}

impl Worker {
    /// Starts the thread on the adapter of this name; shaders in the folder are followed when they change.
    ///
    /// # Errors
    /// The system gives no thread.
    pub fn start(adapter: Option<String>, shaders: Option<&Path>, waker: Waker) -> std::io::Result<Self> {
        let (messages, inbox) = channel();
        let (outbox, events) = channel();
        let post = Post { events: outbox, waker: waker.into() };
        let to = messages.clone();
        let tell = move |path| {
            // Nobody listens: then nobody minds.
            let _ = to.send(Message::Shader(path));
        };
        let shaders = shaders.map_or_else(Shaders::default, |folder| {
            Shaders::watch(folder, tell).unwrap_or_else(|e| {
                post.send(Event::Failed(
                    format!("shaders in {} are not followed: {e}", folder.display()),
                    None,
                ));
                Shaders::default()
            })
        });
        let thread = std::thread::Builder::new()
            .name("renderer".into())
            .spawn(move || work(Renderer::new(adapter, shaders, post.clone()), &inbox, &post))?;
        Ok(Self { messages, ordered: 0, events, thread: Some(thread) })
    }

    /// Sends another order, and says its number; none if the thread is gone.
    pub fn order(&mut self, order: Order) -> Option<u64> {
        self.messages.send(Message::Order(Box::new(order))).ok()?;
        self.ordered += 1;
        Some(self.ordered)
    }

    /// Takes the device away, as a driver may.
    #[cfg(test)]
    pub fn lose_device(&self) {
        let _ = self.messages.send(Message::LoseDevice);
    }

    /// The next event, if there is one.
    pub fn event(&self) -> Option<Event> {
        self.events.try_recv().ok()
    }

    /// Whether the thread ended, which it only does when it panics.
    pub fn is_gone(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        // Not waited for: it may be in the middle of a long frame, and the process is about to end.
        let _ = self.messages.send(Message::Stop);
    }
}

/// The worker's end of it.
#[derive(Clone)]
struct Post {
    events: Sender<Event>,
    waker: std::sync::Arc<dyn Fn() + Send + Sync>,
}

impl Post {
    fn send(&self, event: Event) {
        // Nobody listens: then nobody minds.
        let _ = self.events.send(event);
        (self.waker)();
    }
}

/// Follows orders until told to stop: everything that lies in the inbox first, then one step of work.
fn work(mut renderer: Renderer, inbox: &Receiver<Message>, post: &Post) {
    let (mut taken, mut did) = (0, Did::Nothing);
    loop {
        let mut newest = None;
        let mut edited = BTreeSet::new();
        let mut next = match did {
            Did::Nothing => inbox.recv().map_err(|_| TryRecvError::Disconnected),
            Did::Asked | Did::Reference => inbox.try_recv(),
        };
        loop {
            match next {
                Ok(Message::Order(order)) => {
                    taken += 1;
                    newest = Some(order);
                }
                Ok(Message::Shader(path)) => {
                    edited.insert(path);
                }
                #[cfg(test)]
                Ok(Message::LoseDevice) => renderer.lose_device(),
                Ok(Message::Stop) | Err(TryRecvError::Disconnected) => return,
                Err(TryRecvError::Empty) => break,
            }
            next = inbox.try_recv();
        }
        let is_new = newest.is_some();
        if let Some(order) = newest {
            renderer.take(*order);
        }
        for path in edited {
            renderer.shader_changed(&path);
        }
        let before = std::mem::replace(&mut did, renderer.step());
        if did != Did::Asked && (is_new || before == Did::Asked) {
            post.send(Event::Rests(taken));
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
