//! Returns the mesh as it came.
//!
//! Paper: nothing; the mesh as the file has it.
//!
//! In and out: the same buffers; no pass, no memory, no setting.
//!
//! Departs from the paper: nothing.

use crate::Tessellator;
use frame::info::FrameInfo;
use frame::scene_gpu::{GpuMesh, GpuScene};
use frame::{Knob, Recorder};

/// The tessellator that does nothing.
pub struct Identity;

impl Tessellator for Identity {
    fn name(&self) -> &'static str {
        "identity"
    }

    fn knobs(&mut self) -> Vec<Knob<'_>> {
        Vec::new()
    }

    fn tessellate(
        &mut self,
        _recorder: &mut Recorder<'_>,
        _frame: &FrameInfo,
        _voxel_size: f32,
        scene: &GpuScene,
    ) -> GpuMesh {
        scene.mesh.clone()
    }
}
