//! Global illumination by path tracing through a voxel grid, with swappable stages and measured error.
//!
//! This crate assembles the street: [`settings`] say what is asked for, the pipeline runs one frame as one function
//! over the stage crates, [`output`] writes what came out, [`input`] reads it back, [`metrics`] say how far it is from a
//! [`mod@reference`], [`race`] how fast the structures are alone and [`defects`] what voxels get wrong, [`suite`] what breaks renderers, [`foreign`] filters what others rendered, [`compare`] does all of
//! it for every combination of stages and [`report`] tells what came of it. [`cli`] is
//! the command line around it all.

pub mod cli;
pub mod compare;
pub mod defects;
mod error;
pub mod foreign;
pub mod input;
pub mod metrics;
pub mod output;
pub mod pipeline;
mod progress;
pub mod race;
pub mod reference;
pub mod report;
pub mod settings;
pub mod stages;
pub mod suite;
mod world;

pub use error::Error;
pub use progress::Progress;
pub use settings::RenderSettings;
