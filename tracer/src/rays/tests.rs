//! Rays through the grid on the device against the CPU's walk, and against what a plane says.
#![allow(clippy::unwrap_used)]

use super::{Ray, RayBatch, grid_resources};
use frame::{Gpu, Room};
use glam::{IVec3, Vec3};
use scene::Aabb;
use voxel::grid::reference::CpuGrid;
use voxel::grid::{Grid, Layout};
use voxel::{GRID_BINDS, VoxelGrid};
use wgpu::BufferUsages;
