//! Paths through triangles: the rival of the voxels, and the truth.
//!
//! In: the G-buffer, triangles and a search structure over them (world positions in metres), materials, sky and lights.
//! Out: demodulated radiance in two lobes. Formulas: [`crate::path`]; what a ray meets is [`crate::bvh`]'s.
//!
//! Everything but the search is shared with the voxel tracer: BRDF, lights, noise, sample counts. At a hit the material is
//! read in f32 at mip 0, masks by their nearest texel; nothing is stored in between. A path leaves a triangle by a few
//! roundings of its position, and never meets the triangle it leaves.

#[cfg(test)]
mod tests;

use crate::bvh::{self, Bvh, cwbvh, lbvh};
use crate::path::{PathSettings, Paths, Searched, Structure};
use crate::{Search, Tracer, World};
use frame::scene_gpu::{self, GpuMesh, GpuScene};
use frame::{FrameInfo, GBuffer, Gpu, GpuError, Knob, RadianceImage, Recorder, Uniform};
use wgpu::BindingResource;

const HIT_WGSL: &str = include_str!("bvh_hit.inc.wgsl");

/// What a BVH brings to paths.
pub(crate) fn structure(search: Search) -> Structure {
    let (pass, walk) = match search {
        Search::Lbvh => ("trace/bvh_lbvh", lbvh::WGSL),
        _ => ("trace/bvh_cwbvh", cwbvh::WGSL),
    };
    let mut binds = scene_gpu::MESH_BINDS.to_vec();
    binds.extend(scene_gpu::MATERIAL_BINDS);
    binds.extend(bvh::BVH_BINDS);
    Structure {
        pass,
        sources: vec![scene_gpu::MESH_WGSL, scene_gpu::MATERIAL_WGSL, bvh::RAY_WGSL, walk, HIT_WGSL],
        binds,
        of_triangles: true,
    }
}

/// Most loop iterations of one ray.
pub(crate) fn worst_case(search: Search) -> u32 {
    match search {
        Search::Lbvh => lbvh::WORST_CASE_LOOPS,
        _ => cwbvh::WORST_CASE_LOOPS,
    }
}

/// What [`structure`] binds.
pub(crate) fn resources<'a>(
    scene: &'a GpuScene,
    mesh: &'a GpuMesh,
    bvh: &'a Bvh,
) -> Vec<BindingResource<'a>> {
    let mut all = mesh.resources().to_vec();
    all.extend(scene.material_resources());
    all.extend(bvh.resources());
    all
}

/// The ids `bvh_lbvh` and `bvh_cwbvh`.
pub struct BvhTracer {
    search: Search,
    paths: Paths,
}

impl BvhTracer {
    /// Over the given structure; a grid is no BVH and stands for the wide one.
    pub fn new(search: Search) -> Self {
        Self { search, paths: Paths::new(structure(search)) }
    }
}

impl Tracer for BvhTracer {
    fn name(&self) -> &'static str {
        match self.search {
            Search::Lbvh => "bvh_lbvh",
            _ => "bvh_cwbvh",
        }
    }

    fn knobs(&mut self) -> Vec<Knob<'_>> {
        Vec::new()
    }

    fn search(&self) -> Search {
        self.search
    }

    fn resize(
        &mut self,
        gpu: &Gpu,
        scene: &GpuScene,
        size: [u32; 2],
        paths: &PathSettings,
    ) -> Result<(), GpuError> {
        self.paths.resize(gpu, scene, size, paths)
    }

    fn trace(
        &mut self,
        recorder: &mut Recorder<'_>,
        frame: &FrameInfo,
        uniform: &Uniform,
        world: World<'_>,
        gbuffer: &GBuffer,
        paths: &PathSettings,
    ) -> RadianceImage {
        let (Some(bvh), Some(lights)) = (world.bvh(self.search), world.lights(self.search)) else {
            unreachable!("the pipeline builds what every tracer says it searches");
        };
        let resources = resources(world.scene, world.mesh, bvh);
        let searched =
            Searched { resources: &resources, worst_case: worst_case(self.search), lights, cache: None };
        self.paths.trace(recorder, uniform, world.scene, searched, frame, gbuffer, paths)
    }
}
