//! The passes, compiled for a mesh's vertex layout, and what each of them binds.

use super::SubdivideParams;
use frame::info::{self, Frame};
use frame::scan::{SCAN_WGSL, Sums};
use frame::scene_gpu::{self, GpuMesh, GpuScene};
use frame::{Bind, Buffer, Gpu, Kernel, KernelDesc, KernelError, Recorder, Uniform, surface};
use wgpu::BindingResource;

/// What a tessellator adds: sources before the rest, and where points lie.
#[derive(Clone, Copy)]
pub(crate) struct Shape {
    /// After the mesh and the topology.
    pub(crate) shared: &'static [&'static str],
    /// `shape_class`.
    pub(crate) class: &'static str,
    /// `shape_edge`, `shape_inside`, `shape_frame`.
    pub(crate) points: &'static str,
    /// Whether it reads heights.
    pub(crate) reads_heights: bool,
}

/// What shaping passes read.
pub(super) struct Resources<'a> {
    pub(super) scene: &'a GpuScene,
    pub(super) vertices: &'a Buffer,
    pub(super) topology: &'a Buffer,
    pub(super) classes: &'a Buffer,
    pub(super) sums: &'a Sums,
}

/// The passes.
pub(super) struct Kernels {
    factor: Kernel,
    count: Kernel,
    classes: Kernel,
    vertices: Kernel,
    previous: Kernel,
    stand: Kernel,
    upright: Kernel,
    triangles: Kernel,
    reads_heights: bool,
}

const WORKGROUP: u32 = 256;
const PARAMS: Bind = Bind::uniform::<SubdivideParams>(0, 1, "params");
const TOPOLOGY: Bind = Bind::storage_read(2, 0, "topology");

impl Kernels {
    pub(super) fn new(gpu: &Gpu, stage: &str, shape: &Shape, scene: &GpuScene) -> Result<Self, KernelError> {
        let constants = scene.mesh.layout.constants();
        let base = [
            info::WGSL,
            surface::WGSL,
            scene_gpu::MESH_WGSL,
            SCAN_WGSL,
            include_str!("params.inc.wgsl"),
            include_str!("subdivide.inc.wgsl"),
        ];
        let kernel = |entry: &'static str, sources: &[&str], bindings: &[Bind]| {
            let name = format!("{stage}/{entry}");
            Kernel::new(
                gpu,
                &KernelDesc {
                    name: &name,
                    // What stands has nothing to do with patches.
                    sources: &[&base[..if entry == "stand" { 5 } else { 6 }], sources].concat(),
                    entry,
                    workgroup: [WORKGROUP, 1, 1],
                    bindings,
                    constants: &constants,
                },
            )
        };
        let [vertices, triangles] = scene_gpu::MESH_BINDS;
        let heights: &[Bind] = if shape.reads_heights { &[scene_gpu::HEIGHTS_BIND] } else { &[] };
        let read = |binding, name| Bind::storage_read(2, binding, name);
        let shaping = |out: Bind| {
            let own = [TOPOLOGY, read(1, "classes"), read(2, "in_before"), read(3, "in_blocks"), out];
            [&[PARAMS, vertices, triangles][..], heights, &own].concat()
        };
        let points = |last: &'static str| {
            let rest = [include_str!("points.inc.wgsl"), shape.points, include_str!("places.inc.wgsl"), last];
            [shape.shared, &rest].concat()
        };
        Ok(Self {
            factor: kernel(
                "factor",
                &[include_str!("factor.wgsl")],
                &[
                    Bind::uniform::<Frame>(0, 0, "frame"),
                    PARAMS,
                    vertices,
                    triangles,
                    Bind::storage(2, 0, "topology"),
                ],
            )?,
            count: kernel(
                "count",
                &[include_str!("count.wgsl")],
                &[
                    PARAMS,
                    TOPOLOGY,
                    Bind::storage(3, 0, "out_vertex_counts"),
                    Bind::storage(3, 1, "out_triangle_counts"),
                ],
            )?,
            classes: kernel(
                "classes_join",
                &[shape.shared, &[shape.class, include_str!("classes.wgsl")]].concat(),
                &[
                    &[PARAMS, vertices, triangles][..],
                    heights,
                    &[TOPOLOGY, Bind::storage(3, 0, "out_classes")],
                ]
                .concat(),
            )?,
            vertices: kernel(
                "vertices",
                &points(include_str!("vertices.wgsl")),
                &shaping(Bind::storage(3, 0, "out_vertices")),
            )?,
            previous: kernel(
                "previous",
                &points(include_str!("previous.wgsl")),
                &shaping(Bind::storage(3, 0, "out_previous")),
            )?,
            stand: kernel(
                "stand",
                &[include_str!("stand.wgsl")],
                &[PARAMS, read(0, "in_vertices"), Bind::storage(3, 0, "out_previous")],
            )?,
            upright: kernel(
                "upright",
                &[include_str!("places.inc.wgsl"), include_str!("upright.wgsl")],
                &[
                    PARAMS,
                    vertices,
                    triangles,
                    TOPOLOGY,
                    read(2, "in_before"),
                    read(3, "in_blocks"),
                    Bind::storage(3, 0, "out_vertices"),
                ],
            )?,
            triangles: kernel(
                "triangles",
                &[include_str!("places.inc.wgsl"), include_str!("triangles.wgsl")],
                &[
                    PARAMS,
                    triangles,
                    TOPOLOGY,
                    read(1, "in_before"),
                    read(2, "in_blocks"),
                    read(3, "in_vertex_before"),
                    read(4, "in_vertex_blocks"),
                    Bind::storage(3, 0, "out_triangles"),
                ],
            )?,
            reads_heights: shape.reads_heights,
        })
    }

    pub(super) fn factor(
        &self,
        recorder: &mut Recorder<'_>,
        stage: &str,
        [frame, params]: [&Uniform; 2],
        source: &GpuMesh,
        topology: &Buffer,
        edges: u32,
    ) {
        let [vertices, triangles] = source.resources();
        let resources =
            [frame.binding(), params.binding(), vertices, triangles, topology.as_entire_binding()];
        recorder.compute(
            &format!("{stage}/factor"),
            &self.factor,
            &resources,
            [edges.div_ceil(WORKGROUP), 1, 1],
        );
    }

    pub(super) fn count(
        &self,
        recorder: &mut Recorder<'_>,
        stage: &str,
        params: &Uniform,
        source: &GpuMesh,
        topology: &Buffer,
        [vertices, triangles]: [&Buffer; 2],
    ) {
        let buffers = [topology, vertices, triangles].map(|buffer| buffer.as_entire_binding());
        let [topology, vertices, triangles] = buffers;
        let resources = [params.binding(), topology, vertices, triangles];
        let workgroups = [source.triangle_count.div_ceil(WORKGROUP), 1, 1];
        recorder.compute(&format!("{stage}/count"), &self.count, &resources, workgroups);
    }

    pub(super) fn classes(
        &self,
        recorder: &mut Recorder<'_>,
        stage: &str,
        params: &Uniform,
        from: &Resources<'_>,
        count: u32,
    ) {
        let mut resources = self.mesh(params, from);
        resources.extend([from.topology, from.classes].map(|buffer| buffer.as_entire_binding()));
        self.dispatch(recorder, stage, "classes", &self.classes, &resources, count);
    }

    pub(super) fn vertices(
        &self,
        recorder: &mut Recorder<'_>,
        stage: &str,
        params: &Uniform,
        from: &Resources<'_>,
        into: &GpuMesh,
        count: u32,
    ) {
        let resources = self.shaping(params, from, &into.vertices);
        self.dispatch(recorder, stage, "vertices", &self.vertices, &resources, count);
        let [vertices, triangles] = from.scene.mesh.resources();
        let mut resources = vec![params.binding(), vertices, triangles];
        let buffers = [from.topology, &from.sums.before, &from.sums.blocks, &into.vertices];
        resources.extend(buffers.map(|buffer| buffer.as_entire_binding()));
        self.dispatch(recorder, stage, "upright", &self.upright, &resources, count);
    }

    pub(super) fn previous(
        &self,
        recorder: &mut Recorder<'_>,
        stage: &str,
        params: &Uniform,
        from: &Resources<'_>,
        into: &GpuMesh,
        count: u32,
    ) {
        let resources = self.shaping(params, from, &into.previous);
        self.dispatch(recorder, stage, "previous", &self.previous, &resources, count);
    }

    pub(super) fn stand(
        &self,
        recorder: &mut Recorder<'_>,
        stage: &str,
        params: &Uniform,
        mesh: &GpuMesh,
        count: u32,
    ) {
        let [vertices, previous] = [&mesh.vertices, &mesh.previous].map(|b| b.as_entire_binding());
        let resources = [params.binding(), vertices, previous];
        self.dispatch(recorder, stage, "stand", &self.stand, &resources, count);
    }

    pub(super) fn triangles(
        &self,
        recorder: &mut Recorder<'_>,
        stage: &str,
        params: &Uniform,
        source: &GpuMesh,
        topology: &Buffer,
        [triangle_sums, vertex_sums]: [&Sums; 2],
        into: &GpuMesh,
    ) {
        let buffers = [
            &source.triangles,
            topology,
            &triangle_sums.before,
            &triangle_sums.blocks,
            &vertex_sums.before,
            &vertex_sums.blocks,
            &into.triangles,
        ];
        let mut resources = vec![params.binding()];
        resources.extend(buffers.map(|buffer| buffer.as_entire_binding()));
        self.dispatch(recorder, stage, "triangles", &self.triangles, &resources, into.triangle_count);
    }

    fn mesh<'a>(&self, params: &'a Uniform, from: &Resources<'a>) -> Vec<BindingResource<'a>> {
        let mut resources = vec![
            params.binding(),
            from.vertices.as_entire_binding(),
            from.scene.mesh.triangles.as_entire_binding(),
        ];
        if self.reads_heights {
            resources.push(from.scene.heights.buffer.as_entire_binding());
        }
        resources
    }

    fn shaping<'a>(
        &self,
        params: &'a Uniform,
        from: &Resources<'a>,
        out: &'a Buffer,
    ) -> Vec<BindingResource<'a>> {
        let mut resources = self.mesh(params, from);
        let buffers = [from.topology, from.classes, &from.sums.before, &from.sums.blocks, out];
        resources.extend(buffers.map(|buffer| buffer.as_entire_binding()));
        resources
    }

    fn dispatch(
        &self,
        recorder: &mut Recorder<'_>,
        stage: &str,
        pass: &str,
        kernel: &Kernel,
        resources: &[BindingResource<'_>],
        count: u32,
    ) {
        if count > 0 {
            recorder.compute(
                &format!("{stage}/{pass}"),
                kernel,
                resources,
                [count.div_ceil(WORKGROUP), 1, 1],
            );
        }
    }
}
