//! Pictures: PNG and JPEG from files, data URIs and buffer views, decoded to 8-bit RGBA on all cores.

use super::{Document, Fault, buffers};
use crate::Image;
use image::{ImageFormat, ImageReader, Limits};
use std::borrow::Cow;
use std::io::Cursor;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Longest side, pixels.
const LONGEST_SIDE: u32 = 16_384;
/// Bytes a pixel of all pictures: 4 that stay, and as much again while they are decoded.
const PIXEL_BYTES: u64 = 8;

/// Decodes the pictures named by their index in the file, in that order.
pub(super) fn read(document: &Document, pictures: &[usize], folder: &Path) -> Result<Vec<Image>, Fault> {
    let mut encoded = Vec::with_capacity(pictures.len());
    for &picture in pictures {
        let (name, bytes) =
            bytes(document, picture, folder).map_err(|f| format!("images[{picture}]: {f}"))?;
        let (width, height) = reader(&bytes)
            .and_then(|r| r.into_dimensions().map_err(|f| f.to_string()))
            .map_err(|f| format!("images[{picture}] {name}: {f}"))?;
        if width.max(height) > LONGEST_SIDE {
            return Err(format!(
                "images[{picture}] {name}: {width}x{height} pixels, at most {LONGEST_SIDE} a side"
            ));
        }
        let taken = document.meter.take(u64::from(width) * u64::from(height), PIXEL_BYTES);
        taken.map_err(|over| format!("images[{picture}] {name}: {width}x{height} pixels: {over}"))?;
        encoded.push((picture, name, bytes));
    }
    let next = AtomicUsize::new(0);
    let decoded: Vec<Mutex<Option<Result<Image, Fault>>>> =
        encoded.iter().map(|_| Mutex::new(None)).collect();
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get()).min(encoded.len());
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                while let Some((i, (picture, name, bytes))) = {
                    let i = next.fetch_add(1, Ordering::Relaxed);
                    encoded.get(i).map(|e| (i, e))
                } {
                    let image = decode(name, bytes).map_err(|f| format!("images[{picture}] {name}: {f}"));
                    if let Ok(mut slot) = decoded[i].lock() {
                        *slot = Some(image);
                    }
                }
            });
        }
    });
    let lost = || Err("a picture was not decoded".to_string());
    decoded.into_iter().map(|slot| slot.into_inner().ok().flatten().unwrap_or_else(lost)).collect()
}

/// A name for messages, and the encoded bytes.
fn bytes<'a>(
    document: &'a Document,
    picture: usize,
    folder: &Path,
) -> Result<(String, Cow<'a, [u8]>), Fault> {
    let image = document.root.images.get(picture).ok_or("not there")?;
    let place = format!("images[{picture}]");
    match (&image.uri, image.buffer_view) {
        (Some(uri), _) => {
            let name = match uri.get(..5) {
                Some("data:") => image.name.clone().unwrap_or(place),
                _ => uri.rsplit('/').next().unwrap_or(uri).to_string(),
            };
            Ok((name, buffers::resolve(uri, folder, &document.meter)?.into()))
        }
        (None, Some(view)) => {
            let view = document.buffers.view(&document.root, view, &place)?;
            Ok((image.name.clone().unwrap_or(place), view.bytes.into()))
        }
        (None, None) => Err("neither uri nor bufferView".into()),
    }
}

fn reader(bytes: &[u8]) -> Result<ImageReader<Cursor<&[u8]>>, Fault> {
    match image::guess_format(bytes) {
        Ok(format @ (ImageFormat::Png | ImageFormat::Jpeg)) => {
            let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
            let mut limits = Limits::default();
            limits.max_image_width = Some(LONGEST_SIDE);
            limits.max_image_height = Some(LONGEST_SIDE);
            // Eight bytes a pixel: 16-bit PNG before it is narrowed.
            limits.max_alloc = Some(8 * u64::from(LONGEST_SIDE) * u64::from(LONGEST_SIDE));
            reader.limits(limits);
            Ok(reader)
        }
        _ => Err("neither PNG nor JPEG".into()),
    }
}

fn decode(name: &str, bytes: &[u8]) -> Result<Image, Fault> {
    let picture = reader(bytes)?.decode().map_err(|fault| fault.to_string())?.into_rgba8();
    let (width, height) = picture.dimensions();
    let rgba = picture.into_raw().chunks_exact(4).map(|p| [p[0], p[1], p[2], p[3]]).collect();
    Ok(Image { name: name.into(), width, height, rgba })
}
