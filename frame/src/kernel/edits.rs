//! Shader texts that changed while the program runs: a file's text as it was built in is replaced by what it is now in
//! every kernel that is made from then on.
//!
//! Kernels join whole files, so that a file's text stands in theirs as it is. What was made before stays as it was:
//! whoever edits makes the kernels anew.

use crate::Gpu;
use std::sync::{Mutex, MutexGuard, PoisonError};

struct Edit {
    built: String,
    now: String,
    /// A kernel was made of it.
    is_met: bool,
}

/// All edits of a device's kernels.
#[derive(Default)]
pub(crate) struct Edits(Mutex<Vec<Edit>>);

impl Edits {
    fn list(&self) -> MutexGuard<'_, Vec<Edit>> {
        // Texts are whole, whoever died while holding the lock.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A kernel's joined text as it is now.
    pub(super) fn of(&self, mut source: String) -> String {
        for edit in self.list().iter_mut() {
            if source.contains(&edit.built) {
                edit.is_met = true;
                source = source.replace(&edit.built, &edit.now);
            }
        }
        source
    }
}

impl Gpu {
    /// Kernels made from now on have the text `now` where `built`, a whole shader file, was built in.
    pub fn edit_shader(&self, built: &str, now: &str) {
        let mut edits = self.edits.list();
        edits.retain(|edit| edit.built != built);
        if built != now && !built.trim().is_empty() {
            edits.push(Edit { built: built.into(), now: now.into(), is_met: false });
        }
    }

    /// Whether a kernel was made of this file since it was last edited.
    pub fn edited_shader_is_met(&self, built: &str) -> bool {
        self.edits.list().iter().any(|edit| edit.built == built && edit.is_met)
    }
}
