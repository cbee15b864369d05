//! Tables for people: milliseconds per pass, bytes per part.

use crate::output::log::{Frame, STAGES};
use std::fmt::Write;

/// Milliseconds per pass and per stage: medians over the frames, because single ones jump.
pub fn milliseconds(frames: &[Frame]) -> String {
    let Some(first) = frames.first() else { return String::new() };
    let total = median(frames.iter().map(|f| f.total_ms));
    let mut rows: Vec<(String, Option<f64>)> = Vec::new();
    for stage in STAGES {
        let passes: Vec<_> = first
            .passes
            .iter()
            .filter(|p| p.name.split('/').next() == Some(stage))
            .map(|p| &p.name)
            .collect();
        if passes.is_empty() {
            continue;
        }
        rows.push((stage.into(), median(frames.iter().map(|f| f.stages_ms.get(stage).copied().flatten()))));
        for name in passes {
            let of = |f: &Frame| f.passes.iter().find(|p| p.name == *name).and_then(|p| p.gpu_ms);
            rows.push((format!("  {name}"), median(frames.iter().map(of))));
        }
    }
    rows.push(("total".into(), total));
    let width = rows.iter().map(|(name, _)| name.len()).max().unwrap_or(0);
    let mut text = format!("{:width$}  {:>10}  {:>6}\n", "pass", "gpu ms", "share");
    for (name, ms) in rows {
        let share = ms.zip(total).filter(|(_, total)| *total > 0.0).map(|(ms, total)| 100.0 * ms / total);
        let [ms, share] = [(ms, 2, ""), (share, 1, "%")].map(|(value, digits, unit)| match value {
            Some(value) => format!("{value:.digits$}{unit}"),
            None => "-".into(),
        });
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{name:width$}  {ms:>10}  {share:>6}");
    }
    text
}

/// The middle value; none where any is missing.
fn median(values: impl Iterator<Item = Option<f64>>) -> Option<f64> {
    let mut values = values.collect::<Option<Vec<_>>>()?;
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    match values.len() % 2 {
        0 => values.get(middle.checked_sub(1)?).zip(values.get(middle)).map(|(a, b)| 0.5 * (a + b)),
        _ => values.get(middle).copied(),
    }
}

/// Bytes in megabytes, 10^6 of them.
pub fn megabytes(bytes: u64) -> String {
    format!("{:.2} MB", bytes as f64 / 1e6)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use frame::{FrameLog, PassLog};

    fn frame(trace: Option<f64>) -> Frame {
        let passes = vec![
            PassLog { name: "trace/voxel".into(), gpu_ms: trace, runs: 4 },
            PassLog { name: "gather/trace".into(), gpu_ms: Some(1.0), runs: 1 },
        ];
        Frame::of(&FrameLog { passes, ..Default::default() })
    }

    #[test]
    fn medians() {
        let of = |values: &[f64]| median(values.iter().map(|v| Some(*v)));
        assert_eq!(of(&[3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(of(&[4.0, 1.0]), Some(2.5));
        assert_eq!(of(&[]), None);
        assert_eq!(median([Some(1.0), None].into_iter()), None);
    }

    #[test]
    fn passes_stand_under_their_stage_in_street_order() {
        let text = milliseconds(&[frame(Some(3.0)), frame(Some(5.0)), frame(Some(100.0))]);
        let lines: Vec<_> = text.lines().map(|l| l.split_whitespace().collect::<Vec<_>>()).collect();
        assert_eq!(lines[1], ["gather", "1.00", "16.7%"]);
        assert_eq!(lines[2], ["gather/trace", "1.00", "16.7%"]);
        assert_eq!(lines[4], ["trace/voxel", "5.00", "83.3%"]);
        assert_eq!(lines[5], ["total", "6.00", "100.0%"]);
    }

    #[test]
    fn what_was_not_timed_has_a_dash() {
        let text = milliseconds(&[frame(None)]);
        assert!(text.lines().last().unwrap().split_whitespace().eq(["total", "-", "-"]), "{text}");
    }
}
