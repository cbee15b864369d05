//! glTF 2.0 files: `.gltf` with its buffers and pictures, and `.glb`.
//!
//! A file comes from outside, so nothing in it is trusted: the JSON is taken as plain numbers (`gltf::json`), and
//! every index, count, offset and string is checked where it is used. A refusal names the place and both values; a
//! feature that is left out is a line in [`Scene::warnings`].

mod accessors;
mod animations;
mod assemble;
mod buffers;
mod extensions;
mod images;
mod materials;
mod meshes;
mod nodes;
mod spec_gloss;
mod tangents;
#[cfg(test)]
mod tests;

use crate::budget::Meter;
use crate::{LoadBudget, Scene, SceneError, built_in};
use accessors::Accessors;
use buffers::Buffers;
use gltf::json::validation::Checked;
use gltf::json::{Index, Root};
use std::path::Path;

/// What is wrong and where in the file; the path is added at the door.
type Fault = String;

/// The parsed JSON, its buffers, and what was left out.
struct Document {
    root: Root,
    buffers: Buffers,
    /// What all of it takes.
    meter: Meter,
    warnings: Vec<String>,
}

impl Document {
    fn accessors(&self) -> Accessors<'_> {
        Accessors { root: &self.root, buffers: &self.buffers, meter: &self.meter }
    }
}

/// Reads a scene; the extension of the name decides whether it is one, the content which of the two kinds.
pub(crate) fn load(path: &Path, budget: LoadBudget) -> Result<Scene, SceneError> {
    let extension = path.extension().map(|e| e.to_ascii_lowercase());
    if !extension.is_some_and(|e| e == "gltf" || e == "glb") {
        return Err(SceneError::NoSuchScene {
            name: path.display().to_string(),
            known: built_in::all().iter().map(|b| b.0).collect::<Vec<_>>().join(", "),
        });
    }
    let fail = |message| SceneError::File { path: path.into(), message };
    let meter = Meter::new(budget);
    let bytes = meter.read(path).map_err(fail)?;
    scene(path, &bytes, meter).map_err(fail)
}

/// The same for content that is there already.
pub(crate) fn load_bytes(path: &Path, bytes: &[u8], budget: LoadBudget) -> Result<Scene, SceneError> {
    scene(path, bytes, Meter::new(budget)).map_err(|message| SceneError::File { path: path.into(), message })
}

fn scene(path: &Path, bytes: &[u8], meter: Meter) -> Result<Scene, Fault> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut document = open(bytes, folder, meter)?;
    let name = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    let (materials, pictures) = materials::read(&mut document)?;
    let images = images::read(&document, &pictures, folder)?;
    assemble::scene(name, document, materials, images)
}

/// Parses, decides about version and extensions, and loads the buffers.
fn open(bytes: &[u8], folder: &Path, meter: Meter) -> Result<Document, Fault> {
    let (json, binary) = if bytes.starts_with(b"glTF") { buffers::split_glb(bytes)? } else { (bytes, None) };
    let json = json.strip_prefix(b"\xef\xbb\xbf").unwrap_or(json);
    let mut warnings = Vec::new();
    match json.trim_ascii_start().first() {
        Some(b'{') => {}
        Some(byte) => return Err(format!("neither a GLB nor JSON: it begins with the byte 0x{byte:02x}")),
        None => return Err("no JSON: it is empty".into()),
    }
    extensions::afford(json, &meter)?;
    let root = extensions::parse(json, &mut warnings)?;
    let version = &root.asset.version;
    if !version.starts_with("2.") || root.asset.min_version.as_ref().is_some_and(|least| least != "2.0") {
        let least = root.asset.min_version.as_deref().unwrap_or("none");
        return Err(format!("asset.version \"{version}\", minVersion {least}: 2.0 is supported"));
    }
    extensions::check(&root, &mut warnings)?;
    let buffers = Buffers::read(&root, binary, folder, &meter)?;
    Ok(Document { root, buffers, meter, warnings })
}

/// The element that `asker` points to.
fn item<'a, T>(list: &'a [T], index: Index<T>, name: &str, asker: &str) -> Result<&'a T, Fault> {
    let i = index.value();
    list.get(i).ok_or_else(|| format!("{asker}: {name}[{i}] is not there, the file has {}", list.len()))
}

/// A value of a closed set, or where it is wrong.
fn valid<T: Copy>(value: &Checked<T>, place: &str) -> Result<T, Fault> {
    match value {
        Checked::Valid(value) => Ok(*value),
        Checked::Invalid => Err(format!("{place}: not one of the values glTF knows")),
    }
}
