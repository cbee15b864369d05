//! Samples by estimated variance: the same number, more where the light is noisy, and the same mean.

use super::twin::{fixture, room};
use crate::path::{PathSettings, SampleRule};
use scene::Sky;

#[test]
fn noisy_pixels_get_more_of_the_same_budget() {
    let mut fixture = fixture(Sky::Constant(glam::Vec3::ZERO), None, &[]);
    let voxels = room().build();
    let texels = fixture.gbuffer(&voxels);
    let seen = texels.texels().iter().filter(|t| t.distance > 0.0).count() as f64;
    let mut means = [Vec::new(), Vec::new()];
    for frame in 0..12 {
        fixture.frame.frame_index = frame;
        for (i, samples) in [SampleRule::Fixed, SampleRule::Variance].into_iter().enumerate() {
            let settings = PathSettings { spp: 8, samples, ..PathSettings::default() };
            let traced = fixture.traced(&voxels, &texels, &settings);
            means[i].push(traced.mean(0).0);
            let paths = traced.log.counts["paths"] / seen;
            // Rounded by chance: each of thousands of pixels is off by at most one half, either way.
            assert!((paths - 8.0).abs() < 0.05, "{samples:?}: {paths} paths a pixel");
            let counts: Vec<u32> = traced.samples.iter().map(|s| (s & 0xffff) + (s >> 16)).collect();
            let most = counts.iter().max().unwrap();
            let least = counts.iter().filter(|c| **c > 0).min().unwrap();
            match samples {
                SampleRule::Variance => {
                    assert!(*least >= 4 && *most > 10 && *most <= 20, "{least} to {most}")
                }
                _ => assert_eq!((*least, *most), (8, 8)),
            }
        }
    }
    let [fixed, varied] = means.map(|m| {
        let mean = m.iter().sum::<f64>() / m.len() as f64;
        let variance = m.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (m.len() - 1) as f64;
        (mean, (variance / m.len() as f64).sqrt())
    });
    println!("fixed {} +- {}, by variance {} +- {}", fixed.0, fixed.1, varied.0, varied.1);
    assert!((fixed.0 - varied.0).abs() < 3.5 * fixed.1.hypot(varied.1), "another mean");
}
