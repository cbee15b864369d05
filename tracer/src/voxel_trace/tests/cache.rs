//! Radiance kept in the voxels: what it costs, how right it is, how late, how quiet.

use super::fixture::{Fixture, Model, Traced, at, cells};
use super::twin::{fixture, room};
use crate::path::reference::Texel;
use crate::path::{PathBuild, PathSettings};
use crate::voxel_trace::reference::CpuVoxels;
use frame::cpu::Image;
use frame::surface::Surface;
use glam::Vec3;
use scene::Sky;

fn cached(spp: u32) -> PathSettings {
    let build = PathBuild { cache: true, ..PathBuild::default() };
    PathSettings { spp, build, ..PathSettings::default() }
}

/// A closed room whose lamp is the only light.
fn lit(contours: u32) -> (Fixture, CpuVoxels, Image<Texel>) {
    let mut fixture = fixture(Sky::Constant(Vec3::ZERO), None, &[]);
    fixture.frame.trace_size = [48, 32];
    let mut voxels = room().build();
    voxels.grid.grid.contours = contours;
    let texels = fixture.gbuffer(&voxels);
    (fixture, voxels, texels)
}

/// A small one, nothing in it: nearly all of its voxels are renewed in each frame.
fn small() -> (Fixture, CpuVoxels, Image<Texel>) {
    let (eye, target) = (at(9.0, 7.0, 10.5), at(5.0, 3.0, 3.0));
    let fixture = Fixture::new(Sky::Constant(Vec3::ZERO), None, &[], eye, target);
    let mut model = Model::new(12);
    model.room(|_| Surface { base: Vec3::splat(0.6), ..Surface::default() });
    let lamp = Surface { normal: Vec3::NEG_Y, emission: Vec3::splat(8.0), ..Surface::default() };
    for cell in cells([4, 11, 4], [8, 12, 8]) {
        model.set(cell, &lamp);
    }
    let voxels = model.build();
    let texels = fixture.gbuffer(&voxels);
    (fixture, voxels, texels)
}

/// The same with the lamp's light times `factor`: places and numbers of the records stay.
fn dimmed(voxels: &CpuVoxels, factor: f32) -> CpuVoxels {
    let mut voxels = voxels.clone();
    for record in &mut voxels.records {
        let surface = Surface::unpack_voxel(*record);
        if surface.emission != Vec3::ZERO {
            record[2] = Surface { emission: surface.emission * factor, ..surface }.pack_voxel(0)[2];
        }
    }
    voxels
}

fn next(fixture: &mut Fixture, voxels: &CpuVoxels, texels: &Image<Texel>, settings: &PathSettings) -> Traced {
    let traced = fixture.traced(voxels, texels, settings);
    fixture.frame.frame_index += 1;
    fixture.frame.restart = false;
    traced
}

/// Mean of the diffuse lobe over frames, and its standard error.
fn mean(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (count - 1.0);
    (mean, (variance / count).sqrt())
}

/// Slow value and number of samples of every side, as luminance's stand-in its green.
fn kept(fixture: &Fixture) -> Vec<[f32; 2]> {
    let cache = fixture.cache.borrow();
    let words: Vec<u32> = fixture.gpu.read_buffer(&cache.as_ref().unwrap().entries).unwrap();
    let half =
        |word: u32, high: bool| half::f16::from_bits((word >> if high { 16 } else { 0 }) as u16).to_f32();
    let samples = |word: u32| (word >> 16 & 0xff) as f32;
    let side = |entry: &[u32], side: usize| [half(entry[4 * side], true), samples(entry[4 * side + 3])];
    let regions = 8 * 4096;
    words[..words.len() - regions]
        .chunks_exact(10)
        .flat_map(|entry| [side(entry, 0), side(entry, 1)])
        .collect()
}

#[test]
fn it_has_all_bounces_and_costs_a_quarter_of_the_rays_at_most() {
    for contours in [0, 1] {
        all_bounces(contours);
    }
}

fn all_bounces(contours: u32) {
    let (mut fixture, voxels, texels) = lit(contours);
    let explicit = PathSettings { spp: 4, bounces: None, ..PathSettings::default() };
    let truth: Vec<f64> =
        (0..24).map(|_| next(&mut fixture, &voxels, &texels, &explicit).mean(0).0).collect();
    fixture.frame.frame_index = 0;
    fixture.frame.restart = true;
    let mut found = Vec::new();
    for frame in 0..48 {
        let traced = next(&mut fixture, &voxels, &texels, &cached(4));
        let share = traced.log.counts["cache_rays"] / traced.log.counts["rays"];
        assert!(share > 0.02 && share <= 0.25, "frame {frame}: {share} of the rays renew voxels");
        if frame >= 24 {
            found.push(traced.mean(0).0);
        }
    }
    let ((found, error), (truth, truth_error)) = (mean(&found), mean(&truth));
    println!(
        "contours {contours}: cached {found} +- {error}, explicit {truth} +- {truth_error}: {:+.2} %",
        100.0 * (found / truth - 1.0)
    );
    // The bias that is allowed, and three standard errors.
    assert!(
        (found / truth - 1.0).abs() < 0.02 + 3.0 * error.hypot(truth_error) / truth,
        "{found} for {truth}"
    );
}

#[test]
fn the_first_frame_alone_is_unbiased() {
    let (mut fixture, voxels, texels) = lit(0);
    let explicit = PathSettings { spp: 8, bounces: None, ..PathSettings::default() };
    let truth: Vec<f64> = (0..8).map(|_| next(&mut fixture, &voxels, &texels, &explicit).mean(0).0).collect();
    let first = |seed: u32| {
        let (mut fixture, voxels, texels) = lit(0);
        fixture.frame.seed = seed;
        next(&mut fixture, &voxels, &texels, &cached(8)).mean(0).0
    };
    let found: Vec<f64> = (1..5).map(first).collect();
    let ((found, error), (truth, truth_error)) = (mean(&found), mean(&truth));
    println!("first frame {found} +- {error}, explicit {truth} +- {truth_error}");
    assert!(
        (found / truth - 1.0).abs() < 0.02 + 3.0 * error.hypot(truth_error) / truth,
        "{found} for {truth}"
    );
}

#[test]
fn a_lamp_that_changes_shows_at_once_and_one_that_does_not_is_quiet() {
    let (mut fixture, bright, texels) = small();
    let dark = dimmed(&bright, 0.25);
    for _ in 0..60 {
        next(&mut fixture, &bright, &texels, &cached(4));
    }
    // Steady: the value of each side that is renewed in most frames, over frames that are apart.
    let mut history = Vec::new();
    for _ in 0..12 {
        for _ in 0..4 {
            next(&mut fixture, &bright, &texels, &cached(4));
        }
        history.push(kept(&fixture));
    }
    let sides: Vec<usize> =
        (0..history[0].len()).filter(|i| history.iter().all(|h| h[*i][1] >= 4.0)).collect();
    let deviations: Vec<f64> = sides
        .iter()
        .map(|i| {
            let values: Vec<f64> = history.iter().map(|h| f64::from(h[*i][0])).collect();
            let (mean, error) = mean(&values);
            error * (values.len() as f64).sqrt() / mean.max(1e-6)
        })
        .collect();
    let quiet = deviations.iter().sum::<f64>() / deviations.len() as f64;
    println!("{} sides, relative deviation {quiet:.3}", sides.len());
    assert!(sides.len() > 100 && quiet < 0.1, "{quiet} over {} sides", sides.len());

    // A step down to a quarter: each side's own mean before it is four times the one after it.
    let before: Vec<f64> =
        sides.iter().map(|i| history.iter().map(|h| f64::from(h[*i][0])).sum::<f64>() / 12.0).collect();
    let mut states = vec![kept(&fixture)];
    for _ in 0..30 {
        next(&mut fixture, &dark, &texels, &cached(4));
        states.push(kept(&fixture));
    }
    // Those that are hit, and renewed, nearly each frame.
    let renewed = |i: &usize| states.windows(2).filter(|w| w[0][*i] != w[1][*i]).count();
    let hit: Vec<(usize, f64)> =
        sides.iter().copied().zip(before).filter(|(i, before)| renewed(i) >= 24 && *before > 0.0).collect();
    let gone = |state: &[[f32; 2]]| {
        let share = |(i, before): &(usize, f64)| (before - f64::from(state[*i][0])) / (0.75 * before);
        hit.iter().map(share).sum::<f64>() / hit.len() as f64
    };
    for frame in [5, 10, 15, 20, 25, 30] {
        println!(
            "{frame} frames after the step: {:.1} % of it, {} sides",
            100.0 * gone(&states[frame]),
            hit.len()
        );
    }
    assert!(
        hit.len() > 20 && gone(&states[30]) > 0.9,
        "{:.3} of the step after 30 frames",
        gone(&states[30])
    );
}

#[test]
fn a_sequence_has_the_same_bits_each_time() {
    let run = || {
        let (mut fixture, voxels, texels) = lit(0);
        (0..4).map(|_| next(&mut fixture, &voxels, &texels, &cached(2)).bits).collect::<Vec<_>>()
    };
    assert!(run() == run());
}
