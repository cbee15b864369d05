//! The device against the f64 reference, cell by cell; watertightness; who wins.
#![allow(clippy::unwrap_used)]

use super::Axes;
use super::reference::{Columns, winners};
use crate::grid::reference::CpuGrid;
use crate::test_scenes::{
    Built, Part, Random, build, gpu, number, numbered, quad, soup, sphere, upload, voxelize,
};
use crate::{VoxelError, Voxelizer};
use frame::surface::Surface;
use glam::{IVec3, Quat, Vec3};
use scene::{Aabb, Alpha, Material};
use std::collections::{HashMap, HashSet};

const UNIT: Aabb = Aabb { min: Vec3::ZERO, max: Vec3::ONE };

/// Cells where f32 and f64 may differ: some triangle's depth or distance is so near a step that an error tips it. Depths
/// err by 2^-11 cell (half of what ties are moved by), and where a triangle is a sliver seen from its edge by what
/// cancels in its normal: 2^-21 of the product of its sides, per cell of its length.
fn close_calls(built: &Built, triangles: &[[Vec3; 3]], axes: Axes) -> HashSet<IVec3> {
    let mut cells = HashSet::new();
    for triangle in triangles {
        let [a, b, c] = triangle.map(|p| (p / built.layout.voxel_size).as_dvec3());
        let (ab, ac) = (b - a, c - a);
        for columns in Columns::all(&built.layout, *triangle, axes) {
            let part = ab.cross(ac)[columns.axis].abs().max(1e-9);
            let sides = ab.length() * ac.length();
            let error = 1.0 / 2048.0 + sides * ab.length().max(ac.length()) / part / 2f64.powi(21);
            for [u, v] in columns.bounds(&built.layout).filter(|[u, v]| columns.covers(*u, *v)) {
                // Distances have steps of 1/128 cell, depths of a whole one; an error of the depth is the larger one.
                let tips = |x: f64, step: f64| (x / step - (x / step).round()).abs() * step < error;
                let near = tips(columns.depth(u, v), 1.0) || tips(columns.miss(u, v), 1.0 / 128.0);
                let reach = error.ceil().min(8.0) as i32;
                let mut axis = IVec3::ZERO;
                axis[columns.axis] = 1;
                if near {
                    cells.extend((-reach..=reach).map(|k| columns.cell(u, v) + k * axis));
                }
            }
        }
    }
    cells
}

fn compare(name: &str, built: &Built, triangles: &[[Vec3; 3]], axes: Axes) {
    let expected = winners(&built.layout, axes, triangles.iter().map(|t| (*t, 1)));
    let close = close_calls(built, triangles, axes);
    let there: HashMap<IVec3, u32> =
        built.cells().into_iter().map(|c| (c, number(built.record(c).unwrap()))).collect();
    let (mut differ, mut excused) = (0, 0);
    for cell in expected.keys().chain(there.keys()).collect::<HashSet<_>>() {
        if expected.get(cell).map(|key| key & 0xff_ffff) == there.get(cell).copied() {
            continue;
        }
        if close.contains(cell) {
            excused += 1;
        } else {
            differ += 1;
            println!("{cell}: expected {:x?}, is {:x?}", expected.get(cell), there.get(cell));
        }
    }
    println!("{name}: {} cells, {excused} of {} close calls fell otherwise", there.len(), close.len());
    assert_eq!(differ, 0, "{name}");
    assert_eq!(there.len(), built.voxels.voxel_count as usize);
    assert!(excused * 1000 <= there.len(), "{name}: {excused} of {}", there.len());
    let twin = CpuGrid::new(&built.layout, there.into_keys());
    assert!(twin.structure == built.grid.structure, "{name}: the structure is not the one its cells make");
}

#[test]
fn the_device_finds_the_same_winners_as_the_cpu() {
    let Some(gpu) = gpu() else { return };
    for (name, triangles, grid) in [
        ("soup", soup(3000, 0.3), 100),
        ("splinters", soup(3000, 0.03), 61),
        ("sphere", sphere(Vec3::splat(0.5), 0.47, 20), 130),
    ] {
        let scene = upload(&gpu, &numbered(&triangles));
        let mut voxelizer = Voxelizer::new(&gpu, &scene).unwrap();
        for (text, axes) in [("all", Axes::All), ("dominant", Axes::Dominant)] {
            frame::set_knob(&mut voxelizer.knobs(), "axes", text).unwrap();
            let built = build(&gpu, &mut voxelizer, &scene, UNIT, grid);
            compare(&format!("{name}, {text} axes"), &built, &triangles, axes);
        }
    }
}

#[test]
fn two_builds_and_any_batch_size_give_equal_bits() {
    let Some(gpu) = gpu() else { return };
    let scene = upload(&gpu, &numbered(&soup(2000, 0.4)));
    let mut voxelizer = Voxelizer::new(&gpu, &scene).unwrap();
    let first = build(&gpu, &mut voxelizer, &scene, UNIT, 90);
    for slots in [65_536, 700, 101] {
        voxelizer.slots_per_batch = slots;
        let again = build(&gpu, &mut voxelizer, &scene, UNIT, 90);
        assert!(first.grid.structure == again.grid.structure, "structure, batches of {slots}");
        assert!(first.records == again.records, "records, batches of {slots}");
    }
    let counts = &first.log.counts;
    println!("{} rounds, {} atomic", counts["raster_rounds"], counts["atomic_rounds"]);
}

#[test]
fn a_closed_sphere_lets_no_ray_out() {
    let Some(gpu) = gpu() else { return };
    let center = Vec3::splat(0.5);
    let triangles = sphere(center, 0.48, 40);
    let scene = upload(&gpu, &[(Material::lambert("", Vec3::ONE), triangles)]);
    let mut voxelizer = Voxelizer::new(&gpu, &scene).unwrap();
    let mut leaks = |axes| {
        frame::set_knob(&mut voxelizer.knobs(), "axes", axes).unwrap();
        let built = build(&gpu, &mut voxelizer, &scene, UNIT, 96);
        let mut random = Random(1);
        let rays =
            (0..100_000).map(|_| (center + 0.4 * random.next() * random.direction(), random.direction()));
        let out = rays
            .filter(|(origin, direction)| built.grid.trace(*origin, *direction, 10.0).0.is_none())
            .count();
        println!("{axes} axes: {} voxels, {out} of 100000 rays leave", built.voxels.voxel_count);
        (out, built.voxels.voxel_count)
    };
    let (out, all) = leaks("all");
    let (_, dominant) = leaks("dominant");
    assert_eq!(out, 0);
    // What closes the surface is few.
    assert!(all < dominant + dominant / 50, "{all} {dominant}");
}

#[test]
fn the_furnace_keeps_its_inside_and_nothing_else() {
    let Some(gpu) = gpu() else { return };
    let scene = scene::Scene::load("furnace").unwrap();
    let (scene, _) =
        frame::scene_gpu::GpuScene::new(&gpu, &scene, scene.rest(), &Default::default()).unwrap();
    let mut voxelizer = Voxelizer::new(&gpu, &scene).unwrap();
    for grid in [37, 64, 101] {
        let built = build(&gpu, &mut voxelizer, &scene, scene.bounds, grid);
        let inner = grid as i32 - 4;
        // Each wall is one whole layer behind its face, the edges between walls are open.
        for cell in built.cells() {
            let outside = (0..3).filter(|&k| cell[k] == 1 || cell[k] == inner + 2).count();
            let inside = (0..3).filter(|&k| (2..inner + 2).contains(&cell[k])).count();
            assert_eq!((outside, inside), (1, 2), "grid {grid}: {cell}");
            let surface = Surface::unpack_voxel(built.record(cell).unwrap());
            assert_eq!(surface.emission, Vec3::splat(0.5 * scene.radiance_scale), "grid {grid}: {cell}");
            let to_middle = 0.5 * f32::from(grid as u16) - (cell.as_vec3() + 0.5);
            assert!(surface.normal.dot(to_middle) > 0.0, "grid {grid}: {cell}");
        }
        assert_eq!(built.voxels.voxel_count as i32, 6 * inner * inner, "grid {grid}");
    }
}

#[test]
fn brighter_nearer_lower_wins() {
    let Some(gpu) = gpu() else { return };
    let wall = |depth: f32| quad(Vec3::new(0.0, 0.0, depth), Vec3::X, Vec3::Y);
    let glass = Material {
        alpha: Alpha::Blend,
        base_color: Vec3::ONE.extend(0.4),
        ..Material::lambert("", Vec3::ONE)
    };
    let [red, green] = [Vec3::X, Vec3::Y].map(|color| Material::lambert("", color));
    let lamp = Material::emitter("", Vec3::Z, Vec3::ONE);
    // Layers of 1/16: within one of them, depths in sixteenths of it from its low face.
    let at = |sixteenths: f32| wall((8.0 + sixteenths / 16.0) / 16.0);
    let cases: [(&str, Vec<Part>, Vec3, f32); 5] = [
        ("opaque beats blended", vec![(glass.clone(), at(8.0)), (red.clone(), at(1.0))], Vec3::X, 1.0),
        ("emitting beats opaque", vec![(red.clone(), at(8.0)), (lamp.clone(), at(1.0))], Vec3::Z, 1.0),
        ("nearer the centre", vec![(red.clone(), at(2.0)), (green.clone(), at(9.0))], Vec3::Y, 1.0),
        ("lower number", vec![(red.clone(), at(8.0)), (green.clone(), at(8.0))], Vec3::X, 1.0),
        ("alone it blends", vec![(glass, at(8.0))], Vec3::ONE, 0.4),
    ];
    for (name, parts, color, coverage) in cases {
        let built = voxelize(&gpu, &upload(&gpu, &parts), UNIT, 20);
        let cells = built.cells();
        assert_eq!(cells.len(), 256, "{name}");
        let surfaces: Vec<_> =
            cells.iter().map(|c| Surface::unpack_voxel(built.record(*c).unwrap())).collect();
        assert!(surfaces.iter().all(|s| s.base == color), "{name}: {:?}", surfaces[0]);
        let mean = surfaces.iter().map(|s| s.coverage).sum::<f32>() / 256.0;
        // 0.6 is exactly 9 of 15 steps.
        assert!((mean - coverage).abs() < 1e-5, "{name}: {mean}");
    }
}

#[test]
fn what_has_no_extent_has_no_voxels_and_too_much_is_refused() {
    let Some(gpu) = gpu() else { return };
    let grey = Material::lambert("", Vec3::splat(0.5));
    let nothing = upload(&gpu, &[(grey.clone(), vec![])]);
    let mut voxelizer = Voxelizer::new(&gpu, &nothing).unwrap();
    let built = build(&gpu, &mut voxelizer, &nothing, Aabb::EMPTY, 64);
    assert_eq!((built.voxels.voxel_count, built.voxels.brick_count), (0, 0));
    assert_eq!(built.grid.trace(Vec3::splat(-9.0), Vec3::ONE.normalize(), 99.0).0, None);

    let broken =
        [[Vec3::ZERO; 3], [Vec3::NAN, Vec3::X, Vec3::Y], [Vec3::ZERO, Vec3::X * 1e-30, Vec3::Y * 1e30]];
    let flat = upload(&gpu, &[(grey, [quad(Vec3::ZERO, Vec3::X, Vec3::Y), broken.to_vec()].concat())]);
    let bounds = Aabb { min: Vec3::ZERO, max: Vec3::new(1.0, 1.0, 0.0) };
    for grid in [5, 6, 33] {
        let built = build(&gpu, &mut voxelizer, &flat, bounds, grid);
        assert_eq!(built.layout.cells, [grid, grid, 4]);
        assert_eq!(built.voxels.voxel_count, (grid - 4) * (grid - 4), "grid {grid}");
    }
    let refused = voxelizer.voxelize(&gpu, &flat, &flat.mesh, bounds, 4).map(|_| ());
    assert!(matches!(refused, Err(VoxelError::Grid { grid: 4, least: 5, .. })), "{refused:?}");
}

#[test]
fn shares_of_columns_add_up() {
    let layout = crate::grid::Layout::fit(UNIT, 36, 8192).unwrap();
    let turned = Quat::from_euler(glam::EulerRot::XYZ, 0.3, 0.2, 0.7);
    let lamp = quad(Vec3::splat(0.3), turned * (0.41 * Vec3::X), turned * (0.37 * Vec3::Y));
    for triangle in &lamp {
        let columns = Columns::all(&layout, *triangle, Axes::Dominant)[0];
        let sum: f64 = columns.bounds(&layout).map(|[u, v]| columns.cover(u, v)).sum();
        // The projected area; moving corners by up to 1/512 cell changes an area of some 80 by 0.1 at most.
        let n = (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]);
        let area = f64::from(0.5 * n.abs().max_element() / layout.voxel_size.powi(2));
        assert!((sum - area).abs() < 0.1, "{sum} {area}");
    }
}
