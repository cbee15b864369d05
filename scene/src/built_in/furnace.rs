//! A closed room with a known answer: where every wall has albedo `a` and emits `e`, radiance is `e / (1 - a)` in
//! every direction from every point; after `n` scatterings `e (1 - a^(n + 1)) / (1 - a)`.
//!
//! The room is the cube [-1/2, 1/2]^3 m: six single quadrilaterals that face inward and lie on the scene's bounds.
//! A grid's cells fit the bounds of a cube exactly (`voxel_size` = side / (grid - 4)), so at any grid each wall covers
//! whole cells of its plane: no column is partly covered, and no emission is scaled down. Walls with a thickness
//! would end inside a cell. The price is that a wall lies on the border between two layers of cells; either layer
//! closes the room, for neighbouring walls then meet at an edge of cells that a ray passes with probability 0.

use super::{assembly::Assembly, part::Part};
use crate::{Camera, Material, Scene, Sky};
use glam::Vec3;
use std::f32::consts::FRAC_PI_2;

/// Albedo 1/2, emission 1/2: radiance 1.
pub(super) fn half() -> Scene {
    furnace(0.5, 0.5)
}

/// A closed grey room of this `albedo` (0 to below 1) that emits `emission` from each point of its walls.
pub fn furnace(albedo: f32, emission: f32) -> Scene {
    let mut scene = Assembly::default();
    let material = scene.material(Material::emitter("wall", Vec3::splat(albedo), Vec3::splat(emission)));
    let mut walls = Part::new("walls", material);
    let axes = [Vec3::X, Vec3::Y, Vec3::Z];
    for (i, axis) in axes.into_iter().enumerate() {
        for out in [axis, -axis] {
            let right = axes[(i + 1) % 3];
            let up = right.cross(out);
            let corner = |r: f32, u: f32| 0.5 * (out + r * right + u * up);
            walls.quad([corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)]);
        }
    }
    scene.add(walls);
    let looking = [
        ("north", Vec3::NEG_Z, Vec3::Y),
        ("south", Vec3::Z, Vec3::Y),
        ("west", Vec3::NEG_X, Vec3::Y),
        ("east", Vec3::X, Vec3::Y),
        ("down", Vec3::NEG_Y, Vec3::NEG_Z),
        ("up", Vec3::Y, Vec3::Z),
    ];
    let cameras = looking.map(|(name, target, up)| Camera {
        name: name.into(),
        eye: Vec3::ZERO,
        target,
        up,
        // A square picture per axis: the six see every direction.
        vfov: FRAC_PI_2,
    });
    scene.finish("furnace", cameras.into(), Sky::Constant(Vec3::ZERO))
}
