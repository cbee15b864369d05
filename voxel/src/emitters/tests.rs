//! The power of a voxelized lamp against that of its triangles, counted along random lines.
#![allow(clippy::unwrap_used)]

use super::LINES;
use super::cast::Tree;
use super::flux::{Frame, Lamp, Lit, factor};
use crate::Voxelizer;
use crate::test_scenes::{Part, Random, build, gpu, quad, sphere, upload};
use frame::Gpu;
use frame::surface::Surface;
use glam::{EulerRot, IVec3, Mat3, Quat, Vec3};
use scene::{Aabb, Material};

const UNIT: Aabb = Aabb { min: Vec3::ZERO, max: Vec3::ONE };

fn area(triangles: &[[Vec3; 3]]) -> f64 {
    triangles.iter().map(|[a, b, c]| f64::from(0.5 * (*b - *a).cross(*c - *a).length())).sum()
}

/// The area of one-sided surface, in cell faces, that lights the outside as much as these voxels do.
fn leaving(voxels: &[Lit], frame: Frame, seed: u32) -> f64 {
    let lamp = Lamp::new(voxels).unwrap();
    let met: f64 = frame.lines(LINES, seed).map(|(o, d)| f64::from(lamp.met(o, d))).sum();
    frame.surface() * met / f64::from(LINES)
}

/// Power of the records over that of the triangles, whose light must all leave them.
fn ratio(gpu: &Gpu, triangles: &[[Vec3; 3]], grid: u32, knobs: &[(&str, &str)]) -> f64 {
    let lamp: Part = (Material::emitter("", Vec3::ZERO, Vec3::splat(3.0)), triangles.to_vec());
    let scene = upload(gpu, &[lamp]);
    let mut voxelizer = Voxelizer::new(gpu, &scene).unwrap();
    for (knob, value) in knobs {
        frame::set_knob(&mut voxelizer.knobs(), knob, value).unwrap();
    }
    let built = build(gpu, &mut voxelizer, &scene, UNIT, grid);
    let lit: Vec<Lit> = built
        .cells()
        .into_iter()
        .map(|cell| {
            let surface = Surface::unpack_voxel(built.record(cell).unwrap());
            Lit { cell, normal: surface.normal, share: surface.emission.x / (3.0 * scene.radiance_scale) }
        })
        .collect();
    let size = built.layout.voxel_size;
    let in_cells: Vec<_> = triangles.iter().map(|t| t.map(|p| (p - built.layout.origin) / size)).collect();
    leaving(&lit, Frame::around(&lit, &in_cells).unwrap(), 77) * f64::from(size * size) / area(triangles)
}

#[test]
fn a_lamp_keeps_its_power() {
    let Some(gpu) = gpu() else { return };
    let turned = |x, y, z| {
        let q = Quat::from_euler(EulerRot::XYZ, x, y, z);
        quad(Vec3::splat(0.5) - q * Vec3::new(0.25, 0.2, 0.0), q * (0.5 * Vec3::X), q * (0.4 * Vec3::Y))
    };
    let round = |rows| sphere(Vec3::splat(0.5), 0.3, rows);
    for (name, triangles) in [
        ("flat", turned(0.0, 0.0, 0.0)),
        ("flat, off the grid", quad(Vec3::new(0.213, 0.347, 0.4), 0.3 * Vec3::X, 0.2 * Vec3::Y)),
        ("turned about one axis", turned(0.0, 0.6, 0.0)),
        ("at 45 degrees", turned(0.0, std::f32::consts::FRAC_PI_4, 0.0)),
        ("turned about all", turned(0.5, 0.7, 0.3)),
        (
            "long and thin",
            quad(Vec3::new(0.1, 0.2, 0.3), Vec3::new(0.8, 0.3, 0.4), Vec3::new(-0.01, 0.027, 0.0)),
        ),
        ("sphere", round(12)),
        ("sphere of small triangles", round(120)),
    ] {
        let conservative = [("voxelizer", "compute"), ("cover", "conservative")];
        for knobs in [&[][..], &conservative[..1], &conservative, &conservative[1..]] {
            let ratio = ratio(&gpu, &triangles, 100, knobs);
            println!("{name}, {knobs:?}: {ratio:.4}");
            // 1 % is the contract's; RGB9E5 takes up to 0.2 % of it, the noise of the two counts the rest.
            assert!((ratio - 1.0).abs() < 0.01, "{name}, {knobs:?}: {ratio}");
        }
    }
}

#[test]
fn lines_count_a_layer_by_its_area() {
    // One layer of 10 x 20 voxels that all face up: 200 faces, and the rim's 60 that are entered by half of the lines.
    // Nothing shades anything.
    let layer: Vec<Lit> =
        (0..200).map(|i| Lit { cell: IVec3::new(i % 10, i / 10, 3), normal: Vec3::Z, share: 1.0 }).collect();
    let turned = Mat3::from_euler(EulerRot::XYZ, 0.4, 0.5, 0.6);
    for frame in [Mat3::IDENTITY, turned].map(|m| [[Vec3::ZERO, m * Vec3::X, m * Vec3::Y]]) {
        let area = leaving(&layer, Frame::around(&layer, &frame).unwrap(), 5);
        // About a third of the lines meet the layer: 1/362 of them is a standard error if they were independent.
        assert!((area - 230.0).abs() < 2.0 * 230.0 / 362.0, "{area}");
    }
    assert!(Lamp::new(&[]).is_none());
}

#[test]
fn lines_find_the_front_of_the_first_triangle() {
    let tree = Tree::new(sphere(Vec3::ZERO, 1.0, 16));
    let mut random = Random(4);
    for _ in 0..2000 {
        let d = random.direction();
        let across = d.any_orthonormal_vector();
        assert_eq!(tree.meets_front(-3.0 * d + 0.9 * across, d), Some(true));
        assert_eq!(tree.meets_front(0.5 * across, d), Some(false), "from inside");
        assert_eq!(tree.meets_front(-3.0 * d + 1.01 * across, d), None);
    }
    assert_eq!(Tree::new(Vec::new()).meets_front(Vec3::ZERO, Vec3::X), None);
}

#[test]
fn a_room_needs_no_factor() {
    let walls =
        (0..3).flat_map(|axis| [(axis, 1.0, 1.0), (axis, 9.0, -1.0)]).flat_map(|(axis, layer, sign)| {
            let axes = [Vec3::X, Vec3::Y, Vec3::Z];
            let (u, v) = (8.0 * axes[(axis + 1) % 3], 8.0 * axes[(axis + 2) % 3]);
            let corner = Vec3::ONE.with_x(1.0) + (layer - 1.0) * axes[axis];
            if sign > 0.0 { quad(corner, u, v) } else { quad(corner, v, u) }
        });
    let walls: Vec<_> = walls.collect();
    let lit: Vec<Lit> = (1..9)
        .flat_map(|x| (1..9).map(move |y| IVec3::new(x, y, 0)))
        .map(|cell| Lit { cell, normal: Vec3::Z, share: 1.0 })
        .collect();
    assert_eq!(factor(&lit, walls, 6.0 * 64.0, 1 << 14, 1), 1.0);
}
