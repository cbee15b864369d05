//! The structure over triangles on the device, its search, and its twin.

use super::super::reference::CpuCwbvh;
use super::super::{Cwbvh, Quality, WGSL, build};
use crate::bvh::BvhParams;
use crate::bvh::tests::fixture::{Stage, soup};
use crate::rays::{Met, Ray, RayBatch};
use frame::scene_gpu::GpuMesh;
use glam::Vec3;
use std::ops::Deref;

/// Triangles on the device, and the structure over them.
pub struct Fixture {
    stage: Stage,
    pub cwbvh: Cwbvh,
    batch: RayBatch,
}

impl Deref for Fixture {
    type Target = Stage;

    fn deref(&self) -> &Stage {
        &self.stage
    }
}

impl Fixture {
    pub fn new(stage: Stage) -> Self {
        let batch = RayBatch::of_bvh(&stage.gpu, WGSL).unwrap();
        Self { cwbvh: stage.cwbvh(), batch, stage }
    }

    pub fn scene(name: &str) -> Self {
        Self::new(Stage::scene(name))
    }

    /// Of one opaque material.
    pub fn soup(triangles: &[[Vec3; 3]]) -> Self {
        Self::new(Stage::of(soup(triangles, 0)))
    }

    /// The same triangles, built otherwise.
    pub fn rebuild(&mut self, quality: Quality) {
        let mesh = GpuMesh::new(&self.stage.gpu, &self.stage.geometry).unwrap();
        self.cwbvh = build(&self.stage.gpu, &self.stage.uploaded, &mesh, quality).unwrap();
    }

    pub fn met(&self, rays: &[Ray]) -> Vec<Met> {
        self.stage.met(&self.batch, &self.cwbvh.bvh, rays)
    }

    pub fn blocked(&self, rays: &[Ray]) -> Vec<u32> {
        self.stage.blocked(&self.batch, &self.cwbvh.bvh, rays)
    }

    /// What the device has, for the twin.
    pub fn twin(&self) -> CpuCwbvh {
        let Cwbvh { bvh, triangle_count, .. } = &self.cwbvh;
        let elements = self.gpu.read_buffer(&bvh.elements).unwrap();
        let (node_count, triangle_count) = (bvh.node_count, *triangle_count);
        let params = BvhParams { triangles_at: 5 * node_count, triangle_count, node_count, _pad: 0 };
        CpuCwbvh { elements, params }
    }
}
