//! `--move SHARE`: every k-th connected part circles, for scenes that have no animation of their own.
//!
//! Triangles of an object hang together where they share a corner's position. Parts are counted in the order of
//! the geometry's objects and, inside an object, of their first triangles; of every k = round(1 / SHARE) parts the
//! last one circles. An object that already moves counts as one part and keeps its own motion too.
//! Phase: at time 0 every part is where the file puts it, on the +X side of its circle, and starts towards +Z:
//! offset(t) = r (cos wt - 1, 0, sin wt), r = 0.5 m, w = pi / s.

use super::Mover;
use crate::{Aabb, Geometry, Object, Scene, Triangle};
use glam::Vec3;
use std::collections::HashMap;
use std::f32::consts::TAU;

/// Metres.
const RADIUS: f32 = 0.5;
/// Seconds for one turn.
pub(super) const TURN_S: f32 = 2.0;

/// Where a circling part is at `time` seconds, from where the file puts it.
pub(super) fn offset(time: f32) -> Vec3 {
    let (sin, cos) = (TAU * (time / TURN_S).fract()).sin_cos();
    if sin.is_finite() { RADIUS * Vec3::new(cos - 1.0, 0.0, sin) } else { Vec3::ZERO }
}

/// All places that a circling box reaches.
pub(super) fn swept(part: Aabb) -> Aabb {
    if part.is_empty() {
        return part;
    }
    Aabb {
        min: part.min - RADIUS * Vec3::new(2.0, 0.0, 1.0),
        max: part.max + RADIUS * Vec3::new(0.0, 0.0, 1.0),
    }
}

/// Makes every k-th connected part circle, k = round(1 / `share`) and at least 1; a share of 0 or less moves nothing.
/// Parts that circle are split out of static objects into objects of their own, after all static ones.
pub(crate) fn circle(scene: &mut Scene, share: f32) {
    if share.is_nan() || share <= 0.0 {
        return;
    }
    let every = (1.0 / share).round().max(1.0) as usize;
    let rest = std::mem::take(&mut scene.rest);
    let first_moving = rest.static_object_count();
    let mut count = 0;
    let mut chosen = || {
        count += 1;
        count % every == 0
    };

    // Static objects: what stays, and what leaves as (object, its triangles).
    let mut split = Split::new(&rest);
    let mut leaving: Vec<(usize, Vec<Triangle>)> = Vec::new();
    for (index, object) in rest.objects[..first_moving].iter().enumerate() {
        let triangles = &rest.triangles[object.triangles.start as usize..object.triangles.end as usize];
        let (parts, part_of) = connected_parts(&rest, triangles);
        let own: Vec<Option<usize>> = (0..parts)
            .map(|_| {
                chosen().then(|| {
                    leaving.push((index, Vec::new()));
                    leaving.len() - 1
                })
            })
            .collect();
        let mut staying = Vec::new();
        for (triangle, part) in triangles.iter().zip(part_of) {
            match own[part] {
                Some(at) => leaving[at].1.push(*triangle),
                None => staying.push(*triangle),
            }
        }
        if parts == 0 || !staying.is_empty() {
            split.push(object, used(&staying), &staying, false);
        }
    }
    for (index, object) in rest.objects.iter().enumerate().skip(first_moving) {
        let triangles = &rest.triangles[object.triangles.start as usize..object.triangles.end as usize];
        split.push(object, object.vertices.clone().collect(), triangles, true);
        if chosen()
            && let Some(mover) = scene.motion.movers.get_mut(index - first_moving)
        {
            mover.circles = true;
        }
    }
    for (index, triangles) in leaving {
        split.push(&rest.objects[index], used(&triangles), &triangles, true);
        scene.motion.movers.push(Mover { part: None, mirrored: false, circles: true });
    }
    scene.rest = split.geometry;
    scene.rest.lights = rest.lights;
    scene.bounds = scene.motion.bounds(&scene.rest);
}

/// Number of connected parts, and the part of each triangle; parts are numbered by their first triangle.
fn connected_parts(geometry: &Geometry, triangles: &[Triangle]) -> (usize, Vec<usize>) {
    let mut parent: Vec<usize> = (0..triangles.len()).collect();
    let mut first_at: HashMap<[u32; 3], usize> = HashMap::with_capacity(triangles.len());
    for (t, triangle) in triangles.iter().enumerate() {
        for corner in geometry.corners(triangle) {
            // + 0.0 makes the two zeros one.
            let key = (corner + 0.0).to_array().map(f32::to_bits);
            let other = *first_at.entry(key).or_insert(t);
            let (a, b) = (root(&mut parent, t), root(&mut parent, other));
            // The lower index stays the root, so that roots are first triangles.
            parent[a.max(b)] = a.min(b);
        }
    }
    let mut number = HashMap::new();
    let part_of = (0..triangles.len())
        .map(|t| {
            let next = number.len();
            *number.entry(root(&mut parent, t)).or_insert(next)
        })
        .collect();
    (number.len(), part_of)
}

/// The representative of `t`, halving the path on the way.
fn root(parent: &mut [usize], mut t: usize) -> usize {
    while parent[t] != t {
        parent[t] = parent[parent[t]];
        t = parent[t];
    }
    t
}

/// A geometry rebuilt object by object.
struct Split<'a> {
    source: &'a Geometry,
    geometry: Geometry,
}

impl<'a> Split<'a> {
    fn new(source: &'a Geometry) -> Self {
        Self { source, geometry: Geometry::default() }
    }

    /// Appends some triangles of an object and some of its vertices (ascending, all that the triangles use).
    fn push(&mut self, object: &Object, order: Vec<u32>, triangles: &[Triangle], moving: bool) {
        let first_vertex = self.geometry.positions.len() as u32;
        let first_triangle = self.geometry.triangles.len() as u32;
        let number = self.geometry.objects.len() as u32;
        for triangle in triangles {
            let vertices = triangle.vertices.map(|v| first_vertex + order.partition_point(|&u| u < v) as u32);
            self.geometry.triangles.push(Triangle { vertices, object: number, ..*triangle });
        }
        let (from, to) = (self.source, &mut self.geometry);
        gather(&from.positions, &order, &mut to.positions);
        gather(&from.normals, &order, &mut to.normals);
        gather(&from.tangents, &order, &mut to.tangents);
        gather(&from.uv0, &order, &mut to.uv0);
        gather(&from.uv1, &order, &mut to.uv1);
        gather(&from.colors, &order, &mut to.colors);
        to.objects.push(Object {
            name: object.name.clone(),
            vertices: first_vertex..to.positions.len() as u32,
            triangles: first_triangle..to.triangles.len() as u32,
            moving,
        });
    }
}

/// The vertices of some triangles, ascending.
fn used(triangles: &[Triangle]) -> Vec<u32> {
    let mut vertices: Vec<u32> = triangles.iter().flat_map(|t| t.vertices).collect();
    vertices.sort_unstable();
    vertices.dedup();
    vertices
}

/// Appends the named elements; a list that a geometry does without stays empty.
fn gather<T: Copy>(from: &[T], order: &[u32], to: &mut Vec<T>) {
    if !from.is_empty() {
        to.extend(order.iter().map(|&v| from[v as usize]));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Material, Sky};
    use glam::{Vec2, Vec4};

    /// One object of `parts` separate quads, each of two triangles that share no index but two positions.
    fn quads(parts: u32) -> Scene {
        let mut g = Geometry::default();
        for part in 0..parts {
            let at = Vec3::X * 10.0 * part as f32;
            for corners in [[Vec3::ZERO, Vec3::X, Vec3::Y], [Vec3::Y, Vec3::X, Vec3::ONE]] {
                let base = g.positions.len() as u32;
                g.positions.extend(corners.map(|c| at + c));
                g.triangles.push(Triangle { vertices: [base, base + 1, base + 2], material: 0, object: 0 });
            }
        }
        let n = g.positions.len();
        (g.normals, g.tangents, g.uv0) = (vec![Vec3::Z; n], vec![Vec4::X; n], vec![Vec2::ZERO; n]);
        g.objects.push(Object {
            name: "quads".into(),
            vertices: 0..n as u32,
            triangles: 0..2 * parts,
            moving: false,
        });
        Scene::assemble("quads", vec![Material::default()], vec![], g, vec![], Sky::Constant(Vec3::ZERO))
    }

    #[test]
    fn every_kth_part_leaves_whole() {
        let mut scene = quads(7);
        scene.set_moving(1.0 / 3.0);
        let rest = scene.rest().clone();
        assert_eq!(rest.triangles.len(), 14);
        assert_eq!(rest.static_object_count(), 1);
        let moving: Vec<f32> =
            rest.objects[1..].iter().map(|o| rest.positions[o.vertices.start as usize].x / 10.0).collect();
        assert_eq!(moving, [2.0, 5.0], "parts 3 and 6 of 7");
        assert_eq!(rest.static_triangle_count(), 10);
        assert!(rest.triangles.iter().all(|t| {
            let o = &rest.objects[t.object as usize];
            t.vertices.iter().all(|v| o.vertices.contains(v))
        }));
    }

    #[test]
    fn a_turn_takes_two_seconds_around_half_a_metre() {
        let mut scene = quads(1);
        let bounds = scene.bounds();
        scene.set_moving(1.0);
        let rest = scene.rest().clone();
        let mut posed = rest.clone();
        // 1e-6: sine and cosine of a multiple of pi/2 in f32, times 0.5.
        for (time, offset) in
            [(0.0, Vec3::ZERO), (0.5, Vec3::new(-0.5, 0.0, 0.5)), (1.0, Vec3::NEG_X), (2.0, Vec3::ZERO)]
        {
            scene.pose(time, &mut posed);
            assert!(posed.positions[0].abs_diff_eq(rest.positions[0] + offset, 1e-6), "at {time} s");
            assert!(
                posed
                    .positions
                    .iter()
                    .all(|p| p.clamp(scene.bounds().min - 1e-6, scene.bounds().max + 1e-6) == *p)
            );
        }
        assert_eq!(scene.bounds().size(), bounds.size() + Vec3::new(1.0, 0.0, 1.0));
        assert_eq!(scene.duration(), 2.0);
        assert!(scene.needs().motion);
    }

    #[test]
    fn nothing_moves_for_no_share() {
        let mut scene = quads(3);
        scene.set_moving(0.0);
        scene.set_moving(f32::NAN);
        assert!(!scene.needs().motion);
        assert_eq!(scene.rest().objects.len(), 1);
    }
}
