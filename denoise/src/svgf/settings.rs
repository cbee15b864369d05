//! Settings of the filter, and what its passes get of them.

use super::{ReprojectParams, SvgfParams};
use crate::edge;
use frame::Knob;
use frame::info::FrameInfo;
use glam::Vec3;

/// Settings of the filter. Radii are in trace rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Least share of a new frame in the colour.
    pub alpha_color: f32,
    /// Least share of a new frame in the moments.
    pub alpha_moments: f32,
    /// Frames that a pixel remembers having.
    pub history_max: u32,
    /// How far from the expected plane history may lie, relative to depth.
    pub history_plane: f32,
    /// Least cosine between the shading normals of a pixel and its history.
    pub history_normal: f32,
    /// Levels of the wavelet; each doubles the distance between taps.
    pub levels: u32,
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

impl Default for Settings {
    fn default() -> Self {
        Self {
            alpha_color: 0.2,
            alpha_moments: 0.2,
            history_max: 255,
            history_plane: 0.01,
            history_normal: 0.9,
            levels: 5,
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
        vec![
            Knob::float(
                "alpha_color",
                &mut self.alpha_color,
                0.0..=1.0,
                "",
                "least share of a new frame in the colour; higher follows changes of light, lower leaves less noise, 0 \
                 averages all frames alike. The paper's 0.2",
            ),
            Knob::float(
                "alpha_moments",
                &mut self.alpha_moments,
                0.0..=1.0,
                "",
                "least share of a new frame in the moments of luminance; lower steadies the variance, higher follows \
                 changes. The paper's 0.2",
            ),
            Knob::int(
                "history_max",
                &mut self.history_max,
                1..=1024,
                "frames",
                "frames that a pixel counts at most; bounds 1/N where the alphas are lower. Ours: 255, long past 1/0.2",
            ),
            Knob::float(
                "history_plane",
                &mut self.history_plane,
                0.0..=1.0,
                "",
                "how far from the pixel's plane its history may lie, relative to depth; higher leaves trails behind edges, \
                 lower forgets what moves towards the viewer. The paper gives none: one hundredth",
            ),
            Knob::float(
                "history_normal",
                &mut self.history_normal,
                -1.0..=1.0,
                "",
                "least cosine between the shading normals of a pixel and its history; higher forgets bumps at every motion, \
                 lower drags light around corners. The paper gives none: 0.9, 26 degrees",
            ),
            Knob::int(
                "levels",
                &mut self.levels,
                1..=7,
                "",
                "passes of the wavelet, taps 1, 2, 4, ... rows apart; more smooths wider. The paper's five reach 62 rows",
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
        ]
    }

    /// For the reprojection.
    pub fn reproject_params(&self, frame: &FrameInfo) -> ReprojectParams {
        let before = FrameInfo { camera: frame.previous_camera.clone(), ..frame.clone() }.uniform();
        ReprojectParams {
            previous_forward: before.forward,
            alpha_color: self.alpha_color,
            previous_right: before.right,
            alpha_moments: self.alpha_moments,
            previous_up: before.up,
            plane_tolerance: self.history_plane,
            eye_offset: (frame.camera.eye - Vec3::from(before.eye)).into(),
            normal_min: self.history_normal,
            keeps_history: u32::from(!frame.restart),
            history_max: self.history_max as f32,
            _pad: [0; 2],
        }
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
            _pad: [0; 2],
        }
    }
}
