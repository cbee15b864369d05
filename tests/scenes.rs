//! Does every real scene render, and every broken file end in one clear error? Needs the shared folder.

use crate::support::{frame_of, pipeline, shared};
use gridlight::RenderSettings;
use gridlight::settings::View;
use std::path::{Path, PathBuf};

/// Every `.gltf` or `.glb` directly in a folder of `scenes`, but for the broken ones.
fn scene_files(scenes: &Path) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = scenes
        .read_dir()
        .expect("the folder was found")
        .flatten()
        .filter(|entry| entry.path().is_dir() && entry.file_name() != "malformed")
        .flat_map(|entry| entry.path().read_dir().into_iter().flatten().flatten().map(|e| e.path()))
        .filter(|path| path.extension().is_some_and(|e| e == "gltf" || e == "glb"))
        .collect();
    files.sort();
    files
}

#[test]
fn every_real_scene_renders() {
    let Some(scenes) = shared("scenes") else { return };
    let files = scene_files(&scenes);
    assert_eq!(files.len(), 43, "scenes found in {}", scenes.display());
    let mut failed = Vec::new();
    for file in files {
        let text = std::fs::read(&file).expect("a readable file");
        // A room is dark from outside: where the file has a camera, it is used.
        let has_camera = text.windows(9).any(|word| word == b"\"cameras\"");
        let settings = RenderSettings {
            scene: file.display().to_string(),
            view: if has_camera { View::Camera(0) } else { View::Framing },
            trace_size: [160, 120],
            display_size: [160, 120],
            grid: 64,
            spp: 2,
            ..Default::default()
        };
        let mut pipeline = pipeline(&settings);
        let (picture, rendered) = frame_of(&mut pipeline);
        let strange = picture.texels().iter().flatten().filter(|v| !v.is_finite() || **v < 0.0).count();
        let lit = picture.texels().iter().filter(|p| p.iter().any(|v| *v > 1e-4)).count();
        let distances: Vec<f32> = pipeline.gpu().read_texture(&rendered.trace.distance).expect("a read-back");
        let seen = distances.into_iter().filter(|d| *d > 0.0).count();
        let cut = rendered.log.counts["cut_rays"];
        let name = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        println!("{name}: {} of 19200 pixels see it, {lit} lit", seen);
        if strange > 0 || cut > 0.0 || lit == 0 || seen < 100 {
            failed
                .push(format!("{name}: {strange} strange values, {cut} cut rays, {lit} lit, {} seen", seen));
        }
    }
    assert!(failed.is_empty(), "{}", failed.join("\n"));
}
