//! How much light an emitter gives off, as triangles and as voxels, counted along random lines.
//!
//! In: the emitter's triangles and its voxels alone, in cells. Out: the factor that makes the voxels' light the
//! triangles'.
//!
//! Among uniform isotropic lines through a convex body of surface S, the mean number of times that a line first meets the
//! front of a surface whose light leaves like that of area A is `A / S` (Cauchy and Crofton). With m the mean of what
//! lines meet first in the voxels, the share of a voxel whose normal is turned to the line or else 0, the voxels' area is
//! `S m`; with f the mean number of fronts met first in the triangles, theirs is `S f`. The factor is `f / m`.
//!
//! - What shines from one part of the emitter to another never leaves it, in triangles as in voxels (a row of voxels is a
//!   staircase that shades itself). So only what a line meets first counts.
//! - A surface whose light hardly leaves, `S f` below 1/8 of its area, is a room: rays start inside. Each of them
//!   meets one voxel, and its radiance is right without a factor, which is 1.
//! - The body is a box around the voxels, turned with the largest triangle, and not a sphere: a long lamp is met by a
//!   third of the lines and not by one in hundreds. Lines start uniformly on its faces, with a density proportional to
//!   the cosine inwards. Their numbers are an additive recurrence in five dimensions, shifted by the seed.

use super::cast::Tree;
use crate::grid::Layout;
use crate::grid::reference::CpuGrid;
use glam::{IVec3, Mat3, Vec3};

/// Powers of the root of x^6 = x + 1: the recurrence whose points are spread most evenly (Roberts 2018).
const ROOT: f64 = 1.134_724_138_401_519_4;

/// Below this share of a surface's light, what leaves it says nothing about it.
const LEAST_LEAVING: f64 = 1.0 / 8.0;

/// A voxel of an emitter.
#[derive(Clone, Copy, Debug)]
pub struct Lit {
    /// Within the scene's grid.
    pub cell: IVec3,
    /// Unit, on the front side.
    pub normal: Vec3,
    /// Emission as a share of the surface's.
    pub share: f32,
}

/// A box around an emitter's voxels, for lines to start on.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// Columns are the box's axes in grid space.
    axes: Mat3,
    /// Corners in the box's own axes.
    low: Vec3,
    high: Vec3,
}

impl Frame {
    /// Turned with the largest of these triangles, around all voxels and triangles.
    pub fn around(voxels: &[Lit], triangles: &[[Vec3; 3]]) -> Option<Self> {
        let normal = |[a, b, c]: &[Vec3; 3]| (*b - *a).cross(*c - *a);
        let areas = triangles.iter().map(|t| (normal(t).length_squared(), t));
        let [a, b, c] = areas.max_by(|a, b| a.0.total_cmp(&b.0))?.1;
        let z = (*b - *a).cross(*c - *a).try_normalize()?;
        let edges = [*b - *a, *c - *b, *a - *c];
        let longest = edges.into_iter().max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()))?;
        let x = longest.try_normalize()?;
        let axes = Mat3::from_cols(x, z.cross(x), z);
        let turned = axes.transpose();
        // Half the extent of a cell along each axis.
        let half = 0.5 * (turned.x_axis.abs() + turned.y_axis.abs() + turned.z_axis.abs());
        let cells = voxels.iter().map(|v| turned * (v.cell.as_vec3() + 0.5));
        let corners = triangles.iter().flatten().map(|p| turned * *p);
        let (mut low, mut high) = (Vec3::MAX, Vec3::MIN);
        for (center, half) in cells.map(|c| (c, half)).chain(corners.map(|p| (p, Vec3::ZERO))) {
            (low, high) = (low.min(center - half), high.max(center + half));
        }
        (low.is_finite() && high.is_finite()).then_some(Self { axes, low, high })
    }

    fn pairs(&self) -> [f64; 3] {
        let size = (self.high - self.low).as_dvec3();
        [size.y * size.z, size.z * size.x, size.x * size.y]
    }

    /// In cell faces.
    pub fn surface(&self) -> f64 {
        2.0 * self.pairs().iter().sum::<f64>()
    }

    /// Origin on the box and unit direction inwards of each line, grid space.
    pub fn lines(self, count: u32, seed: u32) -> impl Iterator<Item = (Vec3, Vec3)> {
        let pairs = self.pairs();
        let half: f64 = pairs.iter().sum();
        let shift: [f64; 5] = std::array::from_fn(|i| {
            f64::from(frame::surface::hash(seed ^ ((i as u32) << 28))) / 2f64.powi(32)
        });
        let step: [f64; 5] = std::array::from_fn(|i| ROOT.powi(-(i as i32) - 1));
        (0..count).map(move |n| {
            let u: [f64; 5] = std::array::from_fn(|i| (shift[i] + f64::from(n) * step[i]).fract());
            // Which pair of faces, and which of the two.
            let at = u[0] * half;
            let axis = usize::from(at >= pairs[0]) + usize::from(at >= pairs[0] + pairs[1]);
            let [first, second] = [(axis + 1) % 3, (axis + 2) % 3];
            let is_low = at - pairs[..axis].iter().sum::<f64>() < 0.5 * pairs[axis];
            let (radius, inwards) = (u[3].sqrt() as f32, (1.0 - u[3]).sqrt() as f32);
            let (sin, cos) = (std::f32::consts::TAU * u[4] as f32).sin_cos();
            let (mut o, mut d) = (self.low, Vec3::ZERO);
            o[axis] = if is_low { self.low[axis] } else { self.high[axis] };
            o[first] += u[1] as f32 * (self.high - self.low)[first];
            o[second] += u[2] as f32 * (self.high - self.low)[second];
            (d[axis], d[first], d[second]) =
                (if is_low { inwards } else { -inwards }, radius * cos, radius * sin);
            (self.axes * o, (self.axes * d).normalize())
        })
    }
}

/// The voxels of one emitter, ready for lines.
pub struct Lamp {
    grid: CpuGrid,
    low: Vec3,
    by_record: Vec<Lit>,
}

impl Lamp {
    /// From distinct voxels; none without any.
    pub fn new(voxels: &[Lit]) -> Option<Self> {
        let low = voxels.iter().map(|v| v.cell).reduce(IVec3::min)?;
        let high = voxels.iter().map(|v| v.cell).reduce(IVec3::max)? + 1;
        let cells = (high - low).as_uvec3().to_array();
        let layout = Layout { origin: Vec3::ZERO, voxel_size: 1.0, cells, low: IVec3::ZERO };
        let grid = CpuGrid::new(&layout, voxels.iter().map(|v| v.cell - low));
        let mut by_record = voxels.to_vec();
        for voxel in voxels {
            if let Some(record) = grid.record(voxel.cell - low) {
                by_record[record as usize] = *voxel;
            }
        }
        Some(Self { grid, low: low.as_vec3(), by_record })
    }

    /// What a line meets first: a share, or 0.
    pub fn met(&self, o: Vec3, d: Vec3) -> f32 {
        let hit = self.grid.trace(o - self.low, d, f32::MAX).0;
        let lit = hit.and_then(|hit| self.by_record.get(hit.record as usize));
        lit.filter(|lit| lit.normal.dot(d) < 0.0).map_or(0.0, |lit| lit.share)
    }
}

/// What the emission of all voxels is multiplied with. Triangles in cells, of this area in cell faces.
pub(super) fn factor(voxels: &[Lit], triangles: Vec<[Vec3; 3]>, area: f64, lines: u32, seed: u32) -> f32 {
    let (Some(lamp), Some(frame)) = (Lamp::new(voxels), Frame::around(voxels, &triangles)) else {
        return 1.0;
    };
    let tree = Tree::new(triangles);
    let (mut fronts, mut met) = (0u32, 0.0);
    for (o, d) in frame.lines(lines, seed) {
        fronts += u32::from(tree.meets_front(o, d) == Some(true));
        met += f64::from(lamp.met(o, d));
    }
    let leaving = frame.surface() * f64::from(fronts) / f64::from(lines);
    let is_room = leaving < LEAST_LEAVING * area;
    if is_room || met == 0.0 { 1.0 } else { (f64::from(fronts) / met) as f32 }
}
