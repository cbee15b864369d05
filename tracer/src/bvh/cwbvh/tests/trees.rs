//! What the builder makes.

use super::super::reference::CpuCwbvh;
use super::super::tree::Tree;
use super::super::{Quality, STACK, Triangle, build, elements};
use super::fixture::Fixture;
use crate::bvh::tests::fixture::{Stage, bumpy_ball, ray, soup};
use crate::bvh::{BLOCKED, BvhParams, FREE, margin};
use crate::rays::Ray;
use frame::scene_gpu::GpuMesh;
use glam::Vec3;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::node::CwBvhNode;

/// Walks all nodes: every triangle in one leaf, all its corners in every box above it with most of the margin left.
/// Returns the depth.
fn check_tree(twin: &CpuCwbvh, largest: f32, kept: &[u32]) -> u32 {
    let node = |i: u32| -> [[u32; 4]; 5] { std::array::from_fn(|k| twin.elements[5 * i as usize + k]) };
    let byte = |words: &[u32], i: usize| words[i / 4].to_le_bytes()[i % 4];
    // A quarter goes into roundings (tree.rs).
    let spare = 0.75 * margin(largest);
    let mut seen = Vec::new();
    let mut deepest = 0;
    let mut open: Vec<(u32, Vec<[Vec3; 2]>)> = if kept.is_empty() { vec![] } else { vec![(0, vec![])] };
    while let Some((index, above)) = open.pop() {
        deepest = deepest.max(above.len() as u32);
        let [head, slots, ends @ ..] = node(index);
        let mut children = slots[0];
        for slot in 0..8 {
            let kind = byte(&slots[2..], slot);
            let plane = |axis: usize, first: usize| {
                let step = f32::from_bits(u32::from(head[3].to_le_bytes()[axis]) << 23);
                f32::from_bits(head[axis]) + f32::from(byte(&ends[axis][first..], slot)) * step
            };
            let end = |first| Vec3::from_array([0, 1, 2].map(|axis| plane(axis, first)));
            let mut around = above.clone();
            around.push([end(0), end(2)]);
            if head[3] >> (24 + slot) & 1 == 1 {
                assert_eq!(kind, 32 + 24 + slot as u8);
                open.push((children, around));
                children += 1;
                continue;
            }
            for k in 0..(kind >> 5).count_ones() {
                let at = (twin.params.triangles_at + 3 * (slots[1] + u32::from(kind & 31) + k)) as usize;
                let triangle = &twin.elements[at..at + 3];
                seen.push(triangle[0][3]);
                for corner in triangle {
                    let [x, y, z, _] = corner.map(f32::from_bits);
                    let corner = Vec3::new(x, y, z).as_dvec3();
                    for (level, [low, high]) in around.iter().enumerate() {
                        let room = (corner - low.as_dvec3()).min(high.as_dvec3() - corner).min_element();
                        assert!(room >= f64::from(spare), "node {index}, level {level}: {room} < {spare}");
                    }
                }
            }
        }
    }
    seen.sort_unstable();
    assert_eq!(seen, kept);
    deepest
}

fn check(fixture: &Fixture) {
    let bounds = fixture.geometry.bounds();
    let largest = bounds.min.abs().max(bounds.max.abs()).max_element();
    let all: Vec<_> = (0..fixture.geometry.triangles.len() as u32).collect();
    assert_eq!(check_tree(&fixture.twin(), largest, &all), fixture.cwbvh.depth);
}

#[test]
fn boxes_hold_every_triangle_once_at_every_quality() {
    let mut fixture = Fixture::scene("courtyard");
    let rays = fixture.random_rays(500, 1);
    let expected: Vec<_> = fixture.met(&rays).iter().map(|h| (h.primitive, h.distance, h.weights)).collect();
    for quality in [Quality::Fast, Quality::Medium, Quality::Slow] {
        fixture.rebuild(quality);
        check(&fixture);
        let hits = fixture.met(&rays);
        let visits: u32 = hits.iter().map(|hit| hit.visits).sum();
        println!(
            "{quality:?}: {} nodes, depth {}, {visits} visits",
            fixture.cwbvh.bvh.node_count, fixture.cwbvh.depth
        );
        // The triangle's bits do not depend on the tree.
        assert!(
            hits.iter().map(|h| (h.primitive, h.distance, h.weights)).eq(expected.iter().copied()),
            "{quality:?}"
        );
    }
}

#[test]
fn boxes_hold_their_triangles_at_every_size() {
    // Boxes a few roundings longer than 255 steps: a rounded logarithm takes them for 255. Here from -1/2 to 1/2 of that,
    // from a tenth of a millimetre to a thousand kilometres.
    for exponent in -20..13 {
        for ulps in [0.0, 1.0, 2.0, 4.0, 8.0, 64.0] {
            let half = 0.5 * 255.0 * 2f32.powi(exponent) * (1.0 + ulps * f32::EPSILON);
            let small = half / 64.0;
            let at = |p: Vec3| [p, p + small * Vec3::X, p - small * Vec3::Y];
            let mut triangles: Vec<_> =
                (0..40).map(|i| at(half * (i as f32 / 40.0 - 0.5) * Vec3::ONE)).collect();
            let far = Vec3::splat(half / (1.0 + margin(1.0)));
            triangles
                .extend([[far, far - small * Vec3::X, far - small * Vec3::Y], [-far, small - far, -far]]);
            let geometry = soup(&triangles, 0);
            let corners: Vec<_> = geometry.triangles.iter().map(|t| geometry.corners(t)).collect();
            let tree = Tree::new(&corners, Quality::Medium).unwrap();
            let all: Vec<_> = corners
                .iter()
                .zip(0..)
                .map(|(corners, number)| Triangle { number, corners: *corners, is_sheet: false })
                .collect();
            let params = BvhParams {
                triangles_at: 5 * tree.nodes.len() as u32,
                triangle_count: all.len() as u32,
                node_count: tree.nodes.len() as u32,
                _pad: 0,
            };
            let twin = CpuCwbvh { elements: elements(&tree, &all), params };
            let kept: Vec<_> = (0..all.len() as u32).collect();
            assert_eq!(check_tree(&twin, far.x, &kept), tree.depth);
        }
    }
}

#[test]
fn no_triangle_and_one() {
    let rays = [ray(Vec3::ZERO, Vec3::Z), ray(Vec3::ZERO, -Vec3::Z)];
    let fixture = Fixture::soup(&[]);
    for hit in fixture.met(&rays) {
        assert_eq!((hit.primitive, hit.visits, hit.cut), (Ray::NOTHING, 0, 0));
    }
    assert_eq!(fixture.blocked(&rays), [FREE; 2]);
    let fixture =
        Fixture::soup(&[[Vec3::new(-1.0, -1.0, 1.0), Vec3::new(3.0, -1.0, 1.0), Vec3::new(-1.0, 3.0, 1.0)]]);
    let hits = fixture.met(&rays);
    assert_eq!((hits[0].primitive, hits[0].distance), (0, 1.0));
    assert_eq!(fixture.blocked(&rays), [BLOCKED, FREE]);
    assert_eq!((hits[1].primitive, hits[1].visits), (Ray::NOTHING, 1));
    check(&fixture);
}

#[test]
fn what_is_not_finite_is_not_met() {
    let wall = |z: f32| [Vec3::new(-1.0, -1.0, z), Vec3::new(3.0, -1.0, z), Vec3::new(-1.0, 3.0, z)];
    let bad = |value: f32| [Vec3::new(value, -1.0, 0.5), wall(0.5)[1], wall(0.5)[2]];
    let mut geometry = soup(&[1.0, 2.0, 3.0, 4.0, 5.0].map(wall), 0);
    // Made bad after the upload, as a displacement could.
    let mut fixture = Fixture::new(Stage::of(geometry.clone()));
    for (i, value) in [f32::NAN, f32::INFINITY, -1e20].into_iter().enumerate() {
        geometry.positions[3 * i..3 * i + 3].copy_from_slice(&bad(value));
    }
    let mesh = GpuMesh::new(&fixture.gpu, &geometry).unwrap();
    fixture.cwbvh = build(&fixture.gpu, &fixture.uploaded, &mesh, Quality::Medium).unwrap();
    assert_eq!(fixture.cwbvh.triangle_count, 2);
    let hit = fixture.met(&[ray(Vec3::ZERO, Vec3::Z)])[0];
    assert_eq!((hit.primitive, hit.distance), (3, 4.0));
    check_tree(&fixture.twin(), 5.0, &[3, 4]);
}

#[test]
fn points_and_needles_do_not_hurt() {
    // All at one point, then without any extent along two axes.
    let point = Fixture::soup(&[[Vec3::ZERO; 3]; 100]);
    let needles: Vec<_> =
        (0..100).map(|i| [Vec3::X * i as f32, Vec3::X * (i + 1) as f32, Vec3::X * i as f32]).collect();
    for fixture in [point, Fixture::soup(&needles)] {
        check(&fixture);
        let rays = [ray(Vec3::ONE, -Vec3::ONE), ray(Vec3::X, Vec3::X), ray(Vec3::ZERO, Vec3::Z)];
        assert!(fixture.met(&rays).iter().all(|hit| hit.primitive == Ray::NOTHING));
    }
}

#[test]
fn copies_stay_shallow() {
    let ball = bumpy_ball(8, 3);
    let point = [[Vec3::ZERO; 3]];
    for (corners, times) in [(ball.as_slice(), 100), (&ball[100..101], 30_000), (&point, 3000)] {
        for quality in [Quality::Fast, Quality::Medium, Quality::Slow] {
            let mut copies = corners.repeat(times);
            // Within the margin, which is 10^-12 m of the point: almost copies.
            for (i, [a, ..]) in copies.iter_mut().enumerate() {
                a.x += i as f32 * 1e-16;
            }
            let tree = Tree::new(&copies, quality).unwrap();
            println!("{quality:?}: {times} times {} triangles: depth {}", corners.len(), tree.depth);
            assert!(tree.depth <= 16, "{}", tree.depth);
        }
    }
}

#[test]
fn a_tree_deeper_than_the_stack_is_refused() {
    // A chain: each node's only child is the next one.
    let chain = |levels: u32| {
        let node = |i| CwBvhNode { imask: u8::from(i < levels), child_base_idx: i + 1, ..Default::default() };
        Tree::of(CwBvh { nodes: (0..=levels).map(node).collect(), ..Default::default() })
    };
    assert_eq!(chain(STACK).unwrap().depth, STACK);
    let error = chain(STACK + 1).err().unwrap().to_string();
    assert_eq!(error, "the BVH of 0 triangles is 33 levels deep, rays descend at most 32");
}

#[test]
fn sponza() {
    let Some(stage) = Stage::sponza() else { return };
    let mut fixture = Fixture::new(stage);
    let rays = fixture.random_rays(20_000, 1);
    for quality in [Quality::Fast, Quality::Medium, Quality::Slow] {
        fixture.rebuild(quality);
        let hits = fixture.met(&rays);
        let per_ray = hits.iter().map(|hit| f64::from(hit.visits)).sum::<f64>() / rays.len() as f64;
        let most = hits.iter().map(|hit| hit.visits).max();
        let c = &fixture.cwbvh;
        println!(
            "{quality:?}: {} triangles, {:.0} ms, {} nodes, depth {}, {:.1} MB, {per_ray:.1} visits per ray, at most {most:?}",
            c.triangle_count,
            c.build_ms,
            c.bvh.node_count,
            c.depth,
            c.bvh.elements.bytes() as f64 / 1e6,
        );
        assert!(hits.iter().all(|hit| hit.cut == 0));
        check(&fixture);
        let twin = fixture.twin();
        let count = 4000;
        let same = rays.iter().zip(&hits).take(count).filter(|(ray, hit)| {
            twin.closest(ray.origin.into(), ray.direction.into(), ray.t_max, ray.skip).visits == hit.visits
        });
        // As for the built-in scenes.
        assert!(100 * same.count() >= 99 * count);
    }
}
