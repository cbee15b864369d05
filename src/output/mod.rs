//! Writes what came out: pictures, light and the log, each file whole or not at all.

mod exr;
mod file;
pub mod log;
mod png;

pub use exr::{color_exr, light_exr, lobes_exr};
pub use file::{folder, write};
pub use png::color_png;

use crate::Error;
use frame::{ColorImage, Gpu, cpu::Image};
use half::f16;
use std::path::{Path, PathBuf};

/// The picture on the CPU, top row first: linear radiance, no longer scaled.
///
/// # Errors
/// Reading back fails.
pub fn color(gpu: &Gpu, picture: &ColorImage, radiance_scale: f32) -> Result<Image<[f32; 3]>, Error> {
    let texels: Vec<[f16; 4]> = gpu.read_texture(&picture.texture)?;
    let [width, _] = picture.size();
    // One texel per pixel by construction of the read-back.
    Ok(Image::from_fn(picture.size(), |x, y| {
        let [r, g, b, _] = texels[(y * width + x) as usize].map(f16::to_f32);
        [r, g, b].map(|stored| stored / radiance_scale)
    }))
}

/// `display.png`, or `display.0001.png` for the first of numbered frames.
pub fn numbered(folder: &Path, stem: &str, number: Option<u32>, extension: &str) -> PathBuf {
    match number {
        Some(n) => folder.join(format!("{stem}.{n:04}.{extension}")),
        None => folder.join(format!("{stem}.{extension}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_numbered_with_four_digits() {
        assert_eq!(numbered(Path::new("a"), "display", None, "png"), Path::new("a/display.png"));
        assert_eq!(numbered(Path::new("a"), "display", Some(1), "png"), Path::new("a/display.0001.png"));
    }
}
