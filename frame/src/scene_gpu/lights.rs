//! Sun and punctual lights as shaders read them, and the one scale that keeps all radiance inside small floats.
//!
//! In: [`scene::Sun`] and [`scene::PunctualLight`]s, world space, metres. Out: [`Light`]s, the sun first, and a
//! [`RadianceScale`].
//!
//! All radiance is stored times `radiance_scale = 2^floor(log2(1024 / L))`, L the brightest radiance that anything in
//! the scene gives off or, as white Lambert surface, sends back: texels of the sky, emission, E / pi under the sun,
//! I / (pi d^2) at d = 1/8 of the scene's diagonal from a lamp. Half floats end at 65,504: what is brighter still
//! (a wall next to a lamp, a path through glass) has 64 times room. Below, 1024 is 2^34 times the smallest step 2^-24
//! of half floats and RGB9E5 alike.

use crate::Bind;
use glam::Vec3;
use scene::{Geometry, PunctualKind, Scene, Sky, Sun};
use std::f32::consts::PI;

/// The snippet: `struct Light`, its kinds, and the list.
pub const LIGHT_WGSL: &str = include_str!("light.inc.wgsl");
/// The list.
pub const LIGHTS_BIND: Bind = Bind::storage_read(1, 15, "lights");
/// Vectors of 16 bytes that a [`Light`] takes, `light_at` reads them.
pub const LIGHT_VECTORS: u32 = 4;

const _: () = assert!(size_of::<Light>() == 16 * LIGHT_VECTORS as usize);

crate::gpu_struct! {
    /// See `light.inc.wgsl`.
    pub struct Light {
        /// Metres; of a point or a spot.
        pub position: [f32; 3],
        /// `LIGHT_SUN` and its kin.
        pub kind: u32,
        /// Unit, the way the light travels.
        pub direction: [f32; 3],
        /// Metres beyond which a point or a spot gives nothing.
        pub range: f32,
        /// Times `radiance_scale`: W/m^2 on a plane facing a sun or directional light, W/sr of a point or a spot.
        pub intensity: [f32; 3],
        /// Of a spot's bright core; for a sun the cosine of half the disc's angle.
        pub cos_inner: f32,
        /// Of a spot's edge.
        pub cos_outer: f32,
        /// WGSL rounds the size up to a multiple of 16.
        pub _pad: [u32; 3],
    }
}

const SUN: u32 = 0;
const DIRECTIONAL: u32 = 1;
const POINT: u32 = 2;
const SPOT: u32 = 3;
/// Stands for an unlimited range: far beyond any scene, and its square is still a float.
const UNLIMITED: f32 = 1e18;

/// All lights of one moment, the sun first.
pub(super) fn lights(sun: Option<Sun>, geometry: &Geometry, radiance_scale: f32) -> Vec<Light> {
    let sun = sun.map(|sun| Light {
        kind: SUN,
        direction: sun.direction.into(),
        intensity: (radiance_scale * sun.irradiance).into(),
        range: UNLIMITED,
        cos_inner: (0.5 * sun.angle).cos(),
        ..Light::default()
    });
    let punctual = geometry.lights.iter().map(|light| {
        let (kind, cos_inner, cos_outer) = match light.kind {
            PunctualKind::Directional => (DIRECTIONAL, 1.0, 0.0),
            PunctualKind::Point => (POINT, 1.0, -1.0),
            PunctualKind::Spot { inner, outer } => (SPOT, inner.cos(), outer.cos()),
        };
        Light {
            position: light.position.into(),
            kind,
            direction: light.direction.into(),
            range: light.range.clamp(1e-6, UNLIMITED),
            intensity: (radiance_scale * light.intensity).into(),
            cos_inner,
            cos_outer,
            ..Light::default()
        }
    });
    sun.into_iter().chain(punctual).collect()
}

/// The scale, and what it could not save.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RadianceScale {
    /// A power of two.
    pub scale: f32,
    /// Sky channels, emissions and lights above 0 that stay below the smallest step of half floats and RGB9E5 and are
    /// therefore lost.
    pub lost: usize,
}

/// Stored value of the brightest radiance, at most.
const BRIGHTEST: f32 = 1024.0;
/// The smallest step of half floats and of RGB9E5.
const SMALLEST: f32 = 1.0 / 16_777_216.0;

impl RadianceScale {
    /// Looks at everything that gives off light.
    pub fn of(scene: &Scene, geometry: &Geometry) -> Self {
        let near = (scene.bounds().diagonal() / 8.0).max(1e-3);
        let materials = scene.materials.iter().filter(|m| m.emits());
        let emission = materials.map(|m| if m.unlit { m.base_color.truncate() } else { m.emission });
        let sun = scene.sun.iter().map(|sun| sun.irradiance / PI);
        let punctual = geometry.lights.iter().map(|light| match light.kind {
            PunctualKind::Directional => light.intensity / PI,
            _ => light.intensity / (PI * near * near),
        });
        let sky: &[Vec3] = match &scene.sky {
            Sky::Constant(radiance) => std::slice::from_ref(radiance),
            Sky::Map(map) => &map.radiance,
        };
        let sources: Vec<_> = emission.chain(sun).chain(punctual).collect();
        let all =
            || sources.iter().chain(sky).flat_map(|c| c.to_array()).filter(|c| c.is_finite() && *c > 0.0);
        let brightest = all().fold(0.0_f32, f32::max);
        if brightest == 0.0 {
            return Self { scale: 1.0, lost: 0 };
        }
        // Any finite radiance has a scale: f32 exponents reach from -126 to 127.
        let scale = (BRIGHTEST / brightest).log2().floor().clamp(-100.0, 100.0).exp2();
        Self { scale, lost: all().filter(|c| c * scale < SMALLEST).count() }
    }
}
