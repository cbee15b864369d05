//! `rows.csv`: one line per row, one column per number, for spreadsheets and scripts.
//!
//! Columns ending in `_ms` are medians; each has neighbours `_p95_ms` and `_spread_ms`. Maps are `name=value` joined by
//! `;`, as `--set` takes them. Numbers are the shortest decimals that read back to the same bits. Text that
//! begins like a formula (`=`, `+`, `-`, `@`) gets an apostrophe before it, for spreadsheets would run it.

use super::{Row, Timing};
use crate::Error;
use std::fmt::Display;
use std::path::Path;

/// All rows under a header.
///
/// # Errors
/// None that the writer's words would not tell.
pub fn text(path: &Path, rows: &[Row]) -> Result<Vec<u8>, Error> {
    let fail = |e: &dyn Display| Error::Write { path: path.into(), message: e.to_string() };
    let mut writer = csv::Writer::from_writer(Vec::new());
    let names = cells(&Row::default()).into_iter().map(|(name, _)| name);
    writer.write_record(names).map_err(|e| fail(&e))?;
    for row in rows {
        writer.write_record(cells(row).into_iter().map(|(_, cell)| cell)).map_err(|e| fail(&e))?;
    }
    writer.into_inner().map_err(|e| fail(&e))
}

/// Name and text of each cell, in the order of the columns; the names are the same for every row.
fn cells(row: &Row) -> Vec<(String, String)> {
    let errors = &row.errors;
    let bias = |channel: usize| number(errors.bias.and_then(|bias| bias.get(channel).copied()));
    let mut cells: Vec<(String, String)> = [
        ("scene", word(&row.scene)),
        ("tracer", word(&row.tracer)),
        ("denoiser", word(&row.denoiser)),
        ("upsampler", word(&row.upsampler)),
        ("spp", row.spp.to_string()),
        ("grid", any(row.grid)),
        ("reference", row.reference.to_string()),
        ("rmse", number(errors.rmse)),
        ("rel_mse", number(errors.rel_mse)),
        ("smape", number(errors.smape)),
        ("psnr", number(errors.psnr)),
        ("ssim", number(errors.ssim)),
        ("flip", number(errors.flip)),
        ("hdr_flip", number(errors.hdr_flip)),
        ("bias_r", bias(0)),
        ("bias_g", bias(1)),
        ("bias_b", bias(2)),
        ("nan_count", any(errors.nan_count)),
        ("temporal", number(errors.temporal)),
        ("uncovered", number(errors.uncovered)),
    ]
    .map(|(name, cell)| (name.to_owned(), cell))
    .into();
    let total = [("total", row.total_ms)];
    for (stage, timing) in row.stages_ms.list().into_iter().chain(total) {
        let of = |part: fn(Timing) -> f64| number(timing.map(part));
        cells.push((format!("{stage}_ms"), of(|t| t.median)));
        cells.push((format!("{stage}_p95_ms"), of(|t| t.p95)));
        cells.push((format!("{stage}_spread_ms"), of(|t| t.spread)));
    }
    let last = [
        ("cpu_ms", number(row.cpu_ms)),
        ("build_ms", number(row.build_ms)),
        ("bytes", any(row.bytes)),
        ("memory_bytes", map(row.memory_bytes.iter())),
        ("knobs", word(&map(row.knobs.iter()))),
        ("equal_time", word(row.equal_time.as_deref().unwrap_or_default())),
        ("image", word(row.image.as_deref().unwrap_or_default())),
    ];
    cells.extend(last.map(|(name, cell)| (name.to_owned(), cell)));
    cells
}

fn number(value: Option<f64>) -> String {
    any(value.filter(|v| v.is_finite()))
}

fn any(value: Option<impl Display>) -> String {
    value.map(|v| v.to_string()).unwrap_or_default()
}

fn map<'a>(entries: impl Iterator<Item = (&'a String, impl Display + 'a)>) -> String {
    entries.map(|(name, value)| format!("{name}={value}")).collect::<Vec<_>>().join(";")
}

/// Text that a spreadsheet leaves alone.
fn word(text: &str) -> String {
    match text.starts_with(['=', '@', '+', '-', '\t', '\r']) {
        true => format!("'{text}"),
        false => text.to_owned(),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::panic)]
mod tests {
    use super::*;
    use crate::report::synthetic::{self, row};
    use crate::report::{Errors, Reference, StageTimes};
    use std::collections::HashMap;

    type Cells = HashMap<String, String>;

    fn read(text: &[u8]) -> Vec<Cells> {
        csv::Reader::from_reader(text).deserialize().map(Result::unwrap).collect()
    }

    /// An empty cell is none.
    fn parse<T: std::str::FromStr>(cells: &Cells, name: &str) -> Option<T> {
        let cell = &cells[name];
        (!cell.is_empty()).then(|| cell.parse().unwrap_or_else(|_| panic!("{name}: {cell}")))
    }

    fn pairs<T: std::str::FromStr>(cell: &str) -> std::collections::BTreeMap<String, T> {
        let pair = |pair: &str| {
            let (name, value) = pair.split_once('=')?;
            Some((name.to_owned(), value.parse().ok()?))
        };
        cell.split(';').filter(|part| !part.is_empty()).map(|part| pair(part).unwrap()).collect()
    }

    fn row_of(c: &Cells) -> Row {
        let timing = |stage: &str| {
            let part = |name: &str| parse(c, &format!("{stage}_{name}"));
            Some(Timing { median: part("ms")?, p95: part("p95_ms")?, spread: part("spread_ms")? })
        };
        let bias = ["bias_r", "bias_g", "bias_b"].map(|name| parse(c, name));
        let word = |name: &str| c[name].strip_prefix('\'').unwrap_or(&c[name]).to_owned();
        let some_word = |name: &str| Some(word(name)).filter(|text| !text.is_empty());
        Row {
            scene: word("scene"),
            tracer: word("tracer"),
            denoiser: word("denoiser"),
            upsampler: word("upsampler"),
            spp: parse(c, "spp").unwrap(),
            grid: parse(c, "grid"),
            reference: if c["reference"] == "bvh" { Reference::Bvh } else { Reference::Voxel },
            knobs: pairs(&c["knobs"]),
            equal_time: some_word("equal_time"),
            errors: Errors {
                rmse: parse(c, "rmse"),
                rel_mse: parse(c, "rel_mse"),
                smape: parse(c, "smape"),
                psnr: parse(c, "psnr"),
                ssim: parse(c, "ssim"),
                flip: parse(c, "flip"),
                hdr_flip: parse(c, "hdr_flip"),
                bias: bias[0].map(|r| [r, bias[1].unwrap(), bias[2].unwrap()]),
                nan_count: parse(c, "nan_count"),
                temporal: parse(c, "temporal"),
                uncovered: parse(c, "uncovered"),
            },
            stages_ms: StageTimes {
                tessellate: timing("tessellate"),
                voxel: timing("voxel"),
                bvh: timing("bvh"),
                gather: timing("gather"),
                trace: timing("trace"),
                denoise: timing("denoise"),
                upsample: timing("upsample"),
            },
            total_ms: timing("total"),
            cpu_ms: parse(c, "cpu_ms"),
            build_ms: parse(c, "build_ms"),
            bytes: parse(c, "bytes"),
            memory_bytes: pairs(&c["memory_bytes"]),
            image: some_word("image"),
        }
    }

    #[test]
    fn rows_come_back_as_they_were() {
        let mut rows = synthetic::report("cornell").rows;
        rows.push(Row { scene: "=cmd(),\"quoted\"\nsecond line".into(), ..Row::default() });
        rows.push(Row { knobs: [("a.b".to_owned(), "-0.1".to_owned())].into(), ..Row::default() });
        rows.push(Row {
            errors: Errors { rel_mse: Some(1.0 / 3.0 * 1e-9), ..Errors::default() },
            ..Row::default()
        });
        let read: Vec<Row> = read(&text(Path::new("rows.csv"), &rows).unwrap()).iter().map(row_of).collect();
        assert_eq!(read, rows);
    }

    #[test]
    fn infinity_and_what_was_not_measured_are_empty_and_formulas_are_disarmed() {
        let mut row = row("voxel", "identity", 1, Reference::Bvh);
        row.scene = "=1+1".into();
        row.errors = Errors { psnr: Some(f64::INFINITY), ..Errors::default() };
        row.total_ms = None;
        let cells = &read(&text(Path::new("rows.csv"), &[row]).unwrap())[0];
        assert_eq!(
            [&*cells["psnr"], &*cells["rmse"], &*cells["total_ms"], &*cells["scene"]],
            ["", "", "", "'=1+1"]
        );
    }
}
