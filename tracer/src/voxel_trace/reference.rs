//! The CPU half of `voxel_hit.inc.wgsl`, over [`CpuGrid`].

use crate::path::reference::{Hit, Structure, Tally};
use frame::surface::Surface;
use glam::Vec3;
use voxel::grid::reference::CpuGrid;

const NUDGE: f32 = 1e-3;

/// A grid and its records.
pub(super) struct CpuVoxels {
    pub(super) grid: CpuGrid,
    pub(super) records: Vec<[u32; 4]>,
}

impl Structure for CpuVoxels {
    fn trace(&self, origin: Vec3, direction: Vec3, distance: f32, fresh: bool, tally: &mut Tally) -> Option<Hit> {
        let (hit, walk) = self.grid.trace(origin, direction, distance, if fresh { 2 } else { 1 });
        tally.iterations += u64::from(walk.iterations);
        tally.cut += u64::from(walk.cut);
        let hit = hit?;
        let surface = Surface::unpack_voxel(self.records[hit.record as usize]);
        let towards = |n: Vec3| if n.dot(direction) > 0.0 { -n } else { n };
        let face = towards(surface.normal);
        let entry = towards(Vec3::AXES[hit.axis as usize]);
        Some(Hit { distance: hit.distance, surface, face, entry })
    }

    fn start(&self, point: Vec3, face: Vec3, side: Vec3) -> Vec3 {
        let a = face.abs();
        let height = if self.grid.grid.elevation == 0 { 0.5 * (a.element_sum() + a.max_element()) } else { 1.0 };
        point + self.grid.grid.voxel_size * height * side
    }

    fn leave(&self, point: Vec3, hit: &Hit, direction: Vec3) -> Vec3 {
        let out = if direction.dot(hit.entry) > 0.0 { 1.0 } else { -1.0 };
        point + (out * NUDGE * self.grid.grid.voxel_size) * hit.entry
    }

    fn pass(&self, point: Vec3, hit: &Hit) -> Vec3 {
        point - (NUDGE * self.grid.grid.voxel_size) * hit.entry
    }
}
