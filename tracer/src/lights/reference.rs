//! The CPU half: the same choice as `lights.inc.wgsl`, in f64 once the light is chosen.

use frame::scene_gpu::Light;
use glam::{DVec3, Vec3};
use std::f64::consts::TAU;

const DIRECTIONAL: u32 = 1;
const SPOT: u32 = 3;

/// As in the shader.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LightSample {
    pub(crate) wi: DVec3,
    pub(crate) distance: f32,
    pub(crate) irradiance: DVec3,
}

/// `lights` are those there is a choice of.
pub(crate) fn light_sample(lights: &[Light], diagonal: f32, point: Vec3, u: [f32; 2]) -> LightSample {
    let scaled = u[0] * lights.len() as f32;
    let index = (scaled as usize).min(lights.len() - 1);
    let light = &lights[index];
    let chosen = Vec3::from(light.intensity).as_dvec3() * lights.len() as f64;
    let towards = Vec3::from(light.direction).as_dvec3();
    if light.kind <= DIRECTIONAL {
        let cosine = 1.0 - (1.0 - f64::from(light.cos_inner)) * f64::from(u[1]);
        let radius = (1.0 - cosine * cosine).max(0.0).sqrt();
        let (sin, cos) = (TAU * f64::from(scaled - index as f32)).sin_cos();
        let axis = -towards;
        let side = axis.cross(if axis.x.abs() > 0.7 { DVec3::Y } else { DVec3::X }).normalize();
        let wi = (axis * cosine + radius * (cos * side + sin * axis.cross(side))).normalize();
        return LightSample { wi, distance: 4.0 * diagonal, irradiance: chosen };
    }
    let to_light = (Vec3::from(light.position) - point).as_dvec3();
    let distance_2 = to_light.length_squared().max(1e-12);
    let distance = distance_2.sqrt();
    let wi = to_light / distance;
    let reach_2 = (distance / f64::from(light.range)).powi(2).min(1.0);
    let mut irradiance = chosen / distance_2 * (1.0 - reach_2 * reach_2);
    if light.kind == SPOT {
        let width = f64::from(light.cos_inner - light.cos_outer).max(1e-4);
        let edge = (((-wi).dot(towards) - f64::from(light.cos_outer)) / width).clamp(0.0, 1.0);
        irradiance *= edge * edge;
    }
    LightSample { wi, distance: distance as f32, irradiance }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn light(kind: u32) -> Light {
        Light {
            kind,
            position: [1.0, 2.0, 3.0],
            direction: [0.6, -0.8, 0.0],
            intensity: [5.0; 3],
            range: 4.0,
            cos_inner: 0.9,
            cos_outer: 0.6,
            ..Light::default()
        }
    }

    #[test]
    fn a_lamp_fades_by_the_square_and_ends_at_its_range() {
        let from = |height: f32| light_sample(&[light(2)], 10.0, Vec3::new(1.0, 2.0 - height, 3.0), [0.5; 2]);
        let near = from(2.0);
        assert!((near.wi - DVec3::Y).length() < 1e-6 && (near.distance - 2.0).abs() < 1e-6);
        // I / d^2 (1 - (d / range)^4), KHR_lights_punctual.
        assert!((near.irradiance.x - 5.0 / 4.0 * (1.0 - 1.0 / 16.0)).abs() < 1e-6);
        assert_eq!(from(4.5).irradiance, DVec3::ZERO);
    }

    #[test]
    fn a_spot_is_bright_inside_and_dark_outside() {
        let at = |cosine: f32| {
            let axis = Vec3::from(light(3).direction);
            let across = Vec3::Z * (1.0 - cosine * cosine).sqrt();
            let point = Vec3::from(light(3).position) + cosine * axis + across;
            light_sample(&[light(3)], 10.0, point, [0.5; 2]).irradiance.x / (5.0 * (1.0 - 1.0 / 256.0))
        };
        // The square of the ramp between the two cosines.
        for (cosine, wanted) in [(0.95, 1.0), (0.75, 0.25), (0.55, 0.0)] {
            assert!((at(cosine) - wanted).abs() < 1e-4, "{cosine}: {}", at(cosine));
        }
    }

    #[test]
    fn one_of_many_stands_for_all_and_a_sun_fills_its_disc() {
        let mut sun = light(0);
        sun.intensity = [3.0; 3];
        let lights = [sun, light(1), light(1)];
        let (mut irradiance, mut direction, mut widest) = (0.0, DVec3::ZERO, 1.0f64);
        let axis = -Vec3::from(sun.direction).as_dvec3();
        for i in 0..30_000 {
            let u = [(i as f32 + 0.5) / 30_000.0, (i as f32 * 0.618_034).fract()];
            let sample = light_sample(&lights, 10.0, Vec3::ZERO, u);
            irradiance += sample.irradiance.x / 30_000.0;
            if i < 10_000 {
                direction += sample.wi / 10_000.0;
                widest = widest.min(sample.wi.dot(axis));
            }
        }
        assert!((irradiance - 13.0).abs() < 1e-9, "{irradiance}");
        // Uniform over the cap: the mean of its cosine is the middle of 0.9 and 1, and reaches its edge.
        assert!((direction - 0.95 * axis).length() < 1e-3, "{direction}");
        assert!((widest - 0.9).abs() < 1e-4, "{widest}");
    }
}
