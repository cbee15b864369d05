//! Fills a G-buffer: what the camera sees, by rasterising the triangles.
//!
//! Paper: the gather pass renders the scene from the camera and keeps "the same information" that the voxels hold.
//!
//! In: triangles and materials (group 1, world space, m) and the frame's jittered matrices. Out: a
//! [`GBuffer`] of any size; 0 everywhere where nothing is hit.
//!
//! - Two passes, so that each pixel is shaded once however many triangles cover it: one rasterises which triangle a
//!   pixel sees (vertices pulled by index, depth reversed: cleared to 0, the greater wins; nothing is culled), one meets
//!   that triangle with the pixel's ray and shades the point by the same `mesh_point` and `material_surface` that the
//!   voxelizer and the triangle tracers use. What it keeps is thus exact at the pixel's sample point.
//! - Textures are seen through the pixel's footprint, `A = w d^2 / cos`, w the pixel's solid angle.
//! - Masks are tested at that mip. A blend of opacity o stays with probability o by a hash of pixel, triangle and
//!   seed: the pattern stands still, and layers behind each other are independent.
//! - Seen from behind, a surface has its normal and tangent frame turned over and emits nothing (emission leaves front
//!   faces only); a bit in `motion_id` tells.
//! - Motion is the pixel now minus the pixel one frame ago, both without jitter; 65,504 where the point was behind the
//!   eye.
//!
//! Departs from the paper: masks, blends, motion and backs, on which it is silent.

pub mod reference;
#[cfg(test)]
mod tests;

use frame::info::Frame;
use frame::scene_gpu::{self, GpuMesh, GpuScene};
use frame::{
    Bind, GBuffer, Gpu, GpuError, Kernel, KernelDesc, Knob, RasterDesc, RasterKernel, RasterTargets,
    Recorder, Room, Texture, Uniform,
};
use wgpu::{BindingResource, Color, TextureFormat, TextureUsages};

frame::gpu_struct! {
    /// See `gather.inc.wgsl`.
    pub struct GatherParams {
        /// Pixels of this image.
        pub size: [u32; 2],
        /// 1: textures are seen through the pixel's footprint, 0: at mip 0.
        pub area_scale: f32,
        /// 1: normals turned away from the viewer are bent back.
        pub bend: u32,
    }
}

/// The raster gather, with what it needs for every size it was told of.
pub struct Gather {
    visible: Visible,
    kernel: Kernel,
    targets: Vec<Targets>,
    mips: bool,
    bend: bool,
}

/// How visible triangles are found. Testing opacity is what costs most, so where some triangles need it, those without
/// holes are drawn first and alone.
enum Visible {
    /// Nothing is cut out or blended.
    All(RasterKernel),
    /// First those without holes, then the others.
    SolidThenCut(RasterKernel, RasterKernel),
}

impl Visible {
    fn new(gpu: &Gpu, scene: &GpuScene) -> Result<Self, GpuError> {
        let kernel = |name, entries, bindings: &[&[Bind]]| {
            RasterKernel::new(
                gpu,
                &RasterDesc {
                    name,
                    sources: &sources(include_str!("visible.wgsl")),
                    entries,
                    bindings: &bindings.concat(),
                    constants: &scene.constants(),
                    targets: &[TextureFormat::R32Uint.into()],
                    depth: Some(wgpu::DepthStencilState {
                        format: TextureFormat::Depth32Float,
                        depth_write_enabled: Some(true),
                        depth_compare: Some(wgpu::CompareFunction::Greater),
                        stencil: wgpu::StencilState::default(),
                        bias: wgpu::DepthBiasState::default(),
                    }),
                },
            )
        };
        let (mesh, materials) = (&scene_gpu::MESH_BINDS, &scene_gpu::MATERIAL_BINDS);
        if !scene.needs.coverage {
            let bindings = [&[FRAME][..], mesh];
            return Ok(Self::All(kernel("gather/visible", ["visible_all", "visible_untested"], &bindings)?));
        }
        let bindings = [&[FRAME][..], mesh, &materials[..1]];
        let solid = kernel("gather/solid", ["visible_solid", "visible_untested"], &bindings)?;
        let bindings = [&[FRAME, PARAMS][..], mesh, materials];
        let cut = kernel("gather/cut", ["visible_cut", "visible_tested"], &bindings)?;
        Ok(Self::SolidThenCut(solid, cut))
    }

    fn draw(
        &self,
        recorder: &mut Recorder<'_>,
        pass: &str,
        [uniform, params]: [&Uniform; 2],
        scene: &GpuScene,
        mesh: &GpuMesh,
        into: &Targets,
    ) {
        let [vertices, triangles] = mesh.resources();
        let vertex_count = 3 * mesh.triangle_count;
        let mut draw =
            |pass: &str, kernel: &RasterKernel, resources: &[BindingResource<'_>], is_first: bool| {
                let targets = RasterTargets {
                    colors: &[(into.triangle.view(), is_first.then_some(Color::TRANSPARENT))],
                    depth: Some((into.depth.view(), is_first.then_some(0.0))),
                };
                recorder.raster(pass, kernel, resources, &targets, 0..vertex_count);
                recorder.output(pass, &into.triangle);
            };
        let frame = uniform.binding();
        match self {
            Self::All(kernel) => {
                draw(&format!("{pass}/visible"), kernel, &[frame, vertices, triangles], true)
            }
            Self::SolidThenCut(solid, cut) => {
                let materials = scene.material_resources();
                let resources = [frame.clone(), vertices.clone(), triangles.clone(), materials[0].clone()];
                draw(&format!("{pass}/solid"), solid, &resources, true);
                let mut resources = vec![frame, params.binding(), vertices, triangles];
                resources.extend(materials);
                draw(&format!("{pass}/cut"), cut, &resources, false);
            }
        }
    }
}

/// What the first pass draws into.
struct Targets {
    triangle: Texture,
    depth: Texture,
}

impl Targets {
    fn new(gpu: &Gpu, [width, height]: [u32; 2]) -> Result<Self, GpuError> {
        let make =
            |label, format, usage| gpu.texture(Room::GBuffer, label, [width, height, 1], 1, format, usage);
        let target = TextureUsages::RENDER_ATTACHMENT;
        Ok(Self {
            triangle: make(
                "Gather::triangle",
                TextureFormat::R32Uint,
                target | TextureUsages::TEXTURE_BINDING,
            )?,
            depth: make("Gather::depth", TextureFormat::Depth32Float, target)?,
        })
    }

    fn size(&self) -> [u32; 2] {
        [self.depth.width(), self.depth.height()]
    }
}

const FRAME: Bind = Bind::uniform::<Frame>(0, 0, "frame");
const PARAMS: Bind = Bind::uniform::<GatherParams>(0, 1, "params");

const fn sources(last: &'static str) -> [&'static str; 7] {
    [
        frame::info::WGSL,
        frame::surface::WGSL,
        frame::brdf::WGSL,
        scene_gpu::MESH_WGSL,
        scene_gpu::MATERIAL_WGSL,
        include_str!("gather.inc.wgsl"),
        last,
    ]
}

impl Gather {
    /// Compiles it for this scene's textures and meshes of its vertex layout.
    ///
    /// # Errors
    /// The driver refuses a shader.
    pub fn new(gpu: &Gpu, scene: &GpuScene) -> Result<Self, GpuError> {
        let mut bindings = vec![FRAME, PARAMS];
        bindings.extend(scene_gpu::MESH_BINDS);
        bindings.push(scene_gpu::MESH_PREVIOUS_BIND);
        bindings.extend(scene_gpu::MATERIAL_BINDS);
        let [surface, distance, face_normal, motion_id] = GBuffer::FORMATS;
        bindings.extend([
            Bind::texture_uint(2, 0, "in_triangle"),
            Bind::storage_texture(3, 0, "out_surface", surface),
            Bind::storage_texture(3, 1, "out_distance", distance),
            Bind::storage_texture(3, 2, "out_face_normal", face_normal),
            Bind::storage_texture(3, 3, "out_motion_id", motion_id),
        ]);
        let kernel = Kernel::new(
            gpu,
            &KernelDesc {
                name: "gather",
                sources: &sources(include_str!("gather.wgsl")),
                entry: "gather",
                workgroup: [8, 8, 1],
                bindings: &bindings,
                constants: &scene.constants(),
            },
        )?;
        Ok(Self { visible: Visible::new(gpu, scene)?, kernel, targets: Vec::new(), mips: true, bend: true })
    }

    /// Settings of the stage `gather`.
    pub fn knobs(&mut self) -> Vec<Knob<'_>> {
        vec![
            Knob::bool(
                "mips",
                &mut self.mips,
                "textures are averaged over the pixel; off: mip 0, as the references read them, with more aliasing",
            ),
            Knob::bool(
                "bend",
                &mut self.bend,
                "normals that a map turned away from the viewer are bent back; off: such places are black",
            ),
        ]
    }

    /// Allocates for these sizes of G-buffer and forgets others.
    ///
    /// # Errors
    /// Too large, or out of memory.
    pub fn resize(&mut self, gpu: &Gpu, sizes: &[[u32; 2]]) -> Result<(), GpuError> {
        self.targets.retain(|targets| sizes.contains(&targets.size()));
        for &size in sizes {
            if self.targets.iter().all(|targets| targets.size() != size) {
                self.targets.push(Targets::new(gpu, size)?);
            }
        }
        Ok(())
    }

    /// Records the passes. `mesh` is the scene's or what a tessellator made of it, in the same layout.
    ///
    /// # Panics
    /// [`Gather::resize`] was not told of this size: a mistake in the program.
    pub fn gather(
        &self,
        recorder: &mut Recorder<'_>,
        pass: &str,
        uniform: &Uniform,
        scene: &GpuScene,
        mesh: &GpuMesh,
        out: &GBuffer,
    ) {
        let size = out.size();
        let targets = self.targets.iter().find(|targets| targets.size() == size);
        let targets =
            targets.unwrap_or_else(|| unreachable!("{pass}: resize was not told of {size:?} pixels"));
        let params =
            GatherParams { size, area_scale: if self.mips { 1.0 } else { 0.0 }, bend: u32::from(self.bend) };
        let params = recorder.uniform(&params);
        self.visible.draw(recorder, pass, [uniform, &params], scene, mesh, targets);

        let mut resources: Vec<BindingResource<'_>> = vec![uniform.binding(), params.binding()];
        resources.extend(mesh.resources());
        resources.push(mesh.previous.as_entire_binding());
        resources.extend(scene.material_resources());
        let images = [&targets.triangle, &out.surface, &out.distance, &out.face_normal, &out.motion_id];
        resources.extend(images.map(|image| BindingResource::TextureView(image.view())));
        let surface = format!("{pass}/surface");
        recorder.compute(&surface, &self.kernel, &resources, [size[0].div_ceil(8), size[1].div_ceil(8), 1]);
        recorder.output(&surface, &out.surface);
    }
}
