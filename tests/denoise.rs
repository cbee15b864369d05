//! Does `gridlight denoise` take other renderers' files, say what is wrong with one, and come near Open Image Denoise?

use crate::support::{Scratch, ends, gridlight, read_exr, shared, text};
use frame::cpu::Image;
use gridlight::metrics::Errors;
use gridlight::output;

/// Noisy light of 4 samples, its reference, and what Open Image Denoise made of it; vertical fields of view, degrees.
const CASES: [(&str, f32); 3] = [("sponza_day", 60.0), ("white_room", 58.715), ("garden", 45.0)];

#[test]
fn a_file_without_what_is_needed_is_told_so() {
    let scratch = Scratch::new("denoise-missing");
    output::folder(scratch.path()).unwrap();
    let path = scratch.path().join("plain.0001.exr");
    let picture = Image::from_fn([8, 6], |x, y| [x as f32, y as f32, 0.5]);
    output::color_exr(&path, &picture).unwrap();
    let (from, to) = (path.display(), scratch.path().join("out.exr"));
    let to = to.display();
    let run = |rest: &str| gridlight(&format!("denoise {from} --out {to} {rest}"));
    ends(&run("--denoiser atrous"), 1, "needs normals");
    ends(&run("--denoiser nonsense"), 2, "there are: identity");
    ends(&run("--denoiser identity --depth up"), 2, "possible values: ray, z");
    ends(&run("--denoiser identity --vfov 180"), 2, "below 180");
    ends(&run("--denoiser identity --set atrous.levels=3"), 2, "no such part");
    ends(&run("--denoiser identity --frames 2"), 1, "needs a number");
    ends(&gridlight(&format!("denoise no/such.exr --denoiser identity --out {to}")), 1, "no/such.exr");
    // Nothing is needed by what does nothing, and nothing is changed by it.
    ends(&run("--denoiser identity"), 0, "");
    assert_eq!(read_exr(&scratch.path().join("out.exr")), picture);
}

#[test]
fn frames_of_another_size_are_refused() {
    let scratch = Scratch::new("denoise-sizes");
    output::folder(scratch.path()).unwrap();
    for (number, size) in [(1, [8, 6]), (2, [8, 7])] {
        let path = scratch.path().join(format!("in.{number:04}.exr"));
        output::color_exr(&path, &Image::filled(size, [1.0; 3])).unwrap();
    }
    let [from, to] = ["in.0001.exr", "out.0001.exr"].map(|name| scratch.path().join(name));
    let line = format!("denoise {} --denoiser identity --frames 2 --out {}", from.display(), to.display());
    ends(&gridlight(&line), 1, "is 8x7, the sequence began with 8x6");
}

#[test]
fn other_renderers_light_comes_near_open_image_denoise() {
    let Some(truth) = shared("truth/noisy") else { return };
    let scratch = Scratch::new("denoise-truth");
    for (case, vfov) in CASES {
        let file = |kind: &str| truth.join(format!("{case}_4spp.{kind}.exr"));
        let (reference, oidn) = (read_exr(&file("ref")), read_exr(&file("oidn")));
        let wanted = Errors::between(&reference, &oidn).unwrap().hdr_flip;
        for denoiser in ["atrous", "svgf"] {
            let out = scratch.path().join(format!("{case}.{denoiser}.exr"));
            let line = format!(
                "denoise {} --denoiser {denoiser} --depth ray --vfov {vfov} --runs 1 --json --out {}",
                file("noisy").display(),
                out.display()
            );
            let run = gridlight(&line);
            ends(&run, 0, "");
            let found = Errors::between(&reference, &read_exr(&out)).unwrap();
            println!("{case}, {denoiser}: {:.4} against {wanted:.4}: {}", found.hdr_flip, text(&run.stdout));
            // The bar of the design: a hand-made spatial filter within 1.6 times the network's error.
            let times = found.hdr_flip / wanted;
            assert!(denoiser != "atrous" || times <= 1.6, "{case}, {denoiser}: {times} times the network's");
        }
    }
}
