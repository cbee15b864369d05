//! Closed meshes, aimed at where triangles meet: through neither structure a ray finds a gap.

use super::fixture::{Random, Stage, bumpy_ball, ray_through, soup};
use crate::bvh::{BLOCKED, cwbvh, lbvh};
use crate::rays::{Met, Ray, RayBatch};
use glam::Vec3;

/// A ball of about 1 m.
struct Ball {
    stage: Stage,
    triangles: Vec<[Vec3; 3]>,
}

impl Ball {
    fn new() -> Self {
        let triangles = bumpy_ball(40, 7);
        Self { stage: Stage::of(soup(&triangles, 0)), triangles }
    }

    /// What each structure says that rays meet, and whether they are blocked.
    fn answers(&self, rays: &[Ray]) -> [(&'static str, Vec<Met>, Vec<u32>); 2] {
        let stage = &self.stage;
        let [lbvh, cwbvh] = [&*stage.lbvh(), &stage.cwbvh().bvh];
        [("lbvh", lbvh::WGSL, lbvh), ("cwbvh", cwbvh::WGSL, cwbvh)].map(|(name, walk, bvh)| {
            let batch = RayBatch::of_bvh(&stage.gpu, walk).unwrap();
            (name, stage.met(&batch, bvh, rays), stage.blocked(&batch, bvh, rays))
        })
    }

    /// Two corners of a random triangle.
    fn edge(&self, random: &mut Random) -> [Vec3; 2] {
        let [a, b, c] = self.triangles[random.below(self.triangles.len())];
        [[a, b], [b, c], [c, a]][random.below(3)]
    }
}

#[test]
fn nothing_escapes_a_closed_mesh() {
    let ball = Ball::new();
    let mut random = Random::new(8);
    let rays: Vec<_> = (0..100_000)
        .map(|i| {
            // Every tenth from the origin, which lies on coordinate planes that pass through vertices.
            let origin = if i % 10 == 0 { Vec3::ZERO } else { random.unit() * 0.4 * random.direction() };
            let [a, b] = ball.edge(&mut random).map(Vec3::as_dvec3);
            ray_through(origin, if i % 2 == 0 { a } else { a.lerp(b, random.unit().into()) })
        })
        .collect();
    for (name, met, blocked) in ball.answers(&rays) {
        let escaped = met.iter().filter(|met| met.primitive == Ray::NOTHING).count();
        let lit = blocked.iter().filter(|answer| **answer != BLOCKED).count();
        assert_eq!((escaped, lit), (0, 0), "{name}: of {}", rays.len());
        let visits: u64 = met.iter().map(|met| u64::from(met.visits)).sum();
        println!(
            "{name}: {} triangles, {} visits per ray",
            ball.triangles.len(),
            visits as f64 / rays.len() as f64
        );
    }
}

#[test]
fn no_ray_from_outside_reaches_the_far_side() {
    let ball = Ball::new();
    let mut random = Random::new(8);
    let rays: Vec<_> = (0..60_000)
        .map(|i| {
            // As near as scenes are looked at, and so far that the growth of boxes covers no rounding.
            let away = [3.5, 30.0, 300.0][i % 3];
            let [a, b] = ball.edge(&mut random);
            let origin = away * (a.normalize() + 0.3 * random.direction()).clamp_length_max(1.1);
            ray_through(origin, a.as_dvec3().lerp(b.as_dvec3(), random.below(5) as f64 / 4.0))
        })
        .collect();
    for (name, met, _) in ball.answers(&rays) {
        for (ray, met) in rays.iter().zip(&met) {
            let point = Vec3::from(ray.origin) + met.distance * Vec3::from(ray.direction);
            let is_near_side = met.primitive != Ray::NOTHING && point.dot(ray.direction.into()) < 0.0;
            assert!(is_near_side, "{name}: {ray:?}: {met:?}");
        }
    }
}
