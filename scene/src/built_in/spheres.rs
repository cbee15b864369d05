//! Balls on a lattice: roughness 0 to 1 across, metalness 0, 1/2, 1 down, and a last row that glows.
//!
//! Nothing but a white sky of radiance 1 lights them, so a ball that keeps all energy shows its base colour where it
//! sees only sky.

use super::{assembly::Assembly, part::Part};
use crate::{Camera, Material, Scene, Sky};
use glam::{Vec3, Vec4};

const COLUMNS: u16 = 7;
const METALNESS: [f32; 3] = [0.0, 0.5, 1.0];
const RADIUS_M: f32 = 0.42;
/// Distinct per channel, so that swapped channels show.
const BASE_COLOR: Vec4 = Vec4::new(0.9, 0.6, 0.3, 1.0);

/// Rows from the top are y = 3, 2, 1 and 0; columns x = 0 to 6.
pub(super) fn spheres() -> Scene {
    let mut scene = Assembly::default();
    for column in 0..COLUMNS {
        let share = f32::from(column) / f32::from(COLUMNS - 1);
        for (row, metallic) in METALNESS.into_iter().enumerate() {
            let name = format!("metal_{metallic}_roughness_{share:.2}");
            let base_color = BASE_COLOR;
            let material = Material {
                name: name.clone(),
                base_color,
                metallic,
                roughness: share,
                ..Material::default()
            };
            ball(&mut scene, &name, material, [f32::from(column), 3.0 - row as f32]);
        }
        // From a quarter of the sky's radiance to 16 times, doubling, blue to orange.
        let hue = Vec3::new(0.3, 0.6, 1.0).lerp(Vec3::new(1.0, 0.6, 0.3), share);
        let name = format!("glow_{column}");
        let material = Material::emitter(&name, Vec3::splat(0.5), hue * (0.25 * f32::from(1u16 << column)));
        ball(&mut scene, &name, material, [f32::from(column), 0.0]);
    }
    let target = Vec3::new(3.0, 1.5, 0.0);
    let eye = target + 9.0 * Vec3::Z;
    // 5.6 m of the plane of the balls from top to bottom: all seven columns fit a 4:3 picture.
    let vfov = 2.0 * (2.8f32 / 9.0).atan();
    let camera = Camera { name: "front".into(), eye, target, up: Vec3::Y, vfov };
    scene.finish("spheres", vec![camera], Sky::Constant(Vec3::ONE))
}

fn ball(scene: &mut Assembly, name: &str, material: Material, [x, y]: [f32; 2]) {
    let mut part = Part::new(name, scene.material(material));
    part.ball(Vec3::new(x, y, 0.0), RADIUS_M, [48, 24]);
    scene.add(part);
}
