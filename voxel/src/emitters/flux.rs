//! How much light voxels of an emitter give off, counted along random lines.
//!
//! In: the emitter's voxels alone, each with a unit normal and the share of its emission; the emitter's area in voxel
//! faces. Out: the factor that makes both fluxes equal.
//!
//! A surface of area A that emits radiance L from its front gives off `pi A L`. Among uniform isotropic lines through a
//! convex box of surface S, the mean number of times a line leaves fronts of that surface is `A / S` (Cauchy and
//! Crofton). A line leaves a voxel front where it comes from an empty cell into an occupied one whose normal is turned
//! to it, as rays of the tracer do. With m the mean of the shares met that way, the factor is `A / (S m)`.
//!
//! Lines start uniformly on the faces of the voxels' box, with a density proportional to the cosine inwards. (The box
//! instead of a bounding sphere: the lines are the same, but a long lamp is met by half of them and not by one in
//! hundreds.) Their numbers are an additive recurrence in five dimensions, shifted by the seed; so 2^18 lines count to
//! well below the 1/512 that as many independent ones would.

use crate::grid::Layout;
use crate::grid::reference::CpuGrid;
use glam::{IVec3, Vec3};

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

/// The voxels of one emitter, ready to be counted.
pub struct Lamp {
    grid: CpuGrid,
    lit: Vec<Lit>,
    size: Vec3,
}

/// Powers of the root of x^6 = x + 1: the recurrence whose points are spread most evenly (Roberts 2018).
const ROOT: f64 = 1.134_724_138_401_519_4;

impl Lamp {
    /// From distinct voxels; none without any.
    pub fn new(voxels: &[Lit]) -> Option<Self> {
        let low = voxels.iter().map(|v| v.cell).reduce(IVec3::min)?;
        let high = voxels.iter().map(|v| v.cell).reduce(IVec3::max)? + 1;
        let cells = (high - low).as_uvec3().to_array();
        let layout = Layout { origin: Vec3::ZERO, voxel_size: 1.0, cells };
        let grid = CpuGrid::new(&layout, voxels.iter().map(|v| v.cell - low));
        let mut lit = voxels.to_vec();
        for voxel in voxels {
            if let Some(record) = grid.record(voxel.cell - low) {
                lit[record as usize] = *voxel;
            }
        }
        Some(Self { grid, lit, size: (high - low).as_vec3() })
    }

    /// The area of one-sided surface, in voxel faces, that gives off as much as these voxels, from `lines` lines.
    pub fn area(&self, lines: u32, seed: u32) -> f64 {
        let size = self.size.as_dvec3();
        let pairs = [size.y * size.z, size.z * size.x, size.x * size.y];
        let half: f64 = pairs.iter().sum();
        let shift: [f64; 5] =
            std::array::from_fn(|i| f64::from(frame::surface::hash(seed ^ ((i as u32) << 28))) / 2f64.powi(32));
        let step: [f64; 5] = std::array::from_fn(|i| ROOT.powi(-(i as i32) - 1));
        let mut met = 0.0;
        for n in 0..lines {
            let u: [f64; 5] = std::array::from_fn(|i| (shift[i] + f64::from(n) * step[i]).fract());
            // Which pair of faces, and which of the two.
            let at = u[0] * half;
            let axis = usize::from(at >= pairs[0]) + usize::from(at >= pairs[0] + pairs[1]);
            let into = (at - pairs[..axis].iter().sum::<f64>()) / pairs[axis];
            let low = into < 0.5;
            let (radius, (sin, cos)) = (u[3].sqrt(), (std::f64::consts::TAU * u[4]).sin_cos());
            let (mut o, mut d) = ([0.0; 3], [0.0; 3]);
            let [first, second] = [(axis + 1) % 3, (axis + 2) % 3];
            (o[axis], o[first], o[second]) = (if low { 0.0 } else { size[axis] }, u[1] * size[first], u[2] * size[second]);
            let inwards = (1.0 - u[3]).sqrt();
            (d[axis], d[first], d[second]) = (if low { inwards } else { -inwards }, radius * cos, radius * sin);
            met += self.met(Vec3::from(o.map(|x| x as f32)), Vec3::from(d.map(|x| x as f32)));
        }
        2.0 * half * met / f64::from(lines.max(1))
    }

    /// Sum of the shares along one line.
    fn met(&self, o: Vec3, d: Vec3) -> f64 {
        let (mut sum, mut inside) = (0.0, false);
        self.grid.walk(o, d, f32::MAX, |visit| {
            if visit.empty == 0 && !inside {
                let lit = self.grid.record(visit.cell).and_then(|record| self.lit.get(record as usize));
                sum += lit.filter(|lit| lit.normal.dot(d) < 0.0).map_or(0.0, |lit| f64::from(lit.share));
            }
            inside = visit.empty == 0;
            true
        });
        sum
    }
}
