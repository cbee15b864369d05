//! What is measured: linear radiance and guides as 32-bit OpenEXR, unscaled.
//!
//! Layers are channel names with a dot (`noisy_diffuse.R`) in one part, which is how every reader of layered files,
//! and the shared references, know them. Row 0 is the top.

use crate::Error;
use ::exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image as ExrImage, Layer, LayerAttributes, Vec2,
    WritableImage,
};
use frame::cpu::Image;
use frame::surface::Surface;
use frame::{GBuffer, Gpu, RadianceImage, Texture};
use half::f16;
use std::io::Cursor;
use std::path::Path;

/// One channel: name and values, row by row from the top.
type Channel = (String, Vec<f32>);

/// Writes a picture with channels R, G and B.
///
/// # Errors
/// The file cannot be written.
pub fn color_exr(path: &Path, color: &Image<[f32; 3]>) -> Result<(), Error> {
    write(path, color.size(), planes("", "RGB", color.texels().iter().copied()))
}

/// Writes the light of both lobes, layers `denoised_diffuse` and `denoised_specular`.
///
/// # Errors
/// The file cannot be written.
pub fn lobes_exr(path: &Path, lobes: &[Image<[f32; 3]>; 2]) -> Result<(), Error> {
    let names = ["denoised_diffuse.", "denoised_specular."];
    let channels = names
        .into_iter()
        .zip(lobes)
        .flat_map(|(name, lobe)| planes(name, "RGB", lobe.texels().iter().copied()));
    write(path, lobes[0].size(), channels.collect())
}

/// Writes what travelled at trace size: light before and after the denoiser, and what guided it.
///
/// Light is unscaled radiance, its A the mean length of the lobe's first segments in metres; `albedo` is the base
/// colour, `normal` the shading normal in world space, `distance` runs along the camera ray (m, 0 = nothing hit),
/// `roughness` is perceptual along tangent and bitangent, `motion` in trace pixels from last frame to this one. A lobe
/// that the scene does not have is 0.
///
/// # Errors
/// Reading back fails, or the file cannot be written.
pub fn light_exr(
    path: &Path,
    gpu: &Gpu,
    guides: &GBuffer,
    noisy: &RadianceImage,
    denoised: &RadianceImage,
    radiance_scale: f32,
) -> Result<(), Error> {
    let mut channels = Vec::new();
    for (name, light) in [("noisy", noisy), ("denoised", denoised)] {
        for (lobe, texture) in [("diffuse", Some(&light.diffuse)), ("specular", light.specular.as_ref())] {
            let texels = lobe_texels(gpu, texture, guides.size(), radiance_scale)?;
            channels.extend(planes(&format!("{name}_{lobe}."), "RGBA", texels.into_iter()));
        }
    }
    let distances: Vec<f32> = gpu.read_texture(&guides.distance)?;
    let packed: Vec<[u32; 4]> = gpu.read_texture(&guides.surface)?;
    let motion: Vec<[u32; 2]> = gpu.read_texture(&guides.motion_id)?;
    let surfaces: Vec<Option<Surface>> = packed
        .into_iter()
        .zip(&distances)
        .map(|(words, distance)| (*distance > 0.0).then(|| Surface::unpack_gbuffer(words)))
        .collect();
    let hit = |value: fn(&Surface) -> glam::Vec3| {
        surfaces.iter().map(move |s| s.as_ref().map_or([0.0; 3], |s| value(s).into()))
    };
    channels.extend(planes("albedo.", "RGB", hit(|s| s.base)));
    channels.extend(planes("normal.", "XYZ", hit(|s| s.normal)));
    channels.extend(planes("roughness.", "TB", hit(|s| s.roughness.extend(0.0))));
    channels.extend(planes("distance.", "Z", distances.iter().map(|d| [*d])));
    channels.extend(planes("motion.", "XY", motion.into_iter().map(|[xy, _]| halves(xy))));
    write(path, guides.size(), channels)
}

/// One lobe's texels with radiance unscaled.
fn lobe_texels(
    gpu: &Gpu,
    texture: Option<&Texture>,
    [width, height]: [u32; 2],
    radiance_scale: f32,
) -> Result<Vec<[f32; 4]>, Error> {
    let Some(texture) = texture else { return Ok(vec![[0.0; 4]; width as usize * height as usize]) };
    let texels: Vec<[f16; 4]> = gpu.read_texture(texture)?;
    Ok(texels
        .into_iter()
        .map(|texel| {
            let [r, g, b, length] = texel.map(f16::to_f32);
            [r / radiance_scale, g / radiance_scale, b / radiance_scale, length]
        })
        .collect())
}

/// Two half floats in a word, the first in the low half.
fn halves(word: u32) -> [f32; 2] {
    [word as u16, (word >> 16) as u16].map(|bits| f16::from_bits(bits).to_f32())
}

/// One channel per letter.
fn planes<const N: usize>(
    prefix: &str,
    letters: &str,
    texels: impl Iterator<Item = [f32; N]> + Clone,
) -> Vec<Channel> {
    let plane = |index: usize| texels.clone().map(|texel| texel[index]).collect();
    letters.chars().take(N).enumerate().map(|(index, l)| (format!("{prefix}{l}"), plane(index))).collect()
}

fn write(path: &Path, [width, height]: [u32; 2], channels: Vec<Channel>) -> Result<(), Error> {
    let channels: Vec<_> = channels
        .into_iter()
        .map(|(name, values)| AnyChannel::new(name.as_str(), FlatSamples::F32(values)))
        .collect();
    let layer = Layer::new(
        Vec2(width as usize, height as usize),
        LayerAttributes::default(),
        // Lossless, and read by everything.
        Encoding { compression: ::exr::prelude::Compression::ZIP16, ..Encoding::SMALL_LOSSLESS },
        AnyChannels::sort(channels.into()),
    );
    let mut file = Cursor::new(Vec::new());
    ExrImage::from_layer(layer)
        .write()
        .to_buffered(&mut file)
        .map_err(|e| Error::Write { path: path.into(), message: e.to_string() })?;
    super::write(path, file.get_ref())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use ::exr::prelude::{ReadChannels, ReadLayers, read, read_first_rgba_layer_from_file};

    fn scratch(name: &str) -> std::path::PathBuf {
        std::env::temp_dir().join(format!("gridlight-exr-{}-{name}", std::process::id()))
    }

    #[test]
    fn a_picture_comes_back_bit_for_bit_and_right_way_up() {
        let path = scratch("color.exr");
        let color = Image::from_fn([5, 3], |x, y| [x as f32 / 3.0, y as f32 * 1e5, -1e-7]);
        color_exr(&path, &color).unwrap();
        let read = read_first_rgba_layer_from_file(
            &path,
            |size, _| Image::filled([size.width() as u32, size.height() as u32], [0.0f32; 3]),
            |image, at, (r, g, b, _a): (f32, f32, f32, f32)| {
                *image.get_mut(at.x() as i32, at.y() as i32).unwrap() = [r, g, b];
            },
        )
        .unwrap();
        std::fs::remove_file(&path).unwrap();
        assert_eq!(read.layer_data.channel_data.pixels, color);
    }

    #[test]
    fn layers_keep_their_names_and_values() {
        let path = scratch("layers.exr");
        let texels = [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]];
        let mut channels = planes("normal.", "XYZ", texels.into_iter());
        channels.extend(planes("distance.", "Z", [[7.0], [8.0]].into_iter()));
        write(&path, [2, 1], channels).unwrap();
        let read = read()
            .no_deep_data()
            .largest_resolution_level()
            .all_channels()
            .first_valid_layer()
            .all_attributes();
        let image = read.from_file(&path).unwrap();
        std::fs::remove_file(&path).unwrap();
        let list = &image.layer_data.channel_data.list;
        let names: Vec<_> = list.iter().map(|c| c.name.to_string()).collect();
        assert_eq!(names, ["distance.Z", "normal.X", "normal.Y", "normal.Z"]);
        assert_eq!(list[0].sample_data, FlatSamples::F32(vec![7.0, 8.0]));
        assert_eq!(list[2].sample_data, FlatSamples::F32(vec![2.0, 5.0]));
    }

    #[test]
    fn packed_halves_have_the_first_in_the_low_bits() {
        let word = u32::from(f16::from_f32(1.5).to_bits()) | u32::from(f16::from_f32(-2.0).to_bits()) << 16;
        assert_eq!(halves(word), [1.5, -2.0]);
    }
}
