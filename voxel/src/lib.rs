//! The sparse voxel grid: voxelizing a scene, storing it, and tracing rays through it.
//!
//! [`Voxelizer`] turns the triangles of a [`frame::scene_gpu::GpuMesh`] into a [`VoxelGrid`]: which cells the surface
//! passes ([`raster`] or [`compute`]), where they are stored (`structure`), what they look like (`resolve`), how brightly they shine
//! ([`emitters`]). Where something moves, [`revoxelize`] makes the bricks it touches anew each frame. [`grid`] is the result and the walk through it, for shaders and for the CPU.

mod bend;
pub mod cascades;
pub mod compute;
#[cfg(test)]
mod contour_tests;
mod cover;
pub mod emitters;
mod error;
pub mod grid;
#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod hard_cases;
pub mod raster;
pub mod record;
mod resolve;
pub mod revoxelize;
mod structure;
#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod test_scenes;
#[cfg(test)]
mod tests;
mod voxelizer;

pub use cascades::Cascades;
pub use cover::Cover;
pub use error::VoxelError;
pub use grid::{
    GRID_BINDS, GRID_WGSL, Grid, LEVELS_BINDS, LEVELS_WGSL, TRACE_LEVELS_WGSL, TRACE_WGSL, VoxelGrid,
};
pub use record::RecordLayout;
pub use revoxelize::Rest;
pub use voxelizer::Voxelizer;
