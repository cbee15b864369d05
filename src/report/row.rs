//! One measured configuration against one reference: the line of a table that `rows.csv` and `rows.json` repeat.
//!
//! Times in milliseconds, sizes in bytes (10^6 of them are a MB), errors as the data contract defines them. What could
//! not be measured is `None`: an empty cell in CSV, `null` in JSON, never a guess. Infinity (the PSNR of two equal
//! pictures) has no word in JSON and is left empty too.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt;

/// What an error was measured against.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Reference {
    /// Converged triangles: the true error.
    #[default]
    Bvh,
    /// Converged voxels of the same grid: what sampling and filtering did.
    Voxel,
}

/// One time, measured often.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Timing {
    /// Middle of the runs, ms.
    pub median: f64,
    /// 95 % of the runs took at most this long, ms.
    pub p95: f64,
    /// Distance between the quartiles, ms: half of the runs lie this close together.
    pub spread: f64,
}

/// Milliseconds of each stage on the adapter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StageTimes {
    /// Refining meshes.
    pub tessellate: Option<Timing>,
    /// Voxelizing.
    pub voxel: Option<Timing>,
    /// Building or refitting the search structure over triangles.
    pub bvh: Option<Timing>,
    /// Filling the G-buffers.
    pub gather: Option<Timing>,
    /// Tracing paths.
    pub trace: Option<Timing>,
    /// Removing noise.
    pub denoise: Option<Timing>,
    /// Lifting to display size.
    pub upsample: Option<Timing>,
}

/// How far a picture is from its reference.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Errors {
    /// Root mean square error of linear radiance.
    pub rmse: Option<f64>,
    /// Mean of (x - r)^2 / (r^2 + 0.01).
    pub rel_mse: Option<f64>,
    /// Symmetric mean absolute percentage error, 0..2.
    pub smape: Option<f64>,
    /// Peak signal to noise ratio of the displayed picture, dB.
    pub psnr: Option<f64>,
    /// Structural similarity of the displayed picture, 1 = equal.
    pub ssim: Option<f64>,
    /// FLIP of the displayed picture, 0 = equal.
    pub flip: Option<f64>,
    /// HDR-FLIP, 0 = equal.
    pub hdr_flip: Option<f64>,
    /// Mean over the reference's mean, per channel; 1 = as bright.
    pub bias: Option<[f64; 3]>,
    /// Channels of pixels that are no numbers.
    pub nan_count: Option<u64>,
    /// Error of the change from frame to frame, over a sequence, against references of the row's own tracer whatever
    /// `reference` says.
    pub temporal: Option<f64>,
    /// Relative error of pixels eight frames after they were uncovered, over that of pixels never lost; likewise.
    pub uncovered: Option<f64>,
}

/// One configuration, its times, and its error against one reference.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Built-in name or file.
    pub scene: String,
    /// Id of the tracer.
    pub tracer: String,
    /// Id of the denoiser.
    pub denoiser: String,
    /// Id of the upsampler.
    pub upsampler: String,
    /// Paths per trace pixel.
    pub spp: u32,
    /// Cells on the longest axis; none where no voxels take part.
    pub grid: Option<u32>,
    /// What the errors are against.
    pub reference: Reference,
    /// Knobs set on top of the preset, `id.knob` to value.
    pub knobs: BTreeMap<String, String>,
    /// Plain path tracing that was given the time of another row: that row's [`Row::configuration`].
    pub equal_time: Option<String>,
    /// The errors, at the top level of the JSON object.
    #[serde(flatten)]
    pub errors: Errors,
    /// Per stage.
    pub stages_ms: StageTimes,
    /// The whole frame on the adapter.
    pub total_ms: Option<Timing>,
    /// The whole frame by the wall's clock, presentation off.
    pub cpu_ms: Option<f64>,
    /// What is done once before the first frame on the CPU: building search structures, packing.
    pub build_ms: Option<f64>,
    /// All bytes allocated on the adapter.
    pub bytes: Option<u64>,
    /// The same by part, as `log.json` names them.
    pub memory_bytes: BTreeMap<String, u64>,
    /// The picture's file, relative to the report's folder.
    pub image: Option<String>,
}

impl Timing {
    /// Of repeated measurements in milliseconds; none of no measurement. Between two ranks the value is interpolated.
    pub fn of(samples_ms: &[f64]) -> Option<Self> {
        let mut sorted = samples_ms.to_vec();
        sorted.sort_by(f64::total_cmp);
        let quantile = |share: f64| {
            let rank = share * sorted.len().checked_sub(1)? as f64;
            let [low, high] = [rank.floor(), rank.ceil()].map(|r| sorted.get(r as usize).copied());
            Some(low? + (high? - low?) * rank.fract())
        };
        Some(Self { median: quantile(0.5)?, p95: quantile(0.95)?, spread: quantile(0.75)? - quantile(0.25)? })
    }
}

impl StageTimes {
    /// Name and time, in the order of the street.
    pub fn list(&self) -> [(&'static str, Option<Timing>); 7] {
        [
            ("tessellate", self.tessellate),
            ("voxel", self.voxel),
            ("bvh", self.bvh),
            ("gather", self.gather),
            ("trace", self.trace),
            ("denoise", self.denoise),
            ("upsample", self.upsample),
        ]
    }
}

impl Row {
    /// The configuration in words that tell it from every other of its scene:
    /// `voxel + five_phase + best_candidate, 4 spp, grid 256, five_phase.k0=2`.
    pub fn configuration(&self) -> String {
        format!("{}, {} spp{}", self.stages(), self.spp, self.details())
    }

    /// The configuration but for its samples: rows that share it lie on one curve of error against time.
    pub fn curve(&self) -> String {
        self.stages() + &self.details()
    }

    /// The tracer and its grid, where it has one.
    pub fn tracer_and_grid(&self) -> String {
        match self.grid {
            Some(grid) => format!("{} (grid {grid})", self.tracer),
            None => self.tracer.clone(),
        }
    }

    /// Median of the whole frame, ms.
    pub fn median_ms(&self) -> Option<f64> {
        self.total_ms.map(|t| t.median)
    }

    /// Whether its paths see voxels, so that the gap between the two references is part of its error.
    pub fn traces_voxels(&self) -> bool {
        self.tracer.starts_with("voxel")
    }

    /// What no two rows of a report share; rows are sorted by it.
    pub fn key(&self) -> RowKey<'_> {
        RowKey(self)
    }

    fn stages(&self) -> String {
        format!("{} + {} + {}", self.tracer, self.denoiser, self.upsampler)
    }

    fn details(&self) -> String {
        let grid = self.grid.map(|grid| format!(", grid {grid}")).unwrap_or_default();
        self.knobs.iter().fold(grid, |words, (knob, value)| words + &format!(", {knob}={value}"))
    }
}

/// Identity and order of a row.
#[derive(Clone, Copy, Debug)]
pub struct RowKey<'a>(&'a Row);

impl<'a> RowKey<'a> {
    #[expect(clippy::type_complexity, reason = "a tuple is compared field by field, which is all it is for")]
    fn fields(
        &self,
    ) -> ([&'a str; 4], (Option<u32>, &'a BTreeMap<String, String>, u32), (Option<&'a str>, Reference)) {
        let Row { scene, tracer, denoiser, upsampler, spp, grid, reference, knobs, equal_time, .. } = self.0;
        ([scene, tracer, denoiser, upsampler], (*grid, knobs, *spp), (equal_time.as_deref(), *reference))
    }
}

impl PartialEq for RowKey<'_> {
    fn eq(&self, other: &Self) -> bool {
        self.fields() == other.fields()
    }
}

impl Eq for RowKey<'_> {}

impl PartialOrd for RowKey<'_> {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for RowKey<'_> {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.fields().cmp(&other.fields())
    }
}

impl fmt::Display for RowKey<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, {}, against {}", self.0.scene, self.0.configuration(), self.0.reference)?;
        match &self.0.equal_time {
            Some(other) => write!(f, ", in the time of [{other}]"),
            None => Ok(()),
        }
    }
}

impl fmt::Display for Reference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Bvh => "bvh",
            Self::Voxel => "voxel",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::synthetic::row;

    #[test]
    fn quantiles_of_known_samples() {
        // Ranks 2, 3.8, 1 and 3 of 0..4.
        assert_eq!(
            Timing::of(&[5.0, 1.0, 4.0, 2.0, 3.0]),
            Some(Timing { median: 3.0, p95: 4.8, spread: 2.0 })
        );
        assert_eq!(Timing::of(&[7.0]), Some(Timing { median: 7.0, p95: 7.0, spread: 0.0 }));
        assert_eq!(Timing::of(&[]), None);
    }

    #[test]
    fn configurations_say_all_that_tells_them_apart() {
        let mut row = row("voxel", "five_phase", 4, Reference::Bvh);
        assert_eq!(row.configuration(), "voxel + five_phase + best_candidate, 4 spp, grid 256");
        row.knobs.insert("five_phase.k0".into(), "2".into());
        assert_eq!(row.curve(), "voxel + five_phase + best_candidate, grid 256, five_phase.k0=2");
        row.equal_time = Some("x".into());
        assert_eq!(
            row.key().to_string(),
            "cornell, voxel + five_phase + best_candidate, 4 spp, grid 256, five_phase.k0=2, against bvh, in the time of [x]"
        );
    }
}
