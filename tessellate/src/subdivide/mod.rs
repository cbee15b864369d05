//! Cuts triangles into patches that meet without cracks, and lets a tessellator say where their points lie.
//!
//! In: a [`GpuMesh`], which of its triangles are shaped, and a shape: WGSL functions `shape_class`, `shape_edge`,
//! `shape_inside`, `shape_frame`. Out: a [`GpuMesh`] of the same layout, static triangles first: the vertices that came,
//! then those of patches; each patch has its own, so that seams of texture coordinates and hard edges stay.
//!
//! - **No cracks.** A factor belongs to an edge and follows from its two ends alone: `f = clamp(ceil(|b - a| / l), 1, 64)`.
//!   A point between them is a function of the edge and of `i / f`, counted from the same end by both triangles; a corner is
//!   a function of all corners at its place ([`topology`]). Triangles that are not shaped follow the edges of those that are.
//! - **A patch** is a grid of F rows, F its greatest factor. Grid points on an edge of factor f snap to the nearest of its
//!   f + 1; triangles of which two corners snapped to the same point are left out. `F^2 - 3 F + f0 + f1 + f2` remain.
//! - **Counts** become places by scans ([`frame::scan`]). Where the result would not fit a binding, or 2^24 triangles, l
//!   grows until it does.
//! - **Once.** What stands still is done once per mesh, step and setting; each later call runs over moving patches alone,
//!   for this moment and, from a copy of the mesh kept by the last call, for the one before. Factors stay those of the
//!   first moment, so that a patch's points keep their numbers.
//!
//! Longest loops: 24 halvings to find a patch, 4,096 corners of a class.

mod kernels;
pub(crate) mod topology;

use frame::info::FrameInfo;
use frame::scan::{Scan, Sums};
use frame::scene_gpu::{GpuMesh, GpuScene};
use frame::{Buffer, Gpu, GpuError, Recorder, Room, Uniform, gpu_struct};
pub(crate) use kernels::Shape;
use kernels::{Kernels, Resources};
use topology::{Kind, Source, Topology};

gpu_struct! {
    /// See `subdivide.inc.wgsl`.
    pub struct SubdivideParams {
        /// Of the mesh that came.
        pub triangle_count: u32,
        /// Of the topology.
        pub edge_count: u32,
        /// First invocation of the pass.
        pub first: u32,
        /// Invocations of the pass.
        pub count: u32,
        /// Vertices of the mesh that came.
        pub vertex_base: u32,
        /// Metres.
        pub edge_length: f32,
        /// Metres of edge per metre of distance.
        pub edge_angle: f32,
        /// Factor on displacement.
        pub relief: f32,
    }
}

/// How finely, and how much.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Step {
    /// Least length of an edge's parts, m.
    pub(crate) edge_length: f32,
    /// The same per metre of distance from the eye; 0 = the camera does not count.
    pub(crate) edge_angle: f32,
    /// Factor on displacement.
    pub(crate) relief: f32,
}

/// More triangles than a voxel's record can tell apart.
const MOST_TRIANGLES: u64 = 1 << 24;
/// Words per class.
const CLASS_WORDS: u64 = 12;
/// How often the step may grow.
const ATTEMPTS: u32 = 24;

/// The passes of one tessellator, and what they keep.
pub(crate) struct Subdivider {
    stage: &'static str,
    shape: Shape,
    scan: Scan,
    kernels: Option<Kernels>,
    done: Option<Done>,
}

/// What the last call made, and of what.
struct Done {
    source: GpuMesh,
    step: Step,
    eye: glam::Vec3,
    /// None where nothing is shaped.
    patches: Option<Patches>,
}

/// Patches of a mesh.
struct Patches {
    topology: Buffer,
    counts: [u32; 2],
    static_classes: u32,
    classes: [Buffer; 2],
    vertex_sums: Sums,
    triangle_sums: Sums,
    patch_vertices: u32,
    static_patch_vertices: u32,
    triangles: u32,
    /// The mesh of the last call, where something moves.
    before: Option<Buffer>,
    mesh: GpuMesh,
}

impl Subdivider {
    /// `stage` is what passes' names begin with.
    pub(crate) fn new(gpu: &Gpu, stage: &'static str, shape: Shape) -> Result<Self, GpuError> {
        Ok(Self { stage, shape, scan: Scan::new(gpu)?, kernels: None, done: None })
    }

    /// Makes everything anew at the next call.
    pub(crate) fn forget(&mut self) {
        self.done = None;
    }

    /// The mesh, cut and shaped. `kind` says what to do with a triangle, and is asked once per mesh.
    pub(crate) fn record(
        &mut self,
        recorder: &mut Recorder<'_>,
        frame: &FrameInfo,
        scene: &GpuScene,
        step: Step,
        kind: impl Fn(&Source<'_>, usize) -> (Kind, bool),
    ) -> GpuMesh {
        let eye = if step.edge_angle > 0.0 { frame.camera.eye } else { glam::Vec3::ZERO };
        // The same mesh in the same buffers.
        let known = self.done.take().filter(|done| *done.source.vertices == *scene.mesh.vertices);
        match known {
            Some(done) if done.step == step && done.eye == eye => {
                if let Some(patches) = done.patches.as_ref().filter(|patches| patches.before.is_some()) {
                    let starts = [patches.static_classes, patches.static_patch_vertices];
                    self.shape_patches(recorder, scene, patches, step, starts, patches.before.as_ref());
                }
                self.done = Some(done);
            }
            other => {
                let before = other.and_then(|done| done.patches).and_then(|patches| patches.before);
                match self.make(recorder, frame, scene, step, kind, before) {
                    Ok(patches) => {
                        self.done = Some(Done { source: scene.mesh.clone(), step, eye, patches });
                    }
                    Err(error) => recorder.fail(error),
                }
            }
        }
        match self.done.as_ref().and_then(|done| done.patches.as_ref()) {
            Some(patches) => patches.mesh.clone(),
            None => scene.mesh.clone(),
        }
    }

    /// Everything, from the topology on.
    fn make(
        &mut self,
        recorder: &mut Recorder<'_>,
        frame: &FrameInfo,
        scene: &GpuScene,
        mut step: Step,
        kind: impl Fn(&Source<'_>, usize) -> (Kind, bool),
        before_it: Option<Buffer>,
    ) -> Result<Option<Patches>, GpuError> {
        let gpu = recorder.gpu();
        let source = &scene.mesh;
        recorder.flush();
        let vertices: Vec<u32> = gpu.read_buffer(&source.vertices)?;
        let triangles: Vec<[u32; 4]> = gpu.read_buffer(&source.triangles)?;
        let read = Source {
            vertices: &vertices,
            triangles: triangles.get(..source.triangle_count as usize).unwrap_or_default(),
            layout: source.layout,
            static_triangle_count: source.static_triangle_count as usize,
        };
        let topology = Topology::new(&read, |triangle| kind(&read, triangle));
        if !topology.touched {
            return Ok(None);
        }
        if self.kernels.is_none() {
            self.kernels = Some(Kernels::new(gpu, self.stage, &self.shape, scene)?);
        }
        let Some(kernels) = &self.kernels else { return Ok(None) };
        let words = gpu.storage(Room::Scene, "Subdivider::topology", &topology.words)?;
        let count = source.triangle_count;
        let counts = [0, 1].map(|_| storage(gpu, "Subdivider::counts", 4 * u64::from(count)));
        let [vertex_counts, triangle_counts] = counts;
        let (vertex_counts, triangle_counts) = (vertex_counts?, triangle_counts?);
        let sums = || Sums::new(gpu, Room::Scene, count);
        let (vertex_sums, triangle_sums) = (sums()?, sums()?);
        let frame_uniform = recorder.uniform(&frame.uniform());

        let (mut patch_vertices, mut triangle_count) = (0, 0);
        for _ in 0..ATTEMPTS {
            let params = |first, count_of_pass| SubdivideParams {
                triangle_count: count,
                edge_count: topology.edge_count,
                first,
                count: count_of_pass,
                vertex_base: source.vertex_count,
                edge_length: step.edge_length,
                edge_angle: step.edge_angle,
                relief: step.relief,
            };
            let of_edges = recorder.uniform(&params(0, topology.edge_count));
            kernels.factor(
                recorder,
                self.stage,
                [&frame_uniform, &of_edges],
                source,
                &words,
                topology.edge_count,
            );
            kernels.count(
                recorder,
                self.stage,
                &of_edges,
                source,
                &words,
                [&vertex_counts, &triangle_counts],
            );
            self.scan.record(recorder, self.stage, &vertex_counts, count, &vertex_sums);
            self.scan.record(recorder, self.stage, &triangle_counts, count, &triangle_sums);
            patch_vertices = vertex_sums.total(recorder)?;
            triangle_count = triangle_sums.total(recorder)?;
            let excess = excess(gpu, source, patch_vertices, triangle_count);
            if excess <= 1.0 {
                break;
            }
            // Counts grow with the square of the factor.
            step.edge_length = step.edge_length.max(1e-6) * (excess.sqrt() as f32 * 1.05).min(4.0);
            step.edge_angle *= (excess.sqrt() as f32 * 1.05).min(4.0);
        }
        let is_moving = source.static_triangle_count < count;
        let class_bytes = 4 * CLASS_WORDS * u64::from(topology.class_count);
        let classes = storage(gpu, "Subdivider::classes", class_bytes)?;
        let patches = Patches {
            counts: [topology.edge_count, topology.class_count],
            static_classes: topology.static_class_count,
            classes: [
                classes.clone(),
                if is_moving { storage(gpu, "Subdivider::classes", class_bytes)? } else { classes },
            ],
            patch_vertices,
            static_patch_vertices: before(
                gpu,
                &vertex_sums,
                source.static_triangle_count,
                count,
                patch_vertices,
            )?,
            triangles: triangle_count,
            before: match is_moving {
                true => Some(storage(gpu, "Subdivider::before", source.vertices.bytes())?),
                false => None,
            },
            mesh: GpuMesh {
                vertices: storage(
                    gpu,
                    "Subdivider::vertices",
                    4 * u64::from(source.layout.stride)
                        * (u64::from(source.vertex_count) + u64::from(patch_vertices)),
                )?,
                previous: storage(
                    gpu,
                    "Subdivider::previous",
                    12 * (u64::from(source.vertex_count) + u64::from(patch_vertices)),
                )?,
                triangles: storage(gpu, "Subdivider::triangles", 16 * u64::from(triangle_count).max(1))?,
                vertex_count: source.vertex_count + patch_vertices,
                triangle_count,
                static_triangle_count: before(
                    gpu,
                    &triangle_sums,
                    source.static_triangle_count,
                    count,
                    triangle_count,
                )?,
                layout: source.layout,
            },
            topology: words,
            vertex_sums,
            triangle_sums,
        };
        self.shape_patches(recorder, scene, &patches, step, [0, 0], before_it.as_ref());
        let of_triangles = recorder.uniform(&SubdivideParams {
            triangle_count: count,
            edge_count: topology.edge_count,
            count: patches.triangles,
            vertex_base: source.vertex_count,
            ..SubdivideParams::default()
        });
        let sums = [&patches.triangle_sums, &patches.vertex_sums];
        kernels.triangles(
            recorder,
            self.stage,
            &of_triangles,
            source,
            &patches.topology,
            sums,
            &patches.mesh,
        );
        Ok(Some(patches))
    }

    /// Classes and vertices from these on, of this moment and of the one before, if there is one.
    fn shape_patches(
        &self,
        recorder: &mut Recorder<'_>,
        scene: &GpuScene,
        patches: &Patches,
        step: Step,
        [first_class, first_vertex]: [u32; 2],
        before: Option<&Buffer>,
    ) {
        let Some(kernels) = &self.kernels else { return };
        let source = &scene.mesh;
        let params = |recorder: &mut Recorder<'_>, first: u32, count: u32| -> Uniform {
            recorder.uniform(&SubdivideParams {
                triangle_count: source.triangle_count,
                edge_count: patches.counts[0],
                first,
                count,
                vertex_base: source.vertex_count,
                edge_length: step.edge_length,
                edge_angle: step.edge_angle,
                relief: step.relief,
            })
        };
        let class_count = patches.counts[1] - first_class.min(patches.counts[1]);
        let vertex_count = patches.patch_vertices - first_vertex.min(patches.patch_vertices);
        let of_classes = params(recorder, first_class, class_count);
        let of_vertices = params(recorder, first_vertex, vertex_count);
        let resources = |vertices, classes| Resources {
            scene,
            vertices,
            topology: &patches.topology,
            classes,
            sums: &patches.vertex_sums,
        };
        let now = resources(&source.vertices, &patches.classes[0]);
        recorder.copy_buffer(
            &source.vertices,
            &patches.mesh.vertices,
            source_bytes(source, source.layout.stride),
        );
        recorder.copy_buffer(&source.previous, &patches.mesh.previous, source_bytes(source, 3));
        kernels.classes(recorder, self.stage, &of_classes, &now, class_count);
        kernels.vertices(recorder, self.stage, &of_vertices, &now, &patches.mesh, vertex_count);
        match before {
            Some(before) => {
                let then = resources(before, &patches.classes[1]);
                kernels.classes(recorder, self.stage, &of_classes, &then, class_count);
                kernels.previous(recorder, self.stage, &of_vertices, &then, &patches.mesh, vertex_count);
            }
            None => kernels.stand(recorder, self.stage, &of_vertices, &patches.mesh, vertex_count),
        }
        if let Some(before) = &patches.before {
            recorder.copy_buffer(&source.vertices, before, source.vertices.bytes());
        }
    }
}

fn source_bytes(source: &GpuMesh, stride: u32) -> u64 {
    4 * u64::from(stride) * u64::from(source.vertex_count)
}

fn storage(gpu: &Gpu, label: &str, bytes: u64) -> Result<Buffer, GpuError> {
    let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC;
    gpu.buffer(Room::Scene, label, bytes, usage)
}

/// How many times too large the result would be.
fn excess(gpu: &Gpu, source: &GpuMesh, patch_vertices: u32, triangles: u32) -> f64 {
    let limits = gpu.device.limits();
    let allowed = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
    let vertices = u64::from(source.vertex_count) + u64::from(patch_vertices);
    let needed = [
        (4 * u64::from(source.layout.stride) * vertices, allowed),
        (16 * u64::from(triangles), allowed),
        (u64::from(triangles), MOST_TRIANGLES),
    ];
    needed.into_iter().map(|(bytes, allowed)| bytes as f64 / allowed as f64).fold(0.0, f64::max)
}

/// Sum of what lies before triangle `first` of `count`.
fn before(gpu: &Gpu, sums: &Sums, first: u32, count: u32, total: u32) -> Result<u32, GpuError> {
    if first >= count {
        return Ok(total);
    }
    let within: Vec<u32> = gpu.read_buffer(&sums.before)?;
    let blocks: Vec<u32> = gpu.read_buffer(&sums.blocks)?;
    let at = |list: &[u32], i: u32| list.get(i as usize).copied().unwrap_or(0);
    Ok(at(&within, first) + at(&blocks, first / frame::scan::SCAN_BLOCK))
}
