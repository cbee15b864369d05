//! The Cornell box: the measured data of Cornell University's Program of Computer Graphics.
//!
//! The data is in millimetres with x to the left, y up and z away from the camera; `(278 - x, y, -z) / 100` makes it a
//! room of 5.5 m (ten times the real one) and mirrors nothing: the red wall is to the left, the green one to the right.
//! Reflectances are the usual Rec. 709 stand-ins for the measured spectra. All surfaces are Lambert; the lamp emits
//! from its lower face only.

use super::{
    assembly::Assembly,
    part::{Corner, Part},
};
use crate::{Camera, Material, Scene, Sky};
use glam::{DVec3, Vec2, Vec3};

type Quad = [[f64; 3]; 4];

const FLOOR: [Quad; 1] = [[[552.8, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 559.2], [549.6, 0.0, 559.2]]];
const CEILING: [Quad; 1] =
    [[[556.0, 548.8, 0.0], [556.0, 548.8, 559.2], [0.0, 548.8, 559.2], [0.0, 548.8, 0.0]]];
const BACK: [Quad; 1] =
    [[[549.6, 0.0, 559.2], [0.0, 0.0, 559.2], [0.0, 548.8, 559.2], [556.0, 548.8, 559.2]]];
const RIGHT: [Quad; 1] = [[[0.0, 0.0, 559.2], [0.0, 0.0, 0.0], [0.0, 548.8, 0.0], [0.0, 548.8, 559.2]]];
const LEFT: [Quad; 1] =
    [[[552.8, 0.0, 0.0], [549.6, 0.0, 559.2], [556.0, 548.8, 559.2], [556.0, 548.8, 0.0]]];
const SHORT: [Quad; 5] = [
    [[130.0, 165.0, 65.0], [82.0, 165.0, 225.0], [240.0, 165.0, 272.0], [290.0, 165.0, 114.0]],
    [[290.0, 0.0, 114.0], [290.0, 165.0, 114.0], [240.0, 165.0, 272.0], [240.0, 0.0, 272.0]],
    [[130.0, 0.0, 65.0], [130.0, 165.0, 65.0], [290.0, 165.0, 114.0], [290.0, 0.0, 114.0]],
    [[82.0, 0.0, 225.0], [82.0, 165.0, 225.0], [130.0, 165.0, 65.0], [130.0, 0.0, 65.0]],
    [[240.0, 0.0, 272.0], [240.0, 165.0, 272.0], [82.0, 165.0, 225.0], [82.0, 0.0, 225.0]],
];
const TALL: [Quad; 5] = [
    [[423.0, 330.0, 247.0], [265.0, 330.0, 296.0], [314.0, 330.0, 456.0], [472.0, 330.0, 406.0]],
    [[423.0, 0.0, 247.0], [423.0, 330.0, 247.0], [472.0, 330.0, 406.0], [472.0, 0.0, 406.0]],
    [[472.0, 0.0, 406.0], [472.0, 330.0, 406.0], [314.0, 330.0, 456.0], [314.0, 0.0, 456.0]],
    [[314.0, 0.0, 456.0], [314.0, 330.0, 456.0], [265.0, 330.0, 296.0], [265.0, 0.0, 296.0]],
    [[265.0, 0.0, 296.0], [265.0, 330.0, 296.0], [423.0, 330.0, 247.0], [423.0, 0.0, 247.0]],
];
const LAMP: [Quad; 1] =
    [[[343.0, 548.7, 227.0], [343.0, 548.7, 332.0], [213.0, 548.7, 332.0], [213.0, 548.7, 227.0]]];

/// The scene of the reference images `cornell_*`.
pub(super) fn cornell() -> Scene {
    let mut scene = Assembly::default();
    let wall = |name, albedo| Material { double_sided: true, ..Material::lambert(name, albedo) };
    let white = scene.material(wall("white", Vec3::new(0.885809, 0.698859, 0.666422)));
    let red = scene.material(wall("red", Vec3::new(0.570068, 0.0430135, 0.0443706)));
    let green = scene.material(wall("green", Vec3::new(0.105421, 0.37798, 0.076425)));
    let light = scene.material(Material::emitter(
        "light",
        Vec3::new(0.936461, 0.740433, 0.705267),
        Vec3::new(18.387, 13.9873, 6.75357),
    ));
    let parts: [(&str, u32, &[Quad]); 8] = [
        ("floor", white, &FLOOR),
        ("ceiling", white, &CEILING),
        ("back", white, &BACK),
        ("right", green, &RIGHT),
        ("left", red, &LEFT),
        ("short", white, &SHORT),
        ("tall", white, &TALL),
        ("lamp", light, &LAMP),
    ];
    for (name, material, quads) in parts {
        let mut part = Part::new(name, material);
        for quad in quads {
            measured_quad(&mut part, quad);
        }
        scene.add(part);
    }
    let eye = Vec3::new(0.0, 2.73, 8.0);
    let target = Vec3::new(0.0, 2.73, 0.0);
    let vfov = 39.3077f64.to_radians() as f32;
    let camera = Camera { name: "camera".into(), eye, target, up: Vec3::Y, vfov };
    scene.finish("cornell", vec![camera], Sky::Constant(Vec3::ZERO))
}

/// One quadrilateral of the data; a little out of plane where the measurements are, so all corners share one normal.
fn measured_quad(part: &mut Part, quad: &Quad) {
    let corners = quad.map(|[x, y, z]| DVec3::new(278.0 - x, y, -z) * 0.01);
    let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize().as_vec3();
    let along_u = (corners[1] - corners[0]).as_vec3();
    // v grows along the second side, up where glTF's points down: pictures would be mirrored.
    let uvs = [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y];
    let numbers = [0, 1, 2, 3].map(|i| {
        let (position, uv) = (corners[i].as_vec3(), uvs[i]);
        part.corner(Corner { position, normal, along_u, uv, handedness: -1.0 })
    });
    part.pair(numbers);
}
