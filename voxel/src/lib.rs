//! The sparse voxel grid: voxelizing a scene, storing it, and tracing rays through it.
//!
//! [`Voxelizer`] turns the triangles of a [`frame::scene_gpu::GpuMesh`] into a [`VoxelGrid`]: which cells the surface
//! passes ([`raster`]), where they are stored (`structure`), what they look like (`resolve`), how brightly they shine
//! ([`emitters`]). [`grid`] is the result and the walk through it, for shaders and for the CPU.

#[cfg(test)]
mod contour_tests;
pub mod emitters;
mod error;
pub mod grid;
pub mod raster;
pub mod record;
mod resolve;
mod structure;
#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod test_scenes;
#[cfg(test)]
mod tests;
mod voxelizer;

pub use error::VoxelError;
pub use grid::{GRID_BINDS, GRID_WGSL, Grid, TRACE_WGSL, VoxelGrid};
pub use record::RecordLayout;
pub use voxelizer::Voxelizer;
