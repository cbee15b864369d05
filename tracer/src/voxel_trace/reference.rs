//! The CPU half of `voxel_hit.inc.wgsl`, over [`CpuGrid`].

use crate::path::reference::{Hit, NO_OWN, Ray, Structure, Tally};
use frame::surface::{CREASE_CODE, Surface, normal_pack, surface_basis};
use glam::{UVec3, Vec3};
use voxel::grid::reference::{BEHIND, CpuGrid};

const NUDGE: f32 = 1e-3;
const OFF_PLANE: f32 = 0.02;
const POINT_STEPS: f32 = 256.0;
const SHARP: u32 = 0x8000_0000;

/// A grid and its records.
#[derive(Clone)]
pub(super) struct CpuVoxels {
    pub(super) grid: CpuGrid,
    pub(super) records: Vec<[u32; 4]>,
}

fn point_pack(p: Vec3) -> [u32; 2] {
    let q = (p * POINT_STEPS).clamp(Vec3::ZERO, Vec3::splat(2_097_150.0)).as_uvec3();
    [q.x | (q.z << 21), q.y | ((q.z >> 11) << 21)]
}

impl CpuVoxels {
    fn has_planes(&self) -> bool {
        self.grid.grid.contours != 0
    }

    fn point_unpack(&self, [x, y]: [u32; 2]) -> Vec3 {
        let q = UVec3::new(x & 0x1f_ffff, y & 0x1f_ffff, (x >> 21) | (((y >> 21) & 0x3ff) << 11));
        let grid = &self.grid.grid;
        Vec3::from(grid.origin) + (q.as_vec3() + 0.5) * (grid.voxel_size / POINT_STEPS)
    }

    fn in_grid(&self, point: Vec3) -> Vec3 {
        (point - Vec3::from(self.grid.grid.origin)) / self.grid.grid.voxel_size
    }

    fn beyond(&self, point: Vec3, hit: &Hit, outside: bool) -> Vec3 {
        let grid = &self.grid.grid;
        if let Some(cell) = hit.face_of {
            let low = cell.as_vec3() + NUDGE;
            let within = self.in_grid(point).clamp(low, low + (1.0 - 2.0 * NUDGE));
            let out = if outside { 2.0 * NUDGE } else { 0.0 };
            return Vec3::from(grid.origin) + grid.voxel_size * (within + out * hit.entry);
        }
        let off = grid.voxel_size * if self.has_planes() { OFF_PLANE } else { NUDGE };
        point + (if outside { off } else { -off }) * hit.entry
    }

    fn is_cube(&self, point: Vec3) -> bool {
        let record = self.grid.record(self.in_grid(point).floor().as_ivec3());
        record.is_some_and(|record| self.records[record as usize][1] as i32 >> 24 == CREASE_CODE)
    }
}

impl Structure for CpuVoxels {
    fn trace(&self, ray: &Ray, tally: &mut Tally) -> Option<Hit> {
        let Ray { origin, direction, distance, own } = *ray;
        let beside = if own == NO_OWN { origin } else { self.point_unpack(own) };
        let behind = if own != NO_OWN && own[1] & SHARP != 0 { 0.0 } else { BEHIND };
        let (met, walk) =
            self.grid.trace_surfaces(&self.records, origin, direction, distance, (beside, behind));
        tally.iterations += u64::from(walk.iterations);
        tally.cut += u64::from(walk.cut);
        let met = met?;
        let mut surface = Surface::unpack_voxel(self.records[met.hit.record as usize]);
        let towards = |n: Vec3| if n.dot(direction) > 0.0 { -n } else { n };
        let front = met.normal.dot(direction) < 0.0;
        let side = if front { 1.0 } else { -1.0 };
        let mut face = side * met.normal;
        let is_entered = met.hit.axis < 3 && (!self.has_planes() || met.is_cube);
        let entry = if is_entered { towards(Vec3::AXES[met.hit.axis as usize]) } else { face };
        if met.is_cube {
            face = entry;
        }
        if side * surface.normal != face {
            surface.normal = side * face;
            let along = surface.tangent - surface.tangent.dot(face) * face;
            surface.tangent = if along.length_squared() > 1e-4 {
                along.normalize()
            } else {
                surface_basis(normal_pack(face))[0]
            };
        }
        let point = self.in_grid(origin + met.hit.distance * direction);
        let (mut own, mut beyond) = (met.beside, point - 0.5 * face);
        if self.has_planes() {
            own = point + 0.1 * face - (met.hit.distance / self.grid.grid.voxel_size).min(0.5) * direction;
        } else {
            let offset = if met.is_cube { 0.0 } else { surface.contour };
            beyond = met.hit.cell.as_vec3() + 0.5 + offset * met.normal - face;
        }
        let sharp = |[x, y]: [u32; 2]| [x, if surface.transmission > 0.0 { y | SHARP } else { y }];
        Some(Hit {
            distance: met.hit.distance,
            surface,
            front,
            face,
            entry,
            face_of: is_entered.then_some(met.hit.cell),
            own: sharp(point_pack(own)),
            beyond: sharp(point_pack(beyond)),
        })
    }

    fn start(&self, point: Vec3, face: Vec3, side: Vec3, wo: Vec3) -> Vec3 {
        let a = face.abs();
        let voxel_size = self.grid.grid.voxel_size;
        let height = match (self.has_planes(), self.grid.grid.elevation) {
            (true, _) => OFF_PLANE,
            (false, 0) => 0.5 * (a.element_sum() + a.max_element()),
            (false, _) => 1.0,
        };
        let first = point + voxel_size * height * side;
        if side.dot(wo) <= 0.0 {
            return first;
        }
        let towards_viewer = (1..=18u16).map(|i| point + 0.125 * f32::from(i * (i + 3)) * voxel_size * wo);
        let all: Vec<Vec3> = std::iter::once(first).chain(towards_viewer).collect();
        all.iter().copied().find(|p| !self.is_cube(*p)).unwrap_or(all[18])
    }

    fn starts_from(&self, point: Vec3, side: Vec3, wo: Vec3) -> [u32; 2] {
        let (viewer, sharp) = if side.dot(wo) > 0.0 { (wo, 0) } else { (side, SHARP) };
        let off = if self.has_planes() { 0.1 } else { 0.5 };
        let [x, y] = point_pack(self.in_grid(point + self.grid.grid.voxel_size * (off * side + viewer)));
        [x, y | sharp]
    }

    fn leave(&self, point: Vec3, hit: &Hit, direction: Vec3) -> Vec3 {
        self.beyond(point, hit, direction.dot(hit.entry) > 0.0)
    }

    fn pass(&self, point: Vec3, hit: &Hit) -> Vec3 {
        self.beyond(point, hit, false)
    }
}
