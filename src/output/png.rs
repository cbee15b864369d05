//! The picture to look at: exposure, clamp, sRGB curve, 8 bits.

use crate::Error;
use frame::cpu::Image;
use frame::surface::srgb_from_linear;
use image::ImageEncoder;
use image::codecs::png::PngEncoder;
use std::path::Path;

/// Writes linear radiance, times 2^`exposure_stops`, as an 8-bit sRGB PNG.
///
/// # Errors
/// The file cannot be written.
pub fn color_png(path: &Path, color: &Image<[f32; 3]>, exposure_stops: f32) -> Result<(), Error> {
    let exposure = exposure_stops.exp2();
    let bytes: Vec<u8> =
        color.texels().iter().flatten().map(|radiance| srgb_byte(radiance * exposure)).collect();
    let mut file = Vec::new();
    let [width, height] = color.size();
    PngEncoder::new(&mut file)
        .write_image(&bytes, width, height, image::ExtendedColorType::Rgb8)
        .map_err(|e| Error::Write { path: path.into(), message: e.to_string() })?;
    super::write(path, &file)
}

/// Nearest code; what is not a number is black.
fn srgb_byte(linear: f32) -> u8 {
    (srgb_from_linear(linear.clamp(0.0, 1.0)) * 255.0).round() as u8
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn codes_of_known_radiances() {
        // IEC 61966-2-1: linear 0.2158605 is code 128, the toe is 12.92 x.
        assert_eq!([0.0, 0.2158605, 1.0, 7.0, -1.0, 0.001].map(srgb_byte), [0, 128, 255, 255, 0, 3]);
        assert_eq!(srgb_byte(f32::NAN), 0);
    }

    #[test]
    fn the_top_row_comes_first_and_a_stop_doubles() {
        let path = std::env::temp_dir().join(format!("gridlight-png-{}.png", std::process::id()));
        let color =
            Image::from_fn([2, 2], |_, y| if y == 0 { [0.2158605, 0.0, 0.0] } else { [0.0, 0.5, 0.0] });
        color_png(&path, &color, 1.0).unwrap();
        let read = image::open(&path).unwrap().into_rgb8();
        std::fs::remove_file(&path).unwrap();
        assert_eq!(read.get_pixel(0, 0).0, [srgb_byte(2.0 * 0.2158605), 0, 0]);
        assert_eq!(read.get_pixel(1, 1).0, [0, 255, 0]);
    }
}
