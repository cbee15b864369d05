//! Emitters in nested grids: the factor of each by the size of voxels, which does not depend on where a grid is.
//!
//! In: the mesh as it is on the device; the lattices of all levels. Out: what [`super`] counts, for the part of each emitter
//! that is in a level's grid.
//!
//! An emitter's factor in a level is that of the whole emitter voxelized alone on the level's lattice, wherever the grid
//! is: so a grid that moved has the records of one that was built there. Where that would be too many voxels
//! ([`MOST_VOXELS`]) it is the factor of the next coarser level: it is that of planes by then.

use super::{ALL_LINES, Alone, Counted, LEAST_LINES, LINES, ReadMesh, alone};
use crate::Cover;
use crate::grid::Layout;
use frame::scene_gpu::{GpuMesh, GpuScene};
use frame::{Gpu, GpuError};
use glam::{IVec3, Vec3};

/// Voxels of an emitter beyond which a finer level changes nothing: 512 x 512 of a plane.
const MOST_VOXELS: f64 = 262_144.0;
/// Brick cells of the box around an emitter that is voxelized alone.
const MOST_BRICKS: f64 = 1_048_576.0;

/// The glowing part of a mesh and its factors by level.
pub(crate) struct Lamps {
    mesh: ReadMesh,
    /// By level as the layouts were given, then by object.
    factors: Vec<Vec<f32>>,
}

impl Lamps {
    /// Counts every emitter in every level, coarsest first; none where nothing glows.
    pub(crate) fn new(
        gpu: &Gpu,
        scene: &GpuScene,
        mesh: &GpuMesh,
        levels: &[Layout],
        cover: Cover,
    ) -> Result<Option<Self>, GpuError> {
        if scene.emitters.is_empty() {
            return Ok(None);
        }
        let mesh = ReadMesh::new(gpu, scene, mesh, 0..mesh.triangle_count)?;
        let lines = (ALL_LINES / scene.emitters.len() as u32).clamp(LEAST_LINES, LINES);
        let mut factors: Vec<Vec<f32>> = Vec::new();
        for level in levels {
            let of_level = mesh.each(|at, triangles| {
                // The coarsest has no other's.
                let around = if factors.is_empty() { Some(*level) } else { around(level, &mesh, triangles) };
                around.map(|around| alone(&around, cover, &mesh, triangles).factor(lines)).unwrap_or_else(
                    || factors.last().and_then(|coarser| coarser.get(at)).copied().unwrap_or(1.0),
                )
            });
            factors.push(of_level);
        }
        Ok(Some(Self { mesh, factors }))
    }

    /// The part of every emitter that is in a grid of level number `level`.
    pub(crate) fn counted(&self, level: usize, layout: &Layout, cover: Cover) -> Vec<Counted> {
        let of_level = self.factors.get(level);
        self.mesh.each(|at, triangles| {
            let Alone { voxels, .. } = alone(layout, cover, &self.mesh, triangles);
            Counted { voxels, factor: of_level.and_then(|f| f.get(at)).copied().unwrap_or(1.0) }
        })
    }
}

/// The part of a level's lattice around an emitter; none where it is too much of it.
fn around(level: &Layout, mesh: &ReadMesh, triangles: &[(u32, [u32; 3])]) -> Option<Layout> {
    let (mut low, mut high, mut area) = (Vec3::MAX, Vec3::MIN, 0.0);
    for (_, vertices) in triangles {
        let [a, b, c] = vertices.map(|v| (mesh.vertex(v).0 - level.origin) / level.voxel_size);
        if [a, b, c].iter().all(|p| p.is_finite()) {
            (low, high) = (low.min(a).min(b).min(c), high.max(a).max(b).max(c));
            area += 0.5 * f64::from((b - a).cross(c - a).length());
        }
    }
    let size = (high - low).as_dvec3() + 4.0;
    let bricks = (size / 8.0).ceil().element_product();
    if !(area > 0.0 && area <= MOST_VOXELS && bricks <= MOST_BRICKS) {
        return None;
    }
    let low = low.floor().as_ivec3() - 1;
    let cells = (high.ceil().as_ivec3() + 1 - low).max(IVec3::ONE).as_uvec3().to_array();
    Some(Layout { low, cells, ..*level })
}
