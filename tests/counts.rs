//! Does a change make frames do more work than they did? Counted and not timed, so that it means the same on every
//! machine: rays, steps through the structure, passes, bytes.
//!
//! `tests/data/counts.json` holds what was counted when it was last written; `GRIDLIGHT_WRITE_COUNTS=1 cargo test counts`
//! writes it anew. A count that rose by more than [`TOLERANCE`] fails. One that fell by more is printed: write it down, so
//! that it does not creep back.

use crate::support::pipeline;
use gridlight::RenderSettings;
use gridlight::output::log::MemoryBytes;
use gridlight::settings::{Preset, View};
use std::collections::BTreeMap;
use std::path::Path;

/// What rounding on another adapter may change: paths that take another turn.
const TOLERANCE: f64 = 0.02;

type Counts = BTreeMap<String, BTreeMap<String, f64>>;

fn settings(scene: &str, preset: Preset) -> RenderSettings {
    RenderSettings {
        scene: scene.into(),
        view: View::Camera(0),
        trace_size: [64, 48],
        display_size: [192, 108],
        grid: 128,
        spp: 2,
        preset,
        ..Default::default()
    }
}

/// What two frames and the build before them take.
fn count(settings: &RenderSettings) -> BTreeMap<String, f64> {
    let mut pipeline = pipeline(settings);
    let mut counts = BTreeMap::new();
    for frame in ["first", "second"] {
        let log = pipeline.render().unwrap().log;
        let (rays, steps) = (log.counts["rays"], log.counts["iterations"]);
        assert_eq!(log.counts["cut_rays"], 0.0);
        let passes: u32 = log.passes.iter().map(|p| p.runs).sum();
        let of_frame = [("rays", rays), ("steps", steps), ("passes", f64::from(passes))];
        counts.extend(of_frame.map(|(name, value)| (format!("{frame} frame: {name}"), value)));
    }
    let bytes = MemoryBytes::of(pipeline.gpu()).list();
    counts.extend(bytes.into_iter().map(|(name, bytes)| (format!("bytes: {name}"), bytes as f64)));
    counts
}

#[test]
fn frames_do_no_more_work_than_they_did() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/counts.json");
    let mut now = Counts::new();
    for (scene, preset) in [("cornell", Preset::Paper), ("courtyard", Preset::Default)] {
        for tracer in ["voxel", "bvh_cwbvh"] {
            let settings = RenderSettings { tracer: tracer.into(), ..settings(scene, preset) };
            now.insert(format!("{scene}, {preset:?} preset, {tracer}"), count(&settings));
        }
    }
    if std::env::var_os("GRIDLIGHT_WRITE_COUNTS").is_some() {
        std::fs::write(&file, serde_json::to_string_pretty(&now).unwrap() + "\n").unwrap();
        return;
    }
    let then: Counts = serde_json::from_slice(&std::fs::read(&file).unwrap()).unwrap();
    assert!(then.keys().eq(now.keys()), "other frames are counted than are written down");
    let mut risen = Vec::new();
    for (what, counts) in &now {
        assert!(then[what].keys().eq(counts.keys()), "{what}: other counts than are written down");
        for (name, value) in counts {
            let before = then[what][name];
            if *value > before * (1.0 + TOLERANCE) {
                risen.push(format!("{what}: {name}: {before}, now {value}"));
            } else if *value < before * (1.0 - TOLERANCE) {
                println!("fell, write it down: {what}: {name}: {before}, now {value}");
            }
        }
    }
    assert!(risen.is_empty(), "{}", risen.join("\n"));
}
