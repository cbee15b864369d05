//! The thread that draws the window: takes the newest panels, so that nobody who listens to the user waits for a screen.
//!
//! Panels that were not drawn when newer ones came are left out, unless a screenshot was asked of them; changed pictures
//! never are.

use crate::canvas::{Canvas, Shown};
use egui::{ClippedPrimitive, TexturesDelta};
use gridlight::output;
use std::collections::VecDeque;
use std::path::PathBuf;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;
use winit::dpi::PhysicalSize;

/// The surface had nothing to draw into.
const BEFORE_ANOTHER_TRY: Duration = Duration::from_millis(5);

/// What is to be drawn.
#[derive(Default)]
struct Job {
    size: Option<PhysicalSize<u32>>,
    textures: TexturesDelta,
    panels: Option<(Vec<ClippedPrimitive>, f32)>,
    screenshots: Vec<PathBuf>,
    ends: bool,
}

impl Drop for Job {
    fn drop(&mut self) {
        // Pictures for a window that is gone; egui takes them for forgotten otherwise.
        self.textures.clear();
    }
}

/// What became of it.
#[derive(Default)]
struct Report {
    /// Something was drawn since somebody asked.
    has_drawn: bool,
    is_lost: bool,
    messages: Vec<String>,
}

#[derive(Default)]
struct Desk {
    /// All but the last have a screenshot to be taken.
    jobs: Mutex<VecDeque<Job>>,
    arrived: Condvar,
    report: Mutex<Report>,
}

/// The event loop's end of it.
pub struct Painter {
    desk: Arc<Desk>,
    largest_side: usize,
    thread: Option<JoinHandle<()>>,
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    // Each holder leaves it whole.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Painter {
    /// Moves a canvas to a thread that calls `waker` whenever something was drawn.
    ///
    /// # Errors
    /// The system gives no thread.
    pub fn start(canvas: Canvas, waker: impl Fn() + Send + 'static) -> std::io::Result<Self> {
        let desk = Arc::new(Desk::default());
        let largest_side = canvas.largest_side();
        let its = desk.clone();
        let thread =
            std::thread::Builder::new().name("painter".into()).spawn(move || paint(canvas, &its, waker))?;
        Ok(Self { desk, largest_side, thread: Some(thread) })
    }

    /// Longest side of a picture that can be shown.
    pub fn largest_side(&self) -> usize {
        self.largest_side
    }

    /// The window has another size.
    pub fn resize(&self, size: PhysicalSize<u32>) {
        self.give(|job| job.size = Some(size));
    }

    /// These are the panels now; files in the list get a picture of them.
    pub fn draw(
        &self,
        panels: Vec<ClippedPrimitive>,
        pixels_per_point: f32,
        textures: &mut TexturesDelta,
        screenshots: Vec<PathBuf>,
    ) {
        self.give(|job| {
            job.textures.append(std::mem::take(textures));
            job.panels = Some((panels, pixels_per_point));
            job.screenshots.extend(screenshots);
        });
    }

    /// Whether something was drawn since this was asked last.
    pub fn has_drawn(&self) -> bool {
        std::mem::take(&mut locked(&self.desk.report).has_drawn)
    }

    /// Whether another painter is needed.
    pub fn is_lost(&self) -> bool {
        locked(&self.desk.report).is_lost || self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }

    /// What went wrong since this was asked last.
    pub fn messages(&self) -> Vec<String> {
        std::mem::take(&mut locked(&self.desk.report).messages)
    }

    fn give(&self, change: impl FnOnce(&mut Job)) {
        let mut jobs = locked(&self.desk.jobs);
        if jobs.back().is_none_or(|job| !job.screenshots.is_empty()) {
            jobs.push_back(Job::default());
        }
        if let Some(job) = jobs.back_mut() {
            change(job);
        }
        self.desk.arrived.notify_one();
    }
}

impl Drop for Painter {
    /// Waits: what was asked to be saved is saved, and the surface goes before its window.
    fn drop(&mut self) {
        self.give(|job| job.ends = true);
        if let Some(thread) = self.thread.take() {
            // A painter that panicked has said so.
            let _ = thread.join();
        }
    }
}

fn paint(mut canvas: Canvas, desk: &Desk, waker: impl Fn()) {
    loop {
        let mut job = {
            let mut jobs = locked(&desk.jobs);
            loop {
                match jobs.pop_front() {
                    Some(job) => break job,
                    None => jobs = desk.arrived.wait(jobs).unwrap_or_else(PoisonError::into_inner),
                }
            }
        };
        if let Some(size) = job.size {
            canvas.resize(size);
        }
        canvas.take_textures(&mut job.textures);
        let mut shown = Shown::Yes;
        if let Some((panels, pixels_per_point)) = job.panels.take() {
            for path in std::mem::take(&mut job.screenshots) {
                let taken = canvas.screenshot(&panels, pixels_per_point).map_err(gridlight::Error::from);
                if let Err(e) = taken.and_then(|picture| output::color_png(&path, &picture, 0.0)) {
                    locked(&desk.report).messages.push(e.to_string());
                }
            }
            if !job.ends {
                shown = canvas.draw(&panels, pixels_per_point);
            }
            if shown == Shown::Later {
                // Newer panels may lie there by now.
                let mut jobs = locked(&desk.jobs);
                if jobs.is_empty() {
                    let mut again = Job::default();
                    again.panels = Some((panels, pixels_per_point));
                    jobs.push_back(again);
                }
                drop(jobs);
                std::thread::sleep(BEFORE_ANOTHER_TRY);
            }
        }
        canvas.free_textures(&mut job.textures);
        {
            let mut report = locked(&desk.report);
            report.has_drawn = true;
            report.is_lost |= shown == Shown::Lost;
        }
        waker();
        if job.ends || shown == Shown::Lost {
            return;
        }
    }
}
