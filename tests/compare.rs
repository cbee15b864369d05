//! Do `gridlight reference` and `gridlight compare` keep their contracts: files, rows, cache, shards, messages?

use crate::support::{Scratch, ends, gridlight, text};
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// A comparison so small that it takes seconds, with its references in `cache`.
fn compare(cache: &Path, out: &Path, more: &str) -> std::process::Output {
    gridlight(&format!(
        "compare cornell --camera 0 --trace-size 16x16 --display-size 32x24 --grid 32 --tracers voxel,bvh \
         --denoisers none,five_phase --spp 1 --frames 1 --reference-spp 4 --quiet --cache {} --out {} {more}",
        cache.display(),
        out.display()
    ))
}

fn json(path: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(path).unwrap())
        .unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

fn rows(out: &Path) -> Vec<Value> {
    json(&out.join("rows.json"))["rows"].as_array().unwrap().clone()
}

/// What a row is: tracer, denoiser, grid, reference, and whose time it was given. How many samples fit into that time
/// is another number in every run.
fn names(rows: &[Value]) -> BTreeSet<String> {
    let name = |row: &Value| {
        ["tracer", "denoiser", "upsampler", "grid", "reference", "equal_time"]
            .map(|f| row[f].to_string())
            .join(" ")
    };
    let names: BTreeSet<String> = rows.iter().map(name).collect();
    assert_eq!(names.len(), rows.len(), "no row twice: {names:#?}");
    names
}

/// The states of the cache and when they were written.
fn states(cache: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let folders = std::fs::read_dir(cache).unwrap().map(|e| e.unwrap().path().join("reference.state"));
    let mut states: Vec<_> = folders.map(|path| (path.clone(), std::fs::read(path).unwrap())).collect();
    states.sort();
    states
}

#[test]
fn every_combination_has_its_rows_and_shards_make_the_whole() {
    let scratch = Scratch::new("compare");
    let [cache, out] = ["cache", "whole"].map(|name| scratch.path().join(name));
    let output = compare(&cache, &out, "");
    ends(&output, 0, "");
    assert!(output.stdout.is_empty(), "quiet: {}", text(&output.stdout));
    for file in
        ["rows.csv", "rows.json", "report.md", "report.html", "reference_bvh.exr", "reference_voxel_32.exr"]
    {
        assert!(out.join(file).metadata().unwrap().len() > 0, "{file}");
    }

    let all = rows(&out);
    let csv = std::fs::read_to_string(out.join("rows.csv")).unwrap();
    assert_eq!(csv.lines().count(), 1 + all.len(), "a header and a line per row");
    for (tracer, grid) in [("voxel", Value::from(32)), ("bvh_cwbvh", Value::Null)] {
        for denoiser in ["identity", "five_phase"] {
            for reference in ["bvh", "voxel"] {
                let own = |row: &&Value| {
                    row["tracer"] == tracer && row["denoiser"] == denoiser && row["reference"] == reference
                };
                let of = all.iter().filter(own).filter(|row| row["equal_time"].is_null()).collect::<Vec<_>>();
                // Triangles have no voxels to be measured against.
                let expected = usize::from(tracer == "voxel" || reference == "bvh");
                assert_eq!(of.len(), expected, "{tracer} + {denoiser} against {reference}");
                for row in of {
                    assert_eq!((&row["grid"], &row["spp"]), (&grid, &1.into()), "{row}");
                    assert!(row["rel_mse"].as_f64() > Some(0.0) && row["nan_count"] == 0, "{row}");
                    assert!(
                        row["stages_ms"]["trace"].is_object() && row["bytes"].as_u64() > Some(0),
                        "{row}"
                    );
                    assert!(out.join(row["image"].as_str().unwrap()).is_file(), "{row}");
                }
            }
        }
        // Beside the filtered row, plain paths in its time; beside the plain row, nothing.
        let given: Vec<_> =
            all.iter().filter(|row| row["tracer"] == tracer && row["equal_time"].is_string()).collect();
        assert_eq!(given.len(), if tracer == "voxel" { 2 } else { 1 }, "{tracer} in equal time");
        for row in given {
            assert!(
                row["equal_time"].as_str().unwrap().starts_with(&format!("{tracer} + five_phase + ")),
                "{row}"
            );
            assert!(row["denoiser"] == "identity" && row["spp"].as_u64() >= Some(1), "{row}");
        }
    }

    let before = states(&cache);
    assert_eq!(before.len(), 2, "triangles and voxels");
    // A second run, dealt out to two shards, converges nothing anew.
    let shards = ["one", "two"].map(|name| scratch.path().join(name));
    for (shard, number) in shards.iter().zip(["1/2", "2/2"]) {
        ends(&compare(&cache, shard, &format!("--shard {number}")), 0, "");
    }
    assert!(states(&cache) == before, "references that were there were converged again");
    for file in ["reference_bvh.exr", "reference_voxel_32.exr"] {
        let [ours, theirs] = [&shards[0], &out].map(|folder| std::fs::read(folder.join(file)).unwrap());
        assert!(ours == theirs, "{file} from the cache is another");
    }
    let merged = scratch.path().join("merged");
    let line = format!("report merge {} {} {}", merged.display(), shards[0].display(), shards[1].display());
    ends(&gridlight(&line), 0, "");
    assert!(rows(&shards[0]).len() < all.len(), "a shard is not the whole");
    assert_eq!(names(&rows(&merged)), names(&all));
}

#[test]
fn a_moving_view_has_a_temporal_error_that_falls_with_the_samples() {
    let scratch = Scratch::new("temporal");
    std::fs::create_dir_all(scratch.path()).unwrap();
    let [cache, out, path] = ["cache", "out", "path.json"].map(|name| scratch.path().join(name));
    let keys = r#"{"keys":[{"time":0,"eye":[0,2.7,8],"target":[0,2.7,0]},{"time":0.1,"eye":[0.3,2.7,7.6],"target":[0,2.7,0]}]}"#;
    std::fs::write(&path, keys).unwrap();
    let line = format!(
        "compare cornell --path {} --trace-size 16x16 --display-size 16x16 --tracers bvh --denoisers none \
         --upsamplers nearest --spp 1,16 --reference-spp 4 --temporal-spp 16 --quiet --cache {} --out {}",
        path.display(),
        cache.display(),
        out.display()
    );
    ends(&gridlight(&line), 0, "");
    let temporal = |rows: &[Value], spp: u64| {
        let row = rows.iter().find(|row| row["spp"] == spp).unwrap();
        row["temporal"].as_f64().unwrap_or_else(|| panic!("{row}"))
    };
    let first = rows(&out);
    let [few, many] = [1, 16].map(|spp| temporal(&first, spp));
    // Noise falls by 4; a factor of 2 leaves room for what 256 pixels and 4 frames do not average out.
    assert!(many > 0.0 && few > 2.0 * many, "{few} at one sample, {many} at sixteen");
    // The path's 4 frames, twice, are found again.
    let frames = || -> usize {
        let folders = std::fs::read_dir(&cache).unwrap().map(|e| e.unwrap().path());
        folders
            .filter(|f| f.join("frame.0001.exr").is_file())
            .map(|f| std::fs::read_dir(f).unwrap().count())
            .sum()
    };
    assert_eq!(frames(), 8);
    ends(&gridlight(&line), 0, "");
    assert_eq!(frames(), 8);
    assert_eq!(temporal(&rows(&out), 1), few);

    let still = line.replace(&format!("--path {}", path.display()), "--camera 0 --frames 3");
    ends(&gridlight(&still), 0, "");
    assert!(temporal(&rows(&out), 1) > 0.0, "what stands still flickers, too");
    assert_eq!(frames(), 8, "and needs no references of its frames");
}

#[test]
fn a_comparison_that_cannot_be_made_says_so_and_leaves_nothing() {
    let scratch = Scratch::new("refused");
    let [cache, out] = ["cache", "out"].map(|name| scratch.path().join(name));
    ends(&compare(&cache, &out, "--tracers nosuch"), 2, "there are: voxel");
    ends(&compare(&cache, &out, "--set svgf.x=1"), 2, "--set svgf.x");
    ends(&compare(&cache, &out, "--set five_phase.nose=1"), 2, "nose");
    ends(&compare(&cache, &out, "--shard 3/2"), 2, "no shard");
    ends(&compare(&cache, &out, "--shard 5/5"), 1, "fewer than 5 combinations");
    assert!(!scratch.path().exists(), "nothing is left behind: {:?}", scratch.files());

    // A file where the folder should be.
    std::fs::create_dir_all(scratch.path()).unwrap();
    std::fs::write(&out, "mine").unwrap();
    let output = compare(&cache, &out, "");
    ends(&output, 1, &out.display().to_string());
    let stderr = text(&output.stderr);
    assert_eq!(stderr.lines().count(), 1, "one message: {stderr}");
    assert_eq!(scratch.files(), ["out"]);
    assert_eq!(std::fs::read(&out).unwrap(), b"mine");
}

#[test]
fn a_reference_stops_when_it_is_sure_and_logs_how_sure() {
    let scratch = Scratch::new("until");
    let line = "reference cornell --camera 0 --display-size 16x16 --spp 4096 --until 0.5 --json --out";
    let output = gridlight(&format!("{line} {}", scratch.path().display()));
    ends(&output, 0, "");
    assert_eq!(scratch.files(), ["log.json", "reference.exr", "reference.state", "stderr.exr"]);
    let printed: Value = serde_json::from_slice(&output.stdout).unwrap();
    let number = |field: &str| printed[field].as_f64().unwrap_or_else(|| panic!("{field} in {printed}"));
    assert!(number("spp") < 4096.0 && number("rel_error") <= 0.5, "it stops early: {printed}");
    assert!((number("rel_error").powi(2) / number("noise_rel_mse") - 1.0).abs() < 1e-9, "{printed}");
    assert_eq!((number("resumed_spp"), number("strange")), (0.0, 0.0));

    let log = json(&scratch.path().join("log.json"));
    assert_eq!(log["reference"], printed, "the log and stdout say the same");
    assert!(log["adapter"]["name"].is_string() && log["memory_bytes"]["bvh"].as_u64() > Some(0), "{log}");
    assert_eq!(
        (&log["settings"]["display_size"], &log["settings"]["scene"]),
        (&[16, 16].into(), &"cornell".into())
    );

    // It goes on where it stopped, and says so.
    let spp = number("spp");
    let line = format!(
        "reference cornell --camera 0 --display-size 16x16 --spp {} --out {}",
        spp + 4.0,
        scratch.path().display()
    );
    let output = gridlight(&line);
    ends(&output, 0, "");
    let words = text(&output.stdout);
    assert!(words.contains(&format!("{} samples ({spp} of them from an earlier run)", spp + 4.0)), "{words}");
    ends(&gridlight(&format!("{line} --seed 3")), 1, "seed: 1 there, 3 now");
    ends(&gridlight(&format!("{line} --until 0")), 2, "above 0");
}
