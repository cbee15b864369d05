//! Bytes: GLB chunks, data URIs, files beside the scene, and checked views into them.

use super::{Fault, item};
use crate::budget::Meter;
use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use gltf::json::{Index, Root, buffer};
use percent_encoding::percent_decode_str;
use std::path::{Component, Path, PathBuf};

/// Base64 with or without the padding that data URIs in the wild leave out.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new()
        .with_decode_padding_mode(DecodePaddingMode::Indifferent)
        .with_decode_allow_trailing_bits(true),
);

/// All buffers of a file; `None` where one has no bytes of its own (as extensions may).
pub(super) struct Buffers(Vec<Option<Vec<u8>>>);

/// A part of a buffer.
pub(super) struct View<'a> {
    /// Exactly its bytes.
    pub bytes: &'a [u8],
    /// Bytes from one element to the next, where the file says so.
    pub stride: Option<usize>,
}

impl Buffers {
    /// Loads every buffer; `binary` is the second chunk of a GLB.
    pub(super) fn read(
        root: &Root,
        binary: Option<&[u8]>,
        folder: &Path,
        meter: &Meter,
    ) -> Result<Self, Fault> {
        let mut buffers = Vec::with_capacity(root.buffers.len());
        for (i, buffer) in root.buffers.iter().enumerate() {
            let mut bytes = match (&buffer.uri, binary) {
                (Some(uri), _) => {
                    resolve(uri, folder, meter).map_err(|fault| format!("buffers[{i}]: {fault}"))?
                }
                (None, Some(binary)) if i == 0 => {
                    let taken = meter.take(binary.len() as u64, 1);
                    taken.map_err(|over| format!("buffers[{i}]: the binary chunk {over}"))?;
                    binary.to_vec()
                }
                (None, _) => {
                    buffers.push(None);
                    continue;
                }
            };
            let promised = buffer.byte_length.0;
            if (bytes.len() as u64) < promised {
                return Err(format!("buffers[{i}]: {promised} bytes promised, {} found", bytes.len()));
            }
            bytes.truncate(promised as usize);
            buffers.push(Some(bytes));
        }
        Ok(Self(buffers))
    }

    /// The bytes of a buffer view.
    pub(super) fn view(
        &self,
        root: &Root,
        index: Index<buffer::View>,
        asker: &str,
    ) -> Result<View<'_>, Fault> {
        let view = item(&root.buffer_views, index, "bufferViews", asker)?;
        let place = format!("bufferViews[{}]", index.value());
        item(&root.buffers, view.buffer, "buffers", &place)?;
        let b = view.buffer.value();
        let buffer = self.0.get(b).and_then(Option::as_ref).ok_or_else(|| {
            format!("{place}: buffers[{b}] has neither a URI nor the binary chunk of a GLB")
        })?;
        let (start, length) = (view.byte_offset.map_or(0, |o| o.0), view.byte_length.0);
        let bytes =
            start.checked_add(length).and_then(|end| buffer.get(start as usize..usize::try_from(end).ok()?));
        let bytes = bytes.ok_or_else(|| {
            format!("{place}: {length} bytes from byte {start} needed, buffers[{b}] has {}", buffer.len())
        })?;
        Ok(View { bytes, stride: view.byte_stride.map(|s| s.0) })
    }
}

/// JSON chunk and binary chunk of a GLB; further chunks are passed over, as the format asks.
pub(super) fn split_glb(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), Fault> {
    let word = |at: usize| {
        let four = bytes.get(at..at.checked_add(4)?)?;
        Some(u32::from_le_bytes([four[0], four[1], four[2], four[3]]))
    };
    let (Some(version), Some(length)) = (word(4), word(8)) else {
        return Err(format!("GLB header: 12 bytes needed, the file has {}", bytes.len()));
    };
    if version != 2 {
        return Err(format!("GLB version {version}: 2 is supported"));
    }
    let length = length as usize;
    if length > bytes.len() || length < 12 {
        return Err(format!("GLB header: length {length}, the file has {} bytes", bytes.len()));
    }
    let (mut json, mut binary, mut at) = (None, None, 12);
    while at + 8 <= length {
        let (size, kind) = (word(at).unwrap_or(0) as usize, bytes.get(at + 4..at + 8).unwrap_or_default());
        let Some(chunk) = bytes[..length].get(at + 8..).and_then(|rest| rest.get(..size)) else {
            return Err(format!("GLB chunk at byte {at}: {size} bytes needed, {} left", length - at - 8));
        };
        match (kind, json) {
            (b"JSON", None) => json = Some(chunk),
            (_, None) => return Err("GLB: the first chunk is not JSON".into()),
            (b"BIN\0", _) if binary.is_none() => binary = Some(chunk),
            _ => {}
        }
        at += 8 + size;
    }
    json.map(|json| (json, binary)).ok_or_else(|| "GLB: no JSON chunk".into())
}

/// What a URI stands for: the bytes of a data URI, or of a file in the scene's folder or below.
pub(super) fn resolve(uri: &str, folder: &Path, meter: &Meter) -> Result<Vec<u8>, Fault> {
    if let Some(data) = strip_scheme(uri) {
        let (head, body) = data.split_once(',').ok_or("data URI without a comma")?;
        meter.take(body.len() as u64, 1).map_err(|over| format!("data URI: {over}"))?;
        return if head.ends_with(";base64") {
            BASE64.decode(body).map_err(|fault| format!("data URI: {fault}"))
        } else {
            Ok(percent_decode_str(body).collect())
        };
    }
    let path = local_path(uri)?;
    meter.read(&folder.join(&path)).map_err(|fault| format!("\"{}\": {fault}", path.display()))
}

fn strip_scheme(uri: &str) -> Option<&str> {
    uri.get(..5).filter(|scheme| scheme.eq_ignore_ascii_case("data:")).map(|_| &uri[5..])
}

/// A relative URI as a path that stays in its folder.
fn local_path(uri: &str) -> Result<PathBuf, Fault> {
    // A name for messages: whole URIs can be megabytes.
    let shown: String = uri.chars().take(80).collect();
    let before_slash = uri.split(['/', '\\', '?', '#']).next().unwrap_or(uri);
    if before_slash.contains(':') {
        return Err(format!("\"{shown}\": only data URIs and files beside the scene are read"));
    }
    let path = percent_decode_str(uri).decode_utf8().map_err(|_| format!("\"{shown}\" is not UTF-8"))?;
    let mut depth = 0_i64;
    for component in Path::new(path.as_ref()).components() {
        depth += match component {
            Component::Normal(_) => 1,
            Component::CurDir => 0,
            Component::ParentDir => -1,
            // Further down the depth never recovers.
            Component::RootDir | Component::Prefix(_) => i64::from(i32::MIN),
        };
        if depth < 0 {
            return Err(format!("\"{shown}\" leads out of the scene's folder"));
        }
    }
    if depth == 0 || path.contains('\0') {
        return Err(format!("\"{shown}\" names no file"));
    }
    Ok(PathBuf::from(path.as_ref()))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::LoadBudget;

    #[test]
    fn uris_stay_in_the_folder() {
        for uri in [
            "http://a/b.bin",
            "file:///etc/passwd",
            "/etc/passwd",
            "../x.bin",
            "a/../../x",
            "%2e%2e/x",
            "C:\\x",
            "",
            ".",
            "a%00b",
        ] {
            assert!(local_path(uri).is_err(), "{uri}");
        }
        assert_eq!(local_path("a%20b/../c%C3%A9.bin").unwrap(), PathBuf::from("a b/../c\u{e9}.bin"));
    }

    #[test]
    fn data_uris_with_and_without_padding() {
        let meter = Meter::new(LoadBudget::default());
        for (uri, bytes) in [
            ("data:application/octet-stream;base64,AQI=", &[1, 2][..]),
            ("data:;base64,AQI", &[1, 2]),
            ("DATA:text/plain,a%20b", b"a b"),
        ] {
            assert_eq!(resolve(uri, Path::new(""), &meter).unwrap(), bytes, "{uri}");
        }
        assert!(resolve("data:;base64,$$", Path::new(""), &meter).is_err());
        assert!(resolve("data:", Path::new(""), &meter).is_err());
    }

    #[test]
    fn glb_chunks_are_checked() {
        let glb = |length: u32, chunks: &[(&[u8; 4], u32, &[u8])]| {
            let mut bytes = [b"glTF".as_slice(), &2_u32.to_le_bytes(), &length.to_le_bytes()].concat();
            for (kind, size, body) in chunks {
                bytes.extend([&size.to_le_bytes(), kind.as_slice(), body].concat());
            }
            bytes
        };
        let good = glb(36, &[(b"JSON", 4, b"{  }"), (b"BIN\0", 4, &[1, 2, 3, 4])]);
        assert_eq!(split_glb(&good).unwrap(), (b"{  }".as_slice(), Some([1, 2, 3, 4].as_slice())));
        assert!(split_glb(&good[..30]).is_err());
        assert!(split_glb(b"glTF").is_err());
        assert!(split_glb(&glb(5, &[])).is_err());
        assert!(split_glb(&glb(24, &[(b"JSON", u32::MAX, b"{  }")])).is_err());
        assert!(split_glb(&glb(24, &[(b"BIN\0", 4, b"{  }")])).is_err());
    }
}
