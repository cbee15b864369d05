//! What single rays say: figures over pairs of distances, in voxels.
//!
//! Whether voxels are where a triangle is, is judged along the triangle's normal: half a voxel of height is many voxels
//! along a ray that grazes a floor, and no defect.

use tracer::rays::Met;

/// Farther apart than this, voxels: two different things.
const APART: f32 = 2.0;

/// How far a ray goes, voxels; none where it meets nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pair {
    pub(super) triangle: Option<f32>,
    pub(super) voxel: Option<f32>,
    /// Cosine between the ray and the triangle's normal, not negative; 1 where there is none.
    pub(super) cosine: f32,
}

impl Pair {
    pub(super) fn new(triangle: &Met, voxel: &Met, cosine: f32, voxel_size: f32) -> Self {
        let [triangle, voxel] = [triangle, voxel].map(|met| met.is_hit().then(|| met.distance / voxel_size));
        Self { triangle, voxel, cosine }
    }

    fn agrees(&self) -> bool {
        match (self.triangle, self.voxel) {
            (Some(triangle), Some(voxel)) => self.cosine * (triangle - voxel).abs() <= APART,
            (None, None) => true,
            _ => false,
        }
    }

    /// None where there is no triangle to miss.
    fn misses(&self) -> Option<bool> {
        let triangle = self.triangle?;
        Some(self.voxel.is_none_or(|voxel| self.cosine * (voxel - triangle) > APART))
    }
}

fn share(count: usize, all: usize) -> f64 {
    count as f64 / all.max(1) as f64
}

/// Share of the rays that triangles and voxels disagree about.
pub(super) fn silhouette_error(pairs: &[Pair]) -> f64 {
    share(pairs.iter().filter(|pair| !pair.agrees()).count(), pairs.len())
}

/// Of a million rays that meet a triangle, how many pass where its voxels should be.
pub(super) fn missed_per_million(pairs: &[Pair]) -> f64 {
    let of_triangles: Vec<bool> = pairs.iter().filter_map(Pair::misses).collect();
    1e6 * share(of_triangles.iter().filter(|misses| **misses).count(), of_triangles.len())
}

/// Mean change of voxel distances beyond that of triangle distances from one camera to the next, voxels.
pub(super) fn flicker_voxels(before: &[Pair], after: &[Pair]) -> f64 {
    let changes: Vec<f64> = before
        .iter()
        .zip(after)
        .filter_map(|(before, after)| {
            let of_triangle = (after.triangle? - before.triangle?).abs();
            let of_voxel = match (before.voxel, after.voxel) {
                (Some(before), Some(after)) => (after - before).abs(),
                (None, None) => 0.0,
                _ => f32::INFINITY,
            };
            (of_triangle < APART).then(|| f64::from((of_voxel - of_triangle).clamp(0.0, APART)))
        })
        .collect();
    changes.iter().sum::<f64>() / changes.len().max(1) as f64
}
