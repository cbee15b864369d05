//! Is the light right? Against another renderer's converged images of the Cornell box.

use crate::support::{excess_rel_mse, mean, reference, render};
use gridlight::RenderSettings;
use gridlight::settings::{Preset, View};

fn cornell(grid: u32, bounces: u32, seed: u32, spp: u32) -> RenderSettings {
    RenderSettings {
        scene: "cornell".into(),
        view: View::Camera(0),
        trace_size: [64, 64],
        display_size: [64, 64],
        grid,
        denoiser: "identity".into(),
        upsampler: "nearest".into(),
        preset: Preset::Gltf,
        bounces: Some(bounces),
        seed,
        spp,
        ..Default::default()
    }
}

/// Largest relative difference of a channel's mean, and the excess error.
fn error(grid: u32, bounces: u32, name: &str) -> (f64, f64) {
    let (expected, standard_error) = reference(name);
    // 256 paths a pixel leave 0.3 % of noise in a channel's mean.
    let ours = [1, 2].map(|seed| render(&cornell(grid, bounces, seed, 256)));
    let [a, b, r] = [&ours[0], &ours[1], &expected].map(mean);
    let of_mean = (0..3).map(|c| (0.5 * (a[c] + b[c]) / r[c] - 1.0).abs()).fold(0.0, f64::max);
    let excess = excess_rel_mse([&ours[0], &ours[1]], &expected, &standard_error);
    println!("{name} at grid {grid}: means off by {:.2} %, excess relMSE {excess:.4}", 100.0 * of_mean);
    (of_mean, excess)
}

#[test]
fn cornell_converges_to_the_reference_as_voxels_shrink() {
    for (bounces, name) in [(1, "cornell_64_b1"), (4, "cornell_64_b4")] {
        let (mean_64, excess_64) = error(64, bounces, name);
        let (mean_256, excess_256) = error(256, bounces, name);
        // What voxels may cost in this scene: the project's own bounds for 256 cells.
        assert!(mean_256 < 0.05, "{name}: a channel's mean is off by {:.1} %", 100.0 * mean_256);
        assert!(excess_256 < 0.03, "{name}: excess relMSE {excess_256}");
        assert!(mean_256 < mean_64 && excess_256 < excess_64, "{name}: a finer grid is no better");
    }
}
