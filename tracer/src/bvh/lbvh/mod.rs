//! A binary tree over the triangles, built on the device: the kind of rival the paper raced.
//!
//! Karras 2012, "Maximizing Parallelism in the Construction of BVHs, Octrees, and k-d Trees": the triangles are sorted
//! along a Morton curve, and every inner node of the radix tree over their codes is found on its own. Boxes grow from
//! the leaves to the root.
//!
//! In: a [`GpuMesh`], world space, metres. Out: an [`Lbvh`]; [`WGSL`] searches it. 30-bit codes of centroids in cubic cells
//! (2^-10 of the scene's longest side), equal codes told apart by the order after the stable sort, which is that of the
//! triangles: the same mesh gives the same bits. Ranges of at most 4 triangles are leaves; the nodes inside them stay
//! in the buffer, unused. 64 B per node and 48 B per triangle; 29 B more per triangle are kept for [`LbvhBuilder::refit`].
//!
//! Depth: each node's triangles share more leading bits than its parent's: of 30 bits of code, then of at most 32 bits of
//! place. A way down passes at most 62 nodes, whatever the triangles, and leaves at most one child for later at each:
//! the walk's stack of 64 entries, one of them its end, suffices.
//!
//! Longest loops: 62 nodes upwards; 3 x 32 steps of a node's searches; `n / (256 SORT_BLOCK)` rounds of the sort's sums.
//! A ray: [`WORST_CASE_LOOPS`].

mod sort;
#[cfg(test)]
mod tests;

use super::{Bvh, BvhParams, MOST_VISITS, margin};
use frame::scene_gpu::{self, GpuMesh, GpuScene};
use frame::{
    Bind, Buffer, Gpu, GpuError, Kernel, KernelDesc, KernelError, Recorder, Room, gpu_struct, surface,
};
use scene::Aabb;
use sort::Sort;
use std::ops::Deref;
use wgpu::BufferUsages;

/// The search: `bvh_closest` and `bvh_blocked`, after [`super::RAY_WGSL`].
pub const WGSL: &str = include_str!("traverse.inc.wgsl");

/// Loop iterations of a ray at most: one per visit, and one per triangle of a leaf.
pub const WORST_CASE_LOOPS: u32 = MOST_VISITS * (1 + MOST_IN_LEAF);

const PARAMS_WGSL: &str = include_str!("lbvh.inc.wgsl");
/// As in `lbvh.inc.wgsl`.
const MOST_IN_LEAF: u32 = 4;
/// Invocations per workgroup of every kernel here.
const WORKGROUP: u32 = 256;
/// Cells of the Morton grid along the longest side.
const MORTON_CELLS: f32 = 1024.0;

gpu_struct! {
    /// See `lbvh.inc.wgsl`.
    pub struct LbvhParams {
        /// Corner of the Morton grid, m.
        pub low: [f32; 3],
        /// Triangles.
        pub triangle_count: u32,
        /// Inner nodes; 0 where all triangles fit one leaf.
        pub node_count: u32,
        /// Blocks of the sort.
        pub block_count: u32,
        /// Lowest bit of the digit that is sorted by.
        pub shift: u32,
        /// Morton cells per metre.
        pub cells_per_m: f32,
        /// How much boxes grow on each side, per metre of the largest coordinate.
        pub margin: f32,
        /// WGSL rounds the size up to a multiple of 16.
        pub _pad: [u32; 3],
    }
}

/// The tree, and what a refit needs of its making.
pub struct Lbvh {
    bvh: Bvh,
    /// Of each inner node, then of each triangle's place: the node above.
    parents: Buffer,
    /// Six words per inner node: `bounds.wgsl`.
    boxes: Buffer,
    triangle_count: u32,
}

impl Deref for Lbvh {
    type Target = Bvh;

    fn deref(&self) -> &Bvh {
        &self.bvh
    }
}

/// The kernels that build and refit.
pub struct LbvhBuilder {
    morton: Kernel,
    sort: Sort,
    link: Kernel,
    bounds: Kernel,
    nodes: Kernel,
    /// Per material 1 where light may pass straight through.
    sheets: Buffer,
    /// Around every pose, m: where the Morton grid lies.
    scene_bounds: Aabb,
}

impl LbvhBuilder {
    /// Kernels for meshes of this scene.
    ///
    /// # Errors
    /// The driver refuses a kernel, or memory is out.
    pub fn new(gpu: &Gpu, scene: &GpuScene) -> Result<Self, GpuError> {
        let constants = scene.mesh.layout.constants();
        let of_mesh = [surface::WGSL, scene_gpu::MESH_WGSL];
        let kernel = |entry: &str, text, mesh: bool, bindings: &[Bind]| -> Result<Kernel, KernelError> {
            let read: &[&str] = if mesh { &of_mesh } else { &[] };
            let mesh_binds: &[Bind] = if mesh { &scene_gpu::MESH_BINDS } else { &[] };
            Kernel::new(
                gpu,
                &KernelDesc {
                    name: &format!("bvh/lbvh/{entry}"),
                    sources: &[read, &[PARAMS_WGSL, text]].concat(),
                    entry,
                    workgroup: [WORKGROUP, 1, 1],
                    bindings: &[&[params_bind()], mesh_binds, bindings].concat(),
                    constants: if mesh { &constants } else { &[] },
                },
            )
        };
        let pairs = Bind::storage(3, 0, "out_pairs");
        let elements = Bind::storage(3, 0, "elements");
        let link = [
            Bind::storage_read(2, 0, "in_pairs"),
            Bind::storage(3, 0, "out_elements"),
            Bind::storage(3, 1, "out_parents"),
        ];
        let bounds = [
            Bind::storage_read(2, 0, "in_sheets"),
            Bind::storage_read(2, 1, "in_parents"),
            elements,
            Bind::storage(3, 1, "boxes"),
        ];
        let nodes = [Bind::storage_read(2, 0, "in_boxes"), elements];
        let sheets: Vec<_> = scene.sheets.iter().copied().map(u32::from).collect();
        Ok(Self {
            morton: kernel("morton", include_str!("morton.wgsl"), true, &[pairs])?,
            sort: Sort::new(gpu)?,
            link: kernel("link", include_str!("link.wgsl"), false, &link)?,
            bounds: kernel("bounds", include_str!("bounds.wgsl"), true, &bounds)?,
            nodes: kernel("nodes", include_str!("nodes.wgsl"), false, &nodes)?,
            sheets: gpu.storage(Room::Bvh, "LbvhBuilder::sheets", &sheets)?,
            scene_bounds: scene.bounds,
        })
    }

    /// Records the whole build of a mesh of the scene.
    ///
    /// # Errors
    /// The tree is larger than a binding may be (with 128 MiB: 1.2 million triangles), or memory is out.
    pub fn build(&self, recorder: &mut Recorder<'_>, mesh: &GpuMesh) -> Result<Lbvh, GpuError> {
        let gpu = recorder.gpu();
        let params = self.params(mesh.triangle_count);
        let lbvh = Lbvh::new(gpu, &params)?;
        if mesh.triangle_count == 0 {
            return Ok(lbvh);
        }
        let groups = [mesh.triangle_count.div_ceil(WORKGROUP), 1, 1];
        let uniform = recorder.uniform(&params);
        let pairs = Sort::pairs(gpu, mesh.triangle_count)?;
        let [vertices, triangles] = mesh.resources();
        recorder.compute(
            "bvh/lbvh/morton",
            &self.morton,
            &[uniform.binding(), vertices, triangles, pairs.as_entire_binding()],
            groups,
        );
        self.sort.record(recorder, &params, &pairs)?;
        let [elements, parents] = [&lbvh.elements, &lbvh.parents].map(|b| b.as_entire_binding());
        recorder.compute(
            "bvh/lbvh/link",
            &self.link,
            &[uniform.binding(), pairs.as_entire_binding(), elements, parents],
            groups,
        );
        self.fit(recorder, &params, mesh, &lbvh);
        Ok(lbvh)
    }

    /// Takes over new positions of the same triangles and keeps the tree; a mesh of another number of triangles is built
    /// anew.
    ///
    /// # Errors
    /// Those of [`LbvhBuilder::build`], where it builds.
    pub fn refit(
        &self,
        recorder: &mut Recorder<'_>,
        mesh: &GpuMesh,
        lbvh: &mut Lbvh,
    ) -> Result<(), GpuError> {
        if mesh.triangle_count == lbvh.triangle_count {
            self.fit(recorder, &self.params(mesh.triangle_count), mesh, lbvh);
        } else {
            *lbvh = self.build(recorder, mesh)?;
        }
        Ok(())
    }

    /// Copies the triangles and makes the boxes.
    fn fit(&self, recorder: &mut Recorder<'_>, params: &LbvhParams, mesh: &GpuMesh, lbvh: &Lbvh) {
        if params.triangle_count == 0 {
            return;
        }
        let uniform = recorder.uniform(params);
        let [vertices, triangles] = mesh.resources();
        let [sheets, parents, elements, boxes] =
            [&self.sheets, &lbvh.parents, &lbvh.elements, &lbvh.boxes].map(|b| b.as_entire_binding());
        recorder.clear(&lbvh.boxes);
        recorder.compute(
            "bvh/lbvh/bounds",
            &self.bounds,
            &[uniform.binding(), vertices, triangles, sheets, parents, elements.clone(), boxes.clone()],
            [params.triangle_count.div_ceil(WORKGROUP), 1, 1],
        );
        recorder.compute(
            "bvh/lbvh/nodes",
            &self.nodes,
            &[uniform.binding(), boxes, elements],
            [params.node_count.div_ceil(WORKGROUP), 1, 1],
        );
    }

    fn params(&self, triangle_count: u32) -> LbvhParams {
        let longest = self.scene_bounds.size().max_element();
        LbvhParams {
            low: if longest > 0.0 { self.scene_bounds.min.into() } else { [0.0; 3] },
            triangle_count,
            node_count: if triangle_count > MOST_IN_LEAF { triangle_count - 1 } else { 0 },
            block_count: sort::block_count(triangle_count),
            shift: 0,
            // A scene of a micrometre or less is a point: all codes are equal.
            cells_per_m: if longest > 1e-6 { MORTON_CELLS / longest } else { 0.0 },
            margin: margin(1.0),
            _pad: [0; 3],
        }
    }
}

impl Lbvh {
    fn new(gpu: &Gpu, params: &LbvhParams) -> Result<Self, GpuError> {
        let &LbvhParams { triangle_count, node_count, .. } = params;
        let buffer =
            |label, bytes, usage| gpu.buffer(Room::Bvh, label, bytes, usage | BufferUsages::COPY_SRC);
        let [triangles, nodes] = [triangle_count, node_count].map(u64::from);
        // A binding of an array holds at least one element.
        let element_bytes = (64 * nodes + 48 * triangles).max(16);
        let limits = gpu.device.limits();
        let allowed = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        if element_bytes > allowed {
            return Err(GpuError::TooLarge {
                what: format!("the LBVH of {triangle_count} triangles"),
                needed: element_bytes,
                allowed,
                unit: "bytes",
                advice: "use the voxel tracer, or a scene of fewer triangles",
            });
        }
        let shared = BufferUsages::STORAGE | BufferUsages::COPY_DST;
        let written = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
        let bvh = Bvh {
            elements: buffer("Bvh::elements", element_bytes, shared)?,
            params: buffer("Bvh::params", size_of::<BvhParams>() as u64, written)?,
            node_count,
        };
        let of_bvh = BvhParams { triangles_at: 4 * node_count, triangle_count, node_count, _pad: 0 };
        gpu.queue.write_buffer(&bvh.params, 0, bytemuck::bytes_of(&of_bvh));
        Ok(Self {
            bvh,
            parents: buffer("Lbvh::parents", 4 * (nodes + triangles), shared)?,
            boxes: buffer("Lbvh::boxes", 24 * nodes, shared)?,
            triangle_count,
        })
    }
}

/// What every kernel here binds.
fn params_bind() -> Bind {
    Bind::uniform::<LbvhParams>(0, 0, "params")
}
