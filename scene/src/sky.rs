//! Sky maps from files, and the radiance that arrives from a direction.
//!
//! Inputs: an equirectangular `.hdr` (Radiance RGBE) or `.exr` picture of linear Rec. 709 radiance, any aspect;
//! axes as [`SkyMap`] documents them. Output: radiance per world direction,
//!
//! `x = w atan2(d.x, -d.z) / 2 pi - 1/2`, `y = h acos(d.y) / pi - 1/2`, bilinear between the texels around
//! (x, y): columns wrap, rows stop at the poles. Texel centres lie at (i + 1/2) / w, so a shader that follows the
//! same formula finds the same value.

use crate::budget::Meter;
use crate::{LoadBudget, SceneError, Sky, SkyMap};
use exr::prelude::{MetaData, ReadChannels, ReadLayers, read};
use glam::{DVec3, Vec3};
use image::{DynamicImage, ImageDecoder, codecs::hdr::HdrDecoder};
use std::f32::consts::{PI, TAU};
use std::f64;
use std::io::Cursor;
use std::path::Path;

/// Largest map accepted, columns and rows, whatever the budget. Larger claims are taken for broken headers.
const LARGEST: [usize; 2] = [16384, 8192];
/// Bytes a texel: three floats that stay, and as much again while they are decoded.
const TEXEL_BYTES: u64 = 24;

impl Sky {
    /// Reads an equirectangular `.hdr` or `.exr` file.
    ///
    /// Negative texels, which resampling leaves around bright spots, are set to 0. The Radiance header's
    /// `EXPOSURE` is not applied.
    ///
    /// # Errors
    /// The file cannot be read, is neither format, is larger than 16384 x 8192, or has a texel that is not finite.
    pub fn load(path: &Path) -> Result<Self, SceneError> {
        Self::load_within(path, LoadBudget::default())
    }

    /// The same, taking no more memory than `budget` on the way.
    ///
    /// # Errors
    /// As [`Sky::load`], or the file asks for more.
    pub fn load_within(path: &Path, budget: LoadBudget) -> Result<Self, SceneError> {
        // Before it is read: a name that says neither may be anything.
        kind(path).map_err(|fault| broken(path, fault))?;
        let meter = Meter::new(budget);
        meter.read(path).and_then(|bytes| decode(path, &bytes, &meter)).map_err(|fault| broken(path, fault))
    }

    /// The content of a `.hdr` or `.exr` file, as the extension of `path` says.
    ///
    /// # Errors
    /// As [`Sky::load_within`].
    pub fn of_bytes(path: &Path, bytes: &[u8], budget: LoadBudget) -> Result<Self, SceneError> {
        decode(path, bytes, &Meter::new(budget)).map_err(|fault| broken(path, fault))
    }

    /// Radiance that arrives from `direction` (away from the viewer, any length but 0).
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        match self {
            Self::Constant(radiance) => *radiance,
            Self::Map(map) => map.radiance(direction),
        }
    }

    /// Mean over the sphere of directions: what a scale for all radiance can be chosen from.
    pub fn mean_radiance(&self) -> Vec3 {
        match self {
            Self::Constant(radiance) => *radiance,
            Self::Map(map) => map.mean_radiance(),
        }
    }
}

impl SkyMap {
    fn radiance(&self, direction: Vec3) -> Vec3 {
        let d = direction.normalize_or(Vec3::Y);
        let x = d.x.atan2(-d.z) / TAU * self.width as f32 - 0.5;
        let y = d.y.clamp(-1.0, 1.0).acos() / PI * self.height as f32 - 0.5;
        let (column, row) = (x.floor(), y.floor());
        let texel = |i: f32, j: f32| {
            let i = (i as i64).rem_euclid(i64::from(self.width)) as usize;
            let j = (j as i64).clamp(0, i64::from(self.height) - 1) as usize;
            self.radiance[j * self.width as usize + i]
        };
        let across = |j: f32| texel(column, j).lerp(texel(column + 1.0, j), x - column);
        across(row).lerp(across(row + 1.0), y - row)
    }

    /// Rows weigh by their band of the sphere: `(cos top - cos bottom) / 2`.
    fn mean_radiance(&self) -> Vec3 {
        let (width, height) = (self.width as usize, f64::from(self.height));
        let bands = self.radiance.chunks_exact(width).enumerate().map(|(row, texels)| {
            let [top, bottom] = [row, row + 1].map(|edge| (edge as f64 / height * f64::consts::PI).cos());
            let sum: DVec3 = texels.iter().map(|texel| texel.as_dvec3()).sum();
            sum / width as f64 * (0.5 * (top - bottom))
        });
        bands.sum::<DVec3>().as_vec3()
    }
}

/// What is wrong; the path is added at the door.
type Fault = String;

/// The two formats of a sky.
enum Kind {
    Hdr,
    Exr,
}

fn kind(path: &Path) -> Result<Kind, Fault> {
    match path.extension().map(|e| e.to_ascii_lowercase()).as_ref().and_then(|e| e.to_str()) {
        Some("hdr") => Ok(Kind::Hdr),
        Some("exr") => Ok(Kind::Exr),
        _ => Err("a sky is a .hdr or an .exr file".into()),
    }
}

fn decode(path: &Path, bytes: &[u8], meter: &Meter) -> Result<Sky, Fault> {
    let map = match kind(path)? {
        Kind::Hdr => decode_hdr(bytes, meter)?,
        Kind::Exr => decode_exr(bytes, meter)?,
    };
    Ok(Sky::Map(checked(map)?))
}

fn decode_hdr(bytes: &[u8], meter: &Meter) -> Result<SkyMap, Fault> {
    let decoder = HdrDecoder::new(Cursor::new(bytes)).map_err(|e| format!("header: {e}"))?;
    let (width, height) = decoder.dimensions();
    afford(width as usize, height as usize, meter)?;
    let picture = DynamicImage::from_decoder(decoder)
        .map_err(|e| format!("{width} x {height} texels promised: {e}"))?
        .into_rgb32f();
    Ok(SkyMap { width, height, radiance: picture.pixels().map(|p| Vec3::from_array(p.0)).collect() })
}

fn decode_exr(bytes: &[u8], meter: &Meter) -> Result<SkyMap, Fault> {
    // The header is looked at first: reading the layer allocates what it claims.
    let header =
        MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(|e| format!("header: {e}"))?;
    for layer in &header.headers {
        afford(layer.layer_size.width(), layer.layer_size.height(), meter)?;
    }
    // The decoder is not made for hostile files and may give up in the middle of its arithmetic; in this thread, where it
    // can be caught.
    let pixels = || {
        read()
            .no_deep_data()
            .largest_resolution_level()
            .rgba_channels(
                |size, _channels| (size.width(), vec![Vec3::ZERO; size.area()]),
                |(width, texels): &mut (usize, Vec<Vec3>), at, (r, g, b, _a): (f32, f32, f32, f32)| {
                    texels[at.y() * *width + at.x()] = Vec3::new(r, g, b);
                },
            )
            .first_valid_layer()
            .all_attributes()
            .non_parallel()
            .from_buffered(Cursor::new(bytes))
    };
    let picture = std::panic::catch_unwind(pixels)
        .map_err(|_| "pixels: the decoder gave up".to_owned())?
        .map_err(|e| format!("pixels: {e}"))?;
    let layer = picture.layer_data;
    let (width, height) = (layer.size.width() as u32, layer.size.height() as u32);
    Ok(SkyMap { width, height, radiance: layer.channel_data.pixels.1 })
}

/// Takes the texels that a header claims.
fn afford(width: usize, height: usize, meter: &Meter) -> Result<(), Fault> {
    let [most_columns, most_rows] = LARGEST;
    let claim = format!("header: {width} x {height} texels");
    if width == 0 || height == 0 || width > most_columns || height > most_rows {
        return Err(format!("{claim}; a sky has at least 1 x 1, at most {most_columns} x {most_rows}"));
    }
    meter.take(width as u64 * height as u64, TEXEL_BYTES).map_err(|over| format!("{claim}: {over}"))
}

/// Refuses what is not finite, sets negative values to 0.
fn checked(mut map: SkyMap) -> Result<SkyMap, Fault> {
    let mut bad = map.radiance.iter().enumerate().filter(|(_, texel)| !texel.is_finite());
    if let Some((index, texel)) = bad.next() {
        let (count, all) = (1 + bad.count(), map.radiance.len());
        let (column, row) = (index % map.width as usize, index / map.width as usize);
        return Err(format!(
            "{count} of {all} texels are not finite, the first at column {column}, row {row}: {texel}"
        ));
    }
    map.radiance.iter_mut().for_each(|texel| *texel = texel.max(Vec3::ZERO));
    Ok(map)
}

fn broken(path: &Path, message: Fault) -> SceneError {
    SceneError::File { path: path.into(), message }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::panic)]
mod tests {
    use super::*;
    use exr::prelude::write_rgb_file;

    /// A colour per direction that grows along all three axes and is smooth everywhere, the seam included.
    fn along_axes(d: Vec3) -> Vec3 {
        Vec3::splat(1.5) + d
    }

    fn synthetic(width: u32, height: u32) -> SkyMap {
        let texel = |index: u32| {
            let u = ((index % width) as f32 + 0.5) / width as f32 * TAU;
            let v = ((index / width) as f32 + 0.5) / height as f32 * PI;
            along_axes(Vec3::new(v.sin() * u.sin(), v.cos(), -v.sin() * u.cos()))
        };
        SkyMap { width, height, radiance: (0..width * height).map(texel).collect() }
    }

    /// A file of this test process alone, gone when dropped.
    struct Scratch(std::path::PathBuf);

    impl Scratch {
        fn new(name: &str) -> Self {
            Self(std::env::temp_dir().join(format!("gridlight-sky-{}-{name}", std::process::id())))
        }
    }

    impl Drop for Scratch {
        fn drop(&mut self) {
            let _ = std::fs::remove_file(&self.0);
        }
    }

    #[test]
    fn the_six_axes_and_what_lies_between_them() {
        let sky = Sky::Map(synthetic(128, 64));
        let mut directions = vec![Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
        for i in 0..500 {
            let (y, turn) = (i as f32 / 250.0 - 0.998, i as f32 * 2.4);
            let r = (1.0 - y * y).sqrt();
            directions.push(Vec3::new(r * turn.cos(), y, r * turn.sin()));
        }
        for d in directions {
            // Texels are 0.049 rad apart: linear interpolation of a curvature-1 function errs by 0.049^2 / 8
            // = 3e-4 per axis; at a pole the value stays that of the last row, half a texel (0.025) away.
            let tolerance = if d.y.abs() > 0.999 { 0.025 } else { 7e-4 };
            let error = (sky.radiance(d) - along_axes(d)).abs().max_element();
            assert!(error < tolerance, "{d}: off by {error}");
            assert_eq!(sky.radiance(d), sky.radiance(4.0 * d), "length counts at {d}");
        }
    }

    #[test]
    fn texel_centres_give_texels_and_the_seam_blends_both_sides() {
        let radiance: Vec<_> = (0..8).map(|i| Vec3::splat(i as f32)).collect();
        let sky = Sky::Map(SkyMap { width: 4, height: 2, radiance });
        // Column 0 of row 0 is centred 45 degrees from -Z towards +X, 45 degrees up.
        let centre = Vec3::new(0.5, 0.5f32.sqrt(), -0.5);
        // atan2 and acos are good to a few ulp of pi; texel values differ by at most 4 per texel.
        assert!((sky.radiance(centre) - Vec3::splat(0.0)).abs().max_element() < 1e-5);
        let mirrored = Vec3::new(-0.5, 0.5f32.sqrt(), -0.5);
        assert!((sky.radiance(mirrored) - Vec3::splat(3.0)).abs().max_element() < 1e-5);
        // -Z at 45 degrees up lies on the seam, midway between column 3 and column 0.
        let seam = Vec3::new(0.0, 1.0, -1.0);
        assert!((sky.radiance(seam) - Vec3::splat(1.5)).abs().max_element() < 1e-5);
    }

    #[test]
    fn means_weigh_by_solid_angle() {
        let flat = SkyMap { width: 5, height: 3, radiance: vec![Vec3::new(1.0, 2.0, 3.0); 15] };
        // Sums are f64; the result is rounded to f32 once.
        assert!((Sky::Map(flat).mean_radiance() - Vec3::new(1.0, 2.0, 3.0)).abs().max_element() < 1e-6);
        // Three bands: the outer two hold (1 - cos 60) / 2 = 1/4 of the sphere each.
        let radiance = [4.0, 0.0, 0.0].map(Vec3::splat).to_vec();
        let cap = Sky::Map(SkyMap { width: 1, height: 3, radiance });
        assert!((cap.mean_radiance() - Vec3::ONE).abs().max_element() < 1e-6);
        assert_eq!(Sky::Constant(Vec3::X).mean_radiance(), Vec3::X);
    }

    #[test]
    fn an_exr_comes_back_as_written_but_for_negative_values() {
        let file = Scratch::new("round.exr");
        let map = synthetic(16, 8);
        write_rgb_file(&file.0, 16, 8, |x, y| {
            let texel = map.radiance[y * 16 + x];
            (texel.x, texel.y - 1.5, texel.z)
        })
        .unwrap();
        let Sky::Map(read) = Sky::load(&file.0).unwrap() else { panic!("not a map") };
        assert_eq!((read.width, read.height), (16, 8));
        for (read, written) in read.radiance.iter().zip(&map.radiance) {
            assert_eq!(*read, Vec3::new(written.x, (written.y - 1.5).max(0.0), written.z));
        }
    }

    #[test]
    fn what_is_not_finite_is_refused_with_count_and_place() {
        for (name, value) in [("nan.exr", f32::NAN), ("inf.exr", f32::INFINITY)] {
            let file = Scratch::new(name);
            let bad = |x: usize, y: usize| if y == 2 && x >= 3 { value } else { 1.0 };
            write_rgb_file(&file.0, 8, 4, |x, y| (1.0, bad(x, y), 1.0)).unwrap();
            let message = Sky::load(&file.0).unwrap_err().to_string();
            assert!(message.contains("5 of 32 texels") && message.contains("column 3, row 2"), "{message}");
        }
    }

    #[test]
    fn broken_files_and_absurd_sizes_are_refused() {
        let refused = |name: &str, bytes: &[u8], part: &str| {
            let file = Scratch::new(name);
            std::fs::write(&file.0, bytes).unwrap();
            let message = Sky::load(&file.0).unwrap_err().to_string();
            assert!(message.contains(part), "{name}: {message}");
        };
        let header = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n";
        refused("wide.hdr", format!("{header}-Y 4 +X 100000\n").as_bytes(), "100000 x 4");
        // 16384 x 8192 texels of 24 bytes are 3222 MB.
        refused(
            "budget.hdr",
            format!("{header}-Y 8192 +X 16384\n").as_bytes(),
            "takes 3222 MB on top of 1 MB",
        );
        refused("none.hdr", format!("{header}-Y 0 +X 4\n").as_bytes(), "none.hdr");
        refused("short.hdr", format!("{header}-Y 64 +X 128\nabc").as_bytes(), "short.hdr");
        refused("noise.exr", &[0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0, 9, 9], "noise.exr");
        refused("empty.hdr", b"", "empty.hdr");
        refused("sky.png", b"", ".hdr or an .exr");
        assert!(Sky::load(Path::new("no/such.hdr")).unwrap_err().to_string().starts_with("no/such.hdr: "));
    }

    #[test]
    fn real_maps_load() {
        let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/scenes/hdri"));
        let Ok(entries) = std::fs::read_dir(folder) else {
            return println!("skipped: no {}", folder.display());
        };
        let mut count = 0;
        for path in
            entries.map(|entry| entry.unwrap().path()).filter(|p| p.extension().is_some_and(|e| e == "hdr"))
        {
            let sky = Sky::load(&path).unwrap();
            let Sky::Map(map) = &sky else { panic!("not a map") };
            assert_eq!((map.width, map.height), (1024, 512), "{}", path.display());
            assert!(sky.mean_radiance().min_element() > 0.0, "{} is black", path.display());
            count += 1;
        }
        assert!(count > 0, "no .hdr in {}", folder.display());
    }
}
