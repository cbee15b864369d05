//! The tree over triangles on the device, with how it was made, and a search without it.

use super::super::{Lbvh, LbvhBuilder, WGSL};
use crate::bvh::tests::fixture::{Random, Stage, soup};
use crate::rays::{Met, Ray, RayBatch};
use frame::{FrameLog, Recorder};
use glam::Vec3;
use std::ops::Deref;

/// A search without boxes: whatever it meets, a structure must meet, to the bit.
const ALL_TRIANGLES_WGSL: &str = "
fn bvh_closest(origin: vec3f, direction: vec3f, t_max: f32, skip: u32) -> BvhHit {
    let ray = bvh_ray(origin, direction, skip);
    var hit = BvhHit(BVH_NONE, t_max, vec2f(0.0), 0u, false);
    for (var place = 0u; place < bvh_params.triangle_count; place += 1u) {
        bvh_triangle(ray, place, &hit);
    }
    return hit;
}

fn bvh_blocked(origin: vec3f, direction: vec3f, t_max: f32, skip: u32) -> u32 {
    let ray = bvh_ray(origin, direction, skip);
    var found = BVH_FREE;
    for (var place = 0u; place < bvh_params.triangle_count; place += 1u) {
        var hit = BvhHit(BVH_NONE, t_max, vec2f(0.0), 0u, false);
        bvh_triangle(ray, place, &hit);
        if (hit.triangle != BVH_NONE && found != BVH_BLOCKED) {
            found = select(BVH_BLOCKED, BVH_SHEETS, bvh_is_sheet(place));
        }
    }
    return found;
}";

/// Random triangles in the unit cube, up to `size` m long.
pub(super) fn random_triangles(count: u32, size: f32) -> Vec<[Vec3; 3]> {
    let mut random = Random::new(3);
    (0..count)
        .map(|_| {
            let a = random.point();
            let reach = size * random.unit();
            [a, a + reach * random.direction(), a + reach * random.direction()]
        })
        .collect()
}

/// A tree on the device, and a search without one.
pub(super) struct Planted {
    pub(super) stage: Stage,
    pub(super) builder: LbvhBuilder,
    pub(super) lbvh: Lbvh,
    pub(super) log: FrameLog,
    pub(super) tree: RayBatch,
    all: RayBatch,
}

impl Deref for Planted {
    type Target = Stage;

    fn deref(&self) -> &Stage {
        &self.stage
    }
}

impl Planted {
    pub(super) fn scene(name: &str) -> Self {
        Self::new(Stage::scene(name))
    }

    pub(super) fn soup(triangles: &[[Vec3; 3]]) -> Self {
        Self::new(Stage::of(soup(triangles, 0)))
    }

    pub(super) fn new(stage: Stage) -> Self {
        let builder = LbvhBuilder::new(&stage.gpu, &stage.uploaded).unwrap();
        let mut recorder = Recorder::new(&stage.gpu);
        let lbvh = builder.build(&mut recorder, &stage.uploaded.mesh).unwrap();
        let log = recorder.finish().unwrap();
        let [tree, all] = [WGSL, ALL_TRIANGLES_WGSL].map(|walk| RayBatch::of_bvh(&stage.gpu, walk).unwrap());
        Self { stage, builder, lbvh, log, tree, all }
    }

    pub(super) fn met(&self, rays: &[Ray]) -> Vec<Met> {
        let met = self.stage.met(&self.tree, &self.lbvh, rays);
        assert!(met.iter().all(|met| met.cut == 0), "a ray was cut off");
        met
    }

    pub(super) fn blocked(&self, rays: &[Ray]) -> Vec<u32> {
        self.stage.blocked(&self.tree, &self.lbvh, rays)
    }

    /// Asserts that rays meet through the tree what they meet without it, to the bit; returns how many met something.
    pub(super) fn compare(&self, rays: &[Ray]) -> usize {
        let met = self.met(rays);
        let expected = self.stage.met(&self.all, &self.lbvh, rays);
        let blocked = self.blocked(rays);
        let expected_blocked = self.stage.blocked(&self.all, &self.lbvh, rays);
        for (i, ray) in rays.iter().enumerate() {
            assert_eq!(Met { visits: 0, ..met[i] }, expected[i], "{ray:?}");
            assert_eq!(blocked[i], expected_blocked[i], "{ray:?}");
        }
        met.iter().filter(|met| met.primitive != Ray::NOTHING).count()
    }
}
