//! Cases under the open sky: whatever is white or clear under a white sky must not be seen at all.

use super::super::{assembly::Assembly, glass::clear_glass, part::Part};
use super::Truth;
use crate::{Alpha, Camera, Image, Material, Scene, Sky, Sun, Volume};
use glam::{Vec2, Vec3, Vec4};
use std::f32::consts::PI;

/// Degrees of the grazing sun above the plane.
const GRAZING_DEGREES: f32 = 1.0;
/// sin 1 degree.
const GRAZING_SINE: f32 = 0.017_452_406;
/// Irradiance of the grazing sun across its way; 180 makes the plane about 1 bright.
const GRAZING_IRRADIANCE: f32 = 180.0;
/// A Lambert plane of albedo 1 under nothing but the sun: `E sin(elevation) / pi`.
pub(super) const GRAZING: Truth = Truth::Everywhere(GRAZING_IRRADIANCE * GRAZING_SINE / PI);

/// Refraction gathers light into a smaller cone: within an index n, a white sky is n^2 as bright, reflected or not.
pub(super) const INSIDE_GLASS: Truth = Truth::Everywhere(1.5 * 1.5);

fn view(eye: Vec3, target: Vec3, degrees: f32) -> Vec<Camera> {
    vec![Camera { name: "front".into(), eye, target, up: Vec3::Y, vfov: degrees.to_radians() }]
}

/// Seen from above at a slant; everything of interest is within 2.5 m of the origin.
fn front() -> Vec<Camera> {
    view(Vec3::new(0.0, 1.2, 5.0), Vec3::new(0.0, 0.4, 0.0), 40.0)
}

fn plane(part: &mut Part, half: f32, height: f32) {
    let corner = |x: f32, z: f32| Vec3::new(half * x, height, half * z);
    part.quad([corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0), corner(-1.0, -1.0)]);
}

/// Smooth or rough white metal.
fn metal(roughness: f32) -> Material {
    Material { name: format!("metal_{roughness}"), metallic: 1.0, roughness, ..Material::default() }
}

fn solid(ior: f32) -> Material {
    let clear = Volume { attenuation_distance: f32::INFINITY, attenuation_color: Vec3::ONE };
    Material { volume: Some(clear), ..clear_glass(&format!("glass_{ior}"), ior) }
}

/// Three balls side by side.
fn three_balls(name: &str, materials: [Material; 3]) -> Scene {
    let mut scene = Assembly::default();
    for (i, material) in materials.into_iter().enumerate() {
        let mut ball = Part::new(&format!("ball_{i}"), scene.material(material));
        ball.ball(Vec3::new(1.4 * (i as f32 - 1.0), 0.6, 0.0), 0.6, [48, 24]);
        scene.add(ball);
    }
    scene.finish(name, front(), Sky::Constant(Vec3::ONE))
}

pub(super) fn white_world() -> Scene {
    let mut scene = Assembly::default();
    let white = scene.material(Material::lambert("white", Vec3::ONE));
    let mut ground = Part::new("ground", white);
    plane(&mut ground, 3.0, 0.0);
    scene.add(ground);
    let mut ball = Part::new("ball", white);
    ball.ball(Vec3::new(-0.7, 0.6, 0.0), 0.6, [48, 24]);
    scene.add(ball);
    let mut block = Part::new("block", white);
    block.block(Vec3::new(0.8, 0.5, 0.2), Vec3::ONE, 0.4);
    scene.add(block);
    scene.finish("white_world", front(), Sky::Constant(Vec3::ONE))
}

pub(super) fn black_world() -> Scene {
    let mut scene = Assembly::default();
    let mut ground = Part::new("ground", scene.material(Material::lambert("black", Vec3::ZERO)));
    plane(&mut ground, 3.0, 0.0);
    ground.ball(Vec3::new(0.0, 0.6, 0.0), 0.6, [48, 24]);
    scene.add(ground);
    scene.finish("black_world", front(), Sky::Constant(Vec3::ZERO))
}

/// A ground whose front faces down and a ball whose front is its inside: two-sided, so nobody may tell.
pub(super) fn inverted() -> Scene {
    let mut scene = Assembly::default();
    let white = scene.material(Material { double_sided: true, ..Material::lambert("white", Vec3::ONE) });
    let mut ground = Part::new("ground", white);
    let corner = |x: f32, z: f32| Vec3::new(3.0 * x, 0.0, 3.0 * z);
    ground.quad([corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)]);
    scene.add(ground);
    let mut ball = Part::new("ball", white);
    ball.ball(Vec3::new(0.0, 0.6, 0.0), -0.6, [48, 24]);
    scene.add(ball);
    scene.finish("inverted", front(), Sky::Constant(Vec3::ONE))
}

pub(super) fn roughness_ladder() -> Scene {
    three_balls("roughness_ladder", [0.0, 1e-3, 1.0].map(metal))
}

pub(super) fn index_ladder() -> Scene {
    three_balls("index_ladder", [1.0, 1.0001, 3.0].map(solid))
}

pub(super) fn nested_glass() -> Scene {
    let mut scene = Assembly::default();
    for (ior, radius) in [(1.33, 1.0), (1.5, 0.7), (2.0, 0.4)] {
        let mut ball = Part::new(&format!("ball_{ior}"), scene.material(solid(ior)));
        ball.ball(Vec3::new(0.0, 0.6, 0.0), radius, [64, 32]);
        scene.add(ball);
    }
    scene.finish("nested_glass", front(), Sky::Constant(Vec3::ONE))
}

pub(super) fn inside_glass() -> Scene {
    let mut scene = Assembly::default();
    let mut ball = Part::new("ball", scene.material(solid(1.5)));
    ball.ball(Vec3::ZERO, 1.0, [64, 32]);
    scene.add(ball);
    // Off the middle, where rays meet the surface beyond the critical angle too.
    let eye = Vec3::new(0.85, 0.0, 0.0);
    scene.finish("inside_glass", view(eye, Vec3::new(0.85, 0.1, -1.0), 80.0), Sky::Constant(Vec3::ONE))
}

/// 2 m apart; the camera looks between them along a slant, so that light goes to and fro many times.
pub(super) fn facing_mirrors() -> Scene {
    let mut scene = Assembly::default();
    let mirror = scene.material(metal(0.0));
    for side in [-1.0, 1.0] {
        let mut part = Part::new("mirror", mirror);
        // The front of each faces the other.
        let corner = |y: f32, z: f32| Vec3::new(side, y, -side * z);
        part.quad([corner(-1.5, 1.5), corner(-1.5, -1.5), corner(1.5, -1.5), corner(1.5, 1.5)]);
        scene.add(part);
    }
    scene.finish(
        "facing_mirrors",
        view(Vec3::new(0.1, 0.2, 1.2), Vec3::new(0.8, 0.0, -0.6), 70.0),
        Sky::Constant(Vec3::ONE),
    )
}

/// A white plane in three parts: coordinates as they should be, mirrored along u, and all in one point. The normal map
/// says "straight up" everywhere: the answer is that of a plane without one.
pub(super) fn mirrored_uvs() -> Scene {
    let mut scene = Assembly::default();
    let up = Image { name: "up".into(), width: 4, height: 4, rgba: vec![[128, 128, 255, 255]; 16] };
    let slot = scene.texture(up);
    let white =
        scene.material(Material { normal_texture: Some(slot), ..Material::lambert("white", Vec3::ONE) });
    for i in 0..3 {
        let mut part = Part::new(&format!("part_{i}"), white);
        let corner = |x: f32, z: f32| Vec3::new(2.0 * (i as f32 - 1.0) + x, 0.0, 3.0 * z);
        part.quad([corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0), corner(-1.0, -1.0)]);
        match i {
            1 => {
                part.uv0.iter_mut().for_each(|uv| uv.x = -uv.x);
                part.tangents.iter_mut().for_each(|t| *t = Vec4::new(-t.x, -t.y, -t.z, -t.w));
            }
            2 => part.uv0.fill(Vec2::splat(0.5)),
            _ => {}
        }
        scene.add(part);
    }
    scene.finish("mirrored_uvs", front(), Sky::Constant(Vec3::ONE))
}

pub(super) fn grazing_sun() -> Scene {
    let mut scene = Assembly::default();
    let mut ground = Part::new("ground", scene.material(Material::lambert("white", Vec3::ONE)));
    plane(&mut ground, 3.0, 0.0);
    scene.add(ground);
    let cameras = view(Vec3::new(0.0, 3.0, 1.5), Vec3::new(0.0, 0.0, 0.0), 30.0);
    let mut scene = scene.finish("grazing_sun", cameras, Sky::Constant(Vec3::ZERO));
    let elevation = GRAZING_DEGREES.to_radians();
    let direction = Vec3::new(elevation.cos(), -elevation.sin(), 0.0);
    scene.sun = Some(Sun { direction, irradiance: Vec3::splat(GRAZING_IRRADIANCE), angle: 0.0 });
    scene
}

/// Two black squares that emit 1e-6 and 1e6, and a white floor that both light.
pub(super) fn micro_to_mega() -> Scene {
    let mut scene = Assembly::default();
    let mut ground = Part::new("ground", scene.material(Material::lambert("white", Vec3::splat(0.8))));
    plane(&mut ground, 3.0, 0.0);
    scene.add(ground);
    for (x, radiance) in [(-1.0, 1e-6), (1.0, 1e6)] {
        let material = Material::emitter(&format!("{radiance:e}"), Vec3::ZERO, Vec3::splat(radiance));
        let mut lamp = Part::new(&format!("lamp_{radiance:e}"), scene.material(material));
        let corner = |dx: f32, y: f32| Vec3::new(x + 0.5 * dx, 0.8 + 0.5 * y, -1.0);
        lamp.quad([corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)]);
        scene.add(lamp);
    }
    scene.finish("micro_to_mega", front(), Sky::Constant(Vec3::ZERO))
}

/// Over a floor in sun and sky: eight wires of 1 mm, a curtain of one sheet in waves, and cards cut to leaves.
pub(super) fn wires() -> Scene {
    let mut scene = Assembly::default();
    let mut ground = Part::new("ground", scene.material(Material::lambert("ground", Vec3::splat(0.5))));
    plane(&mut ground, 3.0, 0.0);
    scene.add(ground);
    let mut wires = Part::new("wires", scene.material(Material::lambert("wire", Vec3::splat(0.1))));
    for i in 0..8 {
        let low = Vec3::new(-2.0, 0.3 + 0.12 * i as f32, 0.6);
        wires.block_between(low, low + Vec3::new(1.6, 1e-3, 1e-3));
    }
    scene.add(wires);
    let cloth = Material { double_sided: true, ..Material::lambert("cloth", Vec3::new(0.7, 0.2, 0.2)) };
    let mut curtain = Part::new("curtain", scene.material(cloth));
    curtain
        .sheet([48, 4], Vec2::ONE, |s, t| Vec3::new(-0.2 + 1.2 * s, 1.4 * t + 0.02, 0.08 * (25.0 * s).sin()));
    scene.add(curtain);
    let leaf = |x: u32, y: u32| {
        let (u, v) = ((x as f32 + 0.5) / 16.0 - 0.5, (y as f32 + 0.5) / 16.0 - 0.5);
        let solid = u.hypot(0.5 * v) < 0.22;
        [60, 140, 40, if solid { 255 } else { 0 }]
    };
    let rgba = (0..256).map(|i| leaf(i % 16, i / 16)).collect();
    let slot = scene.texture(Image { name: "leaf".into(), width: 16, height: 16, rgba });
    let leaves = scene.material(Material {
        base_color_texture: Some(slot),
        alpha: Alpha::Mask(0.5),
        double_sided: true,
        ..Material::lambert("leaves", Vec3::ONE)
    });
    let mut cards = Part::new("cards", leaves).repeating(0.3);
    for i in 0..5 {
        let (x, tilt) = (1.2 + 0.2 * i as f32, 0.1 * i as f32);
        cards.quad([
            Vec3::new(x, 0.05, 0.3 - tilt),
            Vec3::new(x + 0.3, 0.05, -0.3),
            Vec3::new(x + 0.3, 1.1, -0.3 + tilt),
            Vec3::new(x, 1.1, 0.3),
        ]);
    }
    scene.add(cards);
    let mut scene = scene.finish("wires", front(), Sky::Constant(Vec3::splat(0.5)));
    let direction = Vec3::new(-0.4, -1.0, -0.5).normalize();
    scene.sun = Some(Sun { direction, irradiance: Vec3::splat(5.0), angle: 0.0 });
    scene
}
