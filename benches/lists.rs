//! Each pass of the street, and each member of each list in its place.

use crate::clock::GpuTime;
use crate::street::{Street, View};
use crate::{bench, group};
use criterion::Criterion;
use frame::Gpu;
use gridlight::RenderSettings;
use gridlight::stages::Kind;

/// `pass/sponza_day/320x240/grid256/spp4/denoise/five_phase/phase1/horizontal`: a steady frame's passes, apart.
pub fn passes(criterion: &mut Criterion<GpuTime>, gpu: &Gpu, view: &View) {
    let settings = RenderSettings { display_size: three_by_two_and_a_quarter(view), ..view.settings.clone() };
    let mut group = group(criterion, &format!("pass/{}", view.path(&settings)));
    // Names are known once a frame was made; that frame also builds what stands still.
    let mut street = Street::new(gpu, &settings);
    let names: Vec<String> = street.frame().passes.into_iter().map(|p| p.name).collect();
    for name in names {
        group.bench_function(&name, |bencher| {
            bencher.iter_custom(|frames| street.gpu_ns(frames, |pass| pass == name));
        });
    }
    group.finish();
}

/// `trace/voxel/…`, `trace/bvh_lbvh/…`: tracing alone, structures built before.
pub fn tracers(criterion: &mut Criterion<GpuTime>, gpu: &Gpu, view: &View) {
    each(criterion, gpu, view, Kind::Tracer, "trace", |settings, id| settings.tracer = id);
}

/// `denoise/svgf/…`.
pub fn denoisers(criterion: &mut Criterion<GpuTime>, gpu: &Gpu, view: &View) {
    each(criterion, gpu, view, Kind::Denoiser, "denoise", |settings, id| settings.denoiser = id);
}

/// `upsample/best_candidate/…`: the paper's 3 by 2.25.
pub fn upsamplers(criterion: &mut Criterion<GpuTime>, gpu: &Gpu, view: &View) {
    let lifted = RenderSettings { display_size: three_by_two_and_a_quarter(view), ..view.settings.clone() };
    let lifted = View { settings: lifted, ..view.clone() };
    each(criterion, gpu, &lifted, Kind::Upsampler, "upsample", |settings, id| settings.upsampler = id);
}

fn each(
    criterion: &mut Criterion<GpuTime>,
    gpu: &Gpu,
    view: &View,
    kind: Kind,
    stage: &str,
    choose: impl Fn(&mut RenderSettings, String),
) {
    let mut street = None;
    let mut group = group(criterion, stage);
    for id in kind.ids() {
        let mut settings = view.settings.clone();
        choose(&mut settings, id.to_owned());
        let name = format!("{id}/{}", view.path(&settings));
        let prefix = format!("{stage}/");
        bench(&mut group, &name, gpu, &mut street, &settings, |pass| pass.starts_with(&prefix));
    }
    group.finish();
}

/// The paper lifts 640x480 to 1920x1080.
fn three_by_two_and_a_quarter(view: &View) -> [u32; 2] {
    let [width, height] = view.settings.trace_size;
    [width * 3, height * 9 / 4]
}
