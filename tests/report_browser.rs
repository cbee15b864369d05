//! Does the report's page work in a browser: slider, zoom, curves, table, also on a phone, without a word on the console?
//!
//! A headless Chromium opens the page with a script appended that does what a reader does, through real DOM events, and
//! writes what it saw into the page; the browser prints the page and the test reads it. The browser is looked for on the
//! path, or named by `GRIDLIGHT_BROWSER`; without one the test is skipped, unless `CI` is set.

use gridlight::report::{
    Errors, Facts, Picture, Reference, ReferenceInfo, Report, Row, StageTimes, Timing, heat_map,
};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

/// What the reader does. `seen` holds what came of it.
const READER: &str = include_str!("data/report_reader.js");

/// A name that would run, end the data, or fill a hole of the template, if anything let it.
const SCENE: &str = "</script><img src=x onerror=\"window.ran=1\"> {{data}}";

#[test]
fn a_reader_on_a_desk_and_on_a_phone() {
    let Some(browser) = browser() else { return };
    let folder = std::env::temp_dir().join(format!("gridlight-browser-{}", std::process::id()));
    let _ = std::fs::remove_dir_all(&folder);
    report(&folder);
    let page = std::fs::read_to_string(folder.join("report.html")).unwrap();
    // Errors must be heard from the first script on; the reader comes after the last.
    let page = page.replacen("<head>", "<head><script>window.heard = []; addEventListener(\"error\", (e) => heard.push(e.message)); console.error = (...words) => heard.push(words.join(\" \"));</script>", 1);
    let page = page.replacen("</body>", &format!("<script>{READER}</script></body>"), 1);
    std::fs::write(folder.join("read.html"), page).unwrap();
    for width in [1280, 390] {
        let seen = read(&browser, &folder, width);
        check(&seen, width);
    }
    std::fs::remove_dir_all(&folder).unwrap();
}

/// Everything the reader saw is as it must be.
fn check(seen: &Value, width: u32) {
    assert_eq!(seen["width"], width, "the page is as wide as asked for: {seen}");
    assert_eq!(seen["errors"], serde_json::json!([]), "nothing on the console at {width} pixels");
    assert_eq!(seen["ran"], false, "a scene's name is text");
    assert_eq!(seen["title"], SCENE);
    assert!(seen["overflow"].as_i64().unwrap() <= 0, "no sideways scrolling at {width} pixels: {seen}");
    // The divider follows the pointer and the keys, and the picture above it is cut there.
    assert_eq!(seen["slider"], serde_json::json!(["50", "25", "27"]), "{seen}");
    assert!(seen["cut"].as_str().unwrap().contains("27%"), "{seen}");
    // Both pictures moved as one, and apart from where they were.
    assert_eq!(seen["zoomed"][0], seen["zoomed"][1], "{seen}");
    assert!(seen["zoomed"][0].as_str().unwrap().contains("scale(2"), "{seen}");
    assert_eq!(seen["fitted"], "translate(0px, 0px) scale(1)");
    assert_eq!(seen["loaded"], serde_json::json!([true, true]), "pictures are in the file");
    // Side by side each pane has half; errors are other pictures than what they are errors of.
    assert!(seen["beside"].as_f64().unwrap() < 0.51, "{seen}");
    assert_eq!(seen["heat"], true);
    // Two tracers, three sample counts, one reference.
    assert_eq!((&seen["points"], &seen["fronts"]), (&6.into(), &1.into()));
    assert!(seen["tip"].as_str().unwrap().contains("relMSE"), "{seen}");
    assert!(
        seen["axis"].as_array().unwrap().iter().any(|label| label == "0.1"),
        "a decade is labelled: {seen}"
    );
    assert_eq!(seen["chosen"], seen["shown"], "a point opens its picture");
    // Sorted by the time, up and down, then by name.
    let times: Vec<f64> = serde_json::from_value(seen["times"].clone()).unwrap();
    assert!(times.len() == 6 && times.is_sorted(), "{times:?}");
    let down: Vec<f64> = serde_json::from_value(seen["times_down"].clone()).unwrap();
    assert!(down.iter().rev().eq(&times), "{down:?}");
    assert_eq!(seen["sorted_by"], serde_json::json!(["descending", "none"]));
    assert_eq!(seen["both"], 12, "rows against both references");
    assert_eq!(seen["filtered"], 3, "rows whose tracer was searched for");
}

/// Opens the page and reads what the reader wrote.
fn read(browser: &Path, folder: &Path, width: u32) -> Value {
    // A window of the desktop has a least width: a phone is a frame within it.
    let frame = format!(
        "<!DOCTYPE html><body style=\"margin:0\"><iframe src=\"read.html\" width=\"{width}\" height=\"844\" style=\"border:0\"></iframe><pre id=\"seen\"></pre><script>addEventListener(\"message\", (e) => document.getElementById(\"seen\").textContent = e.data)</script>"
    );
    std::fs::write(folder.join("frame.html"), frame).unwrap();
    let output = Command::new(browser)
        // The sandbox needs rights that a container lacks; the page is our own.
        .args([
            "--headless=new",
            "--disable-gpu",
            "--no-sandbox",
            "--disable-dev-shm-usage",
            "--no-first-run",
        ])
        .args(["--virtual-time-budget=5000", "--window-size=1400,1000", "--hide-scrollbars", "--dump-dom"])
        .arg(format!("--user-data-dir={}", folder.join("profile").display()))
        .arg(format!("file://{}", folder.join("frame.html").display()))
        .output()
        .unwrap_or_else(|e| panic!("{}: {e}", browser.display()));
    let dom = String::from_utf8_lossy(&output.stdout);
    let seen = dom.split_once("<pre id=\"seen\">").and_then(|(_, rest)| rest.split_once("</pre>"));
    let (seen, _) = seen.unwrap_or_else(|| panic!("no page: {}", String::from_utf8_lossy(&output.stderr)));
    // Text comes back as HTML; ampersands last, or "&amp;lt;" would become "<".
    let seen =
        seen.replace("&lt;", "<").replace("&gt;", ">").replace("&nbsp;", "\u{a0}").replace("&amp;", "&");
    serde_json::from_str(&seen).unwrap_or_else(|e| panic!("the reader did not come to an end: {e}: {seen}"))
}

/// The browser there is.
fn browser() -> Option<PathBuf> {
    if let Some(named) = std::env::var_os("GRIDLIGHT_BROWSER") {
        return Some(named.into());
    }
    let path = std::env::var_os("PATH").unwrap_or_default();
    let names = ["chromium", "chromium-browser", "google-chrome", "headless_shell"];
    let found = names.iter().find_map(|name| {
        std::env::split_paths(&path).map(|folder| folder.join(name)).find(|program| program.is_file())
    });
    assert!(
        found.is_some() || std::env::var_os("CI").is_none(),
        "CI is set and there is no browser: {names:?}"
    );
    if found.is_none() {
        println!("skipped: no browser ({}, or GRIDLIGHT_BROWSER)", names.join(", "));
    }
    found
}

/// Two tracers at three sample counts against two references, with pictures and maps of their errors.
fn report(folder: &Path) {
    std::fs::create_dir_all(folder).unwrap();
    let gradient = |light: f32| frame::cpu::Image::from_fn([64, 48], |x, _| [light * x as f32 / 64.0; 3]);
    let save = |file: &str, image: &frame::cpu::Image<[f32; 3]>| {
        gridlight::output::color_png(&folder.join(file), image, 0.0).unwrap()
    };
    save("reference.png", &gradient(1.0));
    let mut rows = Vec::new();
    let mut pictures = vec![Picture {
        id: "reference bvh".into(),
        reference: true,
        file: "reference.png".into(),
        heat: None,
    }];
    for (tracer, ms) in [("voxel", 2.0), ("bvh_lbvh", 5.0)] {
        for spp in [1, 4, 16] {
            let (file, heat) = (format!("{tracer}.{spp}.png"), format!("{tracer}.{spp}.error.png"));
            let picture = gradient(1.0 + 1.0 / spp as f32);
            save(&file, &picture);
            save(&heat, &heat_map(&picture, &gradient(1.0)).unwrap());
            for reference in [Reference::Bvh, Reference::Voxel] {
                rows.push(row(tracer, spp, reference, ms * f64::from(spp), &file));
            }
            let id = rows.last().unwrap().configuration();
            pictures.push(Picture { id, reference: false, file, heat: Some(heat) });
        }
    }
    let triangles = ReferenceInfo {
        kind: Reference::Bvh,
        grid: None,
        spp: 1024,
        noise_rel_mse: Some(1e-5),
        gap_rmse: None,
        file: "reference.png".into(),
    };
    let facts = Facts {
        commands: vec!["gridlight compare".into()],
        adapter: "made up".into(),
        scene: SCENE.into(),
        trace_size: [64, 48],
        display_size: [64, 48],
    };
    Report::new(facts, vec![triangles], rows, pictures).write(folder).unwrap();
}

fn row(tracer: &str, spp: u32, reference: Reference, ms: f64, image: &str) -> Row {
    let timing = |ms: f64| Some(Timing { median: ms, p95: 1.2 * ms, spread: 0.1 * ms });
    Row {
        scene: SCENE.into(),
        tracer: tracer.into(),
        denoiser: "identity".into(),
        upsampler: "nearest".into(),
        spp,
        reference,
        errors: Errors { rel_mse: Some(0.3 / f64::from(spp)), ssim: Some(0.9), ..Errors::default() },
        stages_ms: StageTimes { trace: timing(0.9 * ms), gather: timing(0.1 * ms), ..StageTimes::default() },
        total_ms: timing(ms),
        image: Some(image.into()),
        ..Row::default()
    }
}
