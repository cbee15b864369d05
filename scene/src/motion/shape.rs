//! A primitive in its own space, and how it is put into the world: morph targets, then a skin or a node's matrix.
//!
//! Normals go through the cofactor matrix, which unlike the inverse transpose also holds where a scale is 0.
//! A mirroring matrix turns triangles inside out; [`Shape::place`] says so and the caller swaps two corners. The
//! handedness of tangents changes with it.

use glam::{Affine3A, Mat3A, Vec3, Vec4};

/// What one morph target adds, per vertex; an empty list adds nothing.
#[derive(Clone, Debug, Default)]
pub(crate) struct Target {
    /// Metres.
    pub positions: Vec<Vec3>,
    /// Before normalizing.
    pub normals: Vec<Vec3>,
    /// Before normalizing.
    pub tangents: Vec<Vec3>,
}

/// Which joints pull a vertex, and how much; weights of a vertex sum to 1.
#[derive(Clone, Debug)]
pub(crate) struct Influences {
    /// Pairs per vertex.
    pub per_vertex: usize,
    /// Joint (index into the skin's list) and weight.
    pub pairs: Vec<(u16, f32)>,
}

/// Vertices in the space of their mesh.
#[derive(Clone, Debug, Default)]
pub(crate) struct Shape {
    /// Metres, finite.
    pub positions: Vec<Vec3>,
    /// Unit.
    pub normals: Vec<Vec3>,
    /// Unit, perpendicular to the normal; w is the handedness.
    pub tangents: Vec<Vec4>,
    /// The file has no normals: every three vertices are a triangle, whose plane gives the normal at every moment.
    pub flat: bool,
    /// Morph targets.
    pub targets: Vec<Target>,
    /// For skins.
    pub influences: Option<Influences>,
}

/// Where a shape goes.
#[derive(Clone, Copy)]
pub(crate) enum Placement<'a> {
    /// World from mesh.
    Rigid(Affine3A),
    /// World from mesh by joint.
    Skinned(&'a [Affine3A]),
}

/// Where the vertices are written; all of the shape's length.
pub(crate) struct Vertices<'a> {
    /// Metres, world space.
    pub positions: &'a mut [Vec3],
    /// Unit.
    pub normals: &'a mut [Vec3],
    /// Unit, w the handedness.
    pub tangents: &'a mut [Vec4],
}

impl Shape {
    /// Writes all vertices in world space; positions that overflow are left as they were. Returns whether the
    /// triangles are mirrored.
    pub(crate) fn place(&self, placement: Placement, weights: &[f32], out: Vertices) -> bool {
        let rigid = match placement {
            Placement::Rigid(m) => Some((m, normal_matrix(m.matrix3))),
            Placement::Skinned(_) => None,
        };
        let mut mirrored = false;
        for v in 0..self.positions.len() {
            let (m, (cofactor, sign)) = match (rigid, placement) {
                (None, Placement::Skinned(joints)) => {
                    let m = self.blend(v, joints);
                    (m, normal_matrix(m.matrix3))
                }
                (Some(rigid), _) => rigid,
                (None, Placement::Rigid(_)) => continue,
            };
            let (position, normal, tangent) = self.morph(v, weights);
            let position = m.transform_point3(position);
            if position.is_finite() {
                out.positions[v] = position;
            }
            out.normals[v] = (cofactor * normal).normalize_or(Vec3::Y);
            out.tangents[v] = perpendicular(m.matrix3 * tangent.truncate(), tangent.w * sign, out.normals[v]);
            mirrored |= v == 0 && sign < 0.0;
        }
        if self.flat {
            flatten(out, mirrored);
        }
        mirrored
    }

    /// Position, normal and tangent of a vertex with its targets added.
    fn morph(&self, v: usize, weights: &[f32]) -> (Vec3, Vec3, Vec4) {
        let (mut position, mut normal, mut tangent) = (self.positions[v], self.normals[v], self.tangents[v]);
        for (target, &weight) in self.targets.iter().zip(weights).filter(|(_, w)| **w != 0.0) {
            position += target.positions.get(v).map_or(Vec3::ZERO, |d| weight * d);
            normal += target.normals.get(v).map_or(Vec3::ZERO, |d| weight * d);
            tangent += target.tangents.get(v).map_or(Vec4::ZERO, |d| (weight * d).extend(0.0));
        }
        (position, normal.normalize_or(self.normals[v]), tangent)
    }

    /// The weighted sum of a vertex's joint matrices; influences and joints were checked when loading.
    fn blend(&self, v: usize, joints: &[Affine3A]) -> Affine3A {
        let Some(influences) = &self.influences else { return Affine3A::IDENTITY };
        let pairs = &influences.pairs[v * influences.per_vertex..(v + 1) * influences.per_vertex];
        let mut sum = Affine3A { matrix3: Mat3A::ZERO, translation: glam::Vec3A::ZERO };
        for &(joint, weight) in pairs.iter().filter(|(_, weight)| *weight != 0.0) {
            let m = joints[joint as usize];
            sum.matrix3 += m.matrix3 * weight;
            sum.translation += m.translation * weight;
        }
        sum
    }
}

/// The matrix normals go through (up to a positive factor), and -1 where `m` mirrors, else 1.
fn normal_matrix(m: Mat3A) -> (Mat3A, f32) {
    // Scaled to about 1 first: products of very small or large entries would leave the range of floats.
    let largest = m.to_cols_array().into_iter().fold(0.0_f32, |a, x| a.max(x.abs()));
    let m = if largest > 0.0 && largest.is_finite() { m * (1.0 / largest) } else { m };
    let (a, b, c) = (m.x_axis, m.y_axis, m.z_axis);
    let cofactor = Mat3A::from_cols(b.cross(c), c.cross(a), a.cross(b));
    let sign = if a.dot(cofactor.x_axis) < 0.0 { -1.0 } else { 1.0 };
    (cofactor * sign, sign)
}

/// A unit tangent perpendicular to a unit normal; any one where `tangent` gives no direction.
pub(crate) fn perpendicular(tangent: Vec3, handedness: f32, normal: Vec3) -> Vec4 {
    let tangent = tangent.normalize_or_zero();
    let in_plane = tangent - normal * normal.dot(tangent);
    // Below 1e-3 of its length the rest is mostly rounding.
    let direction =
        if in_plane.length_squared() > 1e-6 { in_plane.normalize() } else { normal.any_orthonormal_vector() };
    direction.extend(if handedness < 0.0 { -1.0 } else { 1.0 })
}

/// The unit normal of a triangle, counter-clockwise seen from outside; +Y where it has no area.
pub(crate) fn face_normal(a: Vec3, b: Vec3, c: Vec3) -> Vec3 {
    let (ab, ac) = (b - a, c - a);
    // Unit edges first, so that tiny triangles do not underflow.
    ab.normalize_or_zero().cross(ac.normalize_or_zero()).normalize_or(Vec3::Y)
}

/// Gives each three vertices the normal of their plane.
fn flatten(out: Vertices, mirrored: bool) {
    let corners = out.positions.chunks_exact(3).zip(out.normals.chunks_exact_mut(3));
    for ((p, normals), tangents) in corners.zip(out.tangents.chunks_exact_mut(3)) {
        let outward = face_normal(p[0], p[1], p[2]);
        normals.fill(if mirrored { -outward } else { outward });
        for tangent in tangents {
            *tangent = perpendicular(tangent.truncate(), tangent.w, normals[0]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(
        shape: &Shape,
        placement: Placement,
        weights: &[f32],
    ) -> (Vec<Vec3>, Vec<Vec3>, Vec<Vec4>, bool) {
        let n = shape.positions.len();
        let (mut p, mut normals, mut t) = (vec![Vec3::NAN; n], vec![Vec3::ZERO; n], vec![Vec4::ZERO; n]);
        let out = Vertices { positions: &mut p, normals: &mut normals, tangents: &mut t };
        let mirrored = shape.place(placement, weights, out);
        (p, normals, t, mirrored)
    }

    /// A triangle in the plane x + z = 1, its normal and the tangent of its texture.
    fn slanted() -> Shape {
        let normal = Vec3::new(1.0, 0.0, 1.0).normalize();
        Shape {
            positions: vec![Vec3::X, Vec3::new(0.5, 1.0, 0.5), Vec3::Z],
            normals: vec![normal; 3],
            tangents: vec![Vec3::new(1.0, 0.0, -1.0).normalize().extend(1.0); 3],
            ..Shape::default()
        }
    }

    #[test]
    fn normals_stay_perpendicular_and_outside_under_any_scale() {
        for scale in [
            Vec3::new(3.0, 1.0, 0.5),
            Vec3::new(-2.0, 1.0, 1.0),
            Vec3::new(1.0, -1.0, -4.0),
            Vec3::splat(1e-15),
        ] {
            let (p, n, t, mirrored) = place(&slanted(), Placement::Rigid(Affine3A::from_scale(scale)), &[]);
            assert_eq!(mirrored, scale.element_product() < 0.0);
            // The triangle's own plane is the truth; the swap of corners is the caller's.
            let plane = face_normal(p[0], p[1], p[2]) * if mirrored { -1.0 } else { 1.0 };
            let wanted = face_normal(Vec3::X, Vec3::new(0.5, 1.0, 0.5), Vec3::Z);
            let plane = if wanted.dot(slanted().normals[0]) < 0.0 { -plane } else { plane };
            assert!(n[0].dot(plane) > 1.0 - 1e-5, "{scale}: {} against {plane}", n[0]);
            assert!(n[0].dot(t[0].truncate()).abs() < 1e-5);
            // The bitangent is carried along like any direction on the surface.
            let bitangent = slanted().normals[0].cross(slanted().tangents[0].truncate());
            let carried = (bitangent * scale).normalize();
            assert!(n[0].cross(t[0].truncate()).dot(carried) * t[0].w > 0.5, "{scale}");
        }
    }

    #[test]
    fn targets_add_up_by_weight() {
        let lift = Target { positions: vec![Vec3::Y; 3], ..Target::default() };
        let shift = Target { positions: vec![Vec3::X; 3], ..Target::default() };
        let shape = Shape { targets: vec![lift, shift], ..slanted() };
        let (p, ..) = place(&shape, Placement::Rigid(Affine3A::IDENTITY), &[0.5, -2.0]);
        assert_eq!(p[0], Vec3::new(-1.0, 0.5, 0.0));
    }

    #[test]
    fn a_skin_blends_its_joints() {
        let influences = Influences { per_vertex: 2, pairs: [(0, 0.25), (1, 0.75)].repeat(3) };
        let shape = Shape { influences: Some(influences), ..slanted() };
        let joints = [Affine3A::from_translation(Vec3::Y * 4.0), Affine3A::from_translation(Vec3::X * 4.0)];
        let (p, n, ..) = place(&shape, Placement::Skinned(&joints), &[]);
        assert_eq!(p[0], Vec3::X + Vec3::new(3.0, 1.0, 0.0));
        assert!(n[0].abs_diff_eq(slanted().normals[0], 1e-6));
    }

    #[test]
    fn flat_shapes_take_the_normal_of_their_plane() {
        let flat = Shape { flat: true, normals: vec![Vec3::X; 3], ..slanted() };
        let (p, n, ..) = place(&flat, Placement::Rigid(Affine3A::IDENTITY), &[]);
        assert_eq!(n[0], face_normal(p[0], p[1], p[2]));
    }
}
