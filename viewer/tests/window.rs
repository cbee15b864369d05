//! The real window under a virtual display: a script plays a user, and the pictures it leaves are looked at.
//!
//! Skips with a printed reason where there is no `xvfb-run` (`cargo xtask ci` installs it) or no graphics adapter.

#![allow(clippy::unwrap_used, clippy::panic)]

use frame::Gpu;
use frame::cpu::Image;
use gridlight::cli::RenderLine;
use gridlight::pipeline::Pipeline;
use gridlight::{Progress, input, output};
use std::path::{Path, PathBuf};
use std::process::Command;

/// A folder that is gone with the test.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("gridlight-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn file(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // For looking at the pictures afterwards.
        if std::env::var_os("GRIDLIGHT_KEEP").is_none() {
            let _ = std::fs::remove_dir_all(&self.0);
        }
    }
}

fn has(program: &str) -> bool {
    let path = std::env::var_os("PATH").unwrap_or_default();
    std::env::split_paths(&path).any(|folder| folder.join(program).is_file())
}

/// Plays a script over a small Cornell box in the folder; none where there is no screen or no adapter.
fn play(folder: &Folder, script: &str) -> Option<String> {
    let adapter = Gpu::new(None);
    if let (false, _) | (_, Err(_)) = (has("xvfb-run"), &adapter) {
        assert!(
            std::env::var_os("GRIDLIGHT_REQUIRE_WINDOW").is_none(),
            "no xvfb-run, or no graphics adapter"
        );
        println!("skipped: no xvfb-run, or no graphics adapter");
        return None;
    }
    let file = folder.file("script.txt");
    std::fs::write(&file, script).unwrap();
    let small = "cornell --camera 0 --trace-size 48x36 --display-size 96x72 --grid 32 --spp 1 --frames 2";
    let done = Command::new("xvfb-run")
        .args(["--auto-servernum", "--server-args", "-screen 0 1600x1000x24"])
        .arg(env!("CARGO_BIN_EXE_gridlight-viewer"))
        .args(small.split(' '))
        .args(["--window-size", "1200x800", "--script"])
        .arg(&file)
        .current_dir(&folder.0)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&done.stdout).into_owned() + &String::from_utf8_lossy(&done.stderr);
    assert!(done.status.success(), "{said}");
    println!("{said}");
    Some(said)
}

/// The middle of a screenshot, where the picture is.
fn middle(path: &Path) -> image::RgbImage {
    let whole = image::open(path).unwrap_or_else(|e| panic!("{}: {e}", path.display())).into_rgb8();
    let (width, height) = whole.dimensions();
    // The panels take 320 pixels on each side, the bar and the line less than 60.
    image::imageops::crop_imm(&whole, 320, 60, width - 640, height - 120).to_image()
}

/// Mean code of all channels.
fn brightness(picture: &image::RgbImage) -> f64 {
    let codes = picture.as_raw();
    codes.iter().map(|code| f64::from(*code)).sum::<f64>() / codes.len() as f64
}

/// Mean difference of codes.
fn difference(a: &image::RgbImage, b: &image::RgbImage) -> f64 {
    assert_eq!(a.dimensions(), b.dimensions());
    let pairs = a.as_raw().iter().zip(b.as_raw());
    pairs.map(|(a, b)| f64::from(a.abs_diff(*b))).sum::<f64>() / a.as_raw().len() as f64
}

/// What `gridlight render` writes as the last frame of a line.
fn rendered(line: &str) -> Image<[f32; 3]> {
    let settings = line.parse::<RenderLine>().unwrap().settings;
    let mut pipeline = Pipeline::new(Gpu::new(None).unwrap(), &settings, Progress::default()).unwrap();
    (1..settings.frames).for_each(|_| drop(pipeline.render().unwrap()));
    let last = pipeline.render().unwrap();
    output::color(pipeline.gpu(), &last.color, last.frame.radiance_scale).unwrap()
}

#[test]
fn a_user_walks_through_everything() {
    let folder = Folder::new("window");
    std::fs::write(folder.file("broken.glb"), b"glTF, not really").unwrap();
    let script = "
        rest
        screenshot scene.png
        click tracer
        click bvh_cwbvh
        rest
        screenshot tracer.png
        click denoiser
        click identity
        rest
        screenshot denoiser.png
        click upsampler
        click nearest
        rest
        screenshot upsampler.png
        click tessellator
        click identity
        rest
        click compare
        click split
        click B
        click denoiser
        click five_phase
        rest
        screenshot split.png
        drag 0.5,0.5 0.25,0.5
        hover picture
        screenshot divider.png
        hover gather/trace/surface
        pass gather/trace/surface
        screenshot pass.png
        hover picture
        resize 1000x700
        pause 300
        screenshot resized.png
        drop broken.glb
        message broken.glb
        rest
        screenshot broken.png
        turn 0.5,0.5 0.6,0.45
        rest
        picture turned.exr
        save-line turned.txt
        screenshot turned.png
        quit";
    let Some(_) = play(&folder, script) else { return };
    let shot = |name: &str| middle(&folder.file(&format!("{name}.png")));
    let names = ["scene", "tracer", "denoiser", "upsampler", "split", "divider", "pass"];
    let shots = names.map(shot);
    for (name, shot) in names.iter().zip(&shots) {
        // A third of the middle is the box, which is lit everywhere.
        assert!(brightness(shot) > 10.0, "{name} is black: {}", brightness(shot));
    }
    for (pair, names) in shots.windows(2).zip(names.windows(2)) {
        assert!(difference(&pair[0], &pair[1]) > 0.5, "{names:?} look alike");
    }
    let resized = image::open(folder.file("resized.png")).unwrap().into_rgb8();
    assert_eq!(resized.dimensions(), (1000, 700));
    // A scene that cannot be read leaves the one that stands.
    let (before, after) = (shot("resized"), shot("broken"));
    assert!(difference(&before, &after) < 0.5, "{}", difference(&before, &after));
    assert!(difference(&after, &shot("turned")) > 1.0, "the camera turned");

    let line = std::fs::read_to_string(folder.file("turned.txt")).unwrap();
    let seen = input::read_exr(&folder.file("turned.exr")).unwrap();
    assert_eq!(seen.texels(), rendered(&line).texels(), "to the bit: {line}");
}

#[test]
fn a_resting_view_and_a_recorded_path_are_what_the_line_renders() {
    let folder = Folder::new("path");
    let script = "
        rest
        picture rest.exr
        save-line rest.txt
        click record path
        turn 0.5,0.5 0.55,0.5
        turn 0.5,0.5 0.5,0.45
        click end path
        rest
        picture path.exr
        save-line path.txt
        quit";
    let Some(_) = play(&folder, script) else { return };
    for name in ["rest", "path"] {
        let line = std::fs::read_to_string(folder.file(&format!("{name}.txt"))).unwrap();
        // The line is of a shell in the folder.
        let line =
            line.replace("--path path.json", &format!("--path {}", folder.file("path.json").display()));
        assert_eq!(line.contains("--path"), name == "path", "{line}");
        let seen = input::read_exr(&folder.file(&format!("{name}.exr"))).unwrap();
        assert_eq!(seen.texels(), rendered(&line).texels(), "to the bit: {line}");
    }
}
