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
    /// Planes are met in one grid.
    #[error("voxel.contours=on needs voxel.cascades=1, it is {cascades}")]
    CascadedContours {
        /// Levels.
        cascades: u32,
    },
    /// What is kept for a voxel is by its record, which moves.
    #[error("tracer.cache=on needs voxel.cascades=1, it is {cascades}")]
    CascadedCache {
        /// Levels.
        cascades: u32,
    },
    /// Corners of triangles would no longer be placed exactly.
    #[error(
        "--grid {grid} with voxel.cascades={cascades} is {cells} of the finest cells on the longest axis, {most} are allowed; \
         lower one of them"
    )]
    Cascades {
        /// As asked for.
        grid: u32,
        /// Levels.
        cascades: u32,
        /// Both together.
        cells: u64,
        /// 2^16.
        most: u64,
    },
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
