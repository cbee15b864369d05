//! The triangles of one moment as a shader pulls them: packed vertices, triangles, and where vertices were before.
//!
//! In: [`scene::Geometry`], world space, metres. Out: [`GpuMesh`]. A vertex is `stride` words:
//!
//! | word | content |
//! | --- | --- |
//! | 0 to 2 | position, f32, m |
//! | 3 | normal, octahedral 16 + 16 |
//! | 4 | tangent, octahedral 16 + 16 but for the lowest bit, which is set where the handedness is -1 |
//! | 5, 6 | first texture coordinates, f32 |
//! | `uv1_offset` + 0, 1 | second texture coordinates, f32; only where a material reads them |
//! | `color_offset` + 0, 1 | linear RGBA, 16-bit fractions of 1; only where a mesh has colours |
//!
//! A triangle is 4 words: three vertices, then material in the low and object in the high 16 bits. Objects beyond the
//! 65,535th share that number, which only blurs who is who in `motion_id`; materials beyond it are refused.

use crate::{Bind, Buffer, Gpu, GpuError, Room, surface};
use glam::{Vec3, Vec4};
use scene::{Geometry, Triangle};
use std::ops::Range;

/// The snippet: `mesh_*`, after [`crate::surface::WGSL`]. Its `override` constants come from
/// [`VertexLayout::constants`].
pub const MESH_WGSL: &str = include_str!("mesh.inc.wgsl");
/// Vertices and triangles: what every function of the snippet but one reads.
pub const MESH_BINDS: [Bind; 2] =
    [Bind::storage_read(1, 0, "mesh_vertices"), Bind::storage_read(1, 1, "mesh_triangles")];
/// What `mesh_previous_position` reads.
pub const MESH_PREVIOUS_BIND: Bind = Bind::storage_read(1, 20, "mesh_previous");

/// Words without second texture coordinates and colours.
const LEAST_STRIDE: u32 = 7;

/// Where the optional words of a vertex lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VertexLayout {
    /// Words per vertex.
    pub stride: u32,
    /// First word of the second texture coordinates; 0 = none.
    pub uv1_offset: u32,
    /// First word of the colour; 0 = none.
    pub color_offset: u32,
}

impl VertexLayout {
    /// What this geometry needs and no more.
    pub fn of(geometry: &Geometry) -> Self {
        let mut layout = Self { stride: LEAST_STRIDE, uv1_offset: 0, color_offset: 0 };
        if !geometry.uv1.is_empty() {
            layout.uv1_offset = layout.stride;
            layout.stride += 2;
        }
        if !geometry.colors.is_empty() {
            layout.color_offset = layout.stride;
            layout.stride += 2;
        }
        layout
    }

    /// Values of the snippet's `override` constants.
    pub fn constants(&self) -> [(&'static str, f64); 3] {
        [
            ("mesh_stride_words", self.stride.into()),
            ("mesh_uv1_word", self.uv1_offset.into()),
            ("mesh_color_word", self.color_offset.into()),
        ]
    }
}

/// Triangles on the GPU.
#[derive(Clone)]
pub struct GpuMesh {
    /// Packed vertices.
    pub vertices: Buffer,
    /// Three floats per vertex: its position one frame ago, m.
    pub previous: Buffer,
    /// Four words per triangle.
    pub triangles: Buffer,
    /// Number of vertices.
    pub vertex_count: u32,
    /// Number of triangles.
    pub triangle_count: u32,
    /// Leading triangles that never move.
    pub static_triangle_count: u32,
    /// What a vertex consists of.
    pub layout: VertexLayout,
}

impl GpuMesh {
    /// Uploads a geometry that did not move before.
    ///
    /// # Errors
    /// A list is larger than a binding may be, or out of memory.
    pub fn new(gpu: &Gpu, geometry: &Geometry) -> Result<Self, GpuError> {
        let layout = VertexLayout::of(geometry);
        let all = 0..geometry.positions.len();
        let vertices = pack_vertices(geometry, layout, all.clone());
        let mut previous = pack_positions(&geometry.positions);
        let mut triangles: Vec<_> = geometry.triangles.iter().map(pack_triangle).collect();
        // A binding of an array holds at least one element.
        if triangles.is_empty() {
            triangles.push([0; 4]);
            previous.push([0.0; 3]);
        }
        Ok(Self {
            vertices: gpu.storage(Room::Scene, "GpuMesh::vertices", &vertices)?,
            previous: gpu.storage(Room::Scene, "GpuMesh::previous", &previous)?,
            triangles: gpu.storage(Room::Scene, "GpuMesh::triangles", &triangles)?,
            vertex_count: geometry.positions.len() as u32,
            triangle_count: geometry.triangles.len() as u32,
            static_triangle_count: geometry.static_triangle_count(),
            layout,
        })
    }

    /// What [`MESH_BINDS`] binds.
    pub fn resources(&self) -> [wgpu::BindingResource<'_>; 2] {
        [self.vertices.as_entire_binding(), self.triangles.as_entire_binding()]
    }

    /// Rewrites the moving tail; `before` are the positions of the moving vertices until now, and become those of the
    /// frame before.
    pub(super) fn rewrite_tail(&self, gpu: &Gpu, geometry: &Geometry, before: &[Vec3]) {
        let first = geometry.static_vertex_count() as usize;
        let moving = first..geometry.positions.len();
        if moving.is_empty() || before.len() != moving.len() {
            return;
        }
        let write = |buffer: &Buffer, offset: usize, bytes: &[u8]| {
            gpu.queue.write_buffer(buffer, offset as u64, bytes)
        };
        let vertices = pack_vertices(geometry, self.layout, moving);
        write(&self.vertices, 4 * self.layout.stride as usize * first, bytemuck::cast_slice(&vertices));
        write(&self.previous, 12 * first, bytemuck::cast_slice(&pack_positions(before)));
        // A mirroring pose turns windings over.
        let first = geometry.static_triangle_count() as usize;
        let triangles: Vec<_> = geometry.triangles[first..].iter().map(pack_triangle).collect();
        write(&self.triangles, 16 * first, bytemuck::cast_slice(&triangles));
    }
}

fn pack_vertices(geometry: &Geometry, layout: VertexLayout, range: Range<usize>) -> Vec<u32> {
    let mut words = Vec::with_capacity(range.len() * layout.stride as usize);
    for v in range {
        words.extend(geometry.positions[v].to_array().map(f32::to_bits));
        words.push(surface::face_normal_pack(geometry.normals[v]));
        words.push(tangent_pack(geometry.tangents[v]));
        words.extend(geometry.uv0[v].to_array().map(f32::to_bits));
        if layout.uv1_offset != 0 {
            words.extend(geometry.uv1[v].to_array().map(f32::to_bits));
        }
        if layout.color_offset != 0 {
            let [r, g, b, a] =
                geometry.colors[v].to_array().map(|c| (c.clamp(0.0, 1.0) * 65535.0).round() as u32);
            words.extend([r | (g << 16), b | (a << 16)]);
        }
    }
    words
}

fn pack_positions(positions: &[Vec3]) -> Vec<[f32; 3]> {
    positions.iter().map(|p| p.to_array()).collect()
}

fn pack_triangle(triangle: &Triangle) -> [u32; 4] {
    let [a, b, c] = triangle.vertices;
    [a, b, c, triangle.material.min(0xffff) | (triangle.object.min(0xffff) << 16)]
}

/// Word 4 of a vertex, as `mesh_tangent_pack`.
fn tangent_pack(tangent: Vec4) -> u32 {
    (surface::face_normal_pack(tangent.truncate()) & !1) | u32::from(tangent.w < 0.0)
}
