//! Is the light right? Against another renderer's converged images of the Cornell box.
//!
//! The references are means over each pixel's area, our G-buffer looks through pixel centres: it is rendered four times
//! finer along each axis, and averaged. (Through 64 x 64 centres the lamp alone, half of the light in the picture, is off
//! by 7 %.)

use crate::support::{Picture, excess_rel_mse, frame_of, mean, pipeline, read_exr, reference, shared};
use gridlight::RenderSettings;
use gridlight::settings::{Case, Preset, View};

/// Along each axis.
const FINER: u32 = 4;

fn cornell(grid: u32, bounces: u32) -> RenderSettings {
    RenderSettings {
        scene: "cornell".into(),
        view: View::Camera(0),
        trace_size: [64 * FINER; 2],
        display_size: [64 * FINER; 2],
        grid,
        denoiser: "identity".into(),
        upsampler: "nearest".into(),
        preset: Preset::Gltf,
        bounces: Some(bounces),
        spp: 16,
        ..Default::default()
    }
}

/// The mean of each block of `FINER` by `FINER` pixels.
fn averaged(fine: &Picture) -> Picture {
    let n = FINER as i32;
    Picture::from_fn(fine.size().map(|side| side / FINER), |x, y| {
        let mut sum = [0.0; 3];
        for (dy, dx) in (0..n).flat_map(|dy| (0..n).map(move |dx| (dy, dx))) {
            let texel = fine.get(x as i32 * n + dx, y as i32 * n + dy).unwrap();
            sum = [0, 1, 2].map(|c| sum[c] + texel[c] / (n * n) as f32);
        }
        sum
    })
}

/// Largest relative difference of a channel's mean, and the excess error.
fn error(grid: u32, bounces: u32, name: &str) -> (f64, f64) {
    let (expected, standard_error) = reference(name);
    // 256 paths a pixel of the reference leave 0.3 % of noise in a channel's mean.
    let mut pipeline = pipeline(&cornell(grid, bounces));
    let ours = [0, 1].map(|_| averaged(&frame_of(&mut pipeline).0));
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
        assert!(mean_256 < mean_64, "{name}: a finer grid is no better");
        // The noise that is left in the two halves moves the figure by 0.003.
        assert!(excess_256 < excess_64 + 0.003, "{name}: excess relMSE {excess_64} became {excess_256}");
    }
}

#[test]
fn shared_cases_converge_as_voxels_shrink() {
    let Some(truth) = shared("truth") else { return };
    // Bounds on a channel's mean and on the excess error: what voxels of 256 may cost, by the project's own measure.
    for (name, most_of_mean, most_excess) in
        [("cornell_256_b4", 0.05, 0.03), ("sponza_day_lambert", 0.08, f64::INFINITY)]
    {
        let expected = read_exr(&truth.join(format!("{name}.exr")));
        let standard_error = read_exr(&truth.join(format!("{name}.stderr.exr")));
        let error = |grid| {
            let mut settings = RenderSettings {
                grid,
                denoiser: "identity".into(),
                upsampler: "nearest".into(),
                preset: Preset::Gltf,
                spp: 128,
                ..Default::default()
            };
            Case::find_in(&truth, name).unwrap().apply(&mut settings);
            let mut pipeline = pipeline(&settings);
            let ours = [0, 1].map(|_| frame_of(&mut pipeline).0);
            let [a, b, r] = [&ours[0], &ours[1], &expected].map(mean);
            let of_mean = (0..3).map(|c| (0.5 * (a[c] + b[c]) / r[c] - 1.0).abs()).fold(0.0, f64::max);
            let excess = excess_rel_mse([&ours[0], &ours[1]], &expected, &standard_error);
            println!(
                "{name} at grid {grid}: means off by {:.2} %, excess relMSE {excess:.4}",
                100.0 * of_mean
            );
            (of_mean, excess)
        };
        let ((mean_64, excess_64), (mean_256, excess_256)) = (error(64), error(256));
        assert!(mean_256 < most_of_mean && excess_256 < most_excess, "{name}: {mean_256}, {excess_256}");
        assert!(mean_256 < mean_64, "{name}: a finer grid is no better");
        // As above: Cornell's excess is noise at either size.
        assert!(excess_256 < excess_64 + 0.003, "{name}: excess relMSE {excess_64} became {excess_256}");
    }
}
