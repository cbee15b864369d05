//! Does the command line keep its contract: exit codes, messages, files, the log's fields?

use crate::support::{Scratch, ends, gridlight, text};
use serde_json::Value;
use std::path::{Path, PathBuf};

#[test]
fn wrong_usage_is_2() {
    let scratch = Scratch::new("usage");
    let out = format!("--out {}", scratch.path().display());
    ends(&gridlight(""), 2, "Usage");
    ends(&gridlight("paint"), 2, "unrecognized subcommand");
    ends(&gridlight("render cornell"), 2, "--out");
    ends(&gridlight(&format!("render {out}")), 2, "a scene or --case");
    ends(&gridlight(&format!("render cornell {out} --trace-size 640x0")), 2, "WIDTHxHEIGHT");
    ends(&gridlight(&format!("render cornell {out} --denoiser magic")), 2, "identity, five_phase");
    ends(
        &gridlight(&format!("render cornell {out} --eye nan,0,0 --target 0,0,0")),
        2,
        "three finite numbers",
    );
    assert!(!scratch.path().exists(), "wrong usage leaves nothing behind");
}

#[test]
fn help_and_version_are_0() {
    for line in ["--help", "--version", "render --help", "help info"] {
        assert_eq!(gridlight(line).status.code(), Some(0), "{line}");
    }
}

#[test]
fn a_scene_that_does_not_load_is_1_and_named() {
    let scratch = Scratch::new("broken");
    std::fs::create_dir_all(scratch.path()).unwrap();
    let broken = scratch.path().join("broken.gltf");
    std::fs::write(&broken, "{\"asset\":").unwrap();
    let out = scratch.path().join("out");
    for (scene, part) in [("atlantis", "atlantis"), ("no/such.glb", "no/such.glb")] {
        ends(&gridlight(&format!("render {scene} --out {}", out.display())), 1, part);
    }
    let output = gridlight(&format!("render {} --out {}", broken.display(), out.display()));
    ends(&output, 1, "broken.gltf");
    let stderr = text(&output.stderr);
    assert_eq!(stderr.lines().filter(|line| line.starts_with("error:")).count(), 1, "one message: {stderr}");
}

#[test]
fn settings_that_only_the_pipeline_can_judge_are_usage_too() {
    let scratch = Scratch::new("judged");
    let small = format!(
        "render cornell --trace-size 8x8 --display-size 8x8 --grid 16 --spp 1 --out {}",
        scratch.path().display()
    );
    ends(&gridlight(&format!("{small} --camera 9")), 2, "no camera 9");
    ends(&gridlight(&format!("{small} --emit ghost=1,1,1")), 2, "ghost");
    ends(&gridlight(&format!("{small} --set five_phase.nose=1")), 2, "nose");
    ends(&gridlight(&format!("{small} --set warp.speed=9")), 2, "warp");
    assert!(!scratch.path().exists(), "wrong usage leaves nothing behind");
}

#[test]
fn an_adapter_that_is_not_there_is_1() {
    ends(&gridlight("info --adapter no-such-adapter"), 1, "no graphics adapter named \"no-such-adapter\"");
}

#[test]
fn a_render_writes_every_file_and_every_field_of_the_log() {
    let scratch = Scratch::new("render");
    let line =
        "render cornell --camera 0 --trace-size 16x12 --display-size 32x24 --grid 32 --spp 2 --quiet --out";
    let output = gridlight(&format!("{line} {}", scratch.path().display()));
    ends(&output, 0, "");
    assert_eq!(scratch.files(), ["display.exr", "display.png", "light.exr", "log.json"]);
    assert!(output.stdout.is_empty(), "quiet: {}", text(&output.stdout));

    let log: Value =
        serde_json::from_slice(&std::fs::read(scratch.path().join("log.json")).unwrap()).unwrap();
    for (part, fields) in [
        ("/adapter", &["name", "driver", "backend"] as &[_]),
        ("/settings", &["scene", "tracer", "denoiser", "upsampler", "tessellator", "spp", "grid", "seed"]),
        ("/frames/0", &["passes", "stages_ms", "total_ms", "counts"]),
        ("/frames/0/passes/0", &["name", "gpu_ms"]),
        ("/frames/0/stages_ms", &["tessellate", "voxel", "gather", "trace", "denoise", "upsample"]),
        ("/frames/0/counts", &["rays", "voxels", "bricks", "cut_rays", "clamped", "mean_spp"]),
        ("/memory_bytes", &["voxels", "voxels_peak", "gbuffer", "history", "bvh"]),
    ] {
        let object = log.pointer(part).unwrap_or_else(|| panic!("no {part}"));
        for field in fields {
            assert!(object.get(field).is_some(), "no {part}/{field}");
        }
    }
    let number =
        |path: &str| log.pointer(path).and_then(Value::as_f64).unwrap_or_else(|| panic!("no {path}"));
    assert_eq!(number("/frames/0/counts/cut_rays"), 0.0);
    assert!(number("/frames/0/counts/rays") > 0.0 && number("/frames/0/counts/voxels") > 0.0);
    // 32 bytes per pixel, at both sizes; the depth buffers come on top.
    assert!(number("/memory_bytes/gbuffer") >= 32.0 * (16.0 * 12.0 + 32.0 * 24.0));
    assert!(number("/memory_bytes/voxels_peak") >= number("/memory_bytes/voxels"));
}

#[test]
fn frames_in_a_row_are_numbered_and_logged_each() {
    let scratch = Scratch::new("frames");
    let line = "render cornell --trace-size 8x8 --display-size 8x8 --grid 16 --spp 1 --frames 2 --json --out";
    let output = gridlight(&format!("{line} {}", scratch.path().display()));
    ends(&output, 0, "");
    let mut expected = vec!["log.json".to_owned()];
    for number in ["0001", "0002"] {
        expected.extend(["display", "light"].map(|stem| format!("{stem}.{number}.exr")));
        expected.push(format!("display.{number}.png"));
    }
    expected.sort();
    assert_eq!(scratch.files(), expected);
    let log: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(log["frames"].as_array().map(Vec::len), Some(2));
}

#[test]
fn list_names_everything_and_its_json_has_every_knob() {
    let plain = gridlight("list");
    ends(&plain, 0, "");
    let plain = text(&plain.stdout);
    for word in ["courtyard", "furnace", "voxel", "five_phase", "best_candidate"] {
        assert!(plain.contains(word), "{word} is not in: {plain}");
    }
    let listed: Value = serde_json::from_slice(&gridlight("list --json").stdout).unwrap();
    let knobs = listed["knobs"].as_array().unwrap();
    let five_phase = knobs.iter().find(|k| k["id"] == "five_phase").unwrap();
    for knob in five_phase["knobs"].as_array().unwrap() {
        for field in ["name", "unit", "allowed", "default", "doc"] {
            assert!(knob[field].is_string(), "{field} of {knob}");
        }
    }
}

#[test]
fn info_describes_adapter_and_scene() {
    let adapter: Value = serde_json::from_slice(&gridlight("info --json").stdout).unwrap();
    assert!(adapter["adapter"]["name"].is_string() && adapter["limits"]["max_bind_groups"] == 4);
    assert!(adapter["scene"].is_null());
    let line = "info cornell --trace-size 8x8 --display-size 8x8 --grid 32 --json";
    let cornell: Value = serde_json::from_slice(&gridlight(line).stdout).unwrap();
    let scene = &cornell["scene"];
    assert_eq!(scene["needs"]["emission"], true);
    assert_eq!(scene["needs"]["specular"], false);
    for bytes in ["scene", "voxels", "gbuffer", "radiance"] {
        assert!(scene["memory_bytes"][bytes].as_u64() > Some(0), "{bytes} in {scene}");
    }
}

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

#[test]
fn metrics_prints_every_id_as_json() {
    let [reference, test] =
        ["cornell_64_b4.exr", "cornell_64_b1.exr"].map(|name| data(name).display().to_string());
    let output = gridlight(&format!("metrics {reference} {test}"));
    ends(&output, 0, "");
    let metrics: Value = serde_json::from_slice(&output.stdout).unwrap();
    for id in ["rmse", "rel_mse", "smape", "psnr", "ssim", "flip", "hdr_flip", "worst_tile"] {
        assert!(metrics[id].as_f64() > Some(0.0), "{id} in {metrics}");
    }
    assert!(metrics["bias"].as_array().unwrap().iter().all(|ratio| ratio.as_f64() < Some(1.0)), "{metrics}");
    for id in ["nan_count", "inf_count", "negative_count"] {
        assert_eq!(metrics[id], 0, "{id} in {metrics}");
    }
    assert_eq!((&metrics["reference"], &metrics["test"]), (&reference.into(), &test.into()));
    // The same picture twice: an infinite ratio is null.
    let same = data("cornell_64_b1.exr").display().to_string();
    let output = gridlight(&format!("metrics {same} {same} --exposure -2"));
    ends(&output, 0, "");
    let metrics: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(metrics["psnr"].is_null() && metrics["ssim"] == 1.0 && metrics["exposure"] == -2.0, "{metrics}");
}

#[test]
fn metrics_of_what_cannot_be_compared_is_1_with_one_message() {
    let scratch = Scratch::new("metrics");
    std::fs::create_dir_all(scratch.path()).unwrap();
    let written = |name: &str, size: [u32; 2], value: f32| {
        let path = scratch.path().join(name);
        gridlight::output::color_exr(&path, &frame::cpu::Image::filled(size, [1.0, value, 1.0])).unwrap();
        path.display().to_string()
    };
    let small = written("small.exr", [2, 3], 1.0);
    let large = written("large.exr", [4, 3], 1.0);
    let broken = written("broken.exr", [2, 3], f32::NAN);
    let before = scratch.files();
    for (pair, parts) in [
        (format!("{small} {large}"), ["small.exr", "large.exr", "2x3", "4x3"]),
        (format!("{small} {broken}"), ["broken.exr (test)", "the test holds 6 NaN", "column 0", "row 0"]),
        (
            format!("{broken} {small}"),
            ["broken.exr (reference)", "the reference holds 6 NaN", "0 infinite", "error:"],
        ),
        (format!("{small} no_such.exr"), ["no_such.exr", "os error", "error:", ""]),
    ] {
        let output = gridlight(&format!("metrics {pair}"));
        parts.iter().for_each(|part| ends(&output, 1, part));
        assert!(
            output.stdout.is_empty() && text(&output.stderr).lines().count() == 1,
            "{}",
            text(&output.stderr)
        );
    }
    assert_eq!(scratch.files(), before, "nothing is written");
    ends(&gridlight(&format!("metrics {small}")), 2, "TEST.exr");
}

#[test]
fn merging_names_what_is_missing() {
    let scratch = Scratch::new("merge");
    let out = scratch.path().display();
    ends(&gridlight("report"), 2, "merge");
    ends(&gridlight(&format!("report merge {out}")), 2, "<SHARD>");
    ends(&gridlight(&format!("report merge {out} {out}/one {out}/two")), 1, "one/rows.json");
    assert!(!scratch.path().exists(), "a refusal leaves nothing behind");
}
