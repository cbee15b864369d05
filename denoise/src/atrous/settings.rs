//! Settings of the wavelet, and what each level gets of them.

use super::AtrousParams;
use crate::edge;
use frame::Knob;

/// Settings of the wavelet. Radii are in trace rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Levels; each doubles the distance between taps.
    pub levels: u32,
    /// Index into [`TAPS`].
    pub taps: u32,
    /// Of the colour weight at the first level; halves from level to level.
    pub sigma_color: f32,
    /// Of the normals' weight.
    pub sigma_normal: f32,
    /// Of the weight by distance from the pixel's plane, rows.
    pub sigma_plane: f32,
    /// Share of the specular lobe's tangent that the kernel may span.
    pub lobe_spread: f32,
    /// How far the roughness of a specular tap may differ.
    pub roughness_fraction: f32,
    /// Below this a specular lobe is a mirror's.
    pub roughness_min: f32,
}

/// Taps of a level.
pub const TAPS: &[&str] = &["5x5", "3x3"];

impl Default for Settings {
    fn default() -> Self {
        Self {
            levels: 5,
            taps: 1,
            sigma_color: 4.0,
            sigma_normal: 0.4,
            sigma_plane: 1.0,
            lobe_spread: 0.25,
            roughness_fraction: 0.5,
            roughness_min: 0.02,
        }
    }
}

impl Settings {
    /// All of them, lent out.
    pub fn knobs(&mut self) -> Vec<Knob<'_>> {
        vec![
            Knob::int(
                "levels",
                &mut self.levels,
                1..=7,
                "",
                "passes of the wavelet, taps 1, 2, 4, ... rows apart; more smooths wider. The paper's example: five, which \
                 reach 62 rows",
            ),
            Knob::choice(
                "taps",
                &mut self.taps,
                TAPS,
                "taps of a level; 3x3 takes less than half the time and reaches half as far. The paper's is 5x5; 3x3 \
                 has less error on all of the references' noisy pictures",
            ),
            Knob::float(
                "sigma_color",
                &mut self.sigma_color,
                0.01..=100.0,
                "",
                "difference of light, relative to the brighter pixel, that costs a tap 1 - 1/e at the first level; halves \
                 each level. Higher blurs shadows, lower keeps noise. The paper gives none: four, because one sample a \
                 pixel differs from its neighbour by all of it",
            ),
            Knob::float(
                "sigma_normal",
                &mut self.sigma_normal,
                0.001..=2.0,
                "rad",
                "angle between shading normals that costs a tap 1 - 1/e; lower keeps bumps and leaves noise. The paper \
                 gives none: 0.4 leaves 4e-6 at a right angle, and on curved things a few pixels wide it gave 0.8 dB more \
                 than 0.25",
            ),
            Knob::float(
                "sigma_plane",
                &mut self.sigma_plane,
                0.01..=100.0,
                "px",
                "distance from the pixel's plane, in rows at its depth, that costs a tap 1 - 1/e; higher lets light bleed \
                 over steps, lower splits curved surfaces. Ours: one pixel is the least that the picture can show",
            ),
            Knob::float("lobe_spread", &mut self.lobe_spread, 0.0..=10.0, "", edge::LOBE_SPREAD_DOC),
            Knob::float(
                "roughness_fraction",
                &mut self.roughness_fraction,
                0.01..=10.0,
                "",
                edge::ROUGHNESS_FRACTION_DOC,
            ),
            Knob::float("roughness_min", &mut self.roughness_min, 0.0..=1.0, "", edge::ROUGHNESS_MIN_DOC),
        ]
    }

    /// For one level, counted from 0.
    pub fn params(&self, level: u32, columns_per_row: f32) -> AtrousParams {
        let [first_tap, second_tap] = edge::taps(level, columns_per_row);
        AtrousParams {
            first_tap,
            second_tap,
            sigma_color: self.sigma_color / (1u32 << level) as f32,
            sigma_normal: self.sigma_normal,
            sigma_plane: self.sigma_plane,
            lobe_spread: self.lobe_spread,
            roughness_fraction: self.roughness_fraction,
            rows_per_column: 1.0 / columns_per_row,
            reach: if self.taps == 0 { 2 } else { 1 },
            kernel: if self.taps == 0 { [0.375, 0.25, 0.0625] } else { [0.5, 0.25, 0.0] },
            _pad: 0,
            _end: 0,
        }
    }
}
