//! The CPU half of `voxel_hit.inc.wgsl`, over [`CpuGrid`].

use crate::path::reference::{Hit, NO_OWN, Ray, Structure, Tally};
use frame::surface::{Surface, normal_unpack};
use glam::{IVec3, Vec3};
use voxel::grid::reference::CpuGrid;

const NUDGE: f32 = 1e-3;
const PARALLEL: f32 = 0.8;

/// A grid and its records.
pub(super) struct CpuVoxels {
    pub(super) grid: CpuGrid,
    pub(super) records: Vec<[u32; 4]>,
}

fn is_own(own: [u32; 2], normal: Vec3, cell: IVec3) -> bool {
    if own == NO_OWN {
        return false;
    }
    let n = normal_unpack(own[0]);
    let apart = (n.dot(cell.as_vec3()) - f32::from_bits(own[1])).abs();
    n.dot(normal).abs() > PARALLEL && apart < 0.999 * n.abs().max_element()
}

impl Structure for CpuVoxels {
    fn trace(&self, ray: &Ray, tally: &mut Tally) -> Option<Hit> {
        let Ray { origin, direction, distance, own } = *ray;
        let (met, walk) = self.grid.trace(origin, direction, distance, if own == NO_OWN { 2 } else { 1 });
        tally.iterations += u64::from(walk.iterations);
        tally.cut += u64::from(walk.cut);
        let met = met?;
        let record = self.records[met.record as usize];
        let surface = Surface::unpack_voxel(record);
        let towards = |n: Vec3| if n.dot(direction) > 0.0 { -n } else { n };
        Some(Hit {
            distance: met.distance,
            surface,
            front: surface.normal.dot(direction) < 0.0,
            face: towards(surface.normal),
            entry: towards(Vec3::AXES[met.axis as usize]),
            own: [record[0] & 0xff_ffff, surface.normal.dot(met.cell.as_vec3()).to_bits()],
            again: is_own(own, surface.normal, met.cell),
        })
    }

    fn start(&self, point: Vec3, face: Vec3, side: Vec3) -> Vec3 {
        let a = face.abs();
        let height =
            if self.grid.grid.elevation == 0 { 0.5 * (a.element_sum() + a.max_element()) } else { 1.0 };
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
