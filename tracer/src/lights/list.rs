//! What a structure's paths look for: sun and punctual lights, then the emitters that they can meet there.
//!
//! In: the lights of [`GpuScene`], and either the triangles that glow or the voxels that do. Out: one buffer, `lights`: four vectors
//! per light, then one per emitter: what names it (a triangle's number; a cell as `x | y << 16` and `z | level << 16`), its alias, and
//! the share of the time it stands for itself. Emitters are drawn in proportion to their weight: area times mean
//! luminance of a triangle, luminance of a voxel (where levels are nested, times a face's share of the coarsest's), both times `radiance_scale`.

use frame::scene_gpu::{GpuMesh, GpuScene};
use frame::{Alias, Buffer, Gpu, GpuError, Room};
use glam::Vec3;
use voxel::VoxelGrid;
use voxel::grid::Glowing;

/// What finds light, for one structure.
pub struct LightList {
    /// `lights`.
    pub(crate) buffer: Buffer,
    /// After the lights.
    pub(crate) emitter_count: u32,
    /// Of all emitters: m^2 of triangles, none of voxels, times luminance.
    pub(crate) emitter_total: f32,
}

impl LightList {
    /// Of the triangles that glow, as they are on the device.
    ///
    /// # Errors
    /// Reading back fails, or the list is larger than a binding may be.
    pub fn of_triangles(gpu: &Gpu, scene: &GpuScene, mesh: &GpuMesh) -> Result<Self, GpuError> {
        if scene.glows.iter().all(|glow| *glow <= 0.0) {
            return Self::new(gpu, scene, &[]);
        }
        let vertices: Vec<u32> = gpu.read_buffer(&mesh.vertices)?;
        let triangles: Vec<[u32; 4]> = gpu.read_buffer(&mesh.triangles)?;
        let stride = mesh.layout.stride as usize;
        let position = |vertex: u32| {
            let words = vertices.get(vertex as usize * stride..).and_then(|words| words.first_chunk::<3>());
            words.map_or(Vec3::NAN, |words| Vec3::from(words.map(f32::from_bits)))
        };
        let mut emitters = Vec::new();
        for (number, [a, b, c, names]) in (0..mesh.triangle_count).zip(triangles) {
            let glow = scene.glows.get((names & 0xffff) as usize).copied().unwrap_or(0.0);
            let [a, b, c] = [a, b, c].map(position);
            let weight = 0.5 * f64::from((b - a).cross(c - a).length()) * f64::from(glow);
            if weight.is_finite() && weight > 0.0 {
                emitters.push(([number, 0], weight));
            }
        }
        Self::new(gpu, scene, &emitters)
    }

    /// Of the voxels that glow.
    ///
    /// # Errors
    /// The list is larger than a binding may be.
    pub fn of_voxels(gpu: &Gpu, scene: &GpuScene, grid: &VoxelGrid) -> Result<Self, GpuError> {
        let named = |Glowing { cell: [x, y, z], level, face_share, luminance }: &Glowing| {
            ([x | (y << 16), z | (level << 16)], f64::from(*luminance) * f64::from(*face_share))
        };
        let emitters: Vec<_> = grid.glowing.iter().map(named).collect();
        Self::new(gpu, scene, &emitters)
    }

    fn new(gpu: &Gpu, scene: &GpuScene, emitters: &[([u32; 2], f64)]) -> Result<Self, GpuError> {
        let weights: Vec<f64> = emitters.iter().map(|(_, weight)| *weight).collect();
        let alias = Alias::new(&weights);
        let mut vectors: Vec<[u32; 4]> = gpu.read_buffer(&scene.lights)?;
        let entries = emitters.iter().zip(&alias.entries);
        vectors.extend(entries.map(|(([x, y], _), (other, keep))| [*x, *y, *other, keep.to_bits()]));
        Ok(Self {
            buffer: gpu.storage(Room::Scene, "LightList::buffer", &vectors)?,
            emitter_count: emitters.len() as u32,
            emitter_total: alias.total as f32,
        })
    }
}
