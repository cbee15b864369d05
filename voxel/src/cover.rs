//! Which cells a triangle sets, and who finds them: the seam between the two voxelizers.

use crate::compute::{Compute, Lists};
use crate::raster::{Axes, Input, Raster, Rounds};
use crate::structure::Structure;
use frame::scene_gpu::GpuScene;
use frame::{Buffer, Gpu, GpuError, KernelError, Recorder};
use std::ops::Range;

/// The cells of a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cover {
    /// Those its plane passes in the columns whose centres it covers, along these axes: [`crate::raster`].
    Columns(Axes),
    /// All that it enters: [`crate::raster`].
    Boxes,
    /// Those whose 6-separating core it meets: [`crate::compute`].
    Thin,
    /// All that it meets: [`crate::compute`].
    Conservative,
}

/// All voxelizers; each but the first is made when it is first asked for.
pub(crate) struct Finders {
    raster: Raster,
    boxes: Option<Raster>,
    compute: Option<Compute>,
}

/// What marking leaves for voting.
pub(crate) struct Found(Option<Lists>);

impl Finders {
    pub(crate) fn new(gpu: &Gpu, scene: &GpuScene) -> Result<Self, KernelError> {
        Ok(Self { raster: Raster::new(gpu, scene, false)?, boxes: None, compute: None })
    }

    /// Makes what this cover needs.
    pub(crate) fn prepare(&mut self, gpu: &Gpu, scene: &GpuScene, cover: Cover) -> Result<(), KernelError> {
        match cover {
            Cover::Boxes if self.boxes.is_none() => self.boxes = Some(Raster::new(gpu, scene, true)?),
            Cover::Thin | Cover::Conservative if self.compute.is_none() => {
                self.compute = Some(Compute::new(gpu, scene)?);
            }
            _ => {}
        }
        Ok(())
    }

    fn raster(&self, cover: Cover) -> &Raster {
        match &self.boxes {
            Some(boxes) if cover == Cover::Boxes => boxes,
            _ => &self.raster,
        }
    }

    /// Writes 1 for each brick cell that something is in; `marks` must be clear.
    pub(crate) fn mark(
        &self,
        recorder: &mut Recorder<'_>,
        structure: &Structure,
        input: &Input<'_>,
        brick_cells: u32,
        marks: &Buffer,
    ) -> Result<Found, GpuError> {
        if let (Some(compute), Cover::Thin | Cover::Conservative) = (&self.compute, input.cover) {
            let lists = compute.bin(recorder, structure, input, brick_cells)?;
            compute.mark(recorder, input, &lists, marks);
            return Ok(Found(Some(lists)));
        }
        self.raster(input.cover).mark(recorder, input, marks);
        Ok(Found(None))
    }

    /// Finds the winner of each cell of a batch; `keys` hold 0 or what is there already.
    pub(crate) fn vote(
        &self,
        recorder: &mut Recorder<'_>,
        input: &Input<'_>,
        found: &Found,
        structure: &Buffer,
        slots: Range<u32>,
        keys: &Buffer,
        rounds: &Rounds,
    ) {
        match (&self.compute, &found.0) {
            (Some(compute), Some(lists)) => compute.vote(recorder, input, lists, structure, slots, keys),
            _ => self.raster(input.cover).vote(recorder, input, structure, slots, keys, rounds),
        }
    }

    /// Sets the bits of cells of a batch that are bent, once there are winners.
    pub(crate) fn bend(
        &self,
        recorder: &mut Recorder<'_>,
        input: &Input<'_>,
        found: &Found,
        structure: &Buffer,
        slots: Range<u32>,
        keys: &Buffer,
        bends: &Buffer,
    ) {
        match (&self.compute, &found.0) {
            (Some(compute), Some(lists)) => {
                compute.bend(recorder, input, lists, structure, slots, keys, bends);
            }
            _ => self.raster(input.cover).bend(recorder, input, structure, slots, keys, bends),
        }
    }
}
