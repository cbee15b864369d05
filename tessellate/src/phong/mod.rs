//! Rounds curved surfaces: points are pulled towards the tangent planes of their triangle's corners.
//!
//! Paper: "GPU accelerated special effects such as tessellation". Source: Boubekeur and Alexa 2008, "Phong tessellation".
//!
//! In: any mesh. Out: patches ([`crate::subdivide`]) of triangles whose normals leave their plane by more than a degree. With
//! w the weights of the corners p_i, n_i and p their mean:
//!
//! ```text
//! p' = (1 - strength) p + strength sum_i w_i (p - ((p - p_i) . n_i) n_i)
//! ```
//!
//! Normals, tangents, coordinates and colours are interpolated. On an edge both sides' points are averaged, so that hard
//! edges, whose sides have different normals, stay closed; a triangle that is flat keeps its plane away from such edges.
//!
//! Departs from the source in that mean alone.

use crate::Tessellator;
use crate::subdivide::topology::{Kind, Source};
use crate::subdivide::{Shape, Step, Subdivider};
use frame::info::FrameInfo;
use frame::scene_gpu::{GpuMesh, GpuScene};
use frame::{Gpu, GpuError, Knob, Recorder};

const SHAPE: Shape = Shape {
    shared: &[],
    class: include_str!("class.inc.wgsl"),
    points: include_str!("shape.inc.wgsl"),
    reads_heights: false,
};

/// Cosine of the angle between a corner's normal and the triangle's from which on a triangle is flat: one degree.
const FLAT_COSINE: f32 = 0.99985;

/// Phong tessellation.
pub struct Phong {
    detail: f32,
    strength: f32,
    subdivider: Subdivider,
}

impl Phong {
    /// Compiles what every mesh needs; the rest waits for the first mesh.
    ///
    /// # Errors
    /// A kernel was refused.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let subdivider = Subdivider::new(gpu, "tessellate/phong", SHAPE)?;
        Ok(Self { detail: 2.0, strength: 0.75, subdivider })
    }
}

impl Tessellator for Phong {
    fn name(&self) -> &'static str {
        "phong"
    }

    fn knobs(&mut self) -> Vec<Knob<'_>> {
        vec![
            Knob::float(
                "detail",
                &mut self.detail,
                0.1..=64.0,
                "voxels",
                "length of the parts that edges are cut into; lower is rounder and costs with its square. 2: a chord of \
                 two voxels stays within a tenth of a voxel of an arc of five",
            ),
            Knob::float(
                "strength",
                &mut self.strength,
                0.0..=1.0,
                "",
                "share of the way to the tangent planes; 0 leaves triangles flat, 1 bulges. 0.75 as its authors have it",
            ),
        ]
    }

    fn tessellate(
        &mut self,
        recorder: &mut Recorder<'_>,
        frame: &FrameInfo,
        voxel_size: f32,
        scene: &GpuScene,
    ) -> GpuMesh {
        let step = Step { edge_length: self.detail * voxel_size, edge_angle: 0.0, relief: self.strength };
        self.subdivider.record(recorder, frame, scene, step, kind)
    }
}

fn kind(source: &Source<'_>, triangle: usize) -> (Kind, bool) {
    let [a, b, c, _] = source.triangles[triangle];
    let [pa, pb, pc] = [a, b, c].map(|vertex| source.position(vertex));
    let longest = (pb - pa).abs().max((pc - pa).abs()).max_element();
    let Some(face) = ((pb - pa) / longest).cross((pc - pa) / longest).try_normalize() else {
        return (Kind::Flat, false);
    };
    // Normals of the other side are as good: files wind some triangles backwards.
    let is_flat = [a, b, c].iter().all(|&vertex| source.normal(vertex).dot(face).abs() >= FLAT_COSINE);
    (if is_flat { Kind::Flat } else { Kind::Shaped }, false)
}

#[cfg(test)]
mod tests;
