//! Global illumination by path tracing through a voxel grid, with swappable stages and measured error.
//!
//! This crate assembles the street: [`settings`] say what is asked for, the pipeline runs one frame as one function
//! over the stage crates, [`output`] writes what came out, [`report`] tells what was measured, and [`cli`] is the
//! command line around it.

pub mod cli;
mod error;
pub mod output;
pub mod pipeline;
mod progress;
pub mod report;
pub mod settings;
pub mod stages;

pub use error::Error;
pub use progress::Progress;
pub use settings::RenderSettings;
