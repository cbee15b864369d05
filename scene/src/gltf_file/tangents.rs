//! Tangents where the file has none and the material needs them: MikkTSpace, as the format asks.
//!
//! MikkTSpace wants v to point up; glTF's points down, so it gets 1 - v and its signs are glTF's. Vertices whose
//! triangles disagree (mirrored or cut textures) are split.

use crate::Material;
use bevy_mikktspace::TangentSpace;
use glam::{Vec2, Vec3, Vec4};
use std::collections::HashMap;

/// Beyond this, products of coordinates leave the range of floats; such meshes get any tangents.
const LARGEST_COORDINATE: f32 = 1e9;

/// Triangles around one point that MikkTSpace may see: it recurses once for each and compares each with each.
const MOST_AROUND: u32 = 512;

/// The texture coordinates that a material's tangents follow; none where it needs no tangents.
pub(super) fn uv_set(material: &Material) -> Option<u32> {
    let anisotropy = material.anisotropy_texture.filter(|_| material.anisotropy > 0.0);
    let height = material.height.map(|h| h.texture);
    let slot = material.normal_texture.or(anisotropy).or(height);
    slot.map(|slot| slot.uv_set).or((material.anisotropy > 0.0).then_some(0))
}

/// Vertices after splitting.
pub(super) struct Split {
    /// Old vertex of each new one.
    pub order: Vec<u32>,
    /// One per new vertex; 0 where the texture gives no direction.
    pub tangents: Vec<Vec4>,
    /// Of new vertices, in the old order.
    pub triangles: Vec<[u32; 3]>,
}

/// Tangents for every corner, equal ones of a vertex joined again.
pub(super) fn generate(positions: &[Vec3], normals: &[Vec3], uvs: &[Vec2], triangles: &[[u32; 3]]) -> Split {
    let corners = vec![Vec4::ZERO; 3 * triangles.len()];
    let mut mesh = Mesh { positions, normals, uvs, triangles, smooth: Vec::new(), corners };
    let positions_fit = positions.iter().all(|p| p.abs().max_element() < LARGEST_COORDINATE);
    let uvs_fit =
        uvs.len() == positions.len() && uvs.iter().all(|uv| uv.abs().max_element() < LARGEST_COORDINATE);
    if positions_fit && uvs_fit {
        mesh.leave_crowds_out();
        // Its error type has no values.
        let _ = bevy_mikktspace::generate_tangents(&mut mesh);
    }
    let corners = mesh.corners;

    let count = positions.len();
    let mut order: Vec<u32> = (0..count as u32).collect();
    let mut tangents: Vec<Option<Vec4>> = vec![None; count];
    let mut more: HashMap<(u32, [u32; 4]), u32> = HashMap::new();
    let mut split = triangles.to_vec();
    for (v, tangent) in split.as_flattened_mut().iter_mut().zip(corners) {
        let first = *tangents[*v as usize].get_or_insert(tangent);
        if first != tangent {
            *v = *more.entry((*v, tangent.to_array().map(f32::to_bits))).or_insert_with(|| {
                order.push(*v);
                tangents.push(Some(tangent));
                order.len() as u32 - 1
            });
        }
    }
    let tangents = tangents.into_iter().map(|t| t.unwrap_or(Vec4::ZERO)).collect();
    Split { order, tangents, triangles: split }
}

struct Mesh<'a> {
    positions: &'a [Vec3],
    normals: &'a [Vec3],
    uvs: &'a [Vec2],
    triangles: &'a [[u32; 3]],
    /// The triangles that MikkTSpace sees.
    smooth: Vec<usize>,
    corners: Vec<Vec4>,
}

impl Mesh<'_> {
    /// Keeps triangles around very crowded points from MikkTSpace; each follows its own texture.
    fn leave_crowds_out(&mut self) {
        let key = |v: u32| self.positions[v as usize].to_array().map(f32::to_bits);
        let mut around: HashMap<[u32; 3], u32> = HashMap::new();
        for &v in self.triangles.as_flattened() {
            *around.entry(key(v)).or_default() += 1;
        }
        let crowded = |t: &[u32; 3]| t.iter().any(|&v| around.get(&key(v)).is_some_and(|&n| n > MOST_AROUND));
        let (crowds, smooth) = (0..self.triangles.len()).partition(|&t| crowded(&self.triangles[t]));
        self.smooth = smooth;
        let crowds: Vec<usize> = crowds;
        for t in crowds {
            let tangent = self.gradient(self.triangles[t]);
            self.corners[3 * t..3 * t + 3].fill(tangent);
        }
    }

    /// Where u grows on a triangle, and 1 where its texture is not mirrored, else -1.
    fn gradient(&self, triangle: [u32; 3]) -> Vec4 {
        let [a, b, c] = triangle.map(|v| (self.positions[v as usize], self.uvs[v as usize]));
        let ((ab, ac), (s, t)) = ((b.0 - a.0, c.0 - a.0), (b.1 - a.1, c.1 - a.1));
        // v points down, so an area that is negative in (u, v) is not mirrored.
        let sign = if s.perp_dot(t) < 0.0 { 1.0 } else { -1.0 };
        let along = -sign * (t.y * ab - s.y * ac);
        along.normalize_or_zero().extend(sign)
    }

    fn vertex(&self, face: usize, corner: usize) -> usize {
        self.triangles[self.smooth[face]][corner] as usize
    }
}

impl bevy_mikktspace::Geometry for Mesh<'_> {
    fn num_faces(&self) -> usize {
        self.smooth.len()
    }

    fn num_vertices_of_face(&self, _face: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.positions[self.vertex(face, corner)].into()
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        self.normals[self.vertex(face, corner)].into()
    }

    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        let uv = self.uvs[self.vertex(face, corner)];
        [uv.x, 1.0 - uv.y]
    }

    fn set_tangent(&mut self, tangent: Option<TangentSpace>, face: usize, corner: usize) {
        let tangent = tangent.map_or(Vec4::ZERO, |t| Vec4::from(t.tangent_encoded()));
        self.corners[3 * self.smooth[face] + corner] = if tangent.is_finite() { tangent } else { Vec4::ZERO };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: [Vec3; 4] = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y];
    const TRIANGLES: [[u32; 3]; 2] = [[0, 1, 2], [0, 2, 3]];

    fn tangents(uvs: [Vec2; 4]) -> Split {
        generate(&SQUARE, &[Vec3::Z; 4], &uvs, &TRIANGLES)
    }

    #[test]
    fn an_upright_texture_has_its_tangent_along_x_and_its_bitangent_up() {
        // v points down in glTF: the top edge (y = 1) has v = 0.
        let split = tangents([Vec2::new(0.0, 1.0), Vec2::ONE, Vec2::new(1.0, 0.0), Vec2::ZERO]);
        assert_eq!(split.order.len(), 4, "no vertex is split");
        assert!(
            split.tangents.iter().all(|t| t.abs_diff_eq(Vec4::new(1.0, 0.0, 0.0, 1.0), 1e-6)),
            "{:?}",
            split.tangents
        );
    }

    #[test]
    fn a_mirrored_texture_turns_the_handedness() {
        let split = tangents([Vec2::ONE, Vec2::new(0.0, 1.0), Vec2::ZERO, Vec2::new(1.0, 0.0)]);
        assert!(
            split.tangents.iter().all(|t| t.abs_diff_eq(Vec4::new(-1.0, 0.0, 0.0, -1.0), 1e-6)),
            "{:?}",
            split.tangents
        );
    }

    #[test]
    fn a_seam_between_mirrored_halves_is_split() {
        // A fan of two triangles whose textures mirror each other along their shared edge 0-2.
        let uvs = [Vec2::new(0.5, 1.0), Vec2::new(0.0, 1.0), Vec2::new(0.5, 0.0), Vec2::new(0.0, 0.0)];
        let split = tangents(uvs);
        assert_eq!(split.order.len(), 6);
        let signs: Vec<f32> =
            split.triangles.as_flattened().iter().map(|&v| split.tangents[v as usize].w).collect();
        assert_eq!(signs, [-1.0, -1.0, -1.0, 1.0, 1.0, 1.0]);
    }

    #[test]
    fn crowded_points_follow_the_texture_too() {
        // A disc of 2,000 triangles around one point, its texture laid flat over it, upright and mirrored.
        let rim = |i: u32| Vec2::from_angle(i as f32 * std::f32::consts::TAU / 2000.0);
        let flat: Vec<Vec2> = std::iter::once(Vec2::ZERO).chain((0..2000).map(rim)).collect();
        let positions: Vec<Vec3> = flat.iter().map(|p| p.extend(0.0)).collect();
        let triangles: Vec<[u32; 3]> = (0..2000).map(|i| [0, 1 + i, 1 + (i + 1) % 2000]).collect();
        for side in [1.0, -1.0] {
            let uvs: Vec<Vec2> = flat.iter().map(|p| Vec2::new(side * p.x, -p.y)).collect();
            let split = generate(&positions, &vec![Vec3::Z; 2001], &uvs, &triangles);
            let wanted = Vec4::new(side, 0.0, 0.0, side);
            // 1e-3: differences of neighbours 0.003 apart, in f32.
            assert!(split.tangents.iter().all(|t| t.abs_diff_eq(wanted, 1e-3)), "{side}");
        }
    }

    #[test]
    fn textures_without_area_or_range_give_no_direction_and_no_nan() {
        for uv in [Vec2::ZERO, Vec2::splat(1e30)] {
            let split = tangents([uv; 4]);
            assert!(split.tangents.iter().all(|t| t.is_finite()));
        }
        assert!(generate(&SQUARE, &[Vec3::Z; 4], &[], &TRIANGLES).tangents.iter().all(|t| *t == Vec4::ZERO));
    }
}
