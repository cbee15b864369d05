//! The progress bar: one line on stderr, shown once something has taken more than a second.

use crate::Progress;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// What ends sooner needs no bar.
const PATIENCE: Duration = Duration::from_secs(1);

/// Steps of the bar: finer than a terminal is wide.
const STEPS: u64 = 1000;

/// A bar, and the listener that moves it.
pub struct Bar(ProgressBar);

impl Bar {
    /// Hidden until it is needed, for ever if `quiet`. A stderr that is no terminal shows none either.
    pub fn new(quiet: bool) -> (Self, Progress) {
        if quiet {
            return (Self(ProgressBar::hidden()), Progress::default());
        }
        let bar = ProgressBar::with_draw_target(Some(STEPS), ProgressDrawTarget::hidden());
        if let Ok(style) =
            ProgressStyle::with_template("{prefix}{msg:<20} {wide_bar} {percent:>3}% {elapsed}")
        {
            bar.set_style(style);
        }
        let (begun, shown) = (Instant::now(), AtomicBool::new(false));
        let moved = bar.clone();
        let progress = Progress::new(move |what, done| {
            if begun.elapsed() > PATIENCE && !shown.swap(true, Ordering::Relaxed) {
                moved.set_draw_target(ProgressDrawTarget::stderr());
            }
            moved.set_message(what.to_owned());
            moved.set_position((f64::from(done.clamp(0.0, 1.0)) * STEPS as f64) as u64);
        });
        (Self(bar), progress)
    }

    /// Says which of several frames is being rendered.
    pub fn frame(&self, index: u32, count: u32) {
        if count > 1 {
            self.0.set_prefix(format!("frame {} of {count} ", index + 1));
        }
    }

    /// A line on stderr that does not tear the bar.
    pub fn note(&self, line: &str) {
        self.0.suspend(|| eprintln!("{line}"));
    }
}

impl Drop for Bar {
    /// Leaves the terminal clean, however the work ended.
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
