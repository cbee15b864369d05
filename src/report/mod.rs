//! What `gridlight compare` writes: rows of time and error become a table, answers, and a page to look at.
//!
//! Input: [`Row`]s, pictures that already lie in the folder as PNG, and facts about the run. Output in the same folder,
//! each file whole or not at all: `rows.csv` (spreadsheets), `rows.json` (the whole [`Report`]; `gridlight report merge`
//! reads it back), `report.md` (a pull request), `report.html` (one self-contained file with everything). Nothing here
//! touches a GPU or a clock: the same rows give the same bytes, in whatever order they were measured.

mod answers;
mod csv;
mod heat;
mod markdown;
mod merge;
mod page;
mod row;
mod sentences;
mod shard;
#[cfg(test)]
mod synthetic;
mod tables;

pub use answers::{Answers, Entrant, EqualError, EqualTime, Point, Race, TimeToError, VoxelPrice};
pub use heat::{HEAT_DECADES, heat_map};
pub use merge::{MergeError, merge, read};
pub use row::{Errors, Reference, Row, RowKey, StageTimes, Timing};
pub use shard::Shard;

use crate::defects::Defects;
use crate::race::RayRace;
use crate::{Error, output};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// A comparison of one scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// What it was made by and from.
    #[serde(flatten)]
    pub facts: Facts,
    /// Converged pictures that errors are against.
    pub references: Vec<ReferenceInfo>,
    /// Sorted by [`Row::key`].
    pub rows: Vec<Row>,
    /// References first, then by id.
    pub pictures: Vec<Picture>,
    /// What the rows say.
    pub answers: Answers,
    /// Tracing alone, if it was measured.
    #[serde(default)]
    pub race: Option<RayRace>,
    /// What voxels get wrong, one per grid that was measured.
    #[serde(default)]
    pub defects: Vec<Defects>,
}

/// What a comparison was made by and from.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Facts {
    /// Command lines without `--out` and `--shard`: one, or several after a merge.
    pub commands: Vec<String>,
    /// Name of the adapter and its driver.
    pub adapter: String,
    /// Built-in name or file.
    pub scene: String,
    /// Pixels before upsampling.
    pub trace_size: [u32; 2],
    /// Pixels after upsampling.
    pub display_size: [u32; 2],
}

/// A converged picture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReferenceInfo {
    /// Triangles or voxels.
    pub kind: Reference,
    /// Cells on the longest axis; none of triangles.
    pub grid: Option<u32>,
    /// Paths per pixel.
    pub spp: u32,
    /// Its own expected relMSE, from the spread of its samples: errors near it mean nothing.
    pub noise_rel_mse: Option<f64>,
    /// Root mean square difference to the converged triangles: the price of voxels, measured.
    pub gap_rmse: Option<f64>,
    /// Its file, relative to the report's folder.
    pub file: String,
}

/// A PNG that the page shows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Picture {
    /// Unique: [`Row::configuration`], or the reference's name.
    pub id: String,
    /// Whether it is a reference.
    pub reference: bool,
    /// PNG, relative to the report's folder; rows name it as their `image`.
    pub file: String,
    /// PNG of its error against triangles, as [`heat_map`] colours it.
    pub heat: Option<String>,
}

impl Report {
    /// Sorts, and answers what the rows can answer. Race and defects are the caller's to add.
    pub fn new(
        facts: Facts,
        mut references: Vec<ReferenceInfo>,
        mut rows: Vec<Row>,
        mut pictures: Vec<Picture>,
    ) -> Self {
        references.sort_by_key(|r| (r.kind, r.grid));
        rows.sort_by(|a, b| a.key().cmp(&b.key()));
        pictures.sort_by(|a, b| (!a.reference, &a.id).cmp(&(!b.reference, &b.id)));
        let answers = Answers::of(&rows, &references);
        Self { facts, references, rows, pictures, answers, race: None, defects: Vec::new() }
    }

    /// Writes `rows.csv`, `rows.json`, `report.md` and `report.html`; the pictures must lie in `folder` already.
    ///
    /// # Errors
    /// A picture that is not there, or a file that cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), Error> {
        output::folder(folder)?;
        let path = folder.join("rows.csv");
        output::write(&path, &csv::text(&path, &self.rows)?)?;
        let path = folder.join("rows.json");
        output::write(&path, &self.json(&path)?)?;
        output::write(&folder.join("report.md"), self.markdown().as_bytes())?;
        output::write(&folder.join("report.html"), page::text(self, folder)?.as_bytes())
    }

    /// What `report.md` holds.
    pub fn markdown(&self) -> String {
        markdown::text(self)
    }

    fn json(&self, path: &Path) -> Result<Vec<u8>, Error> {
        let mut text = serde_json::to_vec_pretty(self)
            .map_err(|e| Error::Write { path: path.into(), message: e.to_string() })?;
        text.push(b'\n');
        Ok(text)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn a_report_comes_back_from_its_json() {
        let report = synthetic::report("</script><!-- \"quoted\" \u{2028} scene");
        let text = report.json(Path::new("rows.json")).unwrap();
        assert_eq!(serde_json::from_slice::<Report>(&text).unwrap(), report);
    }

    #[test]
    fn the_errors_stand_at_the_top_level_of_a_row_and_what_was_not_measured_is_null() {
        let report = synthetic::report("cornell");
        let value = serde_json::to_value(&report).unwrap();
        let row = &value["rows"][0];
        assert!(
            row["rel_mse"].is_f64() && row["total_ms"]["median"].is_f64() && row["temporal"].is_null(),
            "{row}"
        );
        assert_eq!(value["scene"], "cornell");
    }

    #[test]
    fn the_order_of_measuring_leaves_no_trace() {
        let report = synthetic::report("cornell");
        let Report { facts, mut references, mut rows, mut pictures, .. } = report.clone();
        references.reverse();
        rows.reverse();
        pictures.reverse();
        assert_eq!(Report::new(facts, references, rows, pictures), report);
    }
}
