//! Cuts what has a height map and moves it, with the normals and tangents that fit its new shape.
//!
//! Paper: "Primitive normals, tangents and bitangents are adjusted during the tessellation process using the height map."
//!
//! In: triangles whose material has a height map ([`frame::scene_gpu::Heights`], m). Out: patches ([`crate::subdivide`])
//! of edges `l = max(detail * voxel_size, pixels at that distance)`, detail 0.7 by default: finer relief falls between
//! voxels. With p(u, v) the surface, n its interpolated normal, h(u, v) the height in the mip with about two texels
//! between vertices:
//!
//! - **Where**: `S = p + h d`, d linear between the corners. A corner's d is `m / mean(m . n_i)` over the normals n_i of all
//!   corners at its place, weighed by angle, m their mean: n itself where the surface is smooth, and longer at hard
//!   edges, so that every face moves by h. Its h is the mean over those corners. On an edge h is the mean of what both
//!   sides read, so that a seam of texture coordinates stays closed; it is 0 where a neighbour has no map. Along hard edges,
//!   and for the part of d that lies in a face, h is linear between the corners: relief there would fold the face over.
//! - **Frame**: `S_u = p_u + h_u n + h n_u`, `S_v` alike; `n' = sgn(n . (p_u x p_v)) (S_u x S_v) / |..|`, which is also right where
//!   coordinates are mirrored or sheared. p_u, p_v are those of the triangle turned onto n; h n_u is what curvature adds. The
//!   tangent keeps its coordinates along u and v; the handedness stays.
//! - **Limits**: a slope of 8; 0.9 of the radius towards a centre of curvature; texture coordinates without an area say
//!   nothing (the patch follows its corners, and a mesh of such patches stays as it was); a map's wrapping is its sampler's.
//! - Where a material has a normal map besides, that map holds the relief already: patches move and keep their frames
//!   (`frames`).
//!
//! The default factor depends on the world alone. With `screen` the camera counts, and everything is made anew and counts as
//! moving whenever it moves.
//!
//! Departs from the paper, which gives no formula: everything above.

pub mod reference;

use crate::Tessellator;
use crate::subdivide::topology::{Kind, Source};
use crate::subdivide::{Shape, Step, Subdivider};
use frame::info::FrameInfo;
use frame::scene_gpu::{self, Aabb, GpuMesh, GpuScene, Heights};
use frame::{Gpu, GpuError, Knob, Recorder};

const SHAPE: Shape = Shape {
    shared: &[scene_gpu::HEIGHT_WGSL, include_str!("displace.inc.wgsl")],
    class: include_str!("class.inc.wgsl"),
    points: include_str!("shape.inc.wgsl"),
    reads_heights: true,
};

/// The names of `relief`, in order.
const RELIEFS: &[&str] = &["shape", "normals"];
/// The names of `frames`, in order.
const FRAMES: &[&str] = &["auto", "rebuilt", "kept"];

/// Displacement by height maps.
pub struct Displace {
    detail: f32,
    screen: bool,
    pixels: f32,
    relief: u32,
    frames: u32,
    made_with_frames: u32,
    subdivider: Subdivider,
}

impl Displace {
    /// Compiles what every mesh needs; the rest waits for the first mesh.
    ///
    /// # Errors
    /// A kernel was refused.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        Ok(Self {
            detail: 0.7,
            screen: false,
            pixels: 4.0,
            relief: 0,
            frames: 0,
            made_with_frames: 0,
            subdivider: Subdivider::new(gpu, "tessellate/displace", SHAPE)?,
        })
    }
}

impl Tessellator for Displace {
    fn name(&self) -> &'static str {
        "displace"
    }

    fn knobs(&mut self) -> Vec<Knob<'_>> {
        vec![
            Knob::float(
                "detail",
                &mut self.detail,
                0.1..=64.0,
                "voxels",
                "length of the parts that edges are cut into; lower shows more relief to the camera, and costs with its \
                 square. 0.7: finer falls between voxels",
            ),
            Knob::bool(
                "screen",
                &mut self.screen,
                "parts are also at least `pixels` long as the camera sees them; fewer triangles far away, but the mesh \
                 changes with the camera and every structure is built anew",
            ),
            Knob::float(
                "pixels",
                &mut self.pixels,
                0.5..=64.0,
                "px",
                "display pixels that a part is long at least, with `screen`. 4: half a workgroup's side",
            ),
            Knob::choice(
                "relief",
                &mut self.relief,
                RELIEFS,
                "shape moves the surface; normals only turns its normals, so that silhouettes, shadows and voxels stay \
                 flat. shape: what the paper does",
            ),
            Knob::choice(
                "frames",
                &mut self.frames,
                FRAMES,
                "normals and tangents rebuilt from the height map, or kept as they came; auto keeps them where a normal \
                 map tells the same relief a second time",
            ),
        ]
    }

    fn bounds(&self, scene: &GpuScene) -> Aabb {
        scene.bounds.union(scene.heights.bounds)
    }

    fn tessellate(
        &mut self,
        recorder: &mut Recorder<'_>,
        frame: &FrameInfo,
        voxel_size: f32,
        scene: &GpuScene,
    ) -> GpuMesh {
        if scene.heights.is_empty() {
            return scene.mesh.clone();
        }
        let pixel = 2.0 * (0.5 * frame.camera.vfov).tan() / frame.display_size[1].max(1) as f32;
        let step = Step {
            edge_length: self.detail * voxel_size,
            edge_angle: if self.screen { self.pixels * pixel } else { 0.0 },
            relief: if self.relief == 0 { 1.0 } else { 0.0 },
        };
        if self.made_with_frames != self.frames {
            self.made_with_frames = self.frames;
            self.subdivider.forget();
        }
        let frames = self.frames;
        let kind = |source: &Source<'_>, triangle: usize| kind(source, triangle, &scene.heights, frames);
        let mut mesh = self.subdivider.record(recorder, frame, scene, step, kind);
        if self.screen {
            mesh.static_triangle_count = 0;
        }
        mesh
    }
}

/// Whether a triangle's map says anything about it, and whether its frame stays.
fn kind(source: &Source<'_>, triangle: usize, heights: &Heights, frames: u32) -> (Kind, bool) {
    /// Of the product of its sides, in map coordinates: less area is none.
    const LEAST_AREA: f32 = 1e-6;
    let [a, b, c, word] = source.triangles[triangle];
    let Some(map) = heights.of(word & 0xffff) else { return (Kind::Flat, false) };
    let corners = [a, b, c].map(|vertex| source.position(vertex));
    let places = [a, b, c].map(|vertex| map.place(source.uv(vertex)));
    let is_finite = corners.iter().all(|p| p.is_finite()) && places.iter().all(|p| p.is_finite());
    if !is_finite {
        return (Kind::Flat, false);
    }
    let keeps_frame = match frames {
        0 => map.has_normal_map,
        1 => false,
        _ => true,
    };
    let [ab, ac] = [places[1] - places[0], places[2] - places[0]];
    let is_spread = ab.perp_dot(ac).abs() > LEAST_AREA * ab.length() * ac.length() && ab.perp_dot(ac) != 0.0;
    let [ab, ac] = [corners[1] - corners[0], corners[2] - corners[0]];
    let longest = ab.abs().max(ac.abs()).max_element();
    let has_area = longest > 0.0 && (ab / longest).cross(ac / longest).length() > 1e-6;
    (if is_spread && has_area { Kind::Shaped } else { Kind::Neutral }, keeps_frame)
}

#[cfg(test)]
mod tests;
