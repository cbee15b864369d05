//! The power of a voxelized lamp against that of its triangles.
#![allow(clippy::unwrap_used)]

use super::LINES;
use super::flux::{Lamp, Lit};
use crate::test_scenes::{Part, gpu, quad, sphere, upload, voxelize};
use frame::surface::Surface;
use glam::{EulerRot, Quat, Vec3};
use scene::{Aabb, Material};

const UNIT: Aabb = Aabb { min: Vec3::ZERO, max: Vec3::ONE };

fn area(triangles: &[[Vec3; 3]]) -> f64 {
    triangles.iter().map(|[a, b, c]| f64::from(0.5 * (*b - *a).cross(*c - *a).length())).sum()
}

/// Power of the records over that of the triangles, with lines of another seed than the factors were counted with.
fn ratio(gpu: &frame::Gpu, triangles: &[[Vec3; 3]], grid: u32) -> f64 {
    let lamp: Part = (Material::emitter("", Vec3::ZERO, Vec3::splat(3.0)), triangles.to_vec());
    let scene = upload(gpu, &[lamp]);
    let built = voxelize(gpu, &scene, UNIT, grid);
    let lit: Vec<Lit> = built
        .cells()
        .into_iter()
        .map(|cell| {
            let surface = Surface::unpack_voxel(built.record(cell).unwrap());
            Lit { cell, normal: surface.normal, share: surface.emission.x / (3.0 * scene.radiance_scale) }
        })
        .collect();
    let voxel_area = f64::from(built.layout.voxel_size).powi(2);
    Lamp::new(&lit).unwrap().area(LINES, 77) * voxel_area / area(triangles)
}

#[test]
fn a_lamp_keeps_its_power() {
    let Some(gpu) = gpu() else { return };
    let turned = |x, y, z| {
        let q = Quat::from_euler(EulerRot::XYZ, x, y, z);
        quad(Vec3::splat(0.5) - q * Vec3::new(0.15, 0.1, 0.0), q * (0.3 * Vec3::X), q * (0.2 * Vec3::Y))
    };
    let round = |rows| sphere(Vec3::splat(0.5), 0.1, rows);
    for (name, triangles) in [
        ("flat", turned(0.0, 0.0, 0.0)),
        ("flat, off the grid", quad(Vec3::new(0.213, 0.347, 0.4), 0.3 * Vec3::X, 0.2 * Vec3::Y)),
        ("turned about one axis", turned(0.0, 0.6, 0.0)),
        ("at 45 degrees", turned(0.0, std::f32::consts::FRAC_PI_4, 0.0)),
        ("turned about all", turned(0.5, 0.7, 0.3)),
        ("long and thin", quad(Vec3::new(0.1, 0.2, 0.3), Vec3::new(0.8, 0.3, 0.4), Vec3::new(-0.01, 0.027, 0.0))),
        ("sphere", round(12)),
        ("sphere of small triangles", round(120)),
    ] {
        let ratio = ratio(&gpu, &triangles, 100);
        println!("{name}: {ratio:.4}");
        // 1 % is the contract's; RGB9E5 takes up to 0.2 % of it, the two counts the rest.
        assert!((ratio - 1.0).abs() < 0.01, "{name}: {ratio}");
    }
}

#[test]
fn lines_count_a_face_by_its_area() {
    // One layer of 10 x 20 voxels that all face up: 200 faces, and the rim's 60 that also let light out upwards; from
    // the rim, lines that rise are not met, those that sink are half of them.
    let lit: Vec<Lit> = (0..200)
        .map(|i| Lit { cell: glam::IVec3::new(i % 10, i / 10, 3), normal: Vec3::Z, share: 1.0 })
        .collect();
    let area = Lamp::new(&lit).unwrap().area(LINES, 5);
    assert!((area - 230.0).abs() < 230.0 / 512.0, "{area}");
    assert!(Lamp::new(&[]).is_none());
}
