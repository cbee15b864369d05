//! The CPU half: the same tests in f64, without allowance for rounding, over all cells of a triangle's box. The cells of
//! [`Cover::Boxes`] too, which the raster voxelizer finds.

use crate::Cover;
use crate::grid::Layout;
use crate::raster::{PREFERENCE, TIE};
use glam::{DVec3, IVec3, Vec3};

/// Cells by which a triangle must enter a cell of [`Cover::Boxes`], as in `raster/conservative.inc.wgsl`.
const TOUCH: f64 = 1.0 / 4096.0;

/// Of f32 products, with the sums they go into.
const ROUNDING: f64 = 1.0 / 2_097_152.0;

/// A triangle in cells, ready for tests.
#[derive(Clone, Copy, Debug)]
pub struct Sat {
    corners: [DVec3; 3],
    normal: DVec3,
    is_thin: bool,
    /// Half the side of the cube that it must meet, cells.
    half: f64,
    /// The axis the normal is longest on, and whether the front looks along it.
    pub side: (usize, bool),
}

impl Sat {
    /// From corners in the world, m; none without an area or where a corner is no number. Of a cover that is no
    /// [`Cover::Columns`].
    pub fn new(layout: &Layout, corners: [Vec3; 3], cover: Cover) -> Option<Self> {
        let moved = corners.map(|p| layout.moved(p));
        if moved.iter().any(|p| !p.is_finite() || p.abs().max_element() >= 1e18) {
            return None;
        }
        let mut corners = moved.map(|p| p.as_dvec3());
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        let (size, preference) = (normal.abs(), f64::from(PREFERENCE));
        let axis = match () {
            () if size.x * preference >= size.y.max(size.z) => 0,
            () if size.y * preference >= size.z => 1,
            () => 2,
        };
        // A face on a boundary between cells is the one's behind it.
        if matches!(cover, Cover::Thin | Cover::Boxes) {
            for corner in &mut corners {
                corner[axis] -= f64::from(TIE) * normal[axis].signum();
            }
        }
        let side = (axis, normal[axis] > 0.0);
        let is_thin = cover == Cover::Thin;
        let half = if cover == Cover::Boxes { 0.5 - TOUCH } else { 0.5 };
        (size.max_element() > 0.0).then_some(Self { corners, normal, is_thin, half, side })
    }

    /// All tests of the unit cube around a point: by how many cells it passes each, negative where it fails, and how far
    /// the rounding of f32 may be off.
    fn tests(&self, center: DVec3) -> impl Iterator<Item = (f64, f64)> + use<> {
        let corners = self.corners.map(|p| p - center);
        let low = corners[0].min(corners[1]).min(corners[2]);
        let high = corners[0].max(corners[1]).max(corners[2]);
        let (is_thin, half) = (self.is_thin, self.half);
        let norm = move |m: DVec3| if is_thin { m.abs().max_element() } else { m.abs().element_sum() };
        let n = self.normal;
        let edge = |i: usize| corners[(i + 1) % 3] - corners[i];
        let longest = (0..3).map(|i| edge(i).abs().max_element()).fold(0.0, f64::max);
        let boxes = (half - low).min_element().min((high + half).min_element());
        // Where thin, boxes that only touch do not overlap.
        let boxes = if is_thin && boxes == 0.0 { -f64::EPSILON } else { boxes };
        let plane = (half * norm(n) - n.dot(corners[0]).abs()) / n.length();
        // What cancels in a normal is a product of edges; 2^-21 of it, as all other products.
        let cancelled = ROUNDING * longest * longest * corners[0].abs().element_sum() / n.length();
        let edges = (0..9).filter_map(move |k| {
            let (axis, i) = (k / 3, k % 3);
            let [x, y] = [(axis + 1) % 3, (axis + 2) % 3];
            let (from, e) = (corners[i], edge(i));
            let m = DVec3::new(-e[y], e[x], 0.0) * if n[axis] >= 0.0 { 1.0 } else { -1.0 };
            let inside = -(m.x * from[x] + m.y * from[y]) + half * norm(m);
            let rounding = ROUNDING * ((e[y] * from[x]).abs() + (e[x] * from[y]).abs());
            // An edge along the axis is a point in this projection, and separates nothing.
            (m.length() > 0.0).then(|| (inside / m.length(), rounding / m.length()))
        });
        [(boxes, 0.0), (plane, cancelled)].into_iter().chain(edges.collect::<Vec<_>>())
    }

    /// By how many cells the triangle and the unit cube around a point overlap, along the axis that separates them most;
    /// negative where they do not. A thin triangle's is that of its core.
    pub fn overlap(&self, center: DVec3) -> f64 {
        self.tests(center).map(|(overlap, _)| overlap).fold(f64::MAX, f64::min)
    }

    /// Whether f32 may decide otherwise, with an allowance of so many cells.
    pub fn is_close(&self, center: DVec3, allowance: f64) -> bool {
        self.tests(center).any(|(overlap, rounding)| overlap.abs() <= rounding + allowance)
    }

    /// Distance from a point that decides who wins its cell: of the plane, or of the triangle in [`Cover::Boxes`]. Cells.
    pub fn miss(&self, center: DVec3) -> f64 {
        let unit = self.normal.normalize();
        let above = unit.dot(self.corners[0] - center);
        let edges =
            [0, 1, 2].map(|i| (self.corners[i] - center, self.corners[(i + 1) % 3] - self.corners[i]));
        let is_over = |(from, e): &(DVec3, DVec3)| unit.dot(e.cross(-*from)) >= 0.0;
        if self.half == 0.5 || edges.iter().all(is_over) {
            return above.abs();
        }
        let to_edge = |(from, e): (DVec3, DVec3)| {
            (from + (-from.dot(e) / e.length_squared()).clamp(0.0, 1.0) * e).length()
        };
        edges.into_iter().filter(|(_, e)| *e != DVec3::ZERO).map(to_edge).fold(f64::MAX, f64::min)
    }

    /// Cells of the grid that the triangle may set: those of its box near its plane.
    pub fn candidates(&self, layout: &Layout) -> impl Iterator<Item = IVec3> + use<> {
        let axis = self.side.0;
        let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
        let range = |corners: [f64; 3], most: u32| {
            let low = corners.into_iter().fold(f64::MAX, f64::min) - 1.0;
            let high = corners.into_iter().fold(f64::MIN, f64::max) + 1.0;
            low.floor().clamp(0.0, most.into()) as i32..high.ceil().clamp(0.0, most.into()) as i32
        };
        let of = |k: usize| range(self.corners.map(|p| p[k]), layout.cells[k]);
        let (us, vs, (n, corner)) = (of(u), of(v), (self.normal, self.corners[0]));
        let most = layout.cells[axis];
        vs.flat_map(move |y| us.clone().map(move |x| [x, y])).flat_map(move |[x, y]| {
            let across = n[u] * (f64::from(x) + 0.5 - corner[u]) + n[v] * (f64::from(y) + 0.5 - corner[v]);
            let depth = corner[axis] - across / n[axis];
            // The plane is at most 3/2 cells of depth from the centre of a cell it meets.
            range([depth - 1.5, depth, depth + 1.5], most).map(move |z| {
                let mut cell = IVec3::ZERO;
                (cell[u], cell[v], cell[axis]) = (x, y, z);
                cell
            })
        })
    }

    /// Cells that the triangle sets.
    pub fn cells(&self, layout: &Layout) -> impl Iterator<Item = IVec3> + use<> {
        let sat = *self;
        self.candidates(layout).filter(move |cell| sat.overlap(cell.as_dvec3() + 0.5) >= 0.0)
    }

    /// A cell's key; `class` as [`crate::raster`] says.
    pub fn key(&self, cell: IVec3, class: u32, triangle: u32) -> u32 {
        let steps = if self.is_thin { super::STEPS_THIN } else { super::STEPS_CONSERVATIVE };
        let nearness = (f64::from(steps) * self.miss(cell.as_dvec3() + 0.5)) as u32;
        (class << 30) | (nearness.min(63) << 24) | triangle
    }
}
