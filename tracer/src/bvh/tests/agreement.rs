//! The two structures give the same answers to the bit, so that what is traced through them is the same image.

use super::fixture::{Random, Stage, ray, soup};
use crate::bvh::cwbvh::{self, Cwbvh};
use crate::bvh::lbvh::{self, Lbvh};
use crate::bvh::{BLOCKED, FREE, SHEETS};
use crate::rays::{Met, Ray, RayBatch};
use glam::Vec3;

/// Both over the same triangles.
struct Rivals {
    stage: Stage,
    lbvh: Lbvh,
    cwbvh: Cwbvh,
    by_lbvh: RayBatch,
    by_cwbvh: RayBatch,
}

/// All that an image can depend on.
fn bits(met: &Met) -> [u32; 4] {
    let [v, w] = met.weights;
    [met.primitive, met.distance.to_bits(), v.to_bits(), w.to_bits()]
}

impl Rivals {
    fn new(stage: Stage) -> Self {
        let [by_lbvh, by_cwbvh] =
            [lbvh::WGSL, cwbvh::WGSL].map(|walk| RayBatch::of_bvh(&stage.gpu, walk).unwrap());
        Self { lbvh: stage.lbvh(), cwbvh: stage.cwbvh(), by_lbvh, by_cwbvh, stage }
    }

    /// Asserts that no ray tells them apart; returns what the rays met, and how many answers of each kind shadows had.
    fn compare(&self, rays: &[Ray]) -> (Vec<Met>, [usize; 3]) {
        let stage = &self.stage;
        let ours = stage.met(&self.by_lbvh, &self.lbvh, rays);
        let theirs = stage.met(&self.by_cwbvh, &self.cwbvh.bvh, rays);
        assert!(ours.iter().chain(&theirs).all(|met| met.cut == 0), "a ray was cut off");
        let mut differing =
            rays.iter().zip(ours.iter().zip(&theirs)).filter(|(_, (a, b))| bits(a) != bits(b));
        if let Some(first) = differing.next() {
            panic!("{} of {} rays differ, the first: {first:?}", 1 + differing.count(), rays.len());
        }
        let ours_blocked = stage.blocked(&self.by_lbvh, &self.lbvh, rays);
        let theirs_blocked = stage.blocked(&self.by_cwbvh, &self.cwbvh.bvh, rays);
        let mut shadows = [0; 3];
        for (i, ray) in rays.iter().enumerate() {
            let answer = ours_blocked[i];
            assert_eq!(answer, theirs_blocked[i], "{ray:?} is blocked by one of them");
            assert_eq!(answer == FREE, ours[i].primitive == Ray::NOTHING, "{ray:?}");
            shadows[answer as usize] += 1;
        }
        (ours, shadows)
    }

    /// Half of the rays are random, half awkward.
    fn race(&self, name: &str, count: usize) {
        let mut rays = self.stage.random_rays(count / 2, 51);
        rays.extend(self.stage.awkward_rays(count / 2, 52));
        let (met, shadows) = self.compare(&rays);
        let hits = met.iter().filter(|met| met.primitive != Ray::NOTHING).count();
        println!(
            "{name}: {hits} of {} rays met the same triangle; {shadows:?} free, blocked, sheets",
            rays.len()
        );
        // Otherwise nothing was compared.
        assert!(hits > count / 4, "{name}: {hits}");
    }
}

#[test]
fn built_in_scenes_are_met_alike() {
    for name in ["courtyard", "cornell", "spheres", "glass"] {
        Rivals::new(Stage::scene(name)).race(name, 25_000);
    }
}

#[test]
fn sponza_is_met_alike() {
    if let Some(stage) = Stage::sponza() {
        Rivals::new(stage).race("sponza", 1_000_000);
    }
}

/// Both leave out the same triangles, and what stays is met as if they were not there.
#[test]
fn broken_and_far_triangles_are_left_out_alike() {
    let mut random = Random::new(53);
    let mut triangles: Vec<_> = (0..600)
        .map(|_| {
            let a = random.point();
            [a, a + 0.3 * random.direction(), a + 0.3 * random.direction()]
        })
        .collect();
    // The last that can be met, the first that cannot, and what is no number.
    let far = [1e12, 1e12f32.next_up(), -2e12, 1e17, 1e19, f32::INFINITY, f32::NEG_INFINITY, f32::NAN];
    for (i, far) in far.into_iter().enumerate().skip(1) {
        triangles[100 + i][i % 3][i % 2] = far;
        triangles[200 + i] = [Vec3::splat(far); 3];
    }
    let rivals = Rivals::new(Stage::of(soup(&triangles, 3)));
    let mut rays: Vec<_> = (0..20_000).map(|_| ray(random.point(), random.direction())).collect();
    let (met, shadows) = rivals.compare(&rays);
    let broken = |n: u32| (101..108).contains(&n) || (201..208).contains(&n);
    assert!(met.iter().all(|met| !broken(met.primitive)));
    assert!([FREE, BLOCKED, SHEETS].iter().all(|&answer| shadows[answer as usize] > 100), "{shadows:?}");

    // One at the limit makes every box too large to hide anything.
    triangles[100] =
        [Vec3::new(far[0], 0.0, 0.0), Vec3::new(far[0], far[0], 0.0), Vec3::new(far[0], 0.0, far[0])];
    rays.truncate(2000);
    rays.push(ray(Vec3::splat(5.0), Vec3::new(1.0, 0.3, 0.3)));
    let (met, _) = Rivals::new(Stage::of(soup(&triangles, 3))).compare(&rays);
    assert_eq!(met.last().map(|met| met.primitive), Some(100));
}
