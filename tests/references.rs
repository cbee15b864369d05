//! Do converged images converge to the truth, know how far they got, and go on where they stopped?

use crate::support::{Picture, Scratch, mean, pipeline, reference};
use gridlight::RenderSettings;
use gridlight::metrics::excess_rel_mse;
use gridlight::pipeline::Pipeline;
use gridlight::reference::{Goal, Reference, run};
use gridlight::settings::{Emit, Preset, SunSetting, View};
use std::collections::BTreeMap;
use std::path::Path;
use tracer::Search;

fn cornell(size: u32, bounces: u32) -> RenderSettings {
    RenderSettings {
        scene: "cornell".into(),
        view: View::Camera(0),
        trace_size: [size; 2],
        display_size: [size; 2],
        grid: 64,
        denoiser: "identity".into(),
        upsampler: "nearest".into(),
        preset: Preset::Gltf,
        bounces: Some(bounces),
        ..Default::default()
    }
}

fn samples(spp: u32) -> Goal {
    Goal { spp, within: None, until: None }
}

/// Converges in a folder of its own, which is gone afterwards.
fn converge(pipeline: &mut Pipeline, search: Search, spp: u32, name: &str) -> Reference {
    let scratch = Scratch::new(name);
    let found = run(pipeline, search, samples(spp), scratch.path()).unwrap_or_else(|e| panic!("{name}: {e}"));
    assert_eq!((found.summary.spp, found.summary.strange), (u64::from(spp), 0), "{name}");
    found
}

/// Standard error of each channel's mean; pixels are independent.
fn error_of_mean(standard_error: &Picture) -> [f64; 3] {
    let count = standard_error.texels().len() as f64;
    [0, 1, 2]
        .map(|c| standard_error.texels().iter().map(|s| f64::from(s[c]).powi(2)).sum::<f64>().sqrt() / count)
}

/// Values of two pictures and their standard errors, per pixel and channel: `[a, s_a, b, s_b]`.
fn paired(a: [&Picture; 2], b: [&Picture; 2]) -> Vec<[f64; 4]> {
    let [a, s_a, b, s_b] = [a[0], a[1], b[0], b[1]].map(|picture| picture.texels().as_flattened());
    (0..a.len()).map(|k| [a[k], s_a[k], b[k], s_b[k]].map(f64::from)).collect()
}

/// Every file of a folder.
fn contents(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = std::fs::read_dir(folder).unwrap().map(Result::unwrap);
    entries.map(|e| (e.file_name().into_string().unwrap(), std::fs::read(e.path()).unwrap())).collect()
}

#[test]
fn triangles_converge_to_another_renderers_image() {
    let mut pipeline = pipeline(&cornell(64, 1));
    for (bounces, name) in [(1, "cornell_64_b1"), (4, "cornell_64_b4")] {
        let (expected, expected_error) = reference(name);
        pipeline.change(&cornell(64, bounces)).unwrap();
        let found = converge(&mut pipeline, Search::Cwbvh, 128, name);
        let [ours, theirs] = [&found.mean, &expected].map(mean);
        let [s_ours, s_theirs] = [&found.standard_error, &expected_error].map(error_of_mean);
        for c in 0..3 {
            let off = (ours[c] - theirs[c]).abs();
            // Two standard errors of both, and 0.2 % for what two renderers may round differently.
            let allowed = 0.002 * theirs[c] + 2.0 * s_ours[c].hypot(s_theirs[c]);
            println!(
                "{name}, channel {c}: off by {:.3} %, allowed {:.3} %",
                100.0 * off / theirs[c],
                100.0 * allowed / theirs[c]
            );
            assert!(off <= allowed, "{name}, channel {c}: the mean is {}, theirs {}", ours[c], theirs[c]);
        }

        let pairs = paired([&found.mean, &found.standard_error], [&expected, &expected_error]);
        let excess = excess_rel_mse(&expected, &found.mean, &expected_error, &found.standard_error).unwrap();
        // A squared difference of variance v scatters by sqrt(2) v about v. The channels of a pixel share their paths
        // and scatter as one; pixels are independent. Three such standard errors.
        let scatter = |pixel: &[[f64; 4]]| {
            let each = pixel.iter().map(|[_, s, r, s_r]| (s * s + s_r * s_r) / (r * r + 0.01));
            (2f64.sqrt() * each.sum::<f64>()).powi(2)
        };
        let own = pairs.chunks_exact(3).map(scatter).sum::<f64>().sqrt() / pairs.len() as f64;
        println!("{name}: excess relMSE {excess:.2e}, its own noise {own:.1e}");
        assert!(excess <= 1e-4 + 3.0 * own, "{name}: excess relMSE {excess}, its own noise {own}");

        let near = pairs.iter().filter(|[a, s_a, r, s_r]| (a - r).abs() <= 3.0 * s_a.hypot(*s_r) + 0.01 * r);
        let share = near.count() as f64 / pairs.len() as f64;
        println!("{name}: {:.2} % within three standard errors and 1 %", 100.0 * share);
        // 99.7 % of normal errors are; those of few samples have longer tails.
        assert!(share >= 0.97, "{name}: only {:.2} % of the pixels agree", 100.0 * share);
    }
}

#[test]
fn voxels_converge_to_the_truth_as_they_shrink() {
    let (expected, _) = reference("cornell_64_b4");
    let theirs = mean(&expected);
    let mut pipeline = pipeline(&cornell(64, 4));
    let mut off = |grid| {
        pipeline.change(&RenderSettings { grid, ..cornell(64, 4) }).unwrap();
        let ours = mean(&converge(&mut pipeline, Search::Grid, 32, &format!("voxels-{grid}")).mean);
        let off = (0..3).map(|c| (ours[c] / theirs[c] - 1.0).abs()).fold(0.0, f64::max);
        println!("grid {grid}: a channel's mean is off by {:.2} %", 100.0 * off);
        off
    };
    let (coarse, fine) = (off(64), off(256));
    assert!(fine < coarse, "a finer grid is no better: {fine} after {coarse}");
    // What voxels may cost in this scene: the project's own bound for 256 cells.
    assert!(fine < 0.05, "a channel's mean is off by {:.1} %", 100.0 * fine);
}

#[test]
fn both_bvhs_give_the_same_bits() {
    let mut pipeline = pipeline(&cornell(32, 4));
    let [a, b] = [(Search::Lbvh, "lbvh"), (Search::Cwbvh, "cwbvh")]
        .map(|(search, name)| converge(&mut pipeline, search, 8, name));
    assert_eq!(a.mean.texels(), b.mean.texels());
    assert_eq!(a.standard_error.texels(), b.standard_error.texels());
}

#[test]
fn a_run_goes_on_to_the_same_bits_and_is_left_alone_when_it_is_done() {
    let [parts, whole] = ["parts", "whole"].map(Scratch::new);
    // As two invocations would: nothing is shared but the folder.
    let [mut first, mut second] = [0, 1].map(|_| pipeline(&cornell(32, 4)));
    let go = |pipeline: &mut Pipeline, spp, scratch: &Scratch| {
        run(pipeline, Search::Cwbvh, samples(spp), scratch.path()).unwrap()
    };
    go(&mut first, 8, &parts);
    let eight = contents(parts.path());
    let resumed = go(&mut second, 16, &parts);
    assert_eq!((resumed.summary.resumed_spp, resumed.summary.spp), (8, 16));
    let at_once = go(&mut first, 16, &whole);
    assert_eq!((at_once.summary.resumed_spp, at_once.summary.spp), (0, 16));
    assert_eq!(parts.files(), ["log.json", "reference.exr", "reference.state", "stderr.exr"]);
    let [ours, theirs] = [&parts, &whole].map(|scratch| contents(scratch.path()));
    for file in ["reference.exr", "stderr.exr", "reference.state"] {
        assert!(ours[file] == theirs[file], "{file} of the resumed run is another");
        assert!(ours[file] != eight[file], "{file} did not change from 8 samples to 16");
    }
    assert_eq!(resumed.mean.texels(), at_once.mean.texels());

    let again = go(&mut second, 16, &parts);
    assert_eq!((again.summary.resumed_spp, again.summary.spp), (16, 16));
    assert_eq!(again.mean.texels(), at_once.mean.texels());
    assert!(contents(parts.path()) == ours, "a run that had reached its goal changed a file");
}

#[test]
fn a_folder_of_another_run_is_refused_and_kept() {
    let scratch = Scratch::new("another");
    let own = cornell(16, 3);
    let mut pipeline = pipeline(&own);
    run(&mut pipeline, Search::Grid, samples(4), scratch.path()).unwrap();
    let before = contents(scratch.path());
    let mut refused = |settings: &RenderSettings, search, parts: &[&str]| {
        pipeline.change(settings).unwrap();
        let message = run(&mut pipeline, search, samples(8), scratch.path()).unwrap_err().to_string();
        for part in parts.iter().chain(&["reference.state"]) {
            assert!(message.contains(part), "\"{part}\" is not in: {message}");
        }
        message
    };
    refused(&RenderSettings { grid: 32, ..own.clone() }, Search::Grid, &["grid: 64 there, 32 now"]);
    refused(&RenderSettings { bounces: Some(2), ..own.clone() }, Search::Grid, &["bounces: 3 there, 2 now"]);
    refused(
        &RenderSettings { bounces: None, ..own.clone() },
        Search::Grid,
        &["bounces: 3 there, \"inf\" now"],
    );
    let message =
        refused(&RenderSettings { seed: 7, ..own.clone() }, Search::Grid, &["seed: 1 there, 7 now"]);
    assert!(!message.contains("grid:"), "what is the same is not named: {message}");
    refused(&own, Search::Cwbvh, &["structure: \"voxel\" there, \"bvh\" now"]);
    assert!(contents(scratch.path()) == before, "a refusal changed a file");

    let state = scratch.path().join("reference.state");
    let whole = &before["reference.state"];
    let mut flipped = whole.clone();
    // Among the sums.
    flipped[whole.len() - 1000] ^= 4;
    for (what, broken) in [("flipped", &flipped[..]), ("cut", &whole[..whole.len() - 1000]), ("empty", &[])] {
        std::fs::write(&state, broken).unwrap();
        let broken = contents(scratch.path());
        refused(&own, Search::Grid, &["broken", "delete it"]);
        assert!(contents(scratch.path()) == broken, "{what}: a refusal changed a file");
    }
}

/// Mean of `(a - b)^2 / (s_a^2 + s_b^2)` over two seeds' pixel-channels that have an error of note.
fn ratio_of_squares(settings: &RenderSettings, spp: u32, name: &str) -> f64 {
    let mut pipeline = pipeline(settings);
    let [a, b] = [1, 2].map(|seed| {
        pipeline.change(&RenderSettings { seed, ..settings.clone() }).unwrap();
        converge(&mut pipeline, Search::Cwbvh, spp, &format!("{name}-{seed}"))
    });
    let pairs = paired([&a.mean, &a.standard_error], [&b.mean, &b.standard_error]);
    let mut ratios = Vec::new();
    for [a, s_a, b, s_b] in pairs {
        // Where all samples are the same (a pixel full of the lamp), what is left is the rounding of f32 sums.
        match s_a.hypot(s_b) > 1e-4 * a {
            true => ratios.push((a - b).powi(2) / (s_a * s_a + s_b * s_b)),
            false => assert!((a - b).abs() <= 1e-3 * a, "{name}: {a} and {b} in a pixel without error"),
        }
    }
    let ratio = ratios.iter().sum::<f64>() / ratios.len() as f64;
    println!(
        "{name}: squared differences are {ratio:.3} of what the errors say, {} pixel-channels",
        ratios.len()
    );
    assert!(ratios.len() > 3 * 2000, "{name}: {} pixel-channels are too few", ratios.len());
    ratio
}

/// What the ratio is in theory: 1, and more for errors that are themselves estimates from few batches, n / (n - 2) with n
/// degrees of freedom: of two images of 64 samples, in 18 batches each, 34. The square of a normal number scatters by
/// sqrt(2): with 2,000 pixels or more, whose channels move together, by 3 %, of which four.
const HONEST: std::ops::RangeInclusive<f64> = 34.0 / 32.0 - 0.12..=34.0 / 32.0 + 0.12;

#[test]
fn the_standard_error_of_independent_samples_is_what_two_runs_differ_by() {
    // One light sample of a wide sun, no lamp, no second bounce: nothing that is stratified takes part.
    let settings = RenderSettings {
        emit: vec![Emit { material: "light".into(), radiance: [0.0; 3] }],
        sun: Some(SunSetting { direction: [-0.4, -0.6, -1.0], irradiance: [3.0; 3] }),
        sun_angle: Some(1.0),
        ..cornell(64, 1)
    };
    let ratio = ratio_of_squares(&settings, 64, "sunlit");
    assert!(HONEST.contains(&ratio), "{ratio} is not in {HONEST:?}");
}

#[test]
fn the_standard_error_of_stratified_samples_is_what_two_runs_differ_by() {
    // The first direction is stratified over the samples of a batch, which the spread of single samples would not show.
    let ratio = ratio_of_squares(&cornell(64, 4), 64, "lamplit");
    assert!(HONEST.contains(&ratio), "{ratio} is not in {HONEST:?}");
}

#[test]
fn a_closed_room_has_the_radiance_of_the_closed_form() {
    let settings = RenderSettings { scene: "furnace".into(), bounces: None, ..cornell(32, 0) };
    let mut pipeline = pipeline(&settings);
    for search in [Search::Cwbvh, Search::Grid] {
        let name = format!("furnace-{search:?}");
        let found = converge(&mut pipeline, search, 64, &name);
        let [mean, error] = [mean(&found.mean), error_of_mean(&found.standard_error)];
        println!("{name}: {mean:?} +- {error:?}");
        for c in 0..3 {
            // e / (1 - a) with a = e = 1/2; nothing is quantised but f32 sums.
            assert!(
                (mean[c] - 1.0).abs() <= 3.0 * error[c] + 1e-6,
                "{name}: the mean is {} +- {}",
                mean[c],
                error[c]
            );
        }
        let each =
            found.mean.texels().as_flattened().iter().zip(found.standard_error.texels().as_flattened());
        for (value, error) in each {
            // Errors from 17 degrees of freedom: one in 3 million is eight of them off, and there are a thousand pixels.
            assert!((value - 1.0).abs() <= 8.0 * error + 1e-6, "{name}: a pixel is {value} +- {error}");
        }
    }
}
