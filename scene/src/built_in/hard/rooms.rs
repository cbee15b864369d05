//! Closed rooms: radiance `e / (1 - a)` = 1 at albedo and emission 1/2, or 0 where no light can come in; and rooms that
//! light can hardly enter.

use super::super::{assembly::Assembly, part::Part};
use crate::{Camera, Material, Scene, Sky, Sun};
use glam::{Quat, Vec3};
use std::f32::consts::FRAC_PI_2;

/// Seen from its middle, towards an edge.
fn camera(eye: Vec3, target: Vec3) -> Vec<Camera> {
    vec![Camera { name: "inside".into(), eye, target, up: Vec3::Y, vfov: FRAC_PI_2 }]
}

/// Albedo 1/2, emission 1/2: stored without rounding.
fn half() -> Material {
    Material::emitter("wall", Vec3::splat(0.5), Vec3::splat(0.5))
}

const AXES: [Vec3; 3] = [Vec3::X, Vec3::Y, Vec3::Z];

/// A wall of a cube around `centre`: middle, right and up (m), the front inwards where `facing` is 1.
fn wall(centre: Vec3, half: f32, axis: usize, side: f32, facing: f32) -> [Vec3; 4] {
    let out = AXES[axis] * side;
    let right = AXES[(axis + 1) % 3] * facing;
    let up = (AXES[(axis + 1) % 3]).cross(out);
    [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
        .map(|(r, u): (f32, f32)| centre + half * (out + r * right + u * up))
}

/// All six walls of a cube that faces inwards, or outwards at `facing` -1.
fn cube(part: &mut Part, centre: Vec3, half: f32, facing: f32) {
    for axis in 0..3 {
        for side in [1.0, -1.0] {
            part.quad(wall(centre, half, axis, side, facing));
        }
    }
}

fn closed(name: &str, material: Material, centre: Vec3, half: f32, facing: f32) -> Scene {
    let mut scene = Assembly::default();
    let mut walls = Part::new("walls", scene.material(material));
    cube(&mut walls, centre, half, facing);
    scene.add(walls);
    let target = centre + half * Vec3::new(1.0, -0.4, -1.0);
    scene.finish(name, camera(centre, target), Sky::Constant(Vec3::ZERO))
}

/// A cube of this side, m.
pub(super) fn plain(side: f32) -> Scene {
    let name = match side {
        s if s < 0.1 => "room_1mm",
        s if s > 10.0 => "room_10km",
        _ => "room_1m",
    };
    closed(name, half(), Vec3::ZERO, 0.5 * side, 1.0)
}

/// Floats near 10,000 m are 2^-10 m apart; the walls lie on such numbers.
pub(super) fn far() -> Scene {
    closed("far_from_origin", half(), Vec3::new(1e4, 0.0, -1e4), 0.5, 1.0)
}

/// Each wall is there twice, the same corners in another order.
pub(super) fn coplanar() -> Scene {
    let mut scene = Assembly::default();
    let mut walls = Part::new("walls", scene.material(half()));
    for axis in 0..3 {
        for side in [1.0, -1.0] {
            let [a, b, c, d] = wall(Vec3::ZERO, 0.5, axis, side, 1.0);
            walls.quad([a, b, c, d]);
            walls.quad([b, c, d, a]);
        }
    }
    scene.add(walls);
    scene.finish("coplanar", camera(Vec3::ZERO, Vec3::new(1.0, -0.4, -1.0)), Sky::Constant(Vec3::ZERO))
}

/// One wall is cut into strips of which each is a tenth as wide as the last: 1 m to 1 micrometre.
pub(super) fn million_to_one() -> Scene {
    let mut scene = Assembly::default();
    let mut walls = Part::new("walls", scene.material(half()));
    for axis in 0..3 {
        for side in [1.0, -1.0] {
            let [a, b, c, d] = wall(Vec3::ZERO, 0.5, axis, side, 1.0);
            if (axis, side) != (2, -1.0) {
                walls.quad([a, b, c, d]);
                continue;
            }
            let mut from = 0.0;
            for step in 1..=7 {
                let to = if step == 7 { 1.0 } else { 1.0 - 0.1f32.powi(step) };
                // Pairs of triangles, added whole: the sliver test of built-in shapes would leave the thinnest out.
                walls.strip([a.lerp(b, from), a.lerp(b, to), d.lerp(c, to), d.lerp(c, from)]);
                from = to;
            }
        }
    }
    scene.add(walls);
    scene.finish("million_to_one", camera(Vec3::ZERO, Vec3::new(0.6, -0.2, -1.0)), Sky::Constant(Vec3::ZERO))
}

/// Looks along the wall that it touches.
pub(super) fn touching() -> Scene {
    let mut scene = closed("touching_a_wall", half(), Vec3::ZERO, 0.5, 1.0);
    scene.cameras = camera(Vec3::new(0.0, -0.5 + 1e-5, 0.0), Vec3::new(0.2, -0.5 - 0.2, -0.9));
    scene
}

/// The room and a ball in it, whose inside is seen: both sides of it glow and reflect alike.
pub(super) fn inside_ball() -> Scene {
    let mut scene = Assembly::default();
    let mut walls = Part::new("walls", scene.material(half()));
    cube(&mut walls, Vec3::ZERO, 0.5, 1.0);
    scene.add(walls);
    // Emission leaves fronts only: this ball's front is its inside.
    let mut ball = Part::new("ball", scene.material(half()));
    ball.ball(Vec3::ZERO, -0.25, [32, 16]);
    scene.add(ball);
    scene.finish("inside_geometry", camera(Vec3::ZERO, Vec3::new(0.3, 0.1, -1.0)), Sky::Constant(Vec3::ZERO))
}

/// A hall of 24 x 8 x 24 m with a square lamp of 10 cm in the middle of its ceiling: a voxel at 256 cells.
pub(super) fn small_lamp() -> Scene {
    let mut scene = Assembly::default();
    let white = scene.material(Material::lambert("hall", Vec3::splat(0.7)));
    let mut hall = Part::new("hall", white);
    inward_box(&mut hall, Vec3::new(-12.0, 0.0, -12.0), Vec3::new(12.0, 8.0, 12.0));
    scene.add(hall);
    let mut lamp =
        Part::new("lamp", scene.material(Material::emitter("lamp", Vec3::ZERO, Vec3::splat(10_000.0))));
    let corner = |x: f32, z: f32| Vec3::new(0.05 * x, 7.9, 0.05 * z);
    lamp.quad([corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)]);
    scene.add(lamp);
    let eye = Vec3::new(-9.0, 3.0, 9.0);
    scene.finish("small_lamp", camera(eye, Vec3::new(4.0, 2.0, -6.0)), Sky::Constant(Vec3::ZERO))
}

/// Two rooms of 3 m; a hole of 12 cm in the wall of 20 cm between them; the lamp is in the other.
pub(super) fn keyhole() -> Scene {
    let mut scene = Assembly::default();
    let white = scene.material(Material::lambert("wall", Vec3::splat(0.75)));
    let mut rooms = Part::new("rooms", white);
    inward_box(&mut rooms, Vec3::new(-3.1, 0.0, -1.5), Vec3::new(3.1, 3.0, 1.5));
    scene.add(rooms);
    let mut wall = Part::new("wall", white);
    let (x, hole) = (0.1, 0.06);
    for (low, high) in [
        ([-x, 0.0, -1.5], [x, 1.0 - hole, 1.5]),
        ([-x, 1.0 + hole, -1.5], [x, 3.0, 1.5]),
        ([-x, 1.0 - hole, -1.5], [x, 1.0 + hole, -hole]),
        ([-x, 1.0 - hole, hole], [x, 1.0 + hole, 1.5]),
    ] {
        wall.block_between(Vec3::from(low), Vec3::from(high));
    }
    scene.add(wall);
    let mut lamp =
        Part::new("lamp", scene.material(Material::emitter("lamp", Vec3::ZERO, Vec3::splat(2000.0))));
    let corner = |x: f32, z: f32| Vec3::new(1.6 + 0.5 * x, 2.9, 0.5 * z);
    lamp.quad([corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)]);
    scene.add(lamp);
    let eye = Vec3::new(-0.3, 1.6, 1.2);
    scene.finish("keyhole", camera(eye, Vec3::new(-2.5, 0.6, -0.6)), Sky::Constant(Vec3::ZERO))
}

/// A box of sheets a tenth of a millimetre thick, turned, in sun and white sky, seen from within.
pub(super) fn thin_walls() -> Scene {
    let mut scene = Assembly::default();
    let white = scene.material(Material::lambert("paper", Vec3::splat(0.8)));
    let turn = Quat::from_rotation_y(0.5) * Quat::from_rotation_x(0.3);
    for (half, facing) in [(1.0, 1.0), (1.0 + 1e-4, -1.0)] {
        let mut side = Part::new("sheets", white);
        for axis in 0..3 {
            for out in [1.0, -1.0] {
                side.quad(wall(Vec3::ZERO, half, axis, out, facing).map(|p| turn * p));
            }
        }
        scene.add(side);
    }
    let mut scene =
        scene.finish("thin_walls", camera(Vec3::ZERO, Vec3::new(0.8, 0.3, -1.0)), Sky::Constant(Vec3::ONE));
    let direction = Vec3::new(-0.3, -1.0, -0.2).normalize();
    scene.sun = Some(Sun { direction, irradiance: Vec3::splat(20.0), angle: 0.0 });
    scene
}

/// A box between two corners whose fronts face inwards.
fn inward_box(part: &mut Part, low: Vec3, high: Vec3) {
    let (centre, size) = (0.5 * (low + high), 0.5 * (high - low));
    for axis in 0..3 {
        for side in [1.0, -1.0] {
            part.quad(wall(Vec3::ZERO, 1.0, axis, side, 1.0).map(|p| centre + size * p));
        }
    }
}
