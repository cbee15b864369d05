//! What a frame made that is no light: NaN, infinity, less than nothing, in any texture of any stage.
//!
//! Looked at are the picture, the light before and after the filter (both lobes, with the lengths of their first
//! segments), distances and motion of both G-buffers, and the packed surfaces, as what they unpack to.

use crate::Error;
use crate::pipeline::Rendered;
use frame::surface::Surface;
use frame::{GBuffer, Gpu, RadianceImage};
use half::f16;
use serde::Serialize;
use std::ops::AddAssign;

/// Values that are none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Strange {
    /// Not a number.
    pub nan_count: u64,
    /// Infinite, of either sign.
    pub inf_count: u64,
    /// Below 0 where nothing can be.
    pub negative_count: u64,
}

impl Strange {
    /// Whether all values are.
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }

    fn number(&mut self, value: f32) {
        self.nan_count += u64::from(value.is_nan());
        self.inf_count += u64::from(value.is_infinite());
    }

    fn amount(&mut self, value: f32) {
        self.number(value);
        self.negative_count += u64::from(value < 0.0);
    }
}

impl AddAssign for Strange {
    fn add_assign(&mut self, other: Self) {
        self.nan_count += other.nan_count;
        self.inf_count += other.inf_count;
        self.negative_count += other.negative_count;
    }
}

/// Counts over everything that a frame made.
///
/// # Errors
/// Reading back fails.
pub fn of(gpu: &Gpu, rendered: &Rendered) -> Result<Strange, Error> {
    let mut strange = Strange::default();
    let color: Vec<[f16; 4]> = gpu.read_texture(&rendered.color.texture)?;
    color.as_flattened().iter().for_each(|v| strange.amount(v.to_f32()));
    for light in [&rendered.noisy, &rendered.denoised] {
        of_light(gpu, light, &mut strange)?;
    }
    for guides in [&rendered.trace, &rendered.display] {
        of_guides(gpu, guides, &mut strange)?;
    }
    Ok(strange)
}

fn of_light(gpu: &Gpu, light: &RadianceImage, strange: &mut Strange) -> Result<(), Error> {
    for lobe in [Some(&light.diffuse), light.specular.as_ref()].into_iter().flatten() {
        let texels: Vec<[f16; 4]> = gpu.read_texture(lobe)?;
        texels.as_flattened().iter().for_each(|v| strange.amount(v.to_f32()));
    }
    Ok(())
}

fn of_guides(gpu: &Gpu, guides: &GBuffer, strange: &mut Strange) -> Result<(), Error> {
    let distances: Vec<f32> = gpu.read_texture(&guides.distance)?;
    distances.iter().for_each(|d| strange.amount(*d));
    let motion: Vec<[u32; 2]> = gpu.read_texture(&guides.motion_id)?;
    for [packed, _] in motion {
        let halves = [packed as u16, (packed >> 16) as u16];
        halves.into_iter().for_each(|bits| strange.number(f16::from_bits(bits).to_f32()));
    }
    let surfaces: Vec<[u32; 4]> = gpu.read_texture(&guides.surface)?;
    for (packed, distance) in surfaces.into_iter().zip(distances) {
        if distance > 0.0 {
            let surface = Surface::unpack_gbuffer(packed);
            surface.normal.to_array().into_iter().for_each(|n| strange.number(n));
        }
    }
    Ok(())
}
