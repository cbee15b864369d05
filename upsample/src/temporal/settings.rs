//! What can be set, and how the defaults were chosen.

use super::TemporalParams;
use crate::joint_bilateral;
use frame::Knob;
use frame::info::FrameInfo;

/// Settings of the accumulation and of what it accumulates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Most weight kept, in samples at the pixel's centre.
    pub weight_max: f32,
    /// Standard deviations that what was kept may be off.
    pub clamp_width: f32,
    /// Metres off the plane per metre of distance.
    pub plane_tolerance: f32,
    /// Cosine between shading normals.
    pub normal_min: f32,
    /// This frame's light.
    pub joint: joint_bilateral::Settings,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            weight_max: 8.0,
            clamp_width: 2.0,
            plane_tolerance: 0.02,
            normal_min: 0.9,
            joint: joint_bilateral::Settings::default(),
        }
    }
}

impl Settings {
    pub(crate) fn knobs(&mut self) -> Vec<Knob<'_>> {
        let Self { weight_max, clamp_width, plane_tolerance, normal_min, joint } = self;
        let mut knobs = vec![
            Knob::float(
                "weight_max",
                weight_max,
                0.0..=256.0,
                "",
                "most weight that is kept, in samples at the pixel's centre; a frame brings about 0.12 at 3 by 2.25. \
                 Higher: less noise, longer memory. 8: some 60 frames",
            ),
            Knob::float(
                "clamp_width",
                clamp_width,
                0.0..=100.0,
                "",
                "standard deviations of this frame's 3x3 trace pixels that what was kept may be off; lower follows \
                 changes of light sooner and keeps more noise. 2: one frame in twenty of steady noise is touched",
            ),
            Knob::float(
                "plane_tolerance",
                plane_tolerance,
                0.0..=1.0,
                "",
                "metres off the plane per metre of distance at which a kept pixel is no longer the same place; higher \
                 keeps more of what moves and smears at edges. 0.02, as in the search",
            ),
            Knob::float(
                "normal_min",
                normal_min,
                -1.0..=1.0,
                "",
                "least cosine between normals of a pixel and of what was kept; lower keeps more on turning things. 0.9: \
                 26 degrees",
            ),
        ];
        knobs.extend(joint.knobs());
        knobs
    }

    pub(crate) fn params(&self, frame: &FrameInfo, keeps_history: bool) -> TemporalParams {
        let mut before = frame.clone();
        before.camera = frame.previous_camera.clone();
        let view = before.uniform();
        TemporalParams {
            previous_forward: view.forward,
            weight_max: self.weight_max,
            previous_right: view.right,
            clamp_width: self.clamp_width,
            previous_up: view.up,
            plane_tolerance: self.plane_tolerance,
            eye_offset: (frame.camera.eye - frame.previous_camera.eye).into(),
            normal_min: self.normal_min,
            keeps_history: f32::from(u8::from(keeps_history)),
            _pad: [0.0; 3],
        }
    }
}
