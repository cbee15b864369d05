//! Who is told how far a long piece of work has come.

use std::sync::Arc;

/// A listener that pipelines and long stages report to; cheap to clone, silent by default.
#[derive(Clone)]
pub struct Progress(Arc<Listener>);

type Listener = dyn Fn(&str, f32) + Send + Sync;

impl Progress {
    /// Calls `listen` with what is being done and how much of it is done, 0..1.
    pub fn new(listen: impl Fn(&str, f32) + Send + Sync + 'static) -> Self {
        Self(Arc::new(listen))
    }

    /// Reports.
    pub fn report(&self, what: &str, done: f32) {
        (self.0)(what, done);
    }
}

impl Default for Progress {
    /// Tells nobody.
    fn default() -> Self {
        Self::new(|_, _| {})
    }
}
