//! Every triangle once, every box around its triangles, no way too long, the same bits again.

use super::fixture::{Planted, random_triangles};
use crate::bvh::tests::fixture::{Random, Stage, ray, soup};
use crate::bvh::{FARTHEST_M, margin};
use crate::rays::Ray;
use frame::Recorder;
use glam::Vec3;
use scene::Aabb;

/// The buffer, read back.
struct Tree {
    elements: Vec<[u32; 4]>,
    node_count: u32,
    triangle_count: u32,
    /// What a box may be larger than its triangles.
    margin: f32,
}

/// Whether a triangle can be met at all; on the device the others are points at 10^18 m.
fn is_usable(corners: &[Vec3; 3]) -> bool {
    corners.iter().all(|p| p.abs().cmple(Vec3::splat(FARTHEST_M)).all())
}

/// What a walk over all nodes found.
#[derive(Default)]
struct Found {
    places: Vec<u32>,
    depth: usize,
}

impl Tree {
    fn of(stage: &Planted) -> Self {
        let triangles = 0..stage.geometry.triangles.len();
        let usable = triangles.map(|n| stage.corners(n)).filter(is_usable);
        let bounds = Aabb::of(usable.flatten());
        let largest = bounds.min.abs().max(bounds.max.abs()).max_element();
        Self {
            elements: stage.gpu.read_buffer(&stage.lbvh.elements).unwrap(),
            node_count: stage.lbvh.node_count,
            triangle_count: stage.geometry.triangles.len() as u32,
            margin: margin(largest),
        }
    }

    fn point(&self, element: u32) -> Vec3 {
        let [x, y, z, _] = self.elements[element as usize].map(f32::from_bits);
        Vec3::new(x, y, z)
    }

    fn corners(&self, place: u32) -> [Vec3; 3] {
        [0, 1, 2].map(|i| self.point(4 * self.node_count + 3 * place + i))
    }

    fn number(&self, place: u32) -> u32 {
        self.elements[(4 * self.node_count + 3 * place) as usize][3]
    }

    /// Checks all boxes below a child against `outer`, the box its parent keeps for it; returns the triangles' own.
    fn check(&self, child: u32, outer: Option<Aabb>, depth: usize, found: &mut Found) -> Aabb {
        found.depth = found.depth.max(depth);
        let count = child >> 29;
        let inner = if count > 0 {
            assert!(count <= 4);
            let first = child & ((1 << 29) - 1);
            found.places.extend(first..first + count);
            Aabb::of((first..first + count).map(|place| self.corners(place)).filter(is_usable).flatten())
        } else {
            let at = 4 * child;
            let child_of = |element: u32| self.elements[(at + element) as usize][3];
            let box_of = |low, high| Aabb { min: self.point(at + low), max: self.point(at + high) };
            let left = self.check(child_of(0), Some(box_of(0, 1)), depth + 1, found);
            left.union(self.check(child_of(1), Some(box_of(2, 3)), depth + 1, found))
        };
        match outer {
            Some(outer) if inner.is_empty() => assert_eq!(outer.min, outer.max, "nothing is in a point"),
            // The same subtraction and addition as on the device, so that the boxes are these and no others.
            Some(outer) => {
                assert_eq!(outer.min, inner.min - self.margin);
                assert_eq!(outer.max, inner.max + self.margin);
            }
            None => {}
        }
        inner
    }

    fn checked(&self) -> Found {
        let mut found = Found::default();
        match (self.node_count, self.triangle_count) {
            (0, count) => found.places.extend(0..count),
            _ => {
                self.check(0, None, 0, &mut found);
            }
        }
        // Ranges are contiguous, and the left one comes first.
        assert!(found.places.iter().copied().eq(0..self.triangle_count), "every place once, in order");
        let mut numbers: Vec<_> = found.places.iter().map(|&place| self.number(place)).collect();
        numbers.sort_unstable();
        assert!(numbers.into_iter().eq(0..self.triangle_count), "every triangle once");
        found
    }
}

#[test]
fn holds_every_triangle_once_in_boxes_that_fit() {
    for name in ["courtyard", "cornell", "spheres"] {
        let stage = Planted::scene(name);
        let tree = Tree::of(&stage);
        let found = tree.checked();
        for place in found.places {
            assert_eq!(tree.corners(place), stage.corners(tree.number(place) as usize));
        }
        println!("{name}: {} triangles, {} deep", tree.triangle_count, found.depth);
    }
}

/// Sizes around the leaf's, a workgroup's, a block's of the sort, and several blocks.
#[test]
fn holds_any_number_of_triangles() {
    for count in [0, 1, 2, 3, 4, 5, 6, 255, 257, 2047, 2049, 5000] {
        let triangles = random_triangles(count, 0.3);
        let stage = Planted::soup(&triangles);
        Tree::of(&stage).checked();
        let mut random = Random::new(1);
        let rays: Vec<_> = (0..200).map(|_| ray(random.point(), random.direction())).collect();
        let hits = stage.compare(&rays);
        assert!(hits > 0 || count < 100, "{count} triangles, {hits} hits");
        assert!(hits == 0 || count > 0);
    }
}

#[test]
fn is_the_same_when_built_again() {
    let stage = Planted::scene("courtyard");
    let mut recorder = Recorder::new(&stage.gpu);
    let again = stage.builder.build(&mut recorder, &stage.uploaded.mesh).unwrap();
    recorder.finish().unwrap();
    let words = |lbvh: &crate::bvh::Bvh| stage.gpu.read_buffer::<u32>(&lbvh.elements).unwrap();
    assert_eq!(words(&stage.lbvh), words(&again));
}

/// A chain of codes with one bit each, then equal codes told apart by their places: as deep as so few triangles can be.
fn deep_triangles() -> Vec<[Vec3; 3]> {
    let at = |p: Vec3| [p, p + Vec3::new(0.2, 0.0, 0.1), p + Vec3::new(0.0, 0.2, 0.1)];
    let mut triangles = vec![at(Vec3::ZERO); 1024];
    for bit in 0..10 {
        let far = (1 << bit) as f32 + 0.25;
        triangles.extend([Vec3::X, Vec3::Y, Vec3::Z].map(|axis| at(far * axis)));
    }
    // Makes a Morton cell 1 m wide.
    triangles.push(at(Vec3::splat(1023.8)));
    triangles
}

#[test]
fn stays_within_the_stack_where_the_tree_is_a_chain() {
    let triangles = deep_triangles();
    let stage = Planted::soup(&triangles);
    let depth = Tree::of(&stage).checked().depth;
    // 30 levels of codes, 10 of places less those within a leaf of 4; 62 is what the stack is made for.
    assert!((38..=62).contains(&depth), "{depth} deep");
    let mut random = Random::new(5);
    let towards = |random: &mut Random| {
        let [a, b, c] = triangles[random.below(triangles.len())];
        let origin = 1024.0 * random.point();
        ray(origin, (a + b + c) / 3.0 - origin)
    };
    let rays: Vec<_> = (0..1000).map(|_| towards(&mut random)).collect();
    assert!(stage.compare(&rays) > 900);
}

/// Equal triangles: the lowest number is met, whichever leaf comes first.
#[test]
fn meets_the_first_of_equal_triangles() {
    let one = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let stage = Planted::soup(&[one; 1000]);
    Tree::of(&stage).checked();
    let rays = [ray(Vec3::new(0.2, 0.3, 1.0), Vec3::NEG_Z), ray(Vec3::new(0.2, 0.3, -1.0), Vec3::Z)];
    let met = stage.met(&rays);
    assert!(met.iter().all(|met| (met.primitive, met.distance) == (0, 1.0)), "{met:?}");
    let without_first = rays.map(|ray| Ray { skip: 0, ..ray });
    assert!(stage.met(&without_first).iter().all(|met| met.primitive == 1));
}

/// What is no number, and what is no area, is never met, and all else is as if it were not there.
#[test]
fn bears_broken_triangles() {
    let mut triangles = random_triangles(500, 0.4);
    let bad = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30];
    for (i, bad) in (0..).zip(bad) {
        triangles[100 + i][i % 3].y = bad;
        triangles[200 + i] = [Vec3::splat(bad); 3];
        triangles[300 + i] = [triangles[300 + i][0]; 3];
        triangles[400 + i][1] = triangles[400 + i][0];
    }
    let stage = Planted::new(Stage::of(soup(&triangles, 3)));
    Tree::of(&stage).checked();
    let mut random = Random::new(9);
    let rays: Vec<_> = (0..4000).map(|_| ray(random.point(), random.direction())).collect();
    assert!(stage.compare(&rays) > 2000);
    let broken = |n: u32| (100..500).contains(&n) && n % 100 < 4;
    assert!(stage.met(&rays).iter().all(|met| !broken(met.primitive)));
    // Nothing but broken ones, below and above a leaf's size.
    for count in [3, 40] {
        let stage = Planted::soup(&vec![[Vec3::splat(f32::NAN); 3]; count]);
        assert_eq!(stage.compare(&rays[..100]), 0);
    }
}

/// New positions of the same triangles: the tree stays, its boxes and triangles are those of the new positions.
#[test]
fn refits_to_where_triangles_moved() {
    let mut planted = Planted::soup(&random_triangles(3000, 0.2));
    let before = Tree::of(&planted);
    let bent = |p: &Vec3| *p + 0.3 * Vec3::new((5.0 * p.y).sin(), (7.0 * p.z).cos(), p.x * p.y);
    planted.stage.geometry.positions = planted.stage.geometry.positions.iter().map(bent).collect();
    let moved = frame::scene_gpu::GpuMesh::new(&planted.gpu, &planted.geometry).unwrap();
    let mut recorder = Recorder::new(&planted.stage.gpu);
    planted.builder.refit(&mut recorder, &moved, &mut planted.lbvh).unwrap();
    recorder.finish().unwrap();

    let after = Tree::of(&planted);
    let numbers = |tree: &Tree| (0..3000).map(|place| tree.number(place)).collect::<Vec<_>>();
    assert_eq!(numbers(&before), numbers(&after));
    for place in after.checked().places {
        assert_eq!(after.corners(place), planted.corners(after.number(place) as usize));
    }
    let mut random = Random::new(11);
    let rays: Vec<_> = (0..1000).map(|_| ray(random.point(), random.direction())).collect();
    assert!(planted.compare(&rays) > 500);

    // Of another mesh there is nothing to keep.
    let fewer = frame::scene_gpu::GpuMesh::new(&planted.gpu, &soup(&random_triangles(70, 0.2), 0)).unwrap();
    let mut recorder = Recorder::new(&planted.stage.gpu);
    planted.builder.refit(&mut recorder, &fewer, &mut planted.lbvh).unwrap();
    recorder.finish().unwrap();
    assert_eq!(planted.lbvh.node_count, 69);
}

/// 1.3 million triangles need 146 MB; the device allows 134 MB.
#[test]
fn says_what_does_not_fit() {
    let stage = Planted::soup(&random_triangles(5, 0.2));
    let mut huge = stage.uploaded.mesh.clone();
    huge.triangle_count = 1_300_000;
    let mut recorder = Recorder::new(&stage.gpu);
    let Err(error) = stage.builder.build(&mut recorder, &huge) else { panic!("it fits") };
    let message = error.to_string();
    let allowed = stage.gpu.device.limits().max_storage_buffer_binding_size.to_string();
    assert!(message.contains("145599936") && message.contains(&allowed), "{message}");
}
