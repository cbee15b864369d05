//! Does a bad machine end in one clear message, the right exit code, and files that are whole or absent?

use crate::support::{Scratch, ends, gridlight, text};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// A render that takes seconds, into `out`.
fn slow_render(out: &Path, frames: u32) -> Child {
    Command::new(env!("CARGO_BIN_EXE_gridlight"))
        .args(["render", "cornell", "--trace-size", "64x48", "--display-size", "64x48", "--grid", "32"])
        .args(["--frames", &frames.to_string(), "--quiet", "--out"])
        .arg(out)
        .env("XDG_RUNTIME_DIR", std::env::temp_dir())
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

fn small(out: &Path) -> String {
    format!(
        "render cornell --trace-size 8x8 --display-size 8x8 --grid 16 --spp 1 --quiet --out {}",
        out.display()
    )
}

#[test]
fn without_an_adapter_the_message_says_what_to_install() {
    // A loader that is told of no driver finds none.
    let output = Command::new(env!("CARGO_BIN_EXE_gridlight"))
        .arg("info")
        .env("VK_ICD_FILENAMES", "/no/such/driver.json")
        .env("VK_DRIVER_FILES", "/no/such/driver.json")
        .output()
        .unwrap();
    // Where another backend has one, there is nothing to see.
    if output.status.success() {
        return println!("skipped: an adapter that Vulkan does not know");
    }
    ends(&output, 1, "no graphics adapter");
    assert_eq!(text(&output.stderr).lines().count(), 1, "one message: {}", text(&output.stderr));
}

#[test]
fn a_folder_that_cannot_be_written_is_named_and_nothing_is_left() {
    let scratch = Scratch::new("read-only");
    std::fs::create_dir_all(scratch.path()).unwrap();
    // A file in the way of the folder: refused to the mightiest user, too.
    let taken = scratch.path().join("taken");
    std::fs::write(&taken, "mine").unwrap();
    ends(&gridlight(&small(&taken.join("out"))), 1, "taken");
    assert_eq!(scratch.files(), ["taken"]);
    // A folder in the way of one of the files.
    let out = scratch.path().join("out");
    std::fs::create_dir_all(out.join("log.json/deep")).unwrap();
    ends(&gridlight(&small(&out)), 1, "log.json");
    let left = std::fs::read_dir(&out).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap());
    assert!(left.into_iter().all(|name| !name.ends_with(".part")), "no half of a file is left");
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_said_and_leaves_no_half_of_a_file() {
    // Every write to this device says that there is no space left.
    let scratch = Scratch::new("full");
    let full = Path::new("/dev/full");
    if !full.exists() {
        return println!("skipped: no {}", full.display());
    }
    let output = Command::new(env!("CARGO_BIN_EXE_gridlight"))
        .args(["list", "--json"])
        .env("XDG_RUNTIME_DIR", std::env::temp_dir())
        .stdout(std::fs::OpenOptions::new().write(true).open(full).unwrap())
        .output()
        .unwrap();
    ends(&output, 1, "stdout: No space left on device");
    assert!(!scratch.path().exists());
}

#[test]
fn a_render_that_is_killed_leaves_whole_files_only() {
    let scratch = Scratch::new("killed");
    let mut child = slow_render(scratch.path(), 1000);
    // Killed as soon as it has written something: in the middle of whatever it does then.
    let begun = Instant::now();
    let written = || scratch.path().read_dir().map_or(0, |entries| entries.count());
    while written() < 4 && begun.elapsed() < Duration::from_secs(120) {
        std::thread::sleep(Duration::from_millis(5));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let files = scratch.files();
    assert!(files.len() >= 3, "it wrote nothing in two minutes: {files:?}");
    for name in files.iter().filter(|name| !name.ends_with(".part")) {
        let path = scratch.path().join(name);
        if name.ends_with(".exr") {
            gridlight::input::read_exr_layers(&path).unwrap_or_else(|e| panic!("{e}"));
        } else {
            image::open(&path).unwrap_or_else(|e| panic!("{name}: {e}"));
        }
    }
}

#[test]
fn two_renders_into_one_folder_leave_the_files_of_one_each_whole() {
    let scratch = Scratch::new("two");
    let mut both = [slow_render(scratch.path(), 1), slow_render(scratch.path(), 1)];
    for child in &mut both {
        assert!(child.wait().unwrap().success());
    }
    assert_eq!(
        scratch.files(),
        ["display.0001.exr", "display.0001.png", "light.0001.exr", "log.json"],
        "nothing half written is left"
    );
    gridlight::input::read_exr_layers(&scratch.path().join("light.0001.exr")).unwrap();
}

#[test]
fn more_memory_than_the_adapter_has_is_refused_with_both_numbers() {
    let scratch = Scratch::new("memory");
    // 8192 x 8192 pixels of 32 bytes.
    let line = format!(
        "render cornell --trace-size 8x8 --display-size 8x8 --grid 4096 --quiet --out {}",
        scratch.path().display()
    );
    let output = gridlight(&line);
    if output.status.success() {
        return println!("skipped: this adapter has room for a grid of 4096 cells");
    }
    ends(&output, 1, "grid");
    let said = text(&output.stderr);
    assert!(said.lines().count() == 1 && said.matches(|c: char| c.is_ascii_digit()).count() > 4, "{said}");
    assert!(!scratch.path().join("display.png").exists());
}

#[test]
fn what_loading_may_take_is_set_by_a_flag() {
    let scratch = Scratch::new("budget");
    std::fs::create_dir_all(scratch.path()).unwrap();
    let scene = scratch.path().join("bomb.gltf");
    // A billion corners that no byte stands for.
    std::fs::write(
        &scene,
        r#"{"asset":{"version":"2.0"},"nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
            "accessors":[{"componentType":5126,"count":100000000,"type":"VEC3"}]}"#,
    )
    .unwrap();
    let line = format!("info {} --load-mb 50", scene.display());
    for part in [
        "bomb.gltf: accessors[0]: 100000000 elements",
        "takes 1200 MB",
        "the budget for loading is 50 MB (--load-mb)",
    ] {
        ends(&gridlight(&line), 1, part);
    }
    let sky = scratch.path().join("huge.hdr");
    std::fs::write(&sky, "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8000 +X 16000\n").unwrap();
    let line = format!("info cornell --sky {}", sky.display());
    for part in ["huge.hdr: header: 16000 x 8000 texels", "takes 3072 MB", "2000 MB (--load-mb)"] {
        ends(&gridlight(&line), 1, part);
    }
    // What never ends is not opened.
    if Path::new("/dev/zero").exists() {
        ends(&gridlight("info cornell --path /dev/zero"), 1, "/dev/zero: not a file");
    }
    let line = format!("info cornell --trace-size 8x8 --display-size 8x8 --grid 16 --path {}", sky.display());
    ends(&gridlight(&line), 1, "huge.hdr: no camera path");
}
