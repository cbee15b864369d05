//! Traces a batch of rays through one search structure and says what each met.
//!
//! In: rays in world space, metres, and a structure's snippets with what they bind. Out: per ray a [`Met`], or what
//! `bvh_blocked` answers. For questions to a structure alone: its tests, and races between structures.
//!
//! A dispatch takes at most [`RAYS_PER_DISPATCH`] rays, one per invocation, so that its loops run no longer than one ray's:
//! at most the visits of [`super::MOST_VISITS`] times what a structure does at each.

use super::{BVH_BINDS, RAY_WGSL};
use frame::{Bind, Gpu, GpuError, Kernel, KernelDesc, KernelError, Recorder, Room, gpu_struct};
use wgpu::{BindingResource, BufferUsages};

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
        /// A triangle that is not met, or [`Ray::NO_TRIANGLE`].
        pub skip: u32,
    }
}

impl Ray {
    /// No triangle has this number.
    pub const NO_TRIANGLE: u32 = u32::MAX;
}

gpu_struct! {
    /// What `bvh_closest` answers.
    pub struct Met {
        /// [`Ray::NO_TRIANGLE`] where nothing was met.
        pub triangle: u32,
        /// m; the ray's `t_max` where nothing was met.
        pub distance: f32,
        /// Of the second and third corner.
        pub weights: [f32; 2],
        /// Nodes looked at.
        pub visits: u32,
        /// 1: it wanted to look at more.
        pub cut: u32,
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
    blocked: Kernel,
}

impl RayBatch {
    /// `structure` defines `bvh_closest` and `bvh_blocked` over [`RAY_WGSL`] and [`BVH_BINDS`].
    ///
    /// # Errors
    /// The driver refuses a kernel.
    pub fn new(gpu: &Gpu, structure: &str) -> Result<Self, KernelError> {
        let kernel = |entry, out| {
            let rays = Bind::storage_read(2, 0, "in_rays").of::<Ray>();
            Kernel::new(
                gpu,
                &KernelDesc {
                    name: entry,
                    sources: &[RAY_WGSL, structure, include_str!("rays.wgsl")],
                    entry,
                    workgroup: [WORKGROUP, 1, 1],
                    bindings: &[&BVH_BINDS[..], &[rays, out]].concat(),
                    constants: &[],
                },
            )
        };
        Ok(Self {
            closest: kernel("rays_closest", Bind::storage(3, 0, "out_met").of::<Met>())?,
            blocked: kernel("rays_blocked", Bind::storage(3, 1, "out_blocked"))?,
        })
    }

    /// The nearest triangle of each ray. `structure` is what [`super::Bvh::resources`] gives.
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

    /// Whether something lies on each ray: [`super::FREE`], [`super::BLOCKED`] or [`super::SHEETS`].
    ///
    /// # Errors
    /// Out of memory, or the device was lost.
    pub fn blocked(
        &self,
        gpu: &Gpu,
        structure: &[BindingResource<'_>],
        rays: &[Ray],
    ) -> Result<Answers<u32>, GpuError> {
        trace(gpu, &self.blocked, structure, rays)
    }
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
