//! What can be set, and how the defaults were chosen.

use super::JointParams;
use crate::search;
use frame::Knob;

/// Settings of the mix and of the search that stands in for it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Of the cosine between normals.
    pub normal_power: f32,
    /// Metres off the plane per metre of distance at which a weight is 1/e.
    pub plane_scale: f32,
    /// Where the four do not help.
    pub search: search::Settings,
}

impl Default for Settings {
    fn default() -> Self {
        Self { normal_power: 32.0, plane_scale: 0.01, search: search::Settings::default() }
    }
}

impl Settings {
    pub(crate) fn knobs(&mut self) -> Vec<Knob<'_>> {
        let Self { normal_power, plane_scale, search } = self;
        let mut knobs = vec![
            Knob::float(
                "normal_power",
                normal_power,
                0.0..=256.0,
                "",
                "power of the cosine between normals; higher keeps light off other facets of normal maps and mixes less. \
                 32: half the weight at 12 degrees",
            ),
            Knob::float(
                "plane_scale",
                plane_scale,
                1e-4..=1.0,
                "",
                "metres off the pixel's plane per metre of distance at which a weight is 1/e; lower keeps light in \
                 corners apart, higher mixes over curved things. 0.01: half the search's plane test",
            ),
        ];
        knobs.extend(search.knobs());
        knobs
    }

    /// `parts`: weights of the bilinear part and of the Gaussian one.
    pub(crate) fn params(&self, [wide, narrow]: [f32; 2]) -> JointParams {
        JointParams { normal_power: self.normal_power, plane_scale: self.plane_scale, wide, narrow }
    }
}
