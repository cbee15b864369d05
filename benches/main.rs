//! GPU time of every pass, stage and stage in the list, against the baselines, with criterion's statistics.
//!
//! `cargo bench` measures `courtyard` at 320x240; `GRIDLIGHT_BENCH_CASE=sponza_day` (a row of the shared references) or
//! `GRIDLIGHT_BENCH_SCENE=scene.gltf` another view, `GRIDLIGHT_BENCH_ADAPTER=NAME` another adapter. Names are paths, so
//! that a filter picks a part: `cargo bench -- trace/`. Baselines are criterion's: `--save-baseline before`, then
//! `--baseline before`; `--quick` for a first look.
//!
//! Times are the adapter's, of the passes a name says. On an adapter without a clock the names begin with `wall/` and
//! only whole frames are measured, by the host's clock; nothing else is invented.

mod clock;
mod frame_time;
mod growth;
mod lists;
mod street;

use clock::GpuTime;
use criterion::{BenchmarkGroup, Criterion, SamplingMode};
use frame::Gpu;
use std::time::Duration;
use street::{Street, View};

fn main() {
    let gpu = Gpu::new(std::env::var("GRIDLIGHT_BENCH_ADAPTER").ok().as_deref())
        .unwrap_or_else(|e| street::stop(&e.to_string()));
    let info = &gpu.info;
    let limits = gpu.device.limits();
    println!(
        "adapter: {} ({:?}, {}), driver: {} {}, clock: {}, bindings up to {} MB, workgroups up to {}",
        info.name,
        info.device_type,
        info.backend,
        info.driver,
        info.driver_info,
        gpu.timestamp_period.map_or("the host's".into(), |ns| format!("timestamps of {ns} ns")),
        limits.max_storage_buffer_binding_size / 1_000_000,
        limits.max_compute_invocations_per_workgroup,
    );
    let view = View::chosen();
    // A frame takes a tenth of a second on two cores: ten samples of one frame are what a bench can be given.
    let mut criterion = Criterion::default()
        .with_measurement(GpuTime)
        .sample_size(10)
        .warm_up_time(Duration::from_millis(200))
        .measurement_time(Duration::from_secs(1))
        .configure_from_args();
    if gpu.timestamp_period.is_none() {
        frame_time::wall(&mut criterion, &gpu, &view);
    } else {
        lists::passes(&mut criterion, &gpu, &view);
        lists::tracers(&mut criterion, &gpu, &view);
        lists::denoisers(&mut criterion, &gpu, &view);
        lists::upsamplers(&mut criterion, &gpu, &view);
        frame_time::paper(&mut criterion, &gpu, &view);
        frame_time::moving(&mut criterion, &gpu, &view);
        growth::all(&mut criterion, &gpu, &view);
    }
    criterion.final_summary();
}

/// A group of benches whose iterations are frames.
fn group<'c>(criterion: &'c mut Criterion<GpuTime>, name: &str) -> BenchmarkGroup<'c, GpuTime> {
    let mut group = criterion.benchmark_group(name);
    group.sampling_mode(SamplingMode::Flat);
    group
}

/// One bench: the passes that `of` picks, of frames with these settings. The pipeline is made when the first bench that
/// the filter lets through asks for it.
fn bench(
    group: &mut BenchmarkGroup<'_, GpuTime>,
    name: &str,
    gpu: &Gpu,
    street: &mut Option<Street>,
    settings: &gridlight::RenderSettings,
    of: impl Fn(&str) -> bool,
) {
    group.bench_function(name, |bencher| {
        let street = match street {
            Some(street) => {
                street.change(settings);
                street
            }
            None => street.insert(Street::new(gpu, settings)),
        };
        bencher.iter_custom(|frames| street.gpu_ns(frames, &of));
    });
}
