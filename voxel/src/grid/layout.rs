//! Where the cells lie in the world, and where each section of the structure buffer begins.

use super::{BRICK_WORDS, Grid};
use crate::VoxelError;
use glam::{IVec3, Vec3};
use scene::Aabb;

/// Vertices are moved to the nearest multiple of this many voxels, the grain at which rasterizers place them anyway.
/// A face that lies on a boundary between cells so lies on it exactly.
pub const SNAP: f32 = 1.0 / crate::raster::GRAIN;

/// Empty cells on each side of the scene.
const BORDER: u32 = 2;

/// The grid's place and size; everything that follows from bounds and resolution alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layout {
    /// World position of the low corner of the lattice's cell 0.
    pub origin: Vec3,
    /// Side of a cell, m.
    pub voxel_size: f32,
    /// Per axis.
    pub cells: [u32; 3],
    /// The grid's cell 0 on its lattice: 0, but for a grid that moves with the viewer.
    pub low: IVec3,
}

impl Layout {
    /// Fits `grid` cells to the longest side of the bounds, two of them empty at each end. Bounds without any extent (one
    /// point, or nothing at all) get voxels of a metre.
    ///
    /// # Errors
    /// A grid outside `5..=most`, or bounds that are not finite.
    pub fn fit(bounds: Aabb, grid: u32, most: u32) -> Result<Self, VoxelError> {
        let least = 2 * BORDER + 1;
        if !(least..=most).contains(&grid) {
            return Err(VoxelError::Grid { grid, least, most });
        }
        let size = bounds.size();
        if !(bounds.is_empty() || bounds.min.is_finite() && size.is_finite()) {
            return Err(VoxelError::Bounds { min: bounds.min, max: bounds.max });
        }
        let longest = size.max_element();
        let inner = grid - 2 * BORDER;
        let voxel_size = if longest > 0.0 { longest / inner as f32 } else { 1.0 };
        // A side that is too small to divide: voxels would vanish beside the coordinates.
        if !voxel_size.is_normal() {
            return Err(VoxelError::Bounds { min: bounds.min, max: bounds.max });
        }
        // The longest side divides evenly but for rounding, which snapping takes back.
        let cells = (size / voxel_size - SNAP).ceil().max(Vec3::ZERO).to_array();
        let cells = cells.map(|inside| (inside as u32).min(inner) + 2 * BORDER);
        let low = if bounds.is_empty() { Vec3::ZERO } else { bounds.min };
        Ok(Self { origin: low - BORDER as f32 * voxel_size, voxel_size, cells, low: IVec3::ZERO })
    }

    /// World position of the low corner of cell 0.
    pub fn corner(&self) -> Vec3 {
        self.origin + self.voxel_size * self.low.as_vec3()
    }

    /// A point of the world in cells, moved to the grain. Where it is on the lattice is rounded, which the grid's place
    /// there does not change.
    pub fn moved(&self, point: Vec3) -> Vec3 {
        let steps = ((point - self.origin) / self.voxel_size / SNAP).map(f32::round_ties_even);
        steps * SNAP - self.low.as_vec3()
    }

    /// Cells on the longest axis.
    pub fn longest(&self) -> u32 {
        self.cells.into_iter().max().unwrap_or(0)
    }

    /// Whether the cell is one of the grid's.
    pub fn contains(&self, cell: IVec3) -> bool {
        (0..3).all(|k| (0..self.cells[k] as i32).contains(&cell[k]))
    }

    /// Brick cells per axis.
    pub fn bricks(&self) -> [u32; 3] {
        self.cells.map(|n| n.div_ceil(8))
    }

    /// Groups of bricks per axis.
    pub fn groups(&self) -> [u32; 3] {
        self.cells.map(|n| n.div_ceil(32))
    }

    /// Regions of groups per axis.
    pub fn regions(&self) -> [u32; 3] {
        self.cells.map(|n| n.div_ceil(128))
    }

    /// Number of brick cells, occupied or not.
    pub fn brick_cells(&self) -> u64 {
        self.bricks().map(u64::from).iter().product()
    }

    /// Words of the structure buffer with this many bricks.
    pub fn structure_words(&self, brick_count: u32) -> u64 {
        let grid = self.uniform(0);
        u64::from(grid.bricks_at) + u64::from(BRICK_WORDS) * u64::from(brick_count)
    }

    /// What shaders are told.
    pub fn uniform(&self, elevation: u32) -> Grid {
        let count = |n: [u32; 3]| n.iter().product::<u32>();
        let (bricks, groups, regions) = (self.bricks(), self.groups(), self.regions());
        let groups_at = 2 * count(regions);
        let table_at = groups_at + 2 * count(groups);
        Grid {
            origin: self.corner().into(),
            voxel_size: self.voxel_size,
            cells: self.cells.map(|n| n as i32),
            elevation,
            bricks: bricks.map(|n| n as i32),
            table_at,
            groups: groups.map(|n| n as i32),
            groups_at,
            regions: regions.map(|n| n as i32),
            bricks_at: table_at + count(bricks),
            contours: 0,
            record_words: 4,
            first_record: 0,
            point_steps: 256.0,
            low: self.low.into(),
            reach: 0.0,
            lattice: self.origin.into(),
            _pad: 0,
        }
    }
}
