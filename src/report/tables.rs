//! The two small tables beside the answers: structures alone over the same rays, and what voxels get wrong.
//!
//! Both are text already, so that page and Markdown show the same.

use super::sentences::{percent, significant};
use crate::defects::Defects;
use crate::race::{Heat, RayRace};
use serde::Serialize;

/// A table with the sentence that says what it means.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Table {
    /// Heading.
    pub title: &'static str,
    /// What it means.
    pub sentence: String,
    /// Of the columns; the first holds names, the others numbers.
    pub head: Vec<&'static str>,
    /// As many cells as columns.
    pub rows: Vec<Vec<String>>,
}

/// Those that were measured.
pub fn of(race: Option<&RayRace>, defects: &[Defects]) -> Vec<Table> {
    let race = race.map(of_race);
    let defects = (!defects.is_empty()).then(|| of_defects(defects));
    race.into_iter().chain(defects).collect()
}

fn of_race(race: &RayRace) -> Table {
    let lines = |name: &str, heat: &Heat| -> Vec<Vec<String>> {
        let number = |value: Option<f64>| value.map_or("-".into(), significant);
        let line = |entrant: &crate::race::Entrant| {
            vec![
                format!("{name}, {}", entrant.structure),
                number(entrant.mrays_per_s),
                number(entrant.voxels_times_as_fast),
                significant(entrant.visits_per_ray),
                percent(entrant.hit_share),
            ]
        };
        heat.entrants.iter().map(line).collect()
    };
    Table {
        title: "Rays alone",
        sentence: format!(
            "Every structure traced the same {} primary and {} secondary rays and nothing else; the third column says how \
             many times as fast the voxels of grid {} are.",
            race.primary.rays, race.secondary.rays, race.grid
        ),
        head: vec!["rays", "Mrays/s", "voxels faster by", "visits per ray", "hits"],
        rows: [lines("primary", &race.primary), lines("secondary", &race.secondary)].concat(),
    }
}

/// One column of the table of defects.
type Column = (&'static str, fn(&Defects) -> f64);

fn of_defects(defects: &[Defects]) -> Table {
    let columns: [Column; 8] = [
        ("leaked, walls of 1", |d| d.leaked[0]),
        ("of 2", |d| d.leaked[1]),
        ("of 3", |d| d.leaked[2]),
        ("silhouette error", |d| d.silhouette_error),
        ("brightness, half the grid", |d| d.brightness[0]),
        ("brightness", |d| d.brightness[1]),
        ("missed per million rays", |d| d.missed_per_million),
        ("flicker, voxels", |d| d.flicker_voxels),
    ];
    let row = |d: &Defects| {
        let numbers = columns.iter().map(|(_, of)| significant(of(d)));
        std::iter::once(format!("grid {}", d.grid)).chain(numbers).collect()
    };
    Table {
        title: "Defects of the voxels",
        sentence: "Against triangles: 0 is flawless, and 1 for brightness; leaks are radiance inside closed boxes over that \
                   of their lit outside, by the walls' thickness in voxels."
            .into(),
        head: std::iter::once("voxels").chain(columns.iter().map(|(name, _)| *name)).collect(),
        rows: defects.iter().map(row).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::synthetic;

    #[test]
    fn every_line_has_all_columns_and_nothing_measured_is_no_table() {
        assert_eq!(of(None, &[]), []);
        let tables = of(Some(&synthetic::race()), &[synthetic::defects(128), synthetic::defects(256)]);
        assert_eq!(tables.len(), 2);
        for table in &tables {
            assert!(table.rows.iter().all(|row| row.len() == table.head.len()), "{table:?}");
        }
        assert_eq!(tables[0].rows[1], ["primary, bvh_cwbvh", "0.400", "2.50", "17.0", "98 %"]);
        assert_eq!(tables[1].rows[1][0], "grid 256");
    }
}
