//! Triangle search structures: the rivals of the voxel grid, and the truth.
//!
//! In: a [`frame::scene_gpu::GpuMesh`], world space, metres. Out: a [`Bvh`]: nodes and copies of the triangles in the order of the leaves,
//! in one buffer. [`lbvh`] is built on the GPU (the kind of rival that the paper raced), [`cwbvh`] on the CPU by the
//! crate `obvhs` (the strong rival). Both bring a snippet with the same two functions:
//!
//! - `bvh_closest(origin, direction, t_max, skip) -> BvhHit`: the nearest triangle within `t_max` metres but `skip`.
//! - `bvh_blocked(origin, direction, t_max, skip) -> u32`: [`BLOCKED`] where a triangle that light cannot pass lies
//!   within `t_max`, [`SHEETS`] where only others do, [`FREE`] where none does.
//!
//! Both use the ray and the triangle test of [`RAY_WGSL`], with one order of operands, so that they return the same
//! triangle, distance and weights to the bit. That holds if no box hides what its triangles would show: every box a
//! builder makes is grown by [`margin`] on each side, more than the rounding of a distance, and is taken to be entered
//! earlier by a share of the way there, more than the rounding of the slab test.
//! Of equally distant triangles the lower number wins, whatever the order of the walk. A ray visits at most 4,096
//! nodes; `cut` says that it wanted more.
//!
//! A triangle with a coordinate that is not finite, or farther than [`FARTHEST_M`] from 0, is never met.

pub mod cwbvh;
pub mod lbvh;
#[cfg(test)]
pub(crate) mod tests;

use frame::{Bind, Buffer};

/// Ray, hit, slab and triangle: `bvh_ray`, `bvh_slab`, `bvh_triangle`, `bvh_is_sheet`.
pub const RAY_WGSL: &str = include_str!("ray.inc.wgsl");

/// What every structure binds, group 1.
pub const BVH_BINDS: [Bind; 2] =
    [Bind::storage_read(1, 21, "bvh"), Bind::uniform::<BvhParams>(1, 22, "bvh_params")];

/// Most nodes that a ray visits (contract, "Limits and time").
pub const MOST_VISITS: u32 = 4096;

/// Coordinates up to here, m, leave the triangle test's products, of three lengths each, within the range of floats.
pub const FARTHEST_M: f32 = 1e12;

/// Nothing lies on a ray.
pub const FREE: u32 = 0;
/// Something on it lets no light through.
pub const BLOCKED: u32 = 1;
/// Only masks, blends and thin panes lie on it.
pub const SHEETS: u32 = 2;

frame::gpu_struct! {
    /// See `ray.inc.wgsl`.
    pub struct BvhParams {
        /// Element (16 bytes) at which the triangles begin.
        pub triangles_at: u32,
        /// Triangles, copies counted.
        pub triangle_count: u32,
        /// Nodes before them.
        pub node_count: u32,
        /// WGSL rounds the size up to a multiple of 16.
        pub _pad: u32,
    }
}

/// A structure on the GPU.
pub struct Bvh {
    /// Nodes, then triangles.
    pub elements: Buffer,
    /// [`BvhParams`].
    pub params: Buffer,
    /// Nodes.
    pub node_count: u32,
}

impl Bvh {
    /// What [`BVH_BINDS`] binds.
    pub fn resources(&self) -> [wgpu::BindingResource<'_>; 2] {
        [self.elements.as_entire_binding(), self.params.as_entire_binding()]
    }
}

/// How much boxes are grown on each side, m, in a scene whose coordinates reach up to `largest` (m, absolute): 2^-20 of it.
/// A slab plane is off by at most two roundings of a coordinate, 2^-23 of it each, a distance by a few more.
pub fn margin(largest: f32) -> f32 {
    largest * (1.0 / 1_048_576.0)
}
