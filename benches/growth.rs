//! What a frame costs as one thing grows, with the exponent of its growth: 1 means twice the work takes twice the time.

use crate::clock::GpuTime;
use crate::group;
use crate::street::{Street, View};
use criterion::Criterion;
use frame::Gpu;
use gridlight::RenderSettings;

/// One thing that grows.
struct Axis {
    name: &'static str,
    /// What is timed: passes whose names begin so.
    stage: &'static str,
    sizes: &'static [u32],
    set: fn(&mut RenderSettings, u32),
}

const AXES: [Axis; 4] = [
    Axis { name: "grid", stage: "trace/", sizes: &[64, 128, 256, 512], set: |s, n| s.grid = n },
    Axis {
        name: "rows",
        stage: "",
        sizes: &[60, 120, 240, 480],
        set: |s, n| {
            s.trace_size = [n * 4 / 3, n];
            s.display_size = s.trace_size;
        },
    },
    Axis { name: "spp", stage: "trace/", sizes: &[1, 2, 4, 8], set: |s, n| s.spp = n },
    Axis { name: "bounces", stage: "trace/", sizes: &[1, 2, 4, 8], set: |s, n| s.bounces = Some(n) },
];

/// `growth/grid/…/64` and so on, then one line with the exponent: the slope of log time over log size, least squares
/// over the medians.
pub fn all(criterion: &mut Criterion<GpuTime>, gpu: &Gpu, view: &View) {
    for axis in AXES {
        let mut points = Vec::new();
        let mut group = group(criterion, &format!("growth/{}/{}", axis.name, view.name));
        for size in axis.sizes {
            let mut settings = view.settings.clone();
            (axis.set)(&mut settings, *size);
            let mut times = Vec::new();
            group.bench_function(size.to_string(), |bencher| {
                // A pipeline of its own: sizes change.
                let mut street = Street::new(gpu, &settings);
                bencher.iter_custom(|frames| {
                    let ns = street.gpu_ns(frames, |pass| pass.starts_with(axis.stage));
                    times.push(ns / frames as f64);
                    ns
                });
            });
            times.sort_by(f64::total_cmp);
            points.extend(times.get(times.len() / 2).map(|median| (f64::from(*size), *median)));
        }
        group.finish();
        if let Some(exponent) = slope(&points) {
            println!("growth/{}/{}: time grows with size to the power {exponent:.2}", axis.name, view.name);
        }
    }
}

/// Least squares in logarithms; none with fewer than two points.
fn slope(points: &[(f64, f64)]) -> Option<f64> {
    let logs: Vec<(f64, f64)> = points.iter().map(|(x, y)| (x.ln(), y.ln())).collect();
    let n = logs.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| logs.iter().map(of).sum::<f64>() / n;
    let (mx, my) = (mean(|p| p.0), mean(|p| p.1));
    let across: f64 = logs.iter().map(|(x, _)| (x - mx).powi(2)).sum();
    let along: f64 = logs.iter().map(|(x, y)| (x - mx) * (y - my)).sum();
    (logs.len() >= 2).then(|| along / across)
}
