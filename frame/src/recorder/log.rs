//! What a frame did: passes with their times, outputs by name, counts.

use crate::Texture;
use std::collections::BTreeMap;

/// All passes of one name in one frame.
#[derive(Clone, Debug, PartialEq)]
pub struct PassLog {
    /// Path: stage, implementation, part.
    pub name: String,
    /// Sum over its runs in milliseconds; none where the adapter has no timestamps.
    pub gpu_ms: Option<f64>,
    /// How often it ran.
    pub runs: u32,
}

/// What the [`crate::Recorder`] collected.
#[derive(Clone, Default)]
pub struct FrameLog {
    /// In the order they first ran.
    pub passes: Vec<PassLog>,
    /// The last image each name wrote.
    pub outputs: Vec<(String, Texture)>,
    /// Rays, voxels, fallbacks and the like.
    pub counts: BTreeMap<String, f64>,
}

impl FrameLog {
    /// Milliseconds of all passes whose path begins with this stage; 0 where it ran nothing, none where some pass of
    /// it has no time.
    pub fn stage_ms(&self, stage: &str) -> Option<f64> {
        self.passes.iter().filter(|p| p.name.split('/').next() == Some(stage)).map(|p| p.gpu_ms).sum()
    }

    /// Milliseconds of all passes.
    pub fn total_ms(&self) -> Option<f64> {
        self.passes.iter().map(|p| p.gpu_ms).sum()
    }

    /// What the pass of this name wrote.
    pub fn output(&self, name: &str) -> Option<&Texture> {
        self.outputs.iter().find(|(n, _)| n == name).map(|(_, texture)| texture)
    }

    /// Appends what another recorder collected for the same frame.
    pub fn append(&mut self, other: FrameLog) {
        for pass in other.passes {
            match self.passes.iter_mut().find(|p| p.name == pass.name) {
                Some(p) => {
                    p.gpu_ms = p.gpu_ms.zip(pass.gpu_ms).map(|(a, b)| a + b);
                    p.runs += pass.runs;
                }
                None => self.passes.push(pass),
            }
        }
        self.outputs.extend(other.outputs);
        for (name, count) in other.counts {
            *self.counts.entry(name).or_default() += count;
        }
    }
}
