//! The triangles of a scene in world space at one moment: what every later stage reads.
//!
//! Static objects come first, moving ones after, so that a new moment rewrites one tail of each list.

use crate::light::PunctualLight;
use glam::{Vec2, Vec3, Vec4};
use std::ops::Range;

/// An axis-aligned box in world space, metres. Empty where `min > max`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// Lowest corner.
    pub min: Vec3,
    /// Highest corner.
    pub max: Vec3,
}

impl Aabb {
    /// Holds nothing.
    pub const EMPTY: Self = Self { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    /// The smallest box around finite points; others are left out.
    pub fn of(points: impl IntoIterator<Item = Vec3>) -> Self {
        let mut bounds = Self::EMPTY;
        for p in points {
            bounds.grow(p);
        }
        bounds
    }

    /// Takes in a point; a point that is not finite is left out.
    pub fn grow(&mut self, p: Vec3) {
        if p.is_finite() {
            self.min = self.min.min(p);
            self.max = self.max.max(p);
        }
    }

    /// The smallest box around both.
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Whether no point was ever taken in.
    pub fn is_empty(&self) -> bool {
        self.min.cmpgt(self.max).any()
    }

    /// Side lengths, m; 0 when empty.
    pub fn size(&self) -> Vec3 {
        if self.is_empty() { Vec3::ZERO } else { self.max - self.min }
    }

    /// Middle; the origin when empty.
    pub fn center(&self) -> Vec3 {
        if self.is_empty() { Vec3::ZERO } else { 0.5 * (self.min + self.max) }
    }

    /// Where to put the origin so that floats suffice: the middle of a box that is far from the origin for its size, else
    /// where it is. Beyond 256 diagonals floats are farther apart than 2^-15 of the diagonal, a hundredth of a voxel.
    pub(crate) fn better_origin(&self) -> Vec3 {
        let center = self.center();
        // Whole metres, so that what lies on round numbers stays on them.
        let is_far = center.abs().max_element() > 256.0 * self.diagonal() && center.is_finite();
        if is_far { center.floor() } else { Vec3::ZERO }
    }

    /// Length of the diagonal, m.
    pub fn diagonal(&self) -> f32 {
        self.size().length()
    }
}

/// Three vertices, wound counter-clockwise seen from the front.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Triangle {
    /// Indices into the vertex lists.
    pub vertices: [u32; 3],
    /// Index into [`crate::Scene::materials`].
    pub material: u32,
    /// Index into [`Geometry::objects`].
    pub object: u32,
}

/// One primitive of one node (or of one instance of it): what moves, is named and emits as a whole.
#[derive(Clone, Debug, PartialEq)]
pub struct Object {
    /// Node and primitive, for messages.
    pub name: String,
    /// Its vertices.
    pub vertices: Range<u32>,
    /// Its triangles.
    pub triangles: Range<u32>,
    /// Whether any later moment differs from this one.
    pub moving: bool,
}

/// World-space triangles at one moment.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Geometry {
    /// Metres.
    pub positions: Vec<Vec3>,
    /// Unit length.
    pub normals: Vec<Vec3>,
    /// Unit length, w is the handedness: bitangent = cross(normal, tangent) * w.
    pub tangents: Vec<Vec4>,
    /// First set of texture coordinates; (0, 0) where the file has none. v points down, as in glTF.
    pub uv0: Vec<Vec2>,
    /// Second set; empty when no material reads it.
    pub uv1: Vec<Vec2>,
    /// Linear RGBA that multiplies the base colour; empty when no mesh has any.
    pub colors: Vec<Vec4>,
    /// All triangles, grouped by object.
    pub triangles: Vec<Triangle>,
    /// All objects, static ones first.
    pub objects: Vec<Object>,
    /// Point, spot and directional lights where they are at this moment.
    pub lights: Vec<PunctualLight>,
}

impl Geometry {
    /// Box around all positions.
    pub fn bounds(&self) -> Aabb {
        Aabb::of(self.positions.iter().copied())
    }

    /// Number of leading objects that never move.
    pub fn static_object_count(&self) -> usize {
        self.objects.iter().take_while(|o| !o.moving).count()
    }

    /// Number of leading triangles that never move.
    pub fn static_triangle_count(&self) -> u32 {
        match self.objects.iter().find(|o| o.moving) {
            Some(first) => first.triangles.start,
            None => self.triangles.len() as u32,
        }
    }

    /// Number of leading vertices that never move.
    pub fn static_vertex_count(&self) -> u32 {
        match self.objects.iter().find(|o| o.moving) {
            Some(first) => first.vertices.start,
            None => self.positions.len() as u32,
        }
    }

    /// The corners of a triangle, m.
    pub fn corners(&self, triangle: &Triangle) -> [Vec3; 3] {
        triangle.vertices.map(|v| self.positions[v as usize])
    }
}
