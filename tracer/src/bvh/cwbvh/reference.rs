//! The CPU half: the same elements, the same steps in the same order, f32 throughout. What may differ is that a driver
//! fuses products and sums in the triangle test, or divides less exactly.

use super::STACK;
use crate::bvh::{BvhParams, MOST_VISITS};
use glam::{BVec3, Vec2, Vec3};

const LEAST: f32 = 1e-20;
/// 1 - 2^-21.
const NEARER: f32 = 1.0 - 4.0 * f32::EPSILON;

/// As `BvhHit`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Hit {
    pub(super) triangle: u32,
    pub(super) distance: f32,
    pub(super) weights: Vec2,
    pub(super) visits: u32,
    pub(super) cut: bool,
}

/// As `BvhRay`.
struct Ray {
    origin: Vec3,
    inverse: Vec3,
    axis: usize,
    shear: Vec3,
    skip: u32,
}

fn turned(v: Vec3, axis: usize) -> Vec3 {
    match axis {
        0 => Vec3::new(v.y, v.z, v.x),
        1 => Vec3::new(v.z, v.x, v.y),
        _ => v,
    }
}

impl Ray {
    fn new(origin: Vec3, direction: Vec3, skip: u32) -> Self {
        let a = direction.abs();
        let axis = match a {
            _ if a.x >= a.y && a.x > a.z => 0,
            _ if a.y > a.z => 1,
            _ => 2,
        };
        let d = turned(direction, axis);
        let least = Vec3::select(direction.cmpge(Vec3::ZERO), Vec3::splat(LEAST), Vec3::splat(-LEAST));
        let kept = Vec3::select(a.cmplt(Vec3::splat(LEAST)), least, direction);
        Self { origin, inverse: 1.0 / kept, axis, shear: Vec3::new(d.x, d.y, 1.0) / d.z, skip }
    }
}

/// The nodes and triangles that the GPU has.
pub(super) struct CpuCwbvh {
    pub(super) elements: Vec<[u32; 4]>,
    pub(super) params: BvhParams,
}

impl CpuCwbvh {
    /// As `bvh_closest`.
    pub(super) fn closest(&self, origin: Vec3, direction: Vec3, t_max: f32, skip: u32) -> Hit {
        let ray = Ray::new(origin, direction, skip);
        let back = ray.inverse.cmplt(Vec3::ZERO);
        let octant: u32 =
            [4, 2, 1].iter().zip(<[bool; 3]>::from(back)).map(|(bit, b)| if b { 0 } else { *bit }).sum();
        let mut hit = Hit { triangle: u32::MAX, distance: t_max, weights: Vec2::ZERO, visits: 0, cut: false };
        let mut nodes: [u32; 2] = [0, if self.params.node_count > 0 { 0x8000_0000 } else { 0 }];
        let mut stack = Vec::new();
        loop {
            if nodes[1] < 0x100_0000 {
                match stack.pop() {
                    Some(popped) => nodes = popped,
                    None => break,
                }
            }
            if hit.visits == MOST_VISITS {
                hit.cut = true;
                break;
            }
            hit.visits += 1;
            let first = 31 - nodes[1].leading_zeros();
            let rest = nodes[1] & !(1 << first);
            if rest >= 0x100_0000 {
                stack.push([nodes[0], rest]);
                assert!(stack.len() <= STACK as usize);
            }
            let slot: u32 = (first - 24) ^ octant;
            let index = nodes[0] + (nodes[1] & !(u32::MAX << slot)).count_ones();
            let mut triangles;
            [nodes, triangles] = self.visit(&ray, back, octant, index, hit.distance);
            while triangles[1] != 0 {
                let bit = 31 - triangles[1].leading_zeros();
                triangles[1] &= !(1 << bit);
                self.triangle(&ray, triangles[0] + bit, &mut hit);
            }
        }
        hit
    }

    /// As `cwbvh_visit`: nodes and triangles met.
    fn visit(&self, ray: &Ray, back: BVec3, octant: u32, index: u32, t_max: f32) -> [[u32; 2]; 2] {
        let node: [[u32; 4]; 5] = std::array::from_fn(|i| self.elements[5 * index as usize + i]);
        let [head, slots, ..] = node;
        let byte = |words: [u32; 2], i: usize| words[i / 4].to_le_bytes()[i % 4];
        let mut met = 0;
        for slot in 0..8 {
            let (mut enter, mut leave) = (0.0_f32, t_max);
            for axis in 0..3 {
                let [a, b, c, d] = node[2 + axis];
                let (near, far) = if back.test(axis) { ([c, d], [a, b]) } else { ([a, b], [c, d]) };
                let low = f32::from_bits(head[axis]);
                let step = f32::from_bits(u32::from(head[3].to_le_bytes()[axis]) << 23);
                let plane = |q: u8| (low + f32::from(q) * step - ray.origin[axis]) * ray.inverse[axis];
                enter = enter.max(plane(byte(near, slot)));
                leave = leave.min(plane(byte(far, slot)));
            }
            if enter * NEARER <= leave {
                let kind = u32::from(byte([slots[2], slots[3]], slot));
                let is_node = ((kind & (kind << 1)) >> 4) & 1;
                met |= (kind >> 5) << ((kind ^ (is_node * octant)) & 31);
            }
        }
        [[slots[0], (met & 0xff00_0000) | (head[3] >> 24)], [slots[1], met & 0xff_ffff]]
    }

    /// As `bvh_triangle`.
    fn triangle(&self, ray: &Ray, place: u32, hit: &mut Hit) {
        let at = (self.params.triangles_at + 3 * place) as usize;
        let number = self.elements[at][3];
        let [a, b, c] = [0, 1, 2].map(|i| {
            let [x, y, z, _] = self.elements[at + i].map(f32::from_bits);
            turned(Vec3::new(x, y, z) - ray.origin, ray.axis)
        });
        let [a2, b2, c2] = [a, b, c].map(|v| v.truncate() - ray.shear.truncate() * v.z);
        let [u, v, w] = [edge(c2, b2), edge(a2, c2), edge(b2, a2)];
        let det = u + v + w;
        let inside = (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
        let (low, high) = (a2.min(b2).min(c2), a2.max(b2).max(c2));
        let around = low.cmple(Vec2::ZERO).all() && high.cmpge(Vec2::ZERO).all();
        if !inside || !around || det == 0.0 || number == ray.skip {
            return;
        }
        let distance = ray.shear.z * (u * a.z + v * b.z + w * c.z) / det;
        let nearer = distance < hit.distance || (distance == hit.distance && number < hit.triangle);
        if distance > 0.0 && nearer {
            hit.triangle = number;
            hit.distance = distance;
            hit.weights = Vec2::new(v, w) / det;
        }
    }
}

fn edge(a: Vec2, b: Vec2) -> f32 {
    let swapped = a.x > b.x || (a.x == b.x && a.y > b.y);
    let (p, q) = if swapped { (b, a) } else { (a, b) };
    let area = p.x * q.y - p.y * q.x;
    match a == b {
        true => 0.0,
        false if swapped => -area,
        false => area,
    }
}
