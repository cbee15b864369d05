//! An open court between two arcades, 12 x 6 x 9 m: stone walls, a wooden floor, hanging cloth, glass, metal, a strip
//! of light at the foot of a wall, sun and sky. It stands in for the rooms of the paper's figures and is the picture
//! on the project's front page.
//!
//! The sun comes over the south-west corner, so that the floor and the north arcade are lit, the west wall with its
//! strip is in shade, and the galleries live on bounced light.

use super::{
    arcade::{self, BAY_M, DEPTH_M, IMPOST_M, WALL_M},
    assembly::Assembly,
    glass::clear_glass,
    part::Part,
    textures,
};
use crate::{Camera, Material, Scene, Sky, Sun, Volume};
use glam::{Vec2, Vec3};
use std::f32::consts::TAU;

/// Inner half sizes along x and z, and the height of the outer walls, m.
const HALF_X: f32 = 6.0;
const HALF_Z: f32 = 4.5;
const WALL_TOP: f32 = 6.0;
/// Where the arcades stand, m from the middle.
const ARCADE_Z: f32 = 2.7;
/// Thickness of the outer walls and of the ground, m.
const SHELL_M: f32 = 0.25;

/// The scene with its own camera, "south gallery".
pub(super) fn courtyard() -> Scene {
    let mut scene = Assembly::default();
    shell(&mut scene);
    arcades(&mut scene);
    cloths(&mut scene);
    table(&mut scene);
    screen(&mut scene);
    light_and_metal(&mut scene);
    let camera = Camera {
        name: "south gallery".into(),
        eye: Vec3::new(3.3, 1.65, 3.3),
        target: Vec3::new(-2.3, 1.3, -2.1),
        up: Vec3::Y,
        vfov: 60f32.to_radians(),
    };
    let mut scene = scene.finish("courtyard", vec![camera], Sky::Constant(Vec3::new(2.0, 2.8, 4.4)));
    scene.sun = Some(Sun {
        direction: Vec3::new(0.4, -1.0, -0.45).normalize(),
        irradiance: Vec3::new(20.0, 18.0, 15.0),
        // As wide as the real one.
        angle: 0.53f32.to_radians(),
    });
    scene
}

/// Not a mirror, not chalk: what stone and boards look like.
fn dull(name: &str, color: Vec3, roughness: f32) -> Material {
    Material { specular: 1.0, roughness, ..Material::lambert(name, color) }
}

fn shell(scene: &mut Assembly) {
    let planks = scene.texture(textures::planks());
    let wood = Material { base_color_texture: Some(planks), ..dull("wood", Vec3::ONE, 0.45) };
    let mut floor = Part::new("floor", scene.material(wood)).repeating(2.0);
    let edge = Vec3::new(HALF_X + SHELL_M, 0.0, HALF_Z + SHELL_M);
    floor.block_between(-edge - SHELL_M * Vec3::Y, edge);
    scene.add(floor);

    let ashlar = scene.texture(textures::ashlar());
    let stone = Material { base_color_texture: Some(ashlar), ..dull("stone", Vec3::ONE, 0.85) };
    let mut walls = Part::new("walls", scene.material(stone)).repeating(2.0);
    for side in [-1.0, 1.0] {
        let x = side * (HALF_X + 0.5 * SHELL_M);
        walls.block(Vec3::new(x, 0.5 * WALL_TOP, 0.0), Vec3::new(SHELL_M, WALL_TOP, 2.0 * HALF_Z), 0.0);
        let z = side * (HALF_Z + 0.5 * SHELL_M);
        let width = 2.0 * (HALF_X + SHELL_M);
        walls.block(Vec3::new(0.0, 0.5 * WALL_TOP, z), Vec3::new(width, WALL_TOP, SHELL_M), 0.0);
    }
    scene.add(walls);
}

fn arcades(scene: &mut Assembly) {
    const BAYS: u16 = 5;
    let limestone = scene.texture(textures::limestone());
    let limestone = Material { base_color_texture: Some(limestone), ..dull("limestone", Vec3::ONE, 0.7) };
    let limestone = scene.material(limestone);
    let mut columns = Part::new("columns", limestone);
    let mut arches = Part::new("arches", limestone).repeating(1.5);
    let mut roofs = Part::new("gallery roofs", limestone).repeating(1.5);
    let top = IMPOST_M + WALL_M;
    for side in [-1.0, 1.0] {
        let z = side * ARCADE_Z;
        for i in 1..BAYS {
            arcade::column(&mut columns, Vec3::new(f32::from(i) * BAY_M - HALF_X, 0.0, z));
        }
        // Against the end walls the arches stand on piers of half the width between two arches.
        for end in [-1.0, 1.0] {
            let middle = Vec3::new(end * (HALF_X - 0.125), 0.5 * IMPOST_M, z);
            columns.block(middle, Vec3::new(0.25, IMPOST_M, DEPTH_M), 0.0);
        }
        // Fronts face the court.
        arcade::arches(&mut arches, Vec3::new(side * HALF_X, IMPOST_M, z), -side * Vec3::X, BAYS);
        // The roof juts out over the arches by 0.12 m.
        let [near, far] = [side * (ARCADE_Z - 0.5 * DEPTH_M - 0.12), side * HALF_Z];
        let low = Vec3::new(-HALF_X, top, near.min(far));
        roofs.block_between(low, Vec3::new(HALF_X, top + 0.15, near.max(far)));
    }
    for part in [columns, arches, roofs] {
        scene.add(part);
    }
}

/// Sheets that hang in bays of the north arcade, seen from both sides.
fn cloths(scene: &mut Assembly) {
    let sheets = [
        ("red cloth", Vec3::new(0.62, 0.05, 0.04), -1.0, 0.0),
        ("blue cloth", Vec3::new(0.05, 0.12, 0.42), 1.0, 0.4),
    ];
    for (name, color, bay, turn) in sheets {
        let material = Material { double_sided: true, ..Material::lambert(name, color) };
        let mut cloth = Part::new(name, scene.material(material));
        let foot = Vec3::new(bay * BAY_M, 0.45, -ARCADE_Z);
        cloth.sheet([48, 32], Vec2::new(2.0, 2.0), |s, t| {
            // Folds deepen from the rod down; the lower hem sags between them.
            let depth = 0.05 + 0.09 * (1.0 - t);
            let fold = (TAU * (3.5 * s + turn + 0.12 * t)).sin();
            foot + Vec3::new(
                1.7 * (s - 0.5),
                1.85 * t + 0.03 * (1.0 - t) * (TAU * 3.5 * s).cos(),
                depth * fold,
            )
        });
        scene.add(cloth);
    }
}

/// A low stone table under a sheet of glass, seen at a grazing angle, with a glass ball on it.
fn table(scene: &mut Assembly) {
    const TOP_M: f32 = 0.55;
    const BALL_M: f32 = 0.27;
    let centre = Vec3::new(-0.3, 0.0, 0.5);
    let slate = scene.material(dull("slate", Vec3::new(0.22, 0.24, 0.25), 0.6));
    let mut stone = Part::new("table", slate);
    stone.block(centre + Vec3::Y * 0.21, Vec3::new(1.5, 0.42, 0.8), 0.35);
    scene.add(stone);

    let thin = Material { double_sided: true, ..clear_glass("thin glass", 1.5) };
    let mut pane = Part::new("table pane", scene.material(thin));
    let (sin, cos) = 0.35f32.sin_cos();
    let (right, back) = (Vec3::new(cos, 0.0, -sin), Vec3::new(-sin, 0.0, -cos));
    let at = |x: f32, z: f32| centre + TOP_M * Vec3::Y + x * right + z * back;
    pane.quad([at(-1.0, -0.6), at(1.0, -0.6), at(1.0, 0.6), at(-1.0, 0.6)]);
    scene.add(pane);

    // A tint of green over half a metre, as thick glass has.
    let attenuation_color = Vec3::new(0.75, 0.95, 0.85);
    let volume = Some(Volume { attenuation_distance: 0.5, attenuation_color });
    let solid = Material { volume, ..clear_glass("solid glass", 1.5) };
    let mut ball = Part::new("glass ball", scene.material(solid));
    ball.ball(at(0.35, 0.0) + (BALL_M + 0.002) * Vec3::Y, BALL_M, [64, 32]);
    scene.add(ball);
}

/// An upright pane between two posts; the camera sees it at about 9 degrees.
fn screen(scene: &mut Assembly) {
    let [near, far] = [Vec3::new(1.9, 0.0, 0.5), Vec3::new(1.45, 0.0, -1.1)];
    let thin = Material { double_sided: true, ..clear_glass("screen glass", 1.5) };
    let mut pane = Part::new("screen", scene.material(thin));
    let [low, high] = [0.12, 1.75].map(|y| y * Vec3::Y);
    pane.quad([near + low, far + low, far + high, near + high]);
    scene.add(pane);

    let iron = Material { metallic: 1.0, ..dull("iron", Vec3::new(0.56, 0.54, 0.52), 0.35) };
    let mut posts = Part::new("screen posts", scene.material(iron));
    // Square to the pane: atan(0.45 / 1.6).
    const TURN: f32 = 0.274;
    for foot in [near, far] {
        posts.block(foot + 0.9 * Vec3::Y, Vec3::new(0.07, 1.8, 0.07), TURN);
    }
    scene.add(posts);
}

fn light_and_metal(scene: &mut Assembly) {
    let glow = Material::emitter("strip", Vec3::splat(0.5), Vec3::new(24.0, 11.0, 4.0));
    let mut strip = Part::new("light strip", scene.material(glow));
    strip.block_between(Vec3::new(-HALF_X, 0.05, -2.3), Vec3::new(0.06 - HALF_X, 0.33, 2.3));
    scene.add(strip);

    let chrome = Material { metallic: 1.0, ..dull("polished metal", Vec3::new(0.95, 0.93, 0.88), 0.04) };
    let mut ball = Part::new("metal ball", scene.material(chrome));
    ball.ball(Vec3::new(0.3, 0.42, -1.75), 0.42, [64, 32]);
    scene.add(ball);
}
