//! A compressed wide BVH: eight children per node in 80 bytes, built on the CPU.
//!
//! In: a [`GpuMesh`] as it is on the GPU (displaced, posed), world space, m. Out: a [`Cwbvh`], and [`WGSL`] with the two
//! functions that every structure brings (see [`super`]).
//!
//! Ylitie, Karras, Laine 2017, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs". The crate `obvhs`
//! builds: a binary tree by locally ordered clustering (PLOC), improved by reinsertion, collapsed to eight children by
//! surface area. Children lie on a grid of 255 steps per axis, their boxes rounded outwards; which octant a direction
//! points to orders them. A ray keeps what is left to visit of each level below the root: at most one entry per level, so
//! that [`STACK`] entries suffice for every tree of at most that depth, and a deeper one is refused.
//!
//! Departs from the paper: triangles are tested when their node is visited, not postponed; no entry's distance is kept.

#[cfg(test)]
mod reference;
#[cfg(test)]
mod tests;
mod tree;

use super::{Bvh, BvhParams, FARTHEST_M};
use frame::scene_gpu::{GpuMesh, GpuScene};
use frame::{Gpu, GpuError, Room};
use glam::Vec3;
use std::time::Instant;
use tree::Tree;

macro_rules! stack {
    () => {
        32
    };
}

/// Levels below the root that a ray can descend.
pub const STACK: u32 = stack!();

/// `bvh_closest`, `bvh_blocked`; after [`super::RAY_WGSL`].
pub const WGSL: &str = concat!("const CWBVH_STACK = ", stack!(), "u;\n", include_str!("cwbvh.inc.wgsl"));

/// Loop iterations of a ray that visits as many nodes as a ray may and tests two triangles at each, three times what rays do in
/// any scene measured. One that wants more, on a driver that ends loops, is counted as cut.
pub const WORST_CASE_LOOPS: u32 = super::MOST_VISITS * 5;

/// How long the builder may look for a better tree.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Quality {
    /// The shortest build.
    Fast,
    /// What `obvhs` says takes as long as Embree's build.
    #[default]
    Medium,
    /// The best tree in which each triangle appears once.
    Slow,
}

impl Quality {
    /// All, as a setting lists them.
    pub const NAMES: [&str; 3] = ["fast", "medium", "slow"];

    /// By its place in [`Quality::NAMES`]; beyond them the last.
    pub fn of(choice: u32) -> Self {
        match choice {
            0 => Self::Fast,
            1 => Self::Medium,
            _ => Self::Slow,
        }
    }
}

/// Why there is no structure.
#[derive(Debug, thiserror::Error)]
pub enum CwbvhError {
    /// Rays would run out of stack: hundreds of boxes within one another, which nothing but an order could pair.
    #[error("the BVH of {triangles} triangles is {depth} levels deep, rays descend at most {allowed}")]
    TooDeep {
        /// In the tree.
        triangles: usize,
        /// Levels below the root.
        depth: u32,
        /// At most.
        allowed: u32,
    },
    /// The elements are larger than a binding may be, out of memory, or the mesh cannot be read back.
    #[error(transparent)]
    Gpu(#[from] GpuError),
}

/// The structure, and what it took.
pub struct Cwbvh {
    /// On the GPU.
    pub bvh: Bvh,
    /// Wall time of the build on the CPU, without copies from and to the GPU.
    pub build_ms: f64,
    /// Levels below the root.
    pub depth: u32,
    /// Triangles that can be met.
    pub triangle_count: u32,
}

/// One triangle as the builder sees it.
struct Triangle {
    number: u32,
    corners: [Vec3; 3],
    is_sheet: bool,
}

impl Triangle {
    /// As `ray.inc.wgsl` lays it out.
    fn elements(&self) -> [[u32; 4]; 3] {
        let words = [self.number, self.is_sheet.into(), 0];
        [0, 1, 2].map(|i| {
            let [x, y, z] = self.corners[i].to_array().map(f32::to_bits);
            [x, y, z, words[i]]
        })
    }
}

/// Reads the mesh back, builds on the CPU, uploads. `scene` tells which materials are sheets.
///
/// # Errors
/// A tree that is too deep, one too large for a binding (about 1.7 million triangles fit wgpu's default limits), or the
/// device fails.
pub fn build(gpu: &Gpu, scene: &GpuScene, mesh: &GpuMesh, quality: Quality) -> Result<Cwbvh, CwbvhError> {
    let vertices: Vec<u32> = gpu.read_buffer(&mesh.vertices)?;
    let records: Vec<[u32; 4]> = gpu.read_buffer(&mesh.triangles)?;
    let start = Instant::now();
    // An empty mesh still has one record.
    let records = records.iter().take(mesh.triangle_count as usize);
    let triangles: Vec<_> = records
        .enumerate()
        .filter_map(|(number, &[a, b, c, ids])| {
            let [a, b, c] = [a, b, c].map(|v| position(&vertices, mesh.layout.stride, v));
            let is_sheet = scene.sheets.get((ids & 0xffff) as usize).copied().unwrap_or(false);
            Some(Triangle { number: number as u32, corners: [a?, b?, c?], is_sheet })
        })
        .collect();
    let corners: Vec<_> = triangles.iter().map(|t| t.corners).collect();
    let tree = Tree::new(&corners, quality)?;
    let elements = elements(&tree, &triangles);
    let build_ms = 1e3 * start.elapsed().as_secs_f64();
    let node_count = tree.nodes.len() as u32;
    let params = BvhParams {
        triangles_at: tree::NODE_ELEMENTS * node_count,
        triangle_count: tree.order.len() as u32,
        node_count,
        _pad: 0,
    };
    let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
    let bvh = Bvh {
        elements: gpu.storage(Room::Bvh, "Cwbvh::elements", &elements)?,
        params: gpu.buffer(Room::Bvh, "Cwbvh::params", size_of::<BvhParams>() as u64, usage)?,
        node_count,
    };
    gpu.queue.write_buffer(&bvh.params, 0, bytemuck::bytes_of(&params));
    Ok(Cwbvh { bvh, build_ms, depth: tree.depth, triangle_count: params.triangle_count })
}

/// Of a vertex, if a ray can meet it.
fn position(vertices: &[u32], stride: u32, vertex: u32) -> Option<Vec3> {
    let at = stride as usize * vertex as usize;
    let words = vertices.get(at..at + 3)?;
    let position = Vec3::from_array([0, 1, 2].map(|i| f32::from_bits(words[i])));
    // Not so for NaN either.
    (position.abs().max_element() <= FARTHEST_M && position.is_finite()).then_some(position)
}

/// Nodes, then triangles in the tree's order.
fn elements(tree: &Tree, triangles: &[Triangle]) -> Vec<[u32; 4]> {
    let mut elements = bytemuck::cast_slice(&tree.nodes).to_vec();
    elements.extend(tree.order.iter().flat_map(|&i| triangles[i as usize].elements()));
    // A binding of an array holds at least one element.
    if elements.is_empty() {
        elements.push([0; 4]);
    }
    elements
}
