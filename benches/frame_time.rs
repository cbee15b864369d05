//! Whole frames: voxels against the triangle tracers as the paper raced them and fairly, and what motion costs.

use crate::clock::GpuTime;
use crate::street::{Street, View};
use crate::{bench, group};
use criterion::Criterion;
use frame::Gpu;
use gridlight::RenderSettings;
use gridlight::settings::Preset;
use gridlight::stages::Kind;

/// Shares of the connected parts that circle; 1 updates everything.
const SHARES: [f32; 3] = [0.01, 0.1, 1.0];

/// `frame/fair/voxel/…`: all with the same denoiser and upsampler; `frame/paper/…`: the rivals without, as the paper
/// paired them. Static: structures stand.
pub fn paper(criterion: &mut Criterion<GpuTime>, gpu: &Gpu, view: &View) {
    let mut street = None;
    let mut group = group(criterion, "frame");
    for pairing in ["fair", "paper"] {
        for tracer in Kind::Tracer.ids() {
            let mut settings =
                RenderSettings { preset: Preset::Paper, tracer: tracer.into(), ..view.settings.clone() };
            if pairing == "paper" && tracer != "voxel" {
                settings.denoiser = "identity".into();
                settings.upsampler = "nearest".into();
            }
            let name = format!("{pairing}/{tracer}/{}", view.path(&settings));
            bench(&mut group, &name, gpu, &mut street, &settings, |_| true);
        }
    }
    group.finish();
}

/// `update/0.1/voxel/…`: the passes that bring a structure up to date, as more of the scene moves: voxels rebuilt where
/// something moved against BVHs refitted or rebuilt.
pub fn moving(criterion: &mut Criterion<GpuTime>, gpu: &Gpu, view: &View) {
    let mut group = group(criterion, "update");
    for share in SHARES {
        let mut street = None;
        for tracer in Kind::Tracer.ids() {
            let settings =
                RenderSettings { moving_share: Some(share), tracer: tracer.into(), ..view.settings.clone() };
            let name = format!("{share}/{tracer}/{}", view.path(&settings));
            bench(&mut group, &name, gpu, &mut street, &settings, |pass| {
                pass.starts_with("voxel/") || pass.starts_with("bvh/")
            });
        }
    }
    group.finish();
}

/// `wall/frame/voxel/…`: all that can be said on an adapter without a clock.
pub fn wall(criterion: &mut Criterion<GpuTime>, gpu: &Gpu, view: &View) {
    let mut group = group(criterion, "wall/frame");
    for tracer in Kind::Tracer.ids() {
        let settings = RenderSettings { tracer: tracer.into(), ..view.settings.clone() };
        let mut street = None;
        group.bench_function(format!("{tracer}/{}", view.path(&settings)), |bencher| {
            let street = street.get_or_insert_with(|| Street::new(gpu, &settings));
            bencher.iter_custom(|frames| street.wall_ns(frames));
        });
    }
    group.finish();
}
