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
