//! The triangles of one object of a built-in scene, before they join the others.

use glam::{Vec2, Vec3, Vec4};

/// One object, one material. [`super::shapes`] adds shapes to it.
pub(super) struct Part {
    /// For messages.
    pub name: String,
    /// From [`super::assembly::Assembly::material`].
    pub material: u32,
    /// How often a texture repeats along a metre.
    pub repeats_per_m: f32,
    /// Metres.
    pub positions: Vec<Vec3>,
    /// Unit length.
    pub normals: Vec<Vec3>,
    /// Unit length, w the handedness.
    pub tangents: Vec<Vec4>,
    /// v points down.
    pub uv0: Vec<Vec2>,
    /// Indices into this part's vertices.
    pub triangles: Vec<[u32; 3]>,
}

/// Where a vertex is and how it is turned.
#[derive(Clone, Copy)]
pub(super) struct Corner {
    /// Metres.
    pub position: Vec3,
    /// Unit length.
    pub normal: Vec3,
    /// Along growing u; made perpendicular to the normal and unit when it is added.
    pub along_u: Vec3,
    /// v points down.
    pub uv: Vec2,
    /// 1 where a picture reads as painted, -1 where it is mirrored.
    pub handedness: f32,
}

impl Part {
    /// An empty part whose textures repeat once a metre.
    pub fn new(name: &str, material: u32) -> Self {
        Self {
            name: name.into(),
            material,
            repeats_per_m: 1.0,
            positions: Vec::new(),
            normals: Vec::new(),
            tangents: Vec::new(),
            uv0: Vec::new(),
            triangles: Vec::new(),
        }
    }

    /// The same part with textures that repeat every `metres`.
    pub fn repeating(mut self, metres: f32) -> Self {
        self.repeats_per_m = 1.0 / metres;
        self
    }

    /// Adds a vertex and gives its number.
    pub fn corner(&mut self, corner: Corner) -> u32 {
        let normal = corner.normal;
        let tangent = corner.along_u.reject_from_normalized(normal).try_normalize();
        let tangent = tangent.unwrap_or_else(|| normal.any_orthonormal_vector());
        self.positions.push(corner.position);
        self.normals.push(normal);
        self.tangents.push(tangent.extend(corner.handedness));
        self.uv0.push(corner.uv);
        self.positions.len() as u32 - 1
    }

    /// Adds a triangle, counter-clockwise from the front; one without area is left out.
    pub fn triangle(&mut self, corners: [u32; 3]) {
        let [a, b, c] = corners.map(|corner| self.positions[corner as usize]);
        let longest = (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared());
        // Twice the area over the longest side squared: 1e-4 is flatter than any shape here is meant to be, and
        // far above the rounding of the poles of a sphere.
        if (b - a).cross(c - a).length() > 1e-4 * longest {
            self.triangles.push(corners);
        }
    }
}
