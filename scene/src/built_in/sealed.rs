//! Closed boxes with walls of one, two and three voxels in bright sun: whatever is seen inside them has leaked.
//!
//! The boxes stand in rows, one row per thickness, one box per turn, above a floor whose long side fits the grid: at
//! [`GRID`] cells a voxel is exactly [`VOXEL_M`] wide. Every box has an outer and an inner surface, parallel, and a hollow
//! of 20 voxels. Light has no way in, so radiance inside is 0 however often it scatters.

use super::{assembly::Assembly, part::Part};
use crate::{Camera, Material, Scene, Sky, Sun};
use glam::{Quat, Vec3};

/// Thicknesses of the walls, voxels, in the order of the cameras.
pub const WALLS: [u32; 3] = [1, 2, 3];
/// Most boxes per row: more do not fit the floor.
pub const MOST_TURNS: usize = 4;
/// Cells on the longest axis at which the walls are as thick as [`WALLS`] says.
pub const GRID: u32 = 204;
/// Side of a voxel, m.
const VOXEL_M: f32 = 1.0 / 64.0;
/// Side of the hollow, voxels.
const HOLLOW: f32 = 20.0;
/// Between the centres of boxes, voxels: the diagonal of a box with the thickest walls is 45.
const PITCH: f32 = 50.0;

/// Boxes turned by up to [`MOST_TURNS`] rotations. For each thickness and each turn there are two cameras: inside, from
/// the centre, and outside, from above, seeing nothing but the lit box.
pub fn sealed_boxes(turns: &[Quat]) -> Scene {
    let mut scene = Assembly::default();
    let material = scene.material(Material::lambert("wall", Vec3::splat(0.8)));
    let mut cameras = Vec::new();
    let size = Vec3::new(MOST_TURNS as f32, 0.0, WALLS.len() as f32) * PITCH * VOXEL_M;
    let mut floor = Part::new("floor", material);
    floor.quad([Vec3::ZERO, Vec3::Z * size.z, size, Vec3::X * size.x]);
    scene.add(floor);
    for (row, walls) in WALLS.into_iter().enumerate() {
        for (column, turn) in turns.iter().take(MOST_TURNS).enumerate() {
            let place = Vec3::new(column as f32 + 0.5, 0.5, row as f32 + 0.5);
            let centre = PITCH * VOXEL_M * place;
            let mut part = Part::new(&format!("{walls} voxels, {column}"), material);
            surface(&mut part, centre, *turn, 0.5 * HOLLOW * VOXEL_M, -1.0);
            surface(&mut part, centre, *turn, (0.5 * HOLLOW + walls as f32) * VOXEL_M, 1.0);
            scene.add(part);
            let inside = Camera {
                name: format!("{walls} voxels, {column}, inside"),
                eye: centre,
                // Towards a corner: there elevated starts come closest to other walls.
                target: centre + *turn * Vec3::ONE,
                up: Vec3::Y,
                vfov: 2.0,
            };
            // A ball of ten voxels' radius fits into the box: a third of that is all box at any turn.
            let outside = Camera {
                name: format!("{walls} voxels, {column}, outside"),
                eye: centre + 2.0 * PITCH * VOXEL_M * Vec3::Y,
                target: centre,
                up: Vec3::Z,
                vfov: 2.0 * (3.0 / (2.0 * PITCH)).atan(),
            };
            cameras.extend([inside, outside]);
        }
    }
    let mut scene = scene.finish("sealed boxes", cameras, Sky::Constant(Vec3::ONE));
    let direction = Vec3::new(-0.3, -1.0, -0.2).normalize();
    scene.sun = Some(Sun { direction, irradiance: Vec3::splat(20.0), angle: 0.0 });
    scene
}

/// The six faces of a turned cube, m; `facing` 1 outwards, -1 inwards.
fn surface(part: &mut Part, centre: Vec3, turn: Quat, half: f32, facing: f32) {
    let axes = [Vec3::X, Vec3::Y, Vec3::Z];
    for (i, axis) in axes.into_iter().enumerate() {
        for out in [axis, -axis] {
            let right = axes[(i + 1) % 3];
            let up = out.cross(right) * facing;
            let corner = |r: f32, u: f32| centre + turn * (half * (out + r * right + u * up));
            part.quad([corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)]);
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn the_floor_is_the_longest_side_and_inner_walls_face_the_centre() {
        let scene = sealed_boxes(&[Quat::IDENTITY, Quat::from_rotation_y(0.7), Quat::from_rotation_x(0.6)]);
        let bounds = scene.bounds();
        assert_eq!(bounds.size().max_element(), (GRID - 4) as f32 * VOXEL_M);
        assert_eq!(scene.cameras.len(), 2 * 3 * WALLS.len());
        let geometry = scene.rest();
        let first = &geometry.objects[1];
        let centre = scene.cameras[0].eye;
        let facing = |triangle: usize| {
            let [a, b, c] = geometry.corners(&geometry.triangles[triangle]);
            (b - a).cross(c - a).dot(a - centre)
        };
        let triangles = first.triangles.start as usize..first.triangles.end as usize;
        let (inner, outer): (Vec<_>, Vec<_>) = triangles.enumerate().partition(|(i, _)| *i < 12);
        assert!(inner.iter().all(|(_, t)| facing(*t) < 0.0) && outer.iter().all(|(_, t)| facing(*t) > 0.0));
    }
}
