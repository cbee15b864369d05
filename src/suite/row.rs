//! One measured case and combination, and the files that hold all of them.

use super::strange::Strange;
use crate::{Error, output};
use scene::built_in::hard::{self, Truth};
use serde::Serialize;
use std::fmt::Write;
use std::path::Path;

/// What an error was measured against.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum TruthKind {
    /// A known value everywhere.
    ClosedForm,
    /// Converged triangles.
    Bvh,
}

impl TruthKind {
    pub(super) fn of(truth: Truth) -> Self {
        match truth {
            Truth::Everywhere(_) => Self::ClosedForm,
            Truth::Converged => Self::Bvh,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::ClosedForm => "closed_form",
            Self::Bvh => "bvh",
        }
    }
}

/// One combination on one scene. What cannot be measured is none, never a guess.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Of [`scene::built_in::hard`].
    pub scene: String,
    /// Id.
    pub tracer: String,
    /// Id.
    pub denoiser: String,
    /// Id.
    pub upsampler: String,
    /// Paths per trace pixel.
    pub spp: u32,
    /// Cells on the longest axis, where voxels take part.
    pub grid: Option<u32>,
    /// What the errors are against.
    pub truth: TruthKind,
    /// Of the last frame.
    pub rel_mse: Option<f64>,
    /// Share of the truth's mean radiance, of the last frame; negative where light was made.
    pub energy_lost: Option<f64>,
    /// Over all frames and stages.
    #[serde(flatten)]
    pub strange: Strange,
    /// Rays that were given up, over all frames.
    pub cut_rays: f64,
    /// Root mean square change from frame to frame.
    pub temporal: Option<f64>,
}

/// All of them.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// What it was made by.
    pub command: String,
    /// Name of the adapter and its driver.
    pub adapter: String,
    /// Scene by scene.
    pub rows: Vec<Row>,
}

impl Report {
    /// Writes `rows.csv`, `rows.json` and `report.md`, each whole or not at all.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), Error> {
        let json = folder.join("rows.json");
        let text = serde_json::to_string_pretty(self)
            .map_err(|e| Error::Write { path: json.clone(), message: e.to_string() })?;
        output::write(&json, (text + "\n").as_bytes())?;
        output::write(&folder.join("rows.csv"), self.csv().as_bytes())?;
        output::write(&folder.join("report.md"), self.markdown().as_bytes())
    }

    /// Ids, names and numbers: nothing that needs quotes.
    fn csv(&self) -> String {
        let mut text =
            "scene,tracer,denoiser,upsampler,spp,grid,truth,rel_mse,energy_lost,nan_count,inf_count,\
                        negative_count,cut_rays,temporal\n"
                .to_owned();
        for r in &self.rows {
            let cell = |value: Option<f64>| value.map(|v| v.to_string()).unwrap_or_default();
            let grid = r.grid.map(|g| g.to_string()).unwrap_or_default();
            // Writing to a string cannot fail.
            let _ = writeln!(
                text,
                "{},{},{},{},{},{grid},{},{},{},{},{},{},{},{}",
                r.scene,
                r.tracer,
                r.denoiser,
                r.upsampler,
                r.spp,
                r.truth.name(),
                cell(r.rel_mse),
                cell(r.energy_lost),
                r.strange.nan_count,
                r.strange.inf_count,
                r.strange.negative_count,
                r.cut_rays,
                cell(r.temporal)
            );
        }
        text
    }

    /// A table per scene.
    pub fn markdown(&self) -> String {
        let mut text = format!("# The hard suite\n\n{}\n\n    {}\n", self.adapter, self.command);
        for case in hard::all() {
            let rows: Vec<&Row> = self.rows.iter().filter(|r| r.scene == case.name).collect();
            let Some(first) = rows.first() else { continue };
            let against = match first.truth {
                TruthKind::ClosedForm => "a closed form",
                TruthKind::Bvh => "converged triangles",
            };
            let _ = write!(
                text,
                "\n## {}\n\n{}; against {against}.\n\n\
                 | configuration | relMSE | energy lost | NaN | infinite | negative | cut rays | temporal |\n\
                 | --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n",
                case.name, case.about
            );
            for r in rows {
                let number = |value: Option<f64>| value.map_or("-".into(), |v| format!("{v:.3e}"));
                let percent =
                    |value: Option<f64>| value.map_or("-".into(), |v| format!("{:.2} %", 100.0 * v));
                let grid = r.grid.map(|g| format!(", grid {g}")).unwrap_or_default();
                let _ = writeln!(
                    text,
                    "| {} + {} + {}, {} spp{grid} | {} | {} | {} | {} | {} | {} | {} |",
                    r.tracer,
                    r.denoiser,
                    r.upsampler,
                    r.spp,
                    number(r.rel_mse),
                    percent(r.energy_lost),
                    r.strange.nan_count,
                    r.strange.inf_count,
                    r.strange.negative_count,
                    r.cut_rays,
                    number(r.temporal)
                );
            }
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_has_all_columns_and_what_is_not_known_is_empty() {
        let row = Row {
            scene: "room_1m".into(),
            tracer: "voxel".into(),
            denoiser: "identity".into(),
            upsampler: "nearest".into(),
            spp: 4,
            grid: None,
            truth: TruthKind::ClosedForm,
            rel_mse: Some(0.25),
            energy_lost: None,
            strange: Strange { nan_count: 3, ..Strange::default() },
            cut_rays: 0.0,
            temporal: Some(0.5),
        };
        let report = Report { command: "gridlight compare".into(), adapter: "none".into(), rows: vec![row] };
        let csv = report.csv();
        let lines: Vec<_> = csv.lines().collect();
        assert_eq!(lines.len(), 2);
        assert!(lines.iter().all(|line| line.matches(',').count() == 13), "{csv}");
        assert!(lines.iter().any(|line| line.ends_with("closed_form,0.25,,3,0,0,0,0.5")), "{csv}");
        let table = report.markdown();
        assert!(table.contains("| 2.500e-1 | - | 3 |"), "{table}");
    }
}
