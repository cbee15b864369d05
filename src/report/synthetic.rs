//! Made-up rows and pictures with known numbers, for the tests of this folder.

use super::{Errors, Facts, Picture, Reference, ReferenceInfo, Report, Row, Shard, StageTimes, Timing};
use crate::defects::Defects;
use crate::race::{Entrant, Heat, RayRace};
use std::path::{Path, PathBuf};

/// A row that was neither timed nor measured.
pub fn row(tracer: &str, denoiser: &str, spp: u32, reference: Reference) -> Row {
    Row {
        scene: "cornell".into(),
        tracer: tracer.into(),
        denoiser: denoiser.into(),
        upsampler: "best_candidate".into(),
        spp,
        grid: tracer.starts_with("voxel").then_some(256),
        reference,
        ..Row::default()
    }
}

/// A row with a time and an error.
pub fn measured_row(
    tracer: &str,
    denoiser: &str,
    spp: u32,
    reference: Reference,
    total_ms: f64,
    rel_mse: f64,
) -> Row {
    let timing = |ms: f64| Some(Timing { median: ms, p95: 1.1 * ms, spread: 0.05 * ms });
    Row {
        errors: Errors {
            rmse: Some(0.5 * rel_mse.sqrt()),
            rel_mse: Some(rel_mse),
            bias: Some([1.0, 0.99, 1.0 / 3.0]),
            nan_count: Some(0),
            ..Errors::default()
        },
        stages_ms: StageTimes {
            trace: timing(0.7 * total_ms),
            denoise: timing(0.3 * total_ms),
            ..Default::default()
        },
        total_ms: timing(total_ms),
        bytes: Some(12_345_678),
        memory_bytes: [("voxels".to_owned(), 345_678), ("gbuffer".to_owned(), 12_000_000)].into(),
        ..row(tracer, denoiser, spp, reference)
    }
}

/// Converged voxels this far from triangles.
pub fn voxel_reference(grid: u32, gap_rmse: f64) -> ReferenceInfo {
    ReferenceInfo {
        kind: Reference::Voxel,
        grid: Some(grid),
        spp: 1024,
        noise_rel_mse: Some(1e-5),
        gap_rmse: Some(gap_rmse),
        file: "reference_voxel_256.png".into(),
    }
}

/// Voxels that are 2.5 times as fast as one rival and 6 times as fast as the other.
pub fn race() -> RayRace {
    let heat = |mrays_per_s: f64, hit_share| Heat {
        rays: 76_800,
        entrants: [("voxel", 1.0), ("bvh_cwbvh", 2.5), ("bvh_lbvh", 6.0)]
            .map(|(structure, times)| Entrant {
                structure: structure.into(),
                mrays_per_s: Some(mrays_per_s / times),
                voxels_times_as_fast: Some(times),
                visits_per_ray: 17.0,
                hit_share,
            })
            .into(),
    };
    RayRace { grid: 256, primary: heat(1.0, 0.98), secondary: heat(0.9, 0.97) }
}

/// Of a grid.
pub fn defects(grid: u32) -> Defects {
    Defects {
        grid,
        leaked: [0.04, 0.01, 0.0],
        silhouette_error: 0.02,
        brightness: [0.98, 0.99],
        missed_per_million: 120.0,
        flicker_voxels: 0.2,
    }
}

/// Two tracers, two denoisers, three sample counts, both references; no files.
pub fn report(scene: &str) -> Report {
    share(scene, Shard::default())
}

/// The part of [`report`] that a shard measures.
fn share(scene: &str, shard: Shard) -> Report {
    let mut rows = Vec::new();
    let mut pictures = Vec::new();
    for (k, (tracer, denoiser, spp)) in configurations().filter(|(k, _)| shard.takes(*k)) {
        let ms = f64::from(spp) * if tracer == "voxel" { 3.0 } else { 7.0 };
        let error = (if denoiser == "identity" { 0.5 } else { 0.05 }) / f64::from(spp);
        let file = format!("images/{k}.png");
        for (reference, error) in [(Reference::Bvh, error + 0.002), (Reference::Voxel, error)] {
            let mut row = measured_row(tracer, denoiser, spp, reference, ms, error);
            row.scene = scene.into();
            row.image = Some(file.clone());
            row.knobs.extend((denoiser != "identity").then(|| ("svgf.steps".to_owned(), "4".to_owned())));
            rows.push(row);
        }
        let id = rows.last().map(Row::configuration).unwrap_or_default();
        pictures.push(Picture { id, reference: false, file, heat: None });
    }
    let triangles = ReferenceInfo {
        kind: Reference::Bvh,
        grid: None,
        gap_rmse: None,
        file: "reference_bvh.png".into(),
        ..voxel_reference(256, 0.0)
    };
    let references = vec![voxel_reference(256, 0.04), triangles];
    pictures.extend(references.iter().map(|r| Picture {
        id: format!("reference {}", r.kind),
        reference: true,
        file: r.file.clone(),
        heat: None,
    }));
    let facts = Facts {
        commands: vec!["gridlight compare cornell --spp 1,4,16".into()],
        adapter: "made up".into(),
        scene: scene.into(),
        trace_size: [640, 480],
        display_size: [1920, 1080],
    };
    Report::new(facts, references, rows, pictures)
}

fn configurations() -> impl Iterator<Item = (usize, (&'static str, &'static str, u32))> {
    let tracers = ["voxel", "bvh_cwbvh"].into_iter();
    tracers
        .flat_map(|tracer| ["identity", "svgf"].map(|denoiser| (tracer, denoiser)))
        .flat_map(|(tracer, denoiser)| [1, 4, 16].map(|spp| (tracer, denoiser, spp)))
        .enumerate()
}

/// Writes a shard of the report with its pictures, each of its own grey.
pub fn write_share(folder: &Path, shard: Shard) {
    let report = share("cornell", shard);
    std::fs::create_dir_all(folder.join("images")).expect("a scratch folder can be made");
    for picture in &report.pictures {
        let grey = picture.file.bytes().fold(0u8, u8::wrapping_add);
        let image = image::RgbImage::from_pixel(4, 3, image::Rgb([grey; 3]));
        image.save(folder.join(&picture.file)).expect("a scratch picture can be written");
    }
    report.write(folder).expect("a scratch report can be written");
}

/// A folder of one test, not there yet, gone when dropped.
pub struct Scratch(PathBuf);

impl Scratch {
    /// Of a name that no other test has.
    pub fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("gridlight-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&path);
        Self(path)
    }

    /// Where.
    pub fn path(&self) -> &Path {
        &self.0
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}
