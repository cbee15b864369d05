//! `report.md`: the answers and one table, for a pull request.

use super::sentences::{self, percent, significant};
use super::{Reference, Report, Row, tables};
use std::collections::BTreeMap;
use std::fmt::Write;

/// The whole file.
pub fn text(report: &Report) -> String {
    let facts = &report.facts;
    let [[tw, th], [dw, dh]] = [facts.trace_size, facts.display_size];
    let mut text = format!(
        "# {}: speed against error\n\n{}; traced at {tw}x{th}, shown at {dw}x{dh}.\n\n",
        plain(&facts.scene),
        plain(&facts.adapter)
    );
    // Writing to a string cannot fail.
    for sentence in sentences::of(&report.answers) {
        let _ = writeln!(text, "- {}", plain(&sentence));
    }
    table(&mut text, report);
    text += "\nTimes are medians of whole frames, ± half the distance between quartiles. relMSE has epsilon 0.01. The \
             price of voxels is the share of the squared error that is the gap between converged voxels and converged \
             triangles.\n";
    for measured in tables::of(report.race.as_ref(), &report.defects) {
        small_table(&mut text, &measured);
    }
    for r in &report.references {
        let grid = r.grid.map(|g| format!(", grid {g}")).unwrap_or_default();
        let noise =
            r.noise_rel_mse.map(|n| format!(", own noise relMSE {}", significant(n))).unwrap_or_default();
        let gap = r.gap_rmse.map(|g| format!(", {} RMSE from triangles", significant(g))).unwrap_or_default();
        let _ = write!(text, "\nReference {}{grid}: {} spp{noise}{gap}.\n", r.kind, r.spp);
    }
    for command in &facts.commands {
        let _ = write!(text, "\n    {}\n", command.replace(['\n', '\r'], " "));
    }
    text
}

/// One line per configuration, fastest first; both references side by side.
fn table(text: &mut String, report: &Report) {
    let mut lines: BTreeMap<(String, Option<&str>), [Option<&Row>; 2]> = BTreeMap::new();
    for row in &report.rows {
        let [bvh, voxel] = lines.entry((row.configuration(), row.equal_time.as_deref())).or_default();
        *(if row.reference == Reference::Bvh { bvh } else { voxel }) = Some(row);
    }
    let mut lines: Vec<_> = lines.into_iter().collect();
    let ms = |rows: &[Option<&Row>; 2]| rows.iter().flatten().find_map(|row| row.median_ms());
    lines.sort_by(|(_, a), (_, b)| ms(a).unwrap_or(f64::INFINITY).total_cmp(&ms(b).unwrap_or(f64::INFINITY)));
    *text += "\n| configuration | ms | relMSE, triangles | relMSE, voxels | HDR-FLIP | SSIM | temporal | price of voxels | MB | front |\n\
              | --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | :---: |\n";
    for ((configuration, equal_time), [bvh, voxel]) in lines {
        let Some(row) = bvh.or(voxel) else { continue };
        let time = row
            .total_ms
            .map_or("-".into(), |t| format!("{} ± {}", significant(t.median), significant(0.5 * t.spread)));
        let number = |value: Option<f64>| value.map_or("-".into(), significant);
        let price = report.answers.prices.iter().find(|p| p.configuration == configuration);
        let front = report.answers.pareto.iter().any(|p| p.configuration == configuration);
        let marked = if equal_time.is_some() { " (equal time)" } else { "" };
        let _ = writeln!(
            text,
            "| {}{marked} | {time} | {} | {} | {} | {} | {} | {} | {} | {} |",
            plain(&configuration),
            number(bvh.and_then(|r| r.errors.rel_mse)),
            number(voxel.and_then(|r| r.errors.rel_mse)),
            number(row.errors.hdr_flip),
            number(row.errors.ssim),
            number(row.errors.temporal),
            price.map_or("-".into(), |p| percent(p.share)),
            number(row.bytes.map(|b| b as f64 / 1e6)),
            if front { "●" } else { "" },
        );
    }
}

/// Names to the left, numbers to the right.
fn small_table(text: &mut String, table: &tables::Table) {
    let _ = write!(text, "\n## {}\n\n{}\n\n", table.title, plain(&table.sentence));
    let _ = writeln!(text, "| {} |", table.head.join(" | "));
    let _ = writeln!(text, "| --- |{}", " ---: |".repeat(table.head.len().saturating_sub(1)));
    for row in &table.rows {
        let cells: Vec<String> = row.iter().map(|cell| plain(cell)).collect();
        let _ = writeln!(text, "| {} |", cells.join(" | "));
    }
}

/// Text with nothing in it that Markdown or the HTML within it would act on.
fn plain(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '\n' | '\r' => safe.push(' '),
            '<' => safe.push_str("&lt;"),
            '&' => safe.push_str("&amp;"),
            '|' | '*' | '[' | ']' | '`' | '\\' | '#' => safe.extend(['\\', c]),
            // Within a word an underscore is one; ids are full of them.
            _ => safe.push(c),
        }
    }
    safe
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::synthetic;

    #[test]
    fn a_hostile_name_stays_text() {
        let text = text(&synthetic::report("a|b\n# [x](javascript:1) <script>"));
        assert!(text.starts_with("# a\\|b \\# \\[x\\](javascript:1) &lt;script>: speed"), "{text}");
    }

    #[test]
    fn what_was_measured_beside_frames_has_a_table_each() {
        let report = synthetic::report("cornell");
        let text =
            text(&Report { race: Some(synthetic::race()), defects: vec![synthetic::defects(256)], ..report });
        assert!(text.contains("\n| secondary, bvh_lbvh | 0.150 |"), "{text}");
        assert!(text.contains("\n| grid 256 | 0.0400 |"), "{text}");
    }

    #[test]
    fn every_line_of_the_table_has_all_columns() {
        let text = text(&synthetic::report("cornell"));
        let lines: Vec<_> = text.lines().filter(|line| line.starts_with('|')).collect();
        assert!(lines.len() > 4, "{text}");
        let columns = |line: &str| line.matches('|').count();
        assert!(lines.iter().all(|line| columns(line) == columns(lines[0])), "{text}");
        assert!(text.contains("times as fast as"), "{text}");
    }
}
