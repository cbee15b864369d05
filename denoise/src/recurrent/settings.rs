//! Settings of the recurrent blur, and what its passes get of them.

use super::RecurrentParams;
use crate::{edge, temporal};
use frame::Knob;
use frame::info::FrameInfo;

/// Settings of the blur. Radii are in trace rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Frames of the slow history.
    pub history_max: u32,
    /// Frames of the fast history.
    pub fast_frames: u32,
    /// How far from the expected plane history may lie, relative to depth.
    pub history_plane: f32,
    /// Least cosine between the shading normals of a pixel and its history.
    pub history_normal: f32,
    /// Of the kernel after one frame.
    pub radius: f32,
    /// Of the kernel after many.
    pub radius_min: f32,
    /// Hit distance that counts as far, metres; and what a metre of depth adds to it.
    pub hit_far: [f32; 2],
    /// Frames below which neighbours help.
    pub fix_frames: u32,
    /// How far those lie after one frame, twice.
    pub fix_stride: f32,
    /// Standard errors that the two histories may lie apart.
    pub lag_sigma: f32,
    /// Of the normals' weight: power of the cosine.
    pub sigma_normal: f32,
    /// Of the weight by distance from the pixel's plane, rows.
    pub sigma_depth: f32,
    /// How far the roughness of a specular tap may differ.
    pub roughness_fraction: f32,
    /// Below this a specular lobe is a mirror's.
    pub roughness_min: f32,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            history_max: 30,
            fast_frames: 6,
            history_plane: 0.01,
            history_normal: 0.9,
            radius: 12.0,
            radius_min: 1.0,
            hit_far: [3.0, 0.1],
            fix_frames: 4,
            fix_stride: 14.0,
            lag_sigma: 2.0,
            sigma_normal: 64.0,
            sigma_depth: 1.0,
            roughness_fraction: 0.5,
            roughness_min: 0.02,
        }
    }
}

impl Settings {
    /// All of them, lent out.
    pub fn knobs(&mut self) -> Vec<Knob<'_>> {
        let [hit_far, hit_far_growth] = &mut self.hit_far;
        let mut knobs = vec![
            Knob::int(
                "history_max",
                &mut self.history_max,
                1..=1024,
                "frames",
                "frames of the slow history; more leaves less noise and follows light later. NRD's 30",
            ),
            Knob::int(
                "fast_frames",
                &mut self.fast_frames,
                1..=1024,
                "frames",
                "frames of the fast history that tells when the slow one lags; more is surer and later. NRD's 6",
            ),
        ];
        knobs.extend(temporal::Settings::surface_knobs(&mut self.history_plane, &mut self.history_normal));
        knobs.extend([
            Knob::float(
                "radius",
                &mut self.radius,
                0.0..=64.0,
                "px",
                "radius of the blur after one frame, in rows; falls with the root of the frames. NRD's 30 of 1,440 rows, \
                 which would be 10 of 480: somewhat more, as there is no blur before accumulation",
            ),
            Knob::float(
                "radius_min",
                &mut self.radius_min,
                0.0..=64.0,
                "px",
                "least radius of the blur; higher smooths what history has made quiet already. NRD's 1",
            ),
            Knob::float(
                "hit_far",
                hit_far,
                0.01..=1000.0,
                "m",
                "hit distance from which on diffuse light is blurred with the whole radius; shorter hits down to a quarter. \
                 Higher keeps contact shadows and their noise. NRD's 3",
            ),
            Knob::float(
                "hit_far_growth",
                hit_far_growth,
                0.0..=10.0,
                "",
                "what a metre of depth adds to hit_far, as a pixel spans more there. NRD's 0.1",
            ),
            Knob::int(
                "fix_frames",
                &mut self.fix_frames,
                0..=64,
                "frames",
                "below so many frames a pixel is helped by neighbours; more blurs what was just uncovered for longer. NRD's \
                 history fix ends after 3: the fourth needs none",
            ),
            Knob::float(
                "fix_stride",
                &mut self.fix_stride,
                0.0..=64.0,
                "px",
                "rows between those neighbours, over one plus the pixel's frames. NRD's 14",
            ),
            Knob::float(
                "lag_sigma",
                &mut self.lag_sigma,
                0.0..=1000.0,
                "",
                "standard errors that slow and fast history may lie apart; lower forgets for noise, higher lags. Ours: \
                 two; what chance puts beyond it is a small share",
            ),
            Knob::float(
                "sigma_n",
                &mut self.sigma_normal,
                0.0..=1024.0,
                "",
                "power of the cosine between shading normals; higher keeps bumps and leaves noise. Ours: half of svgf's, as \
                 there are fewer taps",
            ),
            Knob::float(
                "sigma_z",
                &mut self.sigma_depth,
                0.01..=100.0,
                "px",
                "distance from the pixel's plane, in rows at its depth, that costs a tap 1 - 1/e; higher lets light bleed \
                 over steps, lower splits curved surfaces. As svgf's",
            ),
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

    /// What is followed, and how long it is remembered.
    pub fn memory(&self) -> temporal::Settings {
        temporal::Settings {
            alpha_color: 1.0 / self.history_max as f32,
            alpha_moments: 1.0 / self.fast_frames as f32,
            history_max: self.history_max,
            history_plane: self.history_plane,
            history_normal: self.history_normal,
        }
    }

    /// For the blur number `turn` of a frame; recovering takes the first one's.
    pub fn params(&self, frame: &FrameInfo, turn: u32) -> RecurrentParams {
        // The golden angle, so that no two of many frames look the same way; the second blur lies between the first's taps.
        let angle = frame.frame_index as f32 * 2.399_963 + turn as f32 * std::f32::consts::FRAC_PI_8;
        RecurrentParams {
            turn: [angle.cos(), angle.sin()],
            radius: self.radius,
            radius_min: self.radius_min,
            hit_far: self.hit_far,
            sigma_normal: self.sigma_normal,
            sigma_depth: self.sigma_depth,
            roughness_fraction: self.roughness_fraction,
            columns_per_row: frame.columns_per_row(),
            fix_frames: self.fix_frames as f32,
            fix_stride: self.fix_stride,
            lag_sigma: self.lag_sigma,
            fast_frames: self.fast_frames as f32,
        }
    }
}
