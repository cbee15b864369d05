//! Settings of the filter, and what its passes get of them.

use super::SvgfParams;
use crate::{edge, temporal};
use frame::Knob;

/// Settings of the filter. Radii are in trace rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Index into [`PRESETS`].
    pub preset: u32,
    /// What is followed, and how long it is remembered.
    pub temporal: temporal::Settings,
    /// Levels of the wavelet; each doubles the distance between taps.
    pub levels: u32,
    /// Index into [`TAPS`].
    pub taps: u32,
    /// Of the luminance weight, standard deviations.
    pub sigma_luminance: f32,
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

/// Whose numbers the knobs start from.
pub const PRESETS: &[&str] = &["paper", "public"];

/// Taps of a level.
pub const TAPS: &[&str] = &["5x5", "3x3"];

impl Default for Settings {
    fn default() -> Self {
        Self {
            preset: 0,
            temporal: temporal::Settings::default(),
            levels: 5,
            taps: 0,
            sigma_luminance: 4.0,
            sigma_normal: 128.0,
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
        let temporal::Settings { alpha_color, alpha_moments, history_max, history_plane, history_normal } =
            &mut self.temporal;
        let mut knobs = vec![
            Knob::choice(
                "preset",
                &mut self.preset,
                PRESETS,
                "whose numbers the knobs start from; those that were moved keep their value. paper: Schied et al. 2017; \
                 public: 3x3 taps, six levels, sigma_z 4, sigma_n 16, sigma_l 10, shares 0.1, as in public implementations: smoother, blurs more",
            ),
            Knob::float(
                "alpha_color",
                alpha_color,
                0.0..=1.0,
                "",
                "least share of a new frame in the colour; higher follows changes of light, lower leaves less noise, 0 \
                 averages all frames alike. The paper's 0.2",
            ),
            Knob::float(
                "alpha_moments",
                alpha_moments,
                0.0..=1.0,
                "",
                "least share of a new frame in the moments of luminance; lower steadies the variance, higher follows \
                 changes. The paper's 0.2",
            ),
            Knob::int(
                "history_max",
                history_max,
                1..=1024,
                "frames",
                "frames that a pixel counts at most; bounds 1/N where the alphas are lower. Ours: 255, long past 1/0.2",
            ),
        ];
        knobs.extend(temporal::Settings::surface_knobs(history_plane, history_normal));
        knobs.extend([
            Knob::int(
                "levels",
                &mut self.levels,
                1..=7,
                "",
                "passes of the wavelet, taps 1, 2, 4, ... rows apart; more smooths wider. The paper's five reach 62 rows",
            ),
            Knob::choice(
                "taps",
                &mut self.taps,
                TAPS,
                "taps of a level; 3x3 takes less than half the time and reaches half as far. The paper's 5x5; its sequel and \
                 public implementations have 3x3",
            ),
            Knob::float(
                "sigma_l",
                &mut self.sigma_luminance,
                0.0..=100.0,
                "",
                "difference of luminance, in standard deviations of the pixel's own, that costs a tap 1 - 1/e; higher \
                 blurs shadows, lower keeps noise. The paper's four",
            ),
            Knob::float(
                "sigma_n",
                &mut self.sigma_normal,
                0.0..=1024.0,
                "",
                "power of the cosine between shading normals; higher keeps bumps and leaves noise. The paper's 128",
            ),
            Knob::float(
                "sigma_z",
                &mut self.sigma_depth,
                0.01..=100.0,
                "px",
                "distance from the pixel's plane, in rows at its depth, that costs a tap 1 - 1/e; higher lets light bleed \
                 over steps, lower splits curved surfaces. The paper's one, in our measure of depth",
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

    /// With the preset's numbers for every knob of its that still has its default.
    pub fn effective(&self) -> Self {
        let (mut settings, paper) = (*self, Self::default());
        if self.preset == 0 {
            return settings;
        }
        let replace = |value: &mut f32, paper: f32, public: f32| {
            if *value == paper {
                *value = public;
            }
        };
        if settings.taps == paper.taps {
            settings.taps = 1;
        }
        if settings.levels == paper.levels {
            settings.levels = 6;
        }
        replace(&mut settings.sigma_depth, paper.sigma_depth, 4.0);
        replace(&mut settings.sigma_normal, paper.sigma_normal, 16.0);
        replace(&mut settings.sigma_luminance, paper.sigma_luminance, 10.0);
        let (memory, before) = (&mut settings.temporal, paper.temporal);
        replace(&mut memory.alpha_color, before.alpha_color, 0.1);
        replace(&mut memory.alpha_moments, before.alpha_moments, 0.1);
        settings
    }

    /// For one level of the wavelet, counted from 0; the variance takes the first one's.
    pub fn level_params(&self, level: u32, columns_per_row: f32) -> SvgfParams {
        let [first_tap, second_tap] = edge::taps(level, columns_per_row);
        SvgfParams {
            first_tap,
            second_tap,
            sigma_luminance: self.sigma_luminance,
            sigma_normal: self.sigma_normal,
            sigma_depth: self.sigma_depth,
            lobe_spread: self.lobe_spread,
            roughness_fraction: self.roughness_fraction,
            rows_per_column: 1.0 / columns_per_row,
            reach: if self.taps == 0 { 2 } else { 1 },
            kernel: if self.taps == 0 { [0.375, 0.25, 0.0625] } else { [0.5, 0.25, 0.0] },
            least_variance: self.temporal.alpha_color / (2.0 - self.temporal.alpha_color),
            _end: 0,
        }
    }
}
