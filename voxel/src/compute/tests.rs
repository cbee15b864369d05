//! The device against the f64 reference, cell by cell; nothing is missed, nothing gets through; hard cases.
#![allow(clippy::unwrap_used)]

use super::reference::Sat;
use crate::test_scenes::{Built, Random, build, gpu, number, numbered, quad, soup, sphere, upload};
use crate::{Cover, Voxelizer};
use frame::Gpu;
use frame::scene_gpu::GpuScene;
use glam::{IVec3, Vec3};
use scene::{Aabb, Material};
use std::collections::{HashMap, HashSet};

const UNIT: Aabb = Aabb { min: Vec3::ZERO, max: Vec3::ONE };

fn voxelizer(gpu: &Gpu, scene: &GpuScene, cover: Cover) -> Voxelizer {
    let mut voxelizer = Voxelizer::new(gpu, scene).unwrap();
    let of = if cover == Cover::Boxes { "raster" } else { "compute" };
    frame::set_knob(&mut voxelizer.knobs(), "voxelizer", of).unwrap();
    let cells = if cover == Cover::Thin { "thin" } else { "conservative" };
    frame::set_knob(&mut voxelizer.knobs(), "cover", cells).unwrap();
    assert_eq!(voxelizer.cover(), cover);
    voxelizer
}

/// The least key of each cell, and cells in which rounding may decide otherwise: a triangle hardly overlaps or hardly
/// does not, or its distance is near a step.
fn winners(built: &Built, triangles: &[[Vec3; 3]], cover: Cover) -> (HashMap<IVec3, u32>, HashSet<IVec3>) {
    let (mut winners, mut close) = (HashMap::new(), HashSet::new());
    let is_thin = cover == Cover::Thin;
    let steps = f64::from(if is_thin { super::STEPS_THIN } else { super::STEPS_CONSERVATIVE });
    for (number, triangle) in (0..).zip(triangles) {
        let Some(sat) = Sat::new(&built.layout, *triangle, cover) else { continue };
        for cell in sat.candidates(&built.layout) {
            let center = cell.as_dvec3() + 0.5;
            let overlap = sat.overlap(center);
            // What the conservative test allows beyond.
            let allowance = if is_thin { 0.0 } else { 1.0 / 4096.0 };
            if sat.is_close(center, allowance) {
                close.insert(cell);
            }
            if overlap >= 0.0 {
                let key = sat.key(cell, 1, number);
                winners.entry(cell).and_modify(|least: &mut u32| *least = key.min(*least)).or_insert(key);
                let step = steps * sat.miss(center);
                // A distance of nothing is no step.
                if step > 0.5 && (step - step.round()).abs() < steps / 2048.0 {
                    close.insert(cell);
                }
            }
        }
    }
    (winners, close)
}

#[test]
fn the_device_finds_the_same_winners_as_the_cpu() {
    let Some(gpu) = gpu() else { return };
    for (name, triangles, grid) in [
        ("soup", soup(1500, 0.3), 100),
        ("splinters", soup(3000, 0.03), 61),
        ("sphere", sphere(Vec3::splat(0.5), 0.47, 20), 130),
    ] {
        let scene = upload(&gpu, &numbered(&triangles));
        for cover in [Cover::Thin, Cover::Conservative, Cover::Boxes] {
            let built = build(&gpu, &mut voxelizer(&gpu, &scene, cover), &scene, UNIT, grid);
            let (expected, close) = winners(&built, &triangles, cover);
            let there: HashMap<IVec3, u32> =
                built.cells().into_iter().map(|c| (c, number(built.record(c).unwrap()))).collect();
            let all: HashSet<_> = expected.keys().chain(there.keys()).collect();
            let differ = |cell: &&&IVec3| {
                expected.get(**cell).map(|key| key & 0xff_ffff) != there.get(**cell).copied()
            };
            let (excused, wrong): (Vec<&IVec3>, Vec<&IVec3>) =
                all.iter().filter(differ).partition(|cell| close.contains(**cell));
            println!(
                "{name}, {cover:?}: {} cells, {} of {} close calls",
                there.len(),
                excused.len(),
                close.len()
            );
            assert!(
                wrong.is_empty(),
                "{name}, {cover:?}: {} of {}: {:?}",
                wrong.len(),
                there.len(),
                wrong.first()
            );
            assert!(excused.len() * 100 <= there.len(), "{name}, {cover:?}: {}", excused.len());
            if cover == Cover::Conservative {
                // Whatever rounding does, no cell is missed.
                let missed = expected.keys().filter(|cell| !there.contains_key(*cell)).count();
                assert_eq!(missed, 0, "{name}");
            }
        }
    }
}

#[test]
fn every_point_of_a_triangle_is_in_a_conservative_voxel() {
    let Some(gpu) = gpu() else { return };
    let triangles = soup(800, 0.5);
    let scene = upload(&gpu, &[(Material::lambert("", Vec3::ONE), triangles.clone())]);
    let built = build(&gpu, &mut voxelizer(&gpu, &scene, Cover::Conservative), &scene, UNIT, 90);
    let mut random = Random(5);
    // Those without an area, once their corners are moved, have no cells.
    let is_there = |t: &&[Vec3; 3]| Sat::new(&built.layout, **t, Cover::Conservative).is_some();
    for triangle in triangles.iter().filter(is_there) {
        for _ in 0..100 {
            let (mut u, mut v) = (random.next(), random.next());
            if u + v > 1.0 {
                (u, v) = (1.0 - u, 1.0 - v);
            }
            let p = triangle[0] + u * (triangle[1] - triangle[0]) + v * (triangle[2] - triangle[0]);
            let p = (p - built.layout.origin) / built.layout.voxel_size;
            // Moving corners to the grain moves a point by at most 1/512 cell per axis.
            let is_near = (0..8).any(|i| {
                let offset =
                    Vec3::new(f32::from(i as u8 & 1), f32::from((i as u8 >> 1) & 1), f32::from(i as u8 >> 2));
                built.grid.occupied((p + (offset - 0.5) / 250.0).floor().as_ivec3())
            });
            assert!(is_near, "{p}");
        }
    }
}

#[test]
fn a_closed_sphere_lets_no_ray_out() {
    let Some(gpu) = gpu() else { return };
    let center = Vec3::splat(0.5);
    let scene = upload(&gpu, &[(Material::lambert("", Vec3::ONE), sphere(center, 0.48, 40))]);
    for cover in [Cover::Thin, Cover::Conservative] {
        let built = build(&gpu, &mut voxelizer(&gpu, &scene, cover), &scene, UNIT, 96);
        let mut random = Random(1);
        let out = (0..100_000)
            .filter(|_| {
                let origin = center + 0.4 * random.next() * random.direction();
                built.grid.trace(origin, random.direction(), 10.0).0.is_none()
            })
            .count();
        println!("{cover:?}: {} voxels, {out} of 100000 rays leave", built.voxels.voxel_count);
        assert_eq!(out, 0, "{cover:?}");
    }
}

#[test]
fn a_wall_on_a_boundary_is_one_layer_behind_its_face() {
    let Some(gpu) = gpu() else { return };
    let wall = quad(Vec3::new(0.0, 0.0, 0.5), Vec3::X, Vec3::Y);
    let scene = upload(&gpu, &[(Material::lambert("", Vec3::ONE), wall)]);
    let built = build(&gpu, &mut voxelizer(&gpu, &scene, Cover::Thin), &scene, UNIT, 20);
    // 16 cells across the box, and two of border: the face at 10 looks up, its layer is 9. Its edges lie on boundaries
    // too; what only touches a cell from outside does not set it.
    assert!(built.cells().iter().all(|c| c.z == 9), "{:?}", built.cells());
    assert_eq!(built.cells().len(), 256);
}

#[test]
fn one_triangle_of_the_whole_grid_and_many_in_one_voxel() {
    let Some(gpu) = gpu() else { return };
    // Lists of several chunks: 5,000 triangles within a voxel, one of which is nearest to its centre.
    let mut random = Random(8);
    let mut crowd: Vec<[Vec3; 3]> =
        (0..5000).map(|_| [0; 3].map(|_| Vec3::splat(0.5) + (random.point() - 0.5) / 400.0)).collect();
    crowd.push([Vec3::ZERO, Vec3::new(1.0, 0.93, 0.1), Vec3::new(0.9, 1.0, 0.97)]);
    let scene = upload(&gpu, &[(Material::lambert("", Vec3::ONE), crowd.clone())]);
    let mut found = Vec::new();
    for cover in [Cover::Thin, Cover::Conservative] {
        let built = build(&gpu, &mut voxelizer(&gpu, &scene, cover), &scene, UNIT, 260);
        let (expected, close) = winners(&built, &crowd, cover);
        let there: HashSet<IVec3> = built.cells().into_iter().collect();
        let differ = expected.keys().copied().collect::<HashSet<_>>();
        let wrong = differ.symmetric_difference(&there).filter(|c| !close.contains(*c)).count();
        println!("{cover:?}: {} voxels, {} close calls", there.len(), close.len());
        assert_eq!(wrong, 0, "{cover:?}");
        found.push(there);
    }
    assert!(found[0].is_subset(&found[1]));
}
