//! Casts lines against an emitter's triangles: a small tree of boxes, split in the middle of the list.

use glam::Vec3;
use std::ops::Range;

/// Triangles per leaf.
const LEAF: usize = 4;

struct Node {
    low: Vec3,
    high: Vec3,
    /// Of the triangles below; a leaf's are tested.
    triangles: Range<usize>,
    /// The second child; the first is the next node. 0 in a leaf.
    second: usize,
}

/// Triangles that lines can be cast against.
pub(super) struct Tree {
    triangles: Vec<[Vec3; 3]>,
    nodes: Vec<Node>,
}

impl Tree {
    pub(super) fn new(triangles: Vec<[Vec3; 3]>) -> Self {
        let mut tree = Self { nodes: Vec::new(), triangles };
        tree.split(0..tree.triangles.len());
        tree
    }

    /// Halves a range of triangles until leaves are left; the depth is the logarithm of the count.
    fn split(&mut self, range: Range<usize>) {
        let points = || self.triangles[range.clone()].iter().flatten();
        let low = points().copied().reduce(Vec3::min).unwrap_or(Vec3::ZERO);
        let high = points().copied().reduce(Vec3::max).unwrap_or(Vec3::ZERO);
        let node = self.nodes.len();
        self.nodes.push(Node { low, high, triangles: range.clone(), second: 0 });
        if range.len() <= LEAF {
            return;
        }
        let axis = (high - low).max_position();
        let middle = range.len() / 2;
        self.triangles[range.clone()]
            .select_nth_unstable_by(middle, |a, b| center(a)[axis].total_cmp(&center(b)[axis]));
        let middle = range.start + middle;
        self.split(range.start..middle);
        self.nodes[node].second = self.nodes.len();
        self.split(middle..range.end);
    }

    /// Whether the first triangle along a line turns its front to it; none where it meets no triangle.
    pub(super) fn meets_front(&self, o: Vec3, d: Vec3) -> Option<bool> {
        // Zero components give infinities, which order correctly but for 0 * inf on a box's very face.
        let inverse = 1.0 / d;
        let (mut nearest, mut front, mut stack) = (f32::MAX, None, vec![0]);
        while let Some(index) = stack.pop() {
            let node = &self.nodes[index];
            let (a, b) = ((node.low - o) * inverse, (node.high - o) * inverse);
            let (enter, leave) = (a.min(b).max_element(), a.max(b).min_element());
            if enter > leave || enter > nearest || leave < 0.0 {
                continue;
            }
            if node.second != 0 {
                stack.extend([node.second, index + 1]);
                continue;
            }
            for triangle in &self.triangles[node.triangles.clone()] {
                if let Some((t, is_front)) = meet(triangle, o, d)
                    && t < nearest
                {
                    (nearest, front) = (t, Some(is_front));
                }
            }
        }
        front
    }
}

fn center(triangle: &[Vec3; 3]) -> Vec3 {
    triangle[0] + triangle[1] + triangle[2]
}

/// Distance, and whether the front is met (Möller and Trumbore 1997).
fn meet(&[a, b, c]: &[Vec3; 3], o: Vec3, d: Vec3) -> Option<(f32, bool)> {
    let (ab, ac) = (b - a, c - a);
    let p = d.cross(ac);
    let determinant = ab.dot(p);
    if determinant == 0.0 {
        return None;
    }
    let from = o - a;
    let u = from.dot(p) / determinant;
    let q = from.cross(ab);
    let v = d.dot(q) / determinant;
    let t = ac.dot(q) / determinant;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t >= 0.0).then_some((t, determinant > 0.0))
}
