//! Tessellators: meshes in, finer meshes out.
//!
//! | paper, sections 1 to 2 | here |
//! | --- | --- |
//! | "able to include GPU accelerated special effects such as tessellation" | [`Tessellator`], before voxels and gather |
//! | "normals, tangents and bitangents are adjusted during the tessellation process using the height map" | [`displace`] |
//! | the mesh as the file has it | [`identity`] |
//! | ours: curved surfaces rounded, without a height map | [`phong`] |
//!
//! **A new tessellator**: copy the folder `identity/`, rename it, and add one line to [`all`]. The folder's name is the
//! tessellator's name, on the command line too. Its default factor may depend on the world only (`voxel_size`, edge
//! lengths), never on the camera, so that what stands still stays the same mesh and its voxels need not be rebuilt: the same
//! buffers mean the same triangles. What cuts triangles does it by the room `subdivide`, which knows how to leave no cracks.

pub mod displace;
pub mod identity;
pub mod phong;
mod subdivide;

use frame::info::FrameInfo;
use frame::scene_gpu::{Aabb, GpuMesh, GpuScene};
use frame::{Gpu, GpuError, Knob, Recorder};

/// Meshes in, finer meshes out.
///
/// Promises: normals and tangents of the output are of unit length and fit its shape; positions of this frame and of
/// the last one stand side by side (`mesh.previous`); the same input gives the same bits.
pub trait Tessellator {
    /// Its folder and its name in [`all`].
    fn name(&self) -> &'static str;

    /// Its settings, lent out.
    fn knobs(&mut self) -> Vec<Knob<'_>>;

    /// Box around everything it may make of the scene at any moment, m.
    fn bounds(&self, scene: &GpuScene) -> Aabb {
        scene.bounds
    }

    /// Records its passes, named `tessellate/NAME/…`. `voxel_size` in metres is the finest detail that a ray will
    /// meet. While the mesh's buffers stay the same, its static triangles do.
    fn tessellate(
        &mut self,
        recorder: &mut Recorder<'_>,
        frame: &FrameInfo,
        voxel_size: f32,
        scene: &GpuScene,
    ) -> GpuMesh;
}

/// Makes a tessellator: compiles its kernels.
pub type Constructor = fn(&Gpu) -> Result<Box<dyn Tessellator>, GpuError>;

/// Every tessellator by name.
pub fn all() -> &'static [(&'static str, Constructor)] {
    &[
        ("identity", |_| Ok(Box::new(identity::Identity))),
        ("displace", |gpu| Ok(Box::new(displace::Displace::new(gpu)?))),
        ("phong", |gpu| Ok(Box::new(phong::Phong::new(gpu)?))),
    ]
}

#[cfg(test)]
mod tests;
