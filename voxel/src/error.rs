//! What can go wrong while a scene is voxelized.

use frame::{GpuError, KernelError};

/// Why there is no grid.
#[derive(Debug, thiserror::Error)]
pub enum VoxelError {
    /// Fewer cells than the border takes, or more than the raster target of one pixel per column may have.
    #[error("--grid {grid}: allowed is {least}..={most} cells on the longest axis")]
    Grid {
        /// As asked for.
        grid: u32,
        /// Four cells are the border.
        least: u32,
        /// The adapter's largest texture.
        most: u32,
    },
    /// The scene's box has no finite size.
    #[error("the scene's bounds {min} to {max} have no finite size to divide into voxels")]
    Bounds {
        /// Low corner, m.
        min: glam::Vec3,
        /// High corner, m.
        max: glam::Vec3,
    },
    /// A thin voxel does not hold all of its surface's plane.
    #[error("voxel.contours=on needs conservative voxels, voxel.cover is thin; leave it at auto")]
    ThinContours,
    /// The winner of a voxel that triangles are tested against is not the nearest to its centre.
    #[error("voxel.contours=on needs voxel.voxelizer=raster, it is compute")]
    ComputedContours,
    /// A voxel's key holds 24 bits of triangle number.
    #[error("the scene has {triangles} triangles, a voxel's key can number {most}; simplify the scene")]
    Triangles {
        /// In the mesh.
        triangles: u64,
        /// 2^24.
        most: u64,
    },
    /// The device refused.
    #[error(transparent)]
    Gpu(#[from] GpuError),
}

impl From<KernelError> for VoxelError {
    fn from(e: KernelError) -> Self {
        Self::Gpu(e.into())
    }
}
