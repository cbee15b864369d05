//! A brick wall whose joints a height map sets back, in low sun from the side: flat without displacement, full of
//! shadows with it.

use super::{assembly::Assembly, part::Part, textures};
use crate::{Camera, HeightMap, Material, Scene, Sky, Sun};
use glam::{Vec2, Vec3};

/// The pictures span this much wall.
const REPEAT_M: f32 = 2.0;
/// Mortar to the face of the highest brick.
const HEIGHT_M: f32 = 0.06;
/// Sides of the wall, m; its cells of 0.1 m are what a tessellator starts from.
const WALL_M: [f32; 2] = [4.0, 3.0];

/// The scene. The height map alone carries the relief: there is no normal map.
pub(super) fn relief() -> Scene {
    let mut scene = Assembly::default();
    let [color, height] = textures::bricks().map(|image| scene.texture(image));
    let material = Material {
        base_color_texture: Some(color),
        height: Some(HeightMap { texture: height, scale: HEIGHT_M, is_depth: false }),
        ..Material::lambert("bricks", Vec3::ONE)
    };
    let mut wall = Part::new("wall", scene.material(material));
    let [width, top] = WALL_M;
    wall.patch([40, 30], Vec2::new(width, top) / REPEAT_M, |s, t| {
        [Vec3::new(width * (s - 0.5), top * t, 0.0), Vec3::Z, Vec3::X]
    });
    scene.add(wall);

    // Reaches behind the wall, so that the wall lies inside the bounds whichever way a height map moves it.
    let mut floor =
        Part::new("floor", scene.material(Material::lambert("sand", Vec3::new(0.55, 0.48, 0.38))));
    let corner = |x: f32, z: f32| Vec3::new(x, 0.0, z);
    floor.quad([corner(-2.5, 2.5), corner(2.5, 2.5), corner(2.5, -0.5), corner(-2.5, -0.5)]);
    scene.add(floor);

    let (eye, target) = (Vec3::new(1.3, 1.6, 3.6), Vec3::new(-0.1, 1.35, 0.0));
    let camera = Camera { name: "front".into(), eye, target, up: Vec3::Y, vfov: 45f32.to_radians() };
    let mut scene = scene.finish("relief", vec![camera], Sky::Constant(Vec3::new(0.35, 0.45, 0.65)));
    scene.sun = Some(Sun {
        // 20 degrees above the wall's plane.
        direction: Vec3::new(0.85, -0.39, -0.34).normalize(),
        irradiance: Vec3::new(9.0, 7.6, 5.8),
        angle: 0.53f32.to_radians(),
    });
    scene
}
