//! Frame by frame against a build of the same moment, cell by cell: occupancy, records, hits, what a walk skips.
#![allow(clippy::unwrap_used)]

use crate::test_scenes::{Built, Part, Random, build, geometry, gpu, quad, soup, sphere, upload_geometry};
use crate::{Rest, VoxelGrid, Voxelizer};
use frame::scene_gpu::{GpuScene, SceneOptions};
use frame::{FrameLog, Gpu, Recorder};
use glam::{EulerRot, Quat, Vec3};
use scene::{Aabb, Alpha, Geometry, Material, Scene};
use std::collections::BTreeMap;
use std::path::Path;

const UNIT: Aabb = Aabb { min: Vec3::ZERO, max: Vec3::ONE };

/// A grid that follows what moves.
struct Followed {
    voxelizer: Voxelizer,
    grid: VoxelGrid,
    rest: Rest,
}

impl Followed {
    fn new(gpu: &Gpu, scene: &GpuScene, bounds: Aabb, cells: u32, knobs: &[(&str, &str)]) -> Self {
        let mut voxelizer = Voxelizer::new(gpu, scene).unwrap();
        for (knob, value) in knobs {
            frame::set_knob(&mut voxelizer.knobs(), knob, value).unwrap();
        }
        let (grid, rest, _) = voxelizer.voxelize_rest(gpu, scene, &scene.mesh, bounds, cells).unwrap();
        Self { voxelizer, grid, rest }
    }

    fn frame(&mut self, gpu: &Gpu, scene: &GpuScene) -> FrameLog {
        let mut recorder = Recorder::new(gpu);
        let Self { voxelizer, grid, rest } = self;
        voxelizer.revoxelize(&mut recorder, scene, &scene.mesh, grid, rest).unwrap();
        let mut log = recorder.finish().unwrap();
        rest.settle(grid, &mut log);
        log
    }
}

/// Record by cell.
fn voxels(built: &Built) -> BTreeMap<[i32; 3], [u32; 4]> {
    built.cells().into_iter().map(|cell| (cell.to_array(), built.record(cell).unwrap())).collect()
}

/// Compares the grid that followed to a build of this moment.
fn assert_equal(name: &str, gpu: &Gpu, followed: &mut Followed, scene: &GpuScene, bounds: Aabb, cells: u32) {
    let log = followed.frame(gpu, scene);
    let built = build(gpu, &mut followed.voxelizer, scene, bounds, cells);
    let is = Built::read(gpu, followed.grid.clone(), log);
    let (there, expected) = (voxels(&is), voxels(&built));
    let differ = expected.iter().filter(|(cell, record)| there.get(*cell) != Some(record)).count();
    assert_eq!((there.len(), differ), (expected.len(), 0), "{name}: voxels; of them not in the other");
    let counted = (is.voxels.voxel_count, is.voxels.brick_count);
    assert_eq!(counted, (built.voxels.voxel_count, built.voxels.brick_count), "{name}: voxels and bricks");
    assert_eq!(is.voxels.glowing, built.voxels.glowing, "{name}");
    let mut random = Random(9);
    for _ in 0..2000 {
        let o = built.layout.origin
            + built.layout.voxel_size * random.point() * Vec3::from(built.layout.cells.map(|n| n as f32));
        let d = random.direction();
        let (a, b) = (is.grid.trace(o, d, 1e4), built.grid.trace(o, d, 1e4));
        let of = |built: &Built, hit: Option<crate::grid::reference::Hit>| {
            hit.map(|hit| (hit.cell, hit.distance.to_bits(), hit.axis, built.records[hit.record as usize]))
        };
        // As many steps: the same blocks were skipped.
        assert_eq!((of(&is, a.0), a.1), (of(&built, b.0), b.1), "{name}");
    }
}

/// Rotates an object about its own middle and moves it there.
fn place(rest: &Geometry, geometry: &mut Geometry, object: usize, turn: Quat, to: Vec3) {
    let own = rest.objects[object].vertices.start as usize..rest.objects[object].vertices.end as usize;
    let bounds = Aabb::of(rest.positions[own.clone()].iter().copied());
    let middle = 0.5 * (bounds.min + bounds.max);
    for v in own {
        geometry.positions[v] = to + turn * (rest.positions[v] - middle);
        geometry.normals[v] = turn * rest.normals[v];
        geometry.tangents[v] = (turn * rest.tangents[v].truncate()).extend(1.0);
    }
}

/// Triangles of all kinds at rest, and a ball, a lamp and a pane that move.
fn parts() -> (Vec<Part>, usize) {
    let glass = Material {
        alpha: Alpha::Blend,
        base_color: Vec3::ONE.extend(0.4),
        ..Material::lambert("", Vec3::ONE)
    };
    let lamp = Material::emitter("", Vec3::ZERO, Vec3::new(3.0, 2.0, 1.0));
    let rest = vec![
        (Material::lambert("", Vec3::X), soup(60, 0.5)),
        (lamp.clone(), quad(Vec3::new(0.2, 0.9, 0.2), 0.3 * Vec3::X, 0.2 * Vec3::Z)),
    ];
    let moving: [Part; 3] = [
        (Material::lambert("", Vec3::Y), sphere(Vec3::splat(0.5), 0.15, 8)),
        (lamp, quad(Vec3::splat(0.4), 0.1 * Vec3::X, 0.15 * Vec3::Y)),
        (glass, quad(Vec3::splat(0.4), 0.3 * Vec3::Z, 0.2 * Vec3::Y)),
    ];
    let first_moving = rest.len();
    (rest.into_iter().chain(moving).collect(), first_moving)
}

#[test]
fn any_sequence_of_motions_gives_the_voxels_of_a_build() {
    let Some(gpu) = gpu() else { return };
    let (parts, first_moving) = parts();
    let rest = geometry(&parts, first_moving);
    let mut now = rest.clone();
    let mut scene = upload_geometry(&gpu, &parts, &now);
    let conservative = [("voxelizer", "compute"), ("cover", "conservative")];
    let contours = [("contours", "on")];
    for (cells, knobs) in
        [(61, &[][..]), (100, &[]), (70, &conservative[..1]), (50, &conservative), (64, &contours)]
    {
        let mut followed = Followed::new(&gpu, &scene, UNIT, cells, knobs);
        let mut random = Random(cells);
        for step in 0..8 {
            for object in first_moving..parts.len() {
                // One in four stands still, one in four is far away; the others are somewhere, partly outside.
                let kind = random.next();
                let to = 1.4 * random.point() - 0.2;
                let [x, y, z] = (7.0 * random.point()).to_array();
                let turn = Quat::from_euler(EulerRot::XYZ, x, y, z);
                if kind > 0.25 {
                    let to = if kind > 0.75 { to + 10.0 * Vec3::X } else { to };
                    place(&rest, &mut now, object, turn, to);
                }
            }
            scene.update(&gpu, &now);
            assert_equal(&format!("{cells}, step {step}"), &gpu, &mut followed, &scene, UNIT, cells);
        }
    }
}

#[test]
fn what_leaves_restores_what_was_behind_it_and_what_is_outside_is_counted() {
    let Some(gpu) = gpu() else { return };
    let (parts, first_moving) = parts();
    let rest = geometry(&parts, first_moving);
    let mut scene = upload_geometry(&gpu, &parts, &rest);
    let mut followed = Followed::new(&gpu, &scene, UNIT, 80, &[]);
    let away = |scene: &mut GpuScene, to: Vec3| {
        let mut now = rest.clone();
        for object in first_moving..parts.len() {
            place(&rest, &mut now, object, Quat::IDENTITY, to);
        }
        scene.update(&gpu, &now);
    };
    let moving: usize = parts[first_moving..].iter().map(|(_, triangles)| triangles.len()).sum();
    let untouched = voxels(&Built::read(&gpu, followed.grid.clone(), FrameLog::default()));

    away(&mut scene, Vec3::splat(0.5));
    let inside = followed.frame(&gpu, &scene);
    assert_eq!(inside.counts["clipped_triangles"], 0.0);
    assert_ne!(voxels(&Built::read(&gpu, followed.grid.clone(), FrameLog::default())), untouched);
    let touched = inside.counts["dirty_bricks"];
    assert_eq!(touched, inside.counts["moving_bricks"]);

    away(&mut scene, Vec3::splat(7.0));
    let outside = followed.frame(&gpu, &scene);
    assert_eq!(outside.counts["clipped_triangles"], moving as f64);
    // Those of the frame before.
    assert_eq!((outside.counts["dirty_bricks"], outside.counts["moving_bricks"]), (touched, 0.0));
    assert_eq!(voxels(&Built::read(&gpu, followed.grid.clone(), FrameLog::default())), untouched);

    let after = followed.frame(&gpu, &scene);
    assert_eq!((after.counts["dirty_bricks"], after.counts["dirty_share"]), (0.0, 0.0));
    assert_equal("outside", &gpu, &mut followed, &scene, UNIT, 80);
}

#[test]
fn animated_files_give_the_voxels_of_a_build_at_every_moment() {
    let Some(gpu) = gpu() else { return };
    let shared = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/scenes"));
    for (file, cells) in [
        ("box_animated/BoxAnimated.gltf", 60),
        ("fox_skinned/Fox.gltf", 90),
        ("morph_stress_test/MorphStressTest.gltf", 60),
    ] {
        let path = shared.join(file);
        if !path.exists() {
            println!("skipped: no scene at {}", path.display());
            continue;
        }
        let scene = Scene::load(&path.to_string_lossy()).unwrap();
        let mut now = scene.rest().clone();
        let options = SceneOptions { texture_budget_bytes: Some(20_000_000), ..Default::default() };
        let (mut uploaded, _) = GpuScene::new(&gpu, &scene, &now, &options).unwrap();
        let bounds = scene.bounds();
        let mut followed = Followed::new(&gpu, &uploaded, bounds, cells, &[]);
        for step in 0..6 {
            // Out of order: what a frame shows does not depend on the frame before.
            let time = scene.duration() * ((step * 5) % 7) as f32 / 7.0;
            scene.pose(time, &mut now);
            uploaded.update(&gpu, &now);
            assert_equal(&format!("{file} at {time} s"), &gpu, &mut followed, &uploaded, bounds, cells);
        }
    }
}
