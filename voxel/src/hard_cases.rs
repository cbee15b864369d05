//! Scenes that break voxelizers: with each of them the right voxels, or an error that says why not.

use crate::test_scenes::{Built, build, gpu, number, numbered, quad, upload};
use crate::{VoxelError, Voxelizer};
use frame::scene_gpu::GpuScene;
use frame::{Gpu, GpuError};
use glam::Vec3;
use scene::{Aabb, Material};

const UNIT: Aabb = Aabb { min: Vec3::ZERO, max: Vec3::ONE };

/// All ways to voxelize.
const WAYS: [[&str; 3]; 4] = [
    ["raster", "thin", "all"],
    ["raster", "thin", "dominant"],
    ["compute", "thin", "all"],
    ["compute", "conservative", "all"],
];

fn voxelizer(gpu: &Gpu, scene: &GpuScene, way: [&str; 3]) -> Voxelizer {
    let mut voxelizer = Voxelizer::new(gpu, scene).unwrap();
    for (knob, value) in ["voxelizer", "cover", "axes"].into_iter().zip(way) {
        frame::set_knob(&mut voxelizer.knobs(), knob, value).unwrap();
    }
    voxelizer
}

fn grey(triangles: Vec<[Vec3; 3]>) -> (Material, Vec<[Vec3; 3]>) {
    (Material::lambert("", Vec3::splat(0.5)), triangles)
}

/// The same voxels: cells and records.
fn assert_same(name: &str, a: &Built, b: &Built) {
    assert_eq!(a.cells(), b.cells(), "{name}");
    assert!(a.cells().iter().all(|cell| a.record(*cell) == b.record(*cell)), "{name}");
}

#[test]
fn what_is_no_surface_or_is_elsewhere_changes_nothing() {
    let Some(gpu) = gpu() else { return };
    let wall = quad(Vec3::new(0.1, 0.2, 0.53), 0.7 * Vec3::X, 0.6 * Vec3::Y);
    let point = Vec3::splat(0.4);
    let far = |reach: f32| quad(Vec3::splat(reach), Vec3::X, Vec3::Y);
    let cases: [(&str, Vec<[Vec3; 3]>); 7] = [
        ("a point", vec![[point; 3]]),
        ("a line", vec![[point, point + 0.1, point + 0.2]]),
        ("two corners", vec![[point, Vec3::X, Vec3::X]]),
        ("not numbers", vec![[Vec3::NAN; 3], [point, Vec3::X, Vec3::new(0.0, f32::NAN, 0.0)]]),
        ("infinite", vec![[point, Vec3::X, Vec3::INFINITY], [Vec3::NEG_INFINITY, point, Vec3::X]]),
        ("far away", [far(3.0), far(-1e4), far(1e9), far(1e30), far(-1e38)].concat()),
        ("much smaller than a voxel, outside", vec![[2.0 * Vec3::X, 2.0 * Vec3::X + 1e-7, 2.0 * Vec3::ONE]]),
    ];
    for way in WAYS {
        let scene = upload(&gpu, &[grey(wall.clone())]);
        let mut voxelizer = voxelizer(&gpu, &scene, way);
        let alone = build(&gpu, &mut voxelizer, &scene, UNIT, 40);
        assert!(!alone.cells().is_empty());
        for (name, more) in &cases {
            let scene = upload(&gpu, &[grey(wall.clone()), grey(more.clone())]);
            let built = build(&gpu, &mut voxelizer, &scene, UNIT, 40);
            assert_same(&format!("{name}, {way:?}"), &built, &alone);
        }
        let nothing = upload(&gpu, &[grey(Vec::new())]);
        let built = build(&gpu, &mut voxelizer, &nothing, Aabb::EMPTY, 40);
        assert_eq!((built.voxels.voxel_count, built.voxels.brick_count), (0, 0), "{way:?}");
    }
}

#[test]
fn a_gigantic_triangle_covers_its_layer() {
    let Some(gpu) = gpu() else { return };
    let any = upload(&gpu, &[grey(Vec::new())]);
    let mut ways = WAYS.map(|way| (way, voxelizer(&gpu, &any, way)));
    // In the middle of a layer; its other corners are ever farther away.
    for reach in [1e1, 1e3, 1e5] {
        let corners = [
            Vec3::new(-reach, -reach, 0.53),
            Vec3::new(3.0 * reach, -reach, 0.53),
            Vec3::new(-reach, 3.0 * reach, 0.53),
        ];
        let scene = upload(&gpu, &[grey(vec![corners])]);
        for (way, voxelizer) in &mut ways {
            let built = build(&gpu, voxelizer, &scene, UNIT, 40);
            let cells = built.cells();
            let layers: std::collections::BTreeSet<i32> = cells.iter().map(|c| c.z).collect();
            assert_eq!((cells.len(), layers.len()), (1600, 1), "{reach} m, {way:?}");
        }
    }
}

#[test]
fn a_million_triangles_in_one_voxel_have_one_winner() {
    let Some(gpu) = gpu() else { return };
    // 2^20 parallel triangles within the middle voxel of 21, all over its centre. The nearest distance of 1/128 voxel is
    // that of the last 256; of those the first wins.
    let count = 1u32 << 20;
    let side = 1.0 / 17.0;
    let middle = Vec3::splat(0.5);
    let parts: Vec<_> = (0..count)
        .map(|n| {
            let depth = if n < count - 256 { 0.3 } else { 0.0 };
            let at = middle + side * depth * Vec3::Z;
            [(-0.4, -0.4), (0.45, -0.4), (-0.4, 0.45)].map(|(x, y)| at + side * Vec3::new(x, y, 0.0))
        })
        .collect();
    let (crowd, last) = parts.split_at(count as usize - 256);
    // Materials are few: one for the crowd, one for each of the last.
    let mut objects = vec![grey(crowd.to_vec())];
    objects.extend(numbered(last));
    let scene = upload(&gpu, &objects);
    for way in [WAYS[0], WAYS[2], WAYS[3]] {
        let built = build(&gpu, &mut voxelizer(&gpu, &scene, way), &scene, UNIT, 21);
        println!("{way:?}: {:?}", built.log.counts);
        let cells = built.cells();
        assert_eq!(cells, [glam::IVec3::splat(10)], "{way:?}");
        assert_eq!(number(built.record(cells[0]).unwrap()), 0, "{way:?}");
    }
}

#[test]
fn grids_too_small_and_too_large_are_refused_with_numbers() {
    let Some(gpu) = gpu() else { return };
    let scene = upload(&gpu, &[grey(quad(Vec3::ZERO, Vec3::X, Vec3::Y))]);
    let most = gpu.device.limits().max_texture_dimension_2d;
    for way in [WAYS[0], WAYS[2]] {
        let mut voxelizer = voxelizer(&gpu, &scene, way);
        for grid in [0, 1, 4, most + 1, u32::MAX] {
            let refused = voxelizer.voxelize(&gpu, &scene, &scene.mesh, UNIT, grid).map(|_| ());
            let is_clear = matches!(refused, Err(VoxelError::Grid { grid: g, least: 5, most: m }) if g == grid && m == most);
            assert!(is_clear, "{grid}: {refused:?}");
        }
        // One voxel across, and two of border on each side.
        let built = build(&gpu, &mut voxelizer, &scene, UNIT, 5);
        assert_eq!((built.layout.cells, built.voxels.voxel_count > 0), ([5; 3], true), "{way:?}");
        // A cube of the largest grid does not fit a binding.
        let refused = voxelizer.voxelize(&gpu, &scene, &scene.mesh, UNIT, most).map(|_| ());
        assert!(matches!(refused, Err(VoxelError::Gpu(GpuError::TooLarge { .. }))), "{refused:?}");
        // A rod of it does.
        let rod = Aabb { min: Vec3::ZERO, max: Vec3::new(1.0, 0.001, 0.001) };
        let scene = upload(&gpu, &[grey(quad(Vec3::ZERO, Vec3::X, 0.001 * Vec3::Y))]);
        let built = build(&gpu, &mut voxelizer, &scene, rod, most);
        assert_eq!(built.layout.cells[0], most);
        assert!(built.voxels.voxel_count >= 8 * (most - 4), "{way:?}: {}", built.voxels.voxel_count);
    }
}
