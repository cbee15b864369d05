//! OpenEXR files as planes of floats by channel name, and the picture among them.
//!
//! A layer is what stands before the last dot of a channel's name: `albedo.R`, `ViewLayer.Combined.R`; `R` alone belongs
//! to the unnamed layer. A file with several parts says the same by the parts' names, which then stand in front. Half,
//! float and integer channels all become `f32`. Row 0 is the top of the data window.

use crate::Error;
use exr::prelude::{FlatSamples, MetaData, ReadChannels, ReadLayers, read};
use frame::cpu::Image;
use scene::LoadBudget;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

/// Bytes a sample: a float that stays, and as much again while it is decoded.
const SAMPLE_BYTES: u64 = 8;

/// Names by which renderers call the picture, if it is not the unnamed layer.
const BEAUTY: [&str; 4] = ["beauty", "combined", "rgba", "rgb"];

/// All channels of a file, each row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Layers {
    size: [u32; 2],
    channels: BTreeMap<String, Vec<f32>>,
}

impl Layers {
    /// Made up by a test.
    #[cfg(test)]
    pub(crate) fn of(size: [u32; 2], channels: &[(&str, &[f32])]) -> Self {
        let channels = channels.iter().map(|(name, values)| ((*name).into(), values.to_vec())).collect();
        Self { size, channels }
    }

    /// Pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// The channels' full names, sorted.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.channels.keys().map(String::as_str)
    }

    /// The values of a channel by its full name.
    pub fn channel(&self, name: &str) -> Option<&[f32]> {
        self.channels.get(name).map(Vec::as_slice)
    }

    /// R, G and B of a layer by name; `""` is the unnamed one.
    pub fn color(&self, layer: &str) -> Option<Image<[f32; 3]>> {
        let plane = |letter: &str| match layer {
            "" => self.channel(letter),
            _ => self.channel(&format!("{layer}.{letter}")),
        };
        let (r, g, b) = (plane("R")?, plane("G")?, plane("B")?);
        let texels = r.iter().zip(g).zip(b).map(|((r, g), b)| [*r, *g, *b]).collect();
        Image::from_texels(self.size, texels)
    }

    /// The layers that have R, G and B.
    fn colored(&self) -> Vec<&str> {
        self.names()
            .filter_map(|name| match name.rsplit_once('.') {
                Some((layer, "R")) => Some(layer),
                _ => (name == "R").then_some(""),
            })
            .filter(|layer| self.color(layer).is_some())
            .collect()
    }

    /// The layer that is the picture: the unnamed one, one whose name says so, or the only one that has colour.
    pub fn picture(&self) -> Option<&str> {
        let colored = self.colored();
        let is_beauty = |layer: &str| {
            let last = layer.rsplit('.').next().unwrap_or(layer).to_lowercase();
            BEAUTY.contains(&last.as_str())
        };
        match colored.as_slice() {
            [only] => Some(only),
            all => all.iter().copied().find(|l| l.is_empty() || is_beauty(l)),
        }
    }
}

/// Reads the picture of a file: of its unnamed layer, of one called `beauty` or `Combined`, or of the only one that has R,
/// G and B.
///
/// # Errors
/// As [`read_exr_layers`], or it cannot be told which layer is the picture.
pub fn read_exr(path: &Path) -> Result<Image<[f32; 3]>, Error> {
    read_exr_within(path, LoadBudget::default())
}

/// The same, taking no more memory than `budget`.
///
/// # Errors
/// As [`read_exr`], or the file asks for more.
pub fn read_exr_within(path: &Path, budget: LoadBudget) -> Result<Image<[f32; 3]>, Error> {
    let layers = read_exr_layers_within(path, budget)?;
    layers.picture().and_then(|layer| layers.color(layer)).ok_or_else(|| {
        let names: Vec<&str> = layers.names().collect();
        unreadable(path, format!("no channels R, G, B; there are: {}", names.join(", ")))
    })
}

/// Reads every channel of a file.
///
/// # Errors
/// The file cannot be read, is not an OpenEXR picture, has parts of different sizes or a sub-sampled channel, or asks for
/// more memory than loading has by default.
pub fn read_exr_layers(path: &Path) -> Result<Layers, Error> {
    read_exr_layers_within(path, LoadBudget::default())
}

/// The same, taking no more memory than `budget`.
///
/// # Errors
/// As [`read_exr_layers`].
pub fn read_exr_layers_within(path: &Path, budget: LoadBudget) -> Result<Layers, Error> {
    let file = File::open(path).map_err(|e| unreadable(path, e.to_string()))?;
    let not_exr = |e| unreadable(path, format!("not a readable OpenEXR file: {e}"));
    // The header is looked at first: reading a layer allocates what it claims.
    let header = MetaData::read_from_buffered(BufReader::new(file), false).map_err(not_exr)?;
    let claimed = header.headers.iter().map(|part| {
        let [width, height] = [part.layer_size.width(), part.layer_size.height()];
        (width as u64).saturating_mul(height as u64).saturating_mul(part.channels.list.len() as u64)
    });
    let claimed = claimed.fold(0, u64::saturating_add);
    let asked = claimed.saturating_mul(SAMPLE_BYTES);
    if asked > budget.bytes {
        let [asked, most] = [asked, budget.bytes].map(|bytes| bytes.div_ceil(1_000_000));
        return Err(unreadable(
            path,
            format!(
                "its header claims {claimed} samples, which take {asked} MB; the budget for loading is {most} MB \
                 (--load-mb)"
            ),
        ));
    }
    let file = read().no_deep_data().largest_resolution_level().all_channels().all_layers().all_attributes();
    // The decoder is not made for hostile files and may give up in the middle of its arithmetic; in this thread, where it
    // can be caught.
    let parts = std::panic::catch_unwind(|| file.non_parallel().from_file(path))
        .map_err(|_| unreadable(path, "not a readable OpenEXR file: the decoder gave up".into()))?
        .map_err(not_exr)?
        .layer_data;

    let sizes: Vec<[u32; 2]> =
        parts.iter().map(|p| [p.size.width() as u32, p.size.height() as u32]).collect();
    let Some(&size) = sizes.first() else { return Err(unreadable(path, "it has no layer".into())) };
    if let Some(other) = sizes.iter().find(|other| **other != size) {
        let ([w, h], [v, g]) = (size, other);
        return Err(unreadable(path, format!("its parts differ in size: {w}x{h} and {v}x{g}")));
    }
    let several = parts.len() > 1;
    let mut channels = BTreeMap::new();
    for part in parts {
        let prefix = part.attributes.layer_name.filter(|_| several).map(|name| format!("{name}."));
        for channel in part.channel_data.list {
            let name = channel.name.to_string();
            let name = match &prefix {
                Some(prefix) if !name.starts_with(prefix) => format!("{prefix}{name}"),
                _ => name,
            };
            if (channel.sampling.width(), channel.sampling.height()) != (1, 1) {
                return Err(unreadable(path, format!("channel {name} is sub-sampled, which is not read")));
            }
            channels.insert(name, floats(channel.sample_data));
        }
    }
    Ok(Layers { size, channels })
}

fn floats(samples: FlatSamples) -> Vec<f32> {
    match samples {
        FlatSamples::F32(values) => values,
        FlatSamples::F16(values) => values.into_iter().map(half::f16::to_f32).collect(),
        FlatSamples::U32(values) => values.into_iter().map(|v| v as f32).collect(),
    }
}

fn unreadable(path: &Path, message: String) -> Error {
    Error::Read { path: path.into(), message }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use exr::prelude::{
        AnyChannel, AnyChannels, Encoding, FlatImage, Image as ExrImage, ImageAttributes, Layer,
        LayerAttributes, Text, Vec2, WritableImage,
    };
    use half::f16;
    use std::path::PathBuf;

    /// A file of one test, gone when dropped.
    struct Scratch(PathBuf);

    impl Scratch {
        fn new(name: &str) -> Self {
            Self(std::env::temp_dir().join(format!("gridlight-input-{}-{name}", std::process::id())))
        }
    }

    impl Drop for Scratch {
        fn drop(&mut self) {
            let _ = std::fs::remove_file(&self.0);
        }
    }

    /// A part of `width` by 1 pixels: channel `i` holds 10 i, 10 i + 1, ...
    fn part(name: Option<&str>, width: usize, channels: &[&str]) -> Layer<AnyChannels<FlatSamples>> {
        let list = channels.iter().enumerate().map(|(i, channel)| {
            let values = (0..width).map(|x| (10 * i + x) as f32).collect();
            AnyChannel::new(*channel, FlatSamples::F32(values))
        });
        let attributes = LayerAttributes { layer_name: name.map(Text::from), ..Default::default() };
        Layer::new(Vec2(width, 1), attributes, Encoding::FAST_LOSSLESS, AnyChannels::sort(list.collect()))
    }

    fn written(name: &str, parts: Vec<Layer<AnyChannels<FlatSamples>>>) -> Scratch {
        let file = Scratch::new(name);
        let attributes = ImageAttributes::with_size(Vec2(2usize, 1));
        let image: FlatImage = ExrImage { attributes, layer_data: parts.into() };
        image.write().to_file(&file.0).unwrap();
        file
    }

    #[test]
    fn the_picture_is_found_among_layers() {
        for (channels, red) in [
            (vec!["B", "G", "R", "albedo.B", "albedo.G", "albedo.R", "depth.Z"], 20.0),
            (vec!["albedo.R", "albedo.G", "albedo.B", "beauty.R", "beauty.G", "beauty.B"], 30.0),
            (vec!["A.Combined.R", "A.Combined.G", "A.Combined.B", "A.Depth.Z"], 0.0),
            (vec!["only.R", "only.G", "only.B"], 0.0),
        ] {
            let file = written("layers.exr", vec![part(None, 2, &channels)]);
            let picture = read_exr(&file.0).unwrap();
            assert_eq!(
                picture.texels().iter().map(|p| p[0]).collect::<Vec<_>>(),
                [red, red + 1.0],
                "{channels:?}"
            );
        }
    }

    #[test]
    fn which_of_several_layers_is_meant_is_not_guessed() {
        for channels in [vec!["a.R", "a.G", "a.B", "b.R", "b.G", "b.B"], vec!["Y"], vec!["R", "G", "depth.Z"]]
        {
            let file = written("which.exr", vec![part(None, 2, &channels)]);
            let message = read_exr(&file.0).unwrap_err().to_string();
            assert!(message.contains("which.exr") && message.contains(channels[0]), "{message}");
        }
    }

    #[test]
    fn parts_are_layers_too() {
        let parts = vec![part(Some("normal"), 2, &["X", "Y", "Z"]), part(Some("rgba"), 2, &["R", "G", "B"])];
        let file = written("parts.exr", parts);
        let layers = read_exr_layers(&file.0).unwrap();
        let names: Vec<&str> = layers.names().collect();
        assert_eq!(names, ["normal.X", "normal.Y", "normal.Z", "rgba.B", "rgba.G", "rgba.R"]);
        assert_eq!(layers.channel("normal.Y"), Some(&[10.0, 11.0][..]));
        assert_eq!(read_exr(&file.0).unwrap().texels(), [[0.0, 10.0, 20.0], [1.0, 11.0, 21.0]]);
        let uneven = vec![part(Some("a"), 2, &["R"]), part(Some("b"), 1, &["R"])];
        let message = read_exr(&written("uneven.exr", uneven).0).unwrap_err().to_string();
        assert!(message.contains("2x1 and 1x1"), "{message}");
    }

    #[test]
    fn halves_and_integers_become_floats() {
        assert_eq!(floats(FlatSamples::F16(vec![f16::from_f32(0.5), f16::NAN]))[0], 0.5);
        assert!(floats(FlatSamples::F16(vec![f16::NAN]))[0].is_nan());
        assert_eq!(floats(FlatSamples::U32(vec![7])), [7.0]);
    }

    #[test]
    fn broken_files_are_named() {
        let whole = written("whole.exr", vec![part(None, 2, &["R", "G", "B"])]);
        let bytes = std::fs::read(&whole.0).unwrap();
        // Behind the attribute's name, type and length: the first and, as made huge here, the last column and row.
        let window =
            bytes.windows(10).position(|w| w == b"dataWindow").unwrap() + "dataWindow\0box2i\0".len() + 4;
        let mut huge = bytes.clone();
        huge[window + 8..window + 16].copy_from_slice(&[0xff, 0xff, 0xff, 0x0f, 0xff, 0xff, 0xff, 0x0f]);
        for (name, bytes, part) in [
            ("empty.exr", &[][..], "not a readable OpenEXR file"),
            ("png.exr", b"\x89PNG\r\n\x1a\n", "not a readable OpenEXR file"),
            ("short.exr", &bytes[..bytes.len() - 3], "not a readable OpenEXR file"),
            ("header.exr", &bytes[..window], "not a readable OpenEXR file"),
            ("huge.exr", &huge, "the budget for loading is 2000 MB"),
        ] {
            let file = Scratch::new(name);
            std::fs::write(&file.0, bytes).unwrap();
            let message = read_exr(&file.0).unwrap_err().to_string();
            assert!(message.contains(part) && message.contains(name), "{name}: {message}");
        }
        assert!(read_exr(Path::new("no/such.exr")).unwrap_err().to_string().contains("no/such.exr"));
    }
}
