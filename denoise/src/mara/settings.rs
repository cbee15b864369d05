//! Settings of the filter, and what its passes get of them.

use super::MaraParams;
use crate::{edge, temporal};
use frame::Knob;

/// Settings of the filter. Radii are in trace rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// What is followed, and how long it is remembered.
    pub temporal: temporal::Settings,
    /// Pairs of blurs; each quadruples the distance between taps.
    pub rounds: u32,
    /// Taps on either side.
    pub radius: u32,
    /// Of the normals' weight: power of the cosine.
    pub sigma_normal: f32,
    /// Of the weight by distance from the pixel's plane, rows.
    pub sigma_depth: f32,
    /// Share of the specular lobe's slope that the kernel may span.
    pub lobe_spread: f32,
    /// How far the roughness of a specular tap may differ.
    pub roughness_fraction: f32,
    /// Below this a specular lobe is a mirror's.
    pub roughness_min: f32,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            temporal: temporal::Settings {
                alpha_color: 0.1,
                history_max: 32,
                ..temporal::Settings::default()
            },
            rounds: 2,
            radius: 4,
            sigma_normal: 32.0,
            sigma_depth: 1.0,
            lobe_spread: 0.25,
            roughness_fraction: 0.5,
            roughness_min: 0.02,
        }
    }
}

impl Settings {
    /// All of them, lent out.
    pub fn knobs(&mut self) -> Vec<Knob<'_>> {
        let temporal::Settings { alpha_color, history_plane, history_normal, .. } = &mut self.temporal;
        let mut knobs = vec![Knob::float(
            "alpha_color",
            alpha_color,
            0.0..=1.0,
            "",
            "least share of a new frame; higher follows changes of light, lower leaves less noise. The source gives none: a \
             tenth, as its kernels are small",
        )];
        knobs.extend(temporal::Settings::surface_knobs(history_plane, history_normal));
        knobs.extend([
            Knob::int(
                "rounds",
                &mut self.rounds,
                0..=3,
                "",
                "pairs of blurs, taps 1, 4, 16 rows apart; more smooths wider. Ours: two, which reach 20 rows",
            ),
            Knob::int(
                "radius",
                &mut self.radius,
                0..=16,
                "",
                "taps on either side; more costs time and leaves fewer gaps in the second round. Ours: four, that the second \
                 round's steps are the first one's reach",
            ),
            Knob::float(
                "sigma_n",
                &mut self.sigma_normal,
                0.0..=1024.0,
                "",
                "power of the cosine between shading normals; higher keeps bumps and leaves noise. Ours: a quarter of svgf's, \
                 as nothing else smooths here",
            ),
            Knob::float(
                "sigma_z",
                &mut self.sigma_depth,
                0.01..=100.0,
                "px",
                "distance from the pixel's plane, in rows at its depth, that costs a tap 1 - 1/e; higher lets light bleed \
                 over steps, lower splits curved surfaces. As svgf's",
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
        ]);
        knobs
    }

    /// For pass number `pass`: even ones run along rows.
    pub fn params(&self, pass: u32, columns_per_row: f32) -> MaraParams {
        let rows = 4i32.pow(pass / 2);
        let columns = ((rows as f32 * columns_per_row + 0.5).floor() as i32).max(1);
        MaraParams {
            step: if pass.is_multiple_of(2) { [columns, 0] } else { [0, rows] },
            radius: self.radius as i32,
            sigma_normal: self.sigma_normal,
            sigma_depth: self.sigma_depth,
            lobe_spread: self.lobe_spread,
            roughness_fraction: self.roughness_fraction,
            rows_per_column: 1.0 / columns_per_row,
        }
    }
}
