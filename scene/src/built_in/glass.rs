//! Clear glass on a checked floor: three solid balls (index 1.33, 1.5, 2) and thin panes, one lying flat at a grazing
//! angle, one almost edge-on to the camera. A small sky with a horizon and one soft bright patch gives reflections
//! something to show.

use super::{assembly::Assembly, part::Part, textures};
use crate::{Camera, Material, Scene, Sky, SkyMap, TextureSlot, Volume};
use glam::Vec3;
use std::f32::consts::{PI, TAU};

const BALL_M: f32 = 0.55;
/// Half the side of the floor.
const FLOOR_M: f32 = 3.2;

/// The scene; its camera looks a little down, along -Z.
pub(super) fn glass() -> Scene {
    let mut scene = Assembly::default();
    let checks = TextureSlot { linear: false, ..scene.texture(textures::checks()) };
    let checked = Material { base_color_texture: Some(checks), ..Material::lambert("checks", Vec3::ONE) };
    // Two squares of 0.4 m to a repeat.
    let mut floor = Part::new("floor", scene.material(checked)).repeating(0.8);
    let corner = |x: f32, z: f32| FLOOR_M * Vec3::new(x, 0.0, z);
    floor.quad([corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0), corner(-1.0, -1.0)]);
    scene.add(floor);

    let mut block = Part::new("box", scene.material(Material::lambert("red", Vec3::new(0.7, 0.1, 0.08))));
    block.block(Vec3::new(0.1, 0.51, -1.5), Vec3::new(1.8, 1.0, 0.4), 0.2);
    scene.add(block);

    for (ior, x) in [(1.33, -1.3), (1.5, 0.0), (2.0, 1.3)] {
        let clear = Volume { attenuation_distance: f32::INFINITY, attenuation_color: Vec3::ONE };
        let solid = Material { volume: Some(clear), ..clear_glass(&format!("glass_{ior}"), ior) };
        let mut ball = Part::new(&format!("ball_{ior}"), scene.material(solid));
        // 1 cm above the floor, so that no grid joins them.
        ball.ball(Vec3::new(x, BALL_M + 0.01, 0.0), BALL_M, [96, 48]);
        scene.add(ball);
    }

    let pane = scene.material(Material { double_sided: true, ..clear_glass("pane", 1.5) });
    // Its plane passes 0.65 m beside the eye: the camera sees it at about 9 degrees.
    upright(&mut scene, "pane_edge_on", pane, [Vec3::new(-0.65, 0.02, 1.9), Vec3::new(-0.65, 0.02, 0.7)]);
    upright(&mut scene, "pane_upright", pane, [Vec3::new(-2.2, 0.02, 1.0), Vec3::new(-1.2, 0.02, 1.3)]);
    let mut flat = Part::new("pane_flat", pane);
    let corner = |x: f32, z: f32| Vec3::new(x, 0.35, z);
    flat.quad([corner(0.7, 1.9), corner(2.1, 1.9), corner(2.1, 0.7), corner(0.7, 0.7)]);
    scene.add(flat);

    let (eye, target) = (Vec3::new(0.0, 1.2, 5.2), Vec3::new(0.0, 0.45, 0.0));
    let camera = Camera { name: "front".into(), eye, target, up: Vec3::Y, vfov: 36f32.to_radians() };
    scene.finish("glass", vec![camera], Sky::Map(evening()))
}

/// A rectangle 1.2 m high over the line between two points.
fn upright(scene: &mut Assembly, name: &str, material: u32, [from, to]: [Vec3; 2]) {
    let mut pane = Part::new(name, material);
    let up = 1.2 * Vec3::Y;
    pane.quad([from, to, to + up, from + up]);
    scene.add(pane);
}

/// Smooth, colourless, all transmitted; a thin sheet until it is given a volume.
pub(super) fn clear_glass(name: &str, ior: f32) -> Material {
    Material {
        name: name.into(),
        metallic: 0.0,
        roughness: 0.0,
        transmission: 1.0,
        ior,
        ..Material::default()
    }
}

/// Blue above, warm at the horizon, dim ground, and a soft lamp-like patch behind the camera to the left.
fn evening() -> SkyMap {
    const SIZE: [u32; 2] = [64, 32];
    let lamp = Vec3::new(-0.6, 0.6, 0.53).normalize();
    let texel = |index: u32| {
        let u = ((index % SIZE[0]) as f32 + 0.5) / SIZE[0] as f32 * TAU;
        let v = ((index / SIZE[0]) as f32 + 0.5) / SIZE[1] as f32 * PI;
        let d = Vec3::new(v.sin() * u.sin(), v.cos(), -v.sin() * u.cos());
        let horizon = (-8.0 * d.y.abs()).exp();
        let base = if d.y > 0.0 { Vec3::new(0.35, 0.55, 0.95) } else { Vec3::new(0.16, 0.14, 0.12) };
        // The patch falls to 1/e at 0.25 rad, two and a half texels: bilinear look-ups follow it.
        let away = d.angle_between(lamp) / 0.25;
        base + horizon * Vec3::new(1.1, 0.75, 0.45) + (-away * away).exp() * Vec3::new(24.0, 22.0, 18.0)
    };
    SkyMap { width: SIZE[0], height: SIZE[1], radiance: (0..SIZE[0] * SIZE[1]).map(texel).collect() }
}
