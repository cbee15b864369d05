//! The CPU half of `mix.inc.wgsl`: light of several trace pixels, mixed by weight.

use super::reference::{Tap, lobe};
use crate::modulate::reference::Inputs;
use frame::surface::Surface;
use glam::{UVec2, Vec2, Vec3};

/// Weighted light of one lobe.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Mix {
    light: Vec3,
    pub(crate) weight: f32,
    pixel: UVec2,
    heaviest: f32,
}

impl Mix {
    /// `mix_tap`, of one lobe.
    pub(crate) fn tap(&mut self, inputs: &Inputs<'_>, which: usize, tap: &Tap, weight: f32) {
        if !tap.has[which] || weight.is_nan() || weight <= 0.0 {
            return;
        }
        self.light += weight * lobe(inputs, which, tap.pixel);
        self.weight += weight;
        if weight > self.heaviest {
            (self.pixel, self.heaviest) = (tap.pixel, weight);
        }
    }

    /// `mix_mean` or, for the specular lobe (1), `mix_specular`.
    pub(crate) fn taken(&self, inputs: &Inputs<'_>, which: usize, surface: &Surface) -> Vec3 {
        if self.weight <= 0.0 {
            return Vec3::ZERO;
        }
        if which == 1 && surface.roughness == Vec2::ZERO {
            return lobe(inputs, which, self.pixel);
        }
        self.light / self.weight
    }
}
