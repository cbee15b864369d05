//! The CPU half of `height.inc.wgsl` and of `shape_frame`, in f64: what a height map says at a place, and the frame there.

use glam::{DVec2, DVec3};

/// A height map, repeated.
pub struct Map {
    /// Metres over 0..1.
    pub scale: f64,
    mips: Vec<([usize; 2], Vec<f64>)>,
}

impl Map {
    /// `texels` row by row, 0..1. A mip's texel is the mean of what it covers; sides must be powers of two.
    pub fn new(size: [usize; 2], texels: Vec<f64>, scale: f64) -> Self {
        let mut mips = vec![(size, texels)];
        while let Some((from, texels)) = mips.last().filter(|(size, _)| *size != [1, 1]) {
            let size = from.map(|n| (n / 2).max(1));
            let per = [from[0] / size[0], from[1] / size[1]];
            let mean = |i: usize| {
                let [x, y] = [i % size[0] * per[0], i / size[0] * per[1]];
                let covered = (0..per[0] * per[1]).map(|k| (x + k % per[0]) + (y + k / per[0]) * from[0]);
                covered.map(|at| texels[at]).sum::<f64>() / (per[0] * per[1]) as f64
            };
            let next = (0..size[0] * size[1]).map(mean).collect();
            mips.push((size, next));
        }
        Self { scale, mips }
    }

    fn size(&self, level: usize) -> DVec2 {
        let [width, height] = self.mips[level].0;
        DVec2::new(width as f64, height as f64)
    }

    /// `displace_level`: sides of a triangle in places, cut in `rows`.
    pub fn level(&self, [ab, ac]: [DVec2; 2], rows: u32) -> usize {
        let [ab, ac] = [ab, ac].map(|side| side * self.size(0));
        let squares = ab.length_squared() + ac.length_squared() + (ac - ab).length_squared();
        let texels = (squares / 3.0).sqrt() / f64::from(rows);
        ((texels.max(1.0).log2() - 0.5).floor().max(0.0) as usize).min(self.mips.len() - 1)
    }

    /// `height_at`, m.
    pub fn height(&self, level: usize, place: DVec2) -> f64 {
        let ([width, height], texels) = &self.mips[level];
        let at = place * self.size(level) - 0.5;
        let (low, part) = (at.floor(), at - at.floor());
        let texel = |dx: f64, dy: f64| {
            let x = (low.x + dx).rem_euclid(*width as f64) as usize;
            let y = (low.y + dy).rem_euclid(*height as f64) as usize;
            texels[x + y * width]
        };
        let row = |dy: f64| texel(0.0, dy) * (1.0 - part.x) + texel(1.0, dy) * part.x;
        self.scale * (row(0.0) * (1.0 - part.y) + row(1.0) * part.y)
    }

    /// `height_slopes`, m per once across.
    pub fn slopes(&self, level: usize, place: DVec2) -> DVec2 {
        let size = self.size(level);
        let along = |axis: DVec2| {
            let central = |reach: f64| {
                let step = reach * axis / size;
                (self.height(level, place + step) - self.height(level, place - step)) * size.dot(axis)
                    / (2.0 * reach)
            };
            (4.0 * central(1.0) - central(2.0)) / 3.0
        };
        DVec2::new(along(DVec2::X), along(DVec2::Y))
    }
}

/// A corner of a triangle: position (m), normal, place in the map.
#[derive(Clone, Copy)]
pub struct Corner {
    /// Metres.
    pub position: DVec3,
    /// Unit length.
    pub normal: DVec3,
    /// In the map.
    pub place: DVec2,
}

/// The normal of `shape_frame` at a point of a triangle that is cut in `rows`, before it is made upright.
pub fn normal(map: &Map, [a, b, c]: [Corner; 3], rows: u32, weights: DVec2) -> DVec3 {
    let mix =
        |of: fn(&Corner) -> DVec3| of(&a) + weights.x * (of(&b) - of(&a)) + weights.y * (of(&c) - of(&a));
    let sum = mix(|corner| corner.normal);
    let n = sum.normalize();
    let [ab, ac] = [b.place - a.place, c.place - a.place];
    let level = map.level([ab, ac], rows);
    let place = a.place + weights.x * ab + weights.y * ac;
    let det = ab.perp_dot(ac);
    // Derivatives along u and v of what is linear over the triangle.
    let derived =
        |to_b: DVec3, to_c: DVec3| [(to_b * ac.y - to_c * ab.y) / det, (to_c * ab.x - to_b * ac.x) / det];
    let [edge_b, edge_c] = [b.position - a.position, c.position - a.position];
    let face = edge_b.cross(edge_c).normalize();
    let face = if face.dot(n) < 0.0 { -face } else { face };
    let turned = |v: DVec3| v - n.dot(v) / (1.0 + face.dot(n)) * (face + n);
    let [p_u, p_v] = derived(edge_b, edge_c).map(turned);
    let [n_u, n_v] =
        derived(b.normal - a.normal, c.normal - a.normal).map(|v| (v - n.dot(v) * n) / sum.length());
    let area = n.dot(p_u.cross(p_v));
    let height = map.height(level, place);
    let (mut t_u, mut t_v) = (p_u + height * n_u, p_v + height * n_v);
    if n.dot(t_u.cross(t_v)) * area.signum() < 0.1 * area.abs() {
        (t_u, t_v) = (p_u, p_v);
    }
    let moved = n.dot(t_u.cross(t_v));
    let slopes = map.slopes(level, place);
    let gradient = (slopes.x * t_v.cross(n) + slopes.y * n.cross(t_u)) / moved;
    let slopes = slopes * (8.0 / gradient.length()).min(1.0);
    ((t_u + slopes.x * n).cross(t_v + slopes.y * n) * moved.signum()).normalize()
}
