//! Traces a batch of rays through one search structure and says what each met.
//!
//! In: rays in world space, metres, and a structure: a BVH over triangles or the voxel grid. Out: per ray a [`Met`]; of a
//! BVH also what `bvh_blocked` answers. For questions to a structure alone: its tests, races between structures over the
//! same rays, and what the voxels of a scene miss of its triangles.
//!
//! A dispatch takes at most [`RAYS_PER_DISPATCH`] rays, one per invocation, so that its loops run no longer than one
//! ray's: at most the visits of [`crate::bvh::MOST_VISITS`] times what a structure does at each, or the steps of a walk
//! through the grid.

#[cfg(test)]
mod tests;

use crate::bvh::{BVH_BINDS, RAY_WGSL};
use crate::{Search, World};
use frame::{Bind, Gpu, GpuError, Kernel, KernelDesc, KernelError, Recorder, Room, gpu_struct};
use voxel::GRID_BINDS;
use wgpu::{BindingResource, BufferUsages};

const RAYS_WGSL: &str = include_str!("rays.inc.wgsl");
const WORKGROUP: u32 = 64;
/// Bounds the time of a dispatch.
const RAYS_PER_DISPATCH: usize = 1 << 17;

gpu_struct! {
    /// Where to look, and what for.
    pub struct Ray {
        /// m.
        pub origin: [f32; 3],
        /// How far, m.
        pub t_max: f32,
        /// Unit.
        pub direction: [f32; 3],
        /// A triangle that is not met, or [`Ray::NOTHING`]. The grid ignores it: there a ray does not meet
        /// surfaces around its origin that it goes away from.
        pub skip: u32,
    }
}

impl Ray {
    /// No triangle and no voxel has this number.
    pub const NOTHING: u32 = u32::MAX;

    /// Meets whatever lies ahead.
    pub fn new(origin: glam::Vec3, direction: glam::Vec3, t_max: f32) -> Self {
        Self { origin: origin.into(), t_max, direction: direction.into(), skip: Self::NOTHING }
    }
}

gpu_struct! {
    /// What was met first.
    pub struct Met {
        /// A triangle, or the record of a voxel; [`Ray::NOTHING`] where nothing was met.
        pub primitive: u32,
        /// m; the ray's `t_max` where nothing was met.
        pub distance: f32,
        /// Of the triangle's second and third corner; 0 of a voxel.
        pub weights: [f32; 2],
        /// Nodes looked at, or steps through the grid.
        pub visits: u32,
        /// 1: it wanted to look at more.
        pub cut: u32,
    }
}

impl Met {
    /// Whether there was anything.
    pub fn is_hit(&self) -> bool {
        self.primitive != Ray::NOTHING
    }
}

/// One answer per ray, and how long they took.
pub struct Answers<T> {
    /// In the order of the rays.
    pub answers: Vec<T>,
    /// Milliseconds of the tracing dispatches; none where the adapter has no timestamps.
    pub gpu_ms: Option<f64>,
}

/// The kernels for one kind of structure.
pub struct RayBatch {
    closest: Kernel,
    /// None of the grid: a voxel says nothing about light that passes it.
    blocked: Option<Kernel>,
}

impl RayBatch {
    /// Through a BVH: `structure` defines `bvh_closest` and `bvh_blocked` over [`RAY_WGSL`] and [`BVH_BINDS`].
    ///
    /// # Errors
    /// The driver refuses a kernel.
    pub fn of_bvh(gpu: &Gpu, structure: &str) -> Result<Self, KernelError> {
        let sources = [RAY_WGSL, structure, RAYS_WGSL, include_str!("bvh.wgsl")];
        let blocked = Bind::storage(3, 1, "out_blocked");
        Ok(Self {
            closest: kernel(gpu, &sources, "rays_closest", &BVH_BINDS, closest_out())?,
            blocked: Some(kernel(gpu, &sources, "rays_blocked", &BVH_BINDS, blocked)?),
        })
    }

    /// Through the voxel grid.
    ///
    /// # Errors
    /// The driver refuses a kernel.
    pub fn of_grid(gpu: &Gpu) -> Result<Self, KernelError> {
        let sources = [
            frame::surface::WGSL,
            voxel::GRID_WGSL,
            voxel::record::ANY_WGSL,
            voxel::TRACE_WGSL,
            RAYS_WGSL,
            include_str!("grid.wgsl"),
        ];
        let closest = kernel(gpu, &sources, "rays_closest", &GRID_BINDS, closest_out())?;
        Ok(Self { closest, blocked: None })
    }

    /// The nearest triangle or voxel of each ray. `structure` is what [`resources`] gives.
    ///
    /// # Errors
    /// Out of memory, or the device was lost.
    pub fn closest(
        &self,
        gpu: &Gpu,
        structure: &[BindingResource<'_>],
        rays: &[Ray],
    ) -> Result<Answers<Met>, GpuError> {
        trace(gpu, &self.closest, structure, rays)
    }

    /// Whether a triangle lies on each ray: [`crate::bvh::FREE`], [`crate::bvh::BLOCKED`] or [`crate::bvh::SHEETS`]; no
    /// answers of the grid.
    ///
    /// # Errors
    /// Out of memory, or the device was lost.
    pub fn blocked(
        &self,
        gpu: &Gpu,
        structure: &[BindingResource<'_>],
        rays: &[Ray],
    ) -> Result<Answers<u32>, GpuError> {
        match &self.blocked {
            Some(kernel) => trace(gpu, kernel, structure, rays),
            None => Ok(Answers { answers: Vec::new(), gpu_ms: None }),
        }
    }
}

/// What a batch through one of the world's structures binds; none where that was not built.
pub fn resources<'a>(world: World<'a>, search: Search) -> Option<Vec<BindingResource<'a>>> {
    match search {
        Search::Grid => world.grid.map(|grid| grid.resources().into()),
        Search::Lbvh | Search::Cwbvh => world.bvh(search).map(|bvh| bvh.resources().into()),
    }
}

fn closest_out() -> Bind {
    Bind::storage(3, 0, "out_met").of::<Met>()
}

fn kernel(
    gpu: &Gpu,
    sources: &[&str],
    entry: &str,
    structure: &[Bind],
    out: Bind,
) -> Result<Kernel, KernelError> {
    Kernel::new(
        gpu,
        &KernelDesc {
            name: entry,
            sources,
            entry,
            workgroup: [WORKGROUP, 1, 1],
            bindings: &[structure, &[Bind::storage_read(2, 0, "in_rays").of::<Ray>(), out]].concat(),
            constants: &[],
        },
    )
}

fn trace<T: bytemuck::Pod>(
    gpu: &Gpu,
    kernel: &Kernel,
    structure: &[BindingResource<'_>],
    rays: &[Ray],
) -> Result<Answers<T>, GpuError> {
    let mut result = Answers { answers: Vec::with_capacity(rays.len()), gpu_ms: Some(0.0) };
    for rays in rays.chunks(RAYS_PER_DISPATCH) {
        let input = gpu.storage(Room::Bvh, "RayBatch::rays", rays)?;
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
        let output =
            gpu.buffer(Room::Bvh, "RayBatch::answers", (size_of::<T>() * rays.len()) as u64, usage)?;
        let mut recorder = Recorder::new(gpu);
        let resources = [structure, &[input.as_entire_binding(), output.as_entire_binding()]].concat();
        recorder.compute(kernel.name(), kernel, &resources, [(rays.len() as u32).div_ceil(WORKGROUP), 1, 1]);
        let ms = recorder.finish()?.total_ms();
        result.gpu_ms = result.gpu_ms.zip(ms).map(|(sum, ms)| sum + ms);
        result.answers.extend(gpu.read_buffer::<T>(&output)?);
    }
    Ok(result)
}
