//! What several questions share: a render on the adapter there is, the program, reference images, folders.

use frame::Gpu;
use frame::cpu::Image;
use gridlight::pipeline::{Pipeline, Rendered};
use gridlight::{Progress, RenderSettings, input, output};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Linear RGB.
pub type Picture = Image<[f32; 3]>;

/// The device; a test that needs one fails where there is none.
pub fn gpu() -> Gpu {
    Gpu::new(None).expect("this test needs a graphics adapter; `cargo xtask test` installs a software one")
}

/// Everything made ready for these settings.
pub fn pipeline(settings: &RenderSettings) -> Pipeline {
    Pipeline::new(gpu(), settings, Progress::default()).unwrap_or_else(|e| panic!("{}: {e}", settings.scene))
}

/// The same for a scene made by the test.
pub fn pipeline_of(scene: scene::Scene, settings: &RenderSettings) -> Pipeline {
    let name = scene.name.clone();
    Pipeline::of_scene(gpu(), scene, settings, Progress::default()).unwrap_or_else(|e| panic!("{name}: {e}"))
}

/// The next frame, read back, with what else it made.
pub fn frame_of(pipeline: &mut Pipeline) -> (Picture, Rendered) {
    let rendered = pipeline.render().unwrap_or_else(|e| panic!("{}: {e}", pipeline.scene().name));
    let picture = output::color(pipeline.gpu(), &rendered.color, rendered.frame.radiance_scale)
        .unwrap_or_else(|e| panic!("{}: {e}", pipeline.scene().name));
    (picture, rendered)
}

/// The first frame, read back.
pub fn render(settings: &RenderSettings) -> Picture {
    frame_of(&mut pipeline(settings)).0
}

/// An EXR with channels R, G, B. A missing file fails.
pub fn read_exr(path: &Path) -> Picture {
    input::read_exr(path).unwrap_or_else(|e| panic!("{e}"))
}

/// A reference of this name in `tests/data`, with its standard errors.
pub fn reference(name: &str) -> (Picture, Picture) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data");
    (read_exr(&folder.join(format!("{name}.exr"))), read_exr(&folder.join(format!("{name}.stderr.exr"))))
}

/// Mean of each channel.
pub fn mean(picture: &Picture) -> [f64; 3] {
    let count = picture.texels().len() as f64;
    [0, 1, 2].map(|c| picture.texels().iter().map(|p| f64::from(p[c])).sum::<f64>() / count)
}

/// Relative squared error beyond noise: `mean(((x - r)^2 - s_x^2 - s_r^2) / (r^2 + 0.01))`. Ours comes as two independent
/// pictures, whose product of differences holds no noise of ours to begin with.
pub fn excess_rel_mse(ours: [&Picture; 2], reference: &Picture, standard_error: &Picture) -> f64 {
    for picture in ours {
        assert_eq!(picture.size(), reference.size(), "pictures of one size are compared");
    }
    let [a, b] = ours.map(|p| p.texels());
    let mut sum = 0.0;
    for (((a, b), r), s) in a.iter().zip(b).zip(reference.texels()).zip(standard_error.texels()) {
        for c in 0..3 {
            let (r, s) = (f64::from(r[c]), f64::from(s[c]));
            sum += ((f64::from(a[c]) - r) * (f64::from(b[c]) - r) - s * s) / (r * r + 0.01);
        }
    }
    sum / (3.0 * reference.texels().len() as f64)
}

/// A folder beside the repository that holds scenes or references, if it is there and the long tests were asked for
/// (`cargo xtask test --shared`).
pub fn shared(folder: &str) -> Option<PathBuf> {
    if std::env::var_os("GRIDLIGHT_SHARED").is_none() {
        println!("skipped: GRIDLIGHT_SHARED is not set (cargo xtask test --shared)");
        return None;
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared").join(folder);
    if !path.is_dir() {
        println!("skipped: no folder {}", path.display());
        return None;
    }
    Some(path)
}

/// Runs the program to its end.
pub fn gridlight(line: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_gridlight"));
    // Without one the software driver has words of its own on stderr.
    command.env("XDG_RUNTIME_DIR", std::env::temp_dir());
    command.args(line.split_whitespace()).output().unwrap()
}

/// A folder of one test, not there yet, gone when dropped.
pub struct Scratch(PathBuf);

impl Scratch {
    /// Empties the place.
    pub fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("gridlight-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&path);
        Self(path)
    }

    /// Where.
    pub fn path(&self) -> &Path {
        &self.0
    }

    /// Names of the files in it, sorted.
    pub fn files(&self) -> Vec<String> {
        let entries = std::fs::read_dir(&self.0).unwrap();
        let mut names: Vec<_> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// What a program said.
pub fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// Fails unless the program ended with this code, and these words on stderr.
#[track_caller]
pub fn ends(output: &Output, code: i32, part: &str) {
    let stderr = text(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{stderr}");
    assert!(stderr.contains(part), "\"{part}\" is not in: {stderr}");
}
