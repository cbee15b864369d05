//! The CPU half: one triangle as columns, in f64 on the same moved corners, and who wins each cell.
//!
//! Coverage is decided in integers (corners are multiples of 1/256 cell), edges by the rasterizer's top-left rule; the
//! rest has 53 bits where the shader has 24.

use super::{Axes, GRAIN, PREFERENCE, TIE};
use crate::grid::Layout;
use glam::{DVec2, DVec3, I64Vec2, IVec3, Vec3};
use std::collections::HashMap;
use std::ops::Range;

/// A triangle, projected along the axis its normal is longest on.
#[derive(Clone, Copy, Debug)]
pub struct Columns {
    /// The axis columns run along.
    pub axis: usize,
    /// Whether the front looks towards larger depths.
    pub faces_up: bool,
    /// Corners in 1/256 column, in the order that makes the area positive.
    corners: [I64Vec2; 3],
    /// Whether the last two corners changed places for that.
    swapped: bool,
    base: DVec3,
    slope: DVec2,
    /// Distance from the plane per cell of depth.
    steep: f64,
    range: [f64; 2],
}

const AXES: [[usize; 3]; 3] = [[1, 2, 0], [2, 0, 1], [0, 1, 2]];

fn turn(p: DVec3, axis: usize) -> DVec3 {
    DVec3::from(AXES[axis].map(|k| p[k]))
}

fn cross(a: I64Vec2, b: I64Vec2) -> i64 {
    a.x * b.y - a.y * b.x
}

/// Corners of a triangle in cells, moved to the grain, and its normal.
struct Moved {
    corners: [DVec3; 3],
    normal: DVec3,
}

impl Moved {
    /// From corners in the world, m; none where one is no number.
    fn new(layout: &Layout, corners: [Vec3; 3]) -> Option<Self> {
        let moved = corners.map(|p| layout.moved(p));
        // Beyond this, products of integers would overflow; nothing of it is inside any grid.
        if moved.iter().any(|p| !p.is_finite() || p.abs().max_element() > 2.0f32.powi(22)) {
            return None;
        }
        let corners = moved.map(|p| p.as_dvec3());
        Some(Self { corners, normal: (corners[1] - corners[0]).cross(corners[2] - corners[0]) })
    }

    /// The axis the normal is longest on.
    fn dominant(&self) -> usize {
        let (size, preference) = (self.normal.abs(), f64::from(PREFERENCE));
        match () {
            () if size.x * preference >= size.y.max(size.z) => 0,
            () if size.y * preference >= size.z => 1,
            () => 2,
        }
    }
}

impl Columns {
    /// A triangle with corners in the world, m, along the dominant axis first; nothing along axes it has no area on.
    pub fn all(layout: &Layout, corners: [Vec3; 3], axes: Axes) -> Vec<Self> {
        let Some(moved) = Moved::new(layout, corners) else { return Vec::new() };
        let first = moved.dominant();
        let more = match axes {
            Axes::All => vec![(first + 1) % 3, (first + 2) % 3],
            Axes::Dominant => Vec::new(),
        };
        std::iter::once(first).chain(more).filter_map(|axis| Self::along(&moved, axis)).collect()
    }

    fn along(moved: &Moved, axis: usize) -> Option<Self> {
        let normal = turn(moved.normal, axis);
        if normal.z == 0.0 {
            return None;
        }
        let corners = moved.corners;
        let faces_up = normal.z > 0.0;
        let behind = DVec3::Z * if faces_up { -f64::from(TIE) } else { f64::from(TIE) };
        let turned = corners.map(|p| turn(p, axis) + behind);
        let mut flat = turned.map(|p| (p.truncate() * f64::from(GRAIN)).as_i64vec2());
        let swapped = cross(flat[1] - flat[0], flat[2] - flat[0]) < 0;
        if swapped {
            flat.swap(1, 2);
        }
        let depths = turned.map(|p| p.z);
        Some(Self {
            axis,
            faces_up,
            corners: flat,
            swapped,
            base: turned[0],
            slope: -normal.truncate() / normal.z,
            steep: normal.z.abs() / normal.length(),
            range: [depths.into_iter().fold(f64::MAX, f64::min), depths.into_iter().fold(f64::MIN, f64::max)],
        })
    }

    /// Columns `[u, v]` of the grid that the triangle may touch.
    pub fn bounds(&self, layout: &Layout) -> impl Iterator<Item = [i32; 2]> + use<> {
        let [us, vs]: [Range<i32>; 2] = [0, 1].map(|k| {
            let most = layout.cells[AXES[self.axis][k]] as i64;
            let all = self.corners.map(|p| p[k].div_euclid(GRAIN as i64));
            let [low, high] = [all.iter().min(), all.iter().max()].map(|n| n.copied().unwrap_or(0));
            low.clamp(0, most) as i32..(high + 1).clamp(0, most) as i32
        });
        vs.flat_map(move |v| us.clone().map(move |u| [u, v]))
    }

    /// Twice the signed areas beside each edge, opposite to each corner, of a point in 1/256 column.
    fn edges(&self, p: I64Vec2) -> [i64; 3] {
        let [a, b, c] = self.corners;
        [(b, c), (c, a), (a, b)].map(|(from, to)| cross(to - from, p - from))
    }

    fn center(u: i32, v: i32) -> I64Vec2 {
        let grain = GRAIN as i64;
        grain * I64Vec2::new(u.into(), v.into()) + grain / 2
    }

    /// Whether the column's centre is covered; one on an edge belongs to the triangle left of or above which it is not.
    pub fn covers(&self, u: i32, v: i32) -> bool {
        let [a, b, c] = self.corners;
        let edges = self.edges(Self::center(u, v));
        [(b, c), (c, a), (a, b)].iter().zip(edges).all(|((from, to), area)| {
            let d = *to - *from;
            // Rows run downwards: a top edge goes right, a left edge goes up.
            area > 0 || area == 0 && (d.y < 0 || d.y == 0 && d.x > 0)
        })
    }

    /// Weights of the three corners at the column's centre.
    pub fn weights(&self, u: i32, v: i32) -> Vec3 {
        let [a, b, c] = self.edges(Self::center(u, v)).map(|e| e as f64);
        let [b, c] = if self.swapped { [c, b] } else { [b, c] };
        (DVec3::new(a, b, c) / (a + b + c)).as_vec3()
    }

    /// Depth of the plane at the column's centre, cells.
    pub fn depth(&self, u: i32, v: i32) -> f64 {
        let center = DVec2::new(f64::from(u) + 0.5, f64::from(v) + 0.5);
        (self.base.z + self.slope.dot(center - self.base.truncate())).clamp(self.range[0], self.range[1])
    }

    /// Axis, and whether the front looks along it.
    pub fn side(&self) -> (usize, bool) {
        (self.axis, self.faces_up)
    }

    /// The column that a cell is in.
    pub fn column(&self, cell: IVec3) -> [i32; 2] {
        [cell[AXES[self.axis][0]], cell[AXES[self.axis][1]]]
    }

    /// The cell the triangle's plane passes in this column.
    pub fn cell(&self, u: i32, v: i32) -> IVec3 {
        let turned = [u, v, self.depth(u, v).floor() as i32];
        let mut cell = [0; 3];
        for (k, n) in AXES[self.axis].into_iter().zip(turned) {
            cell[k] = n;
        }
        IVec3::from(cell)
    }

    /// Distance of the plane from the cell's centre, cells.
    pub fn miss(&self, u: i32, v: i32) -> f64 {
        let depth = self.depth(u, v);
        self.steep * (depth - depth.floor() - 0.5).abs()
    }

    /// A cell's key; `class` as the module says.
    pub fn key(&self, u: i32, v: i32, class: u32, triangle: u32) -> u32 {
        (class << 30) | (((128.0 * self.miss(u, v)) as u32).min(63) << 24) | triangle
    }

    /// Share of the column that the triangle covers, 0..1.
    pub fn cover(&self, u: i32, v: i32) -> f64 {
        let grain = GRAIN as i64;
        let low = grain * I64Vec2::new(u.into(), v.into());
        let corners = [low, low + I64Vec2::new(grain, 0), low + grain, low + I64Vec2::new(0, grain)];
        let edges = corners.map(|p| self.edges(p));
        if edges.iter().flatten().all(|e| *e >= 0) {
            return 1.0;
        }
        if (0..3).any(|k| edges.iter().all(|e| e[k] <= 0)) {
            return 0.0;
        }
        // The column's square, cut by each edge in turn (Sutherland and Hodgman).
        let mut polygon: Vec<DVec2> = corners.iter().map(|p| (*p - low).as_dvec2() / grain as f64).collect();
        let [a, b, c] = self.corners.map(|p| (p - low).as_dvec2() / grain as f64);
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let side = |p: DVec2| (to - from).perp_dot(p - from);
            let before = std::mem::take(&mut polygon);
            for (i, &p) in before.iter().enumerate() {
                let q = before[(i + 1) % before.len()];
                let (s, t) = (side(p), side(q));
                if s >= 0.0 {
                    polygon.push(p);
                }
                if (s > 0.0) != (t > 0.0) && s != t && s != 0.0 && t != 0.0 {
                    polygon.push(p + (q - p) * (s / (s - t)));
                }
            }
        }
        let doubled: f64 =
            polygon.iter().enumerate().map(|(i, p)| p.perp_dot(polygon[(i + 1) % polygon.len()])).sum();
        0.5 * doubled
    }
}

/// The winner's key of each occupied cell. Triangles are numbered in order, each comes with its class.
pub fn winners(
    layout: &Layout,
    axes: Axes,
    triangles: impl IntoIterator<Item = ([Vec3; 3], u32)>,
) -> HashMap<IVec3, u32> {
    let mut winners = HashMap::new();
    for (number, (corners, class)) in (0..).zip(triangles) {
        for columns in Columns::all(layout, corners, axes) {
            for [u, v] in columns.bounds(layout) {
                let cell = columns.cell(u, v);
                if columns.covers(u, v) && layout.contains(cell) {
                    let key = columns.key(u, v, class, number);
                    winners.entry(cell).and_modify(|least: &mut u32| *least = key.min(*least)).or_insert(key);
                }
            }
        }
    }
    winners
}
