//! Do numbers stay right on hard cases: no NaN, no infinity, nothing below 0, no ray given up, no energy lost?

use crate::support::{gpu, shared};
use frame::cpu::Image;
use gridlight::pipeline::Pipeline;
use gridlight::settings::{Preset, View};
use gridlight::suite::{Row, measure, strange};
use gridlight::{Progress, RenderSettings, stages::Kind};
use scene::built_in::hard::{HardScene, Truth, all};

fn settings(grid: u32) -> RenderSettings {
    RenderSettings {
        trace_size: [32, 24],
        display_size: [48, 36],
        view: View::Camera(0),
        grid,
        spp: 2,
        bounces: None,
        ..Default::default()
    }
}

fn pipeline(case: &HardScene, settings: &RenderSettings) -> Pipeline {
    let scene = (case.build)();
    Pipeline::of_scene(gpu(), scene, settings, Progress::default())
        .unwrap_or_else(|e| panic!("{}: {e}", case.name))
}

fn case(name: &str) -> &'static HardScene {
    all().iter().find(|case| case.name == name).unwrap()
}

/// Two frames, measured; without a closed form against black, which only the error minds.
fn measured(case: &HardScene, pipeline: &mut Pipeline) -> Row {
    let radiance = if let Truth::Everywhere(radiance) = case.truth { radiance } else { 0.0 };
    let truth = Image::filled(pipeline.settings().display_size, [radiance; 3]);
    measure(case, pipeline, &truth, 2).unwrap_or_else(|e| panic!("{}: {e}", case.name))
}

fn all_is_light(row: &Row) -> bool {
    row.strange.is_none() && row.cut_rays == 0.0
}

#[test]
fn every_stage_makes_nothing_but_light_of_every_hard_scene() {
    let mut wrong = Vec::new();
    for case in all() {
        let row = measured(case, &mut pipeline(case, &settings(32)));
        println!(
            "{:16} relMSE {:?}, lost {:?}, temporal {:?}",
            case.name, row.rel_mse, row.energy_lost, row.temporal
        );
        if !all_is_light(&row) {
            wrong.push(format!("{}: {:?}, {} cut rays", case.name, row.strange, row.cut_rays));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Every implementation of one kind in turn, the others plain.
fn in_turn(case: &HardScene, preset: Preset, wrong: &mut Vec<String>) {
    let plain =
        RenderSettings { denoiser: "identity".into(), upsampler: "nearest".into(), preset, ..settings(32) };
    let mut pipeline = pipeline(case, &plain);
    let mut try_one = |settings: RenderSettings| {
        let name = format!(
            "{}, {preset:?}: {} + {} + {} + {}",
            case.name, settings.tessellator, settings.tracer, settings.denoiser, settings.upsampler
        );
        if let Err(e) = pipeline.change(&settings) {
            // `oidn` needs a library that most machines lack; nothing else may be missing.
            assert!(settings.denoiser == "oidn", "{name}: {e}");
            return;
        }
        let row = measured(case, &mut pipeline);
        if !all_is_light(&row) {
            wrong.push(format!("{name}: {:?}, {} cut rays", row.strange, row.cut_rays));
        }
    };
    for kind in [Kind::Tracer, Kind::Denoiser, Kind::Upsampler, Kind::Tessellator] {
        for id in kind.ids() {
            // A tracer of an adapter that traces rays itself is refused elsewhere.
            if id == "bvh_rayquery" {
                continue;
            }
            let id = id.to_owned();
            try_one(match kind {
                Kind::Tracer => RenderSettings { tracer: id, ..plain.clone() },
                Kind::Denoiser => RenderSettings { denoiser: id, ..plain.clone() },
                Kind::Upsampler => RenderSettings { upsampler: id, ..plain.clone() },
                Kind::Tessellator => RenderSettings { tessellator: id, ..plain.clone() },
            });
        }
    }
}

#[test]
fn every_implementation_makes_nothing_but_light() {
    let mut wrong = Vec::new();
    in_turn(case("wires"), Preset::Default, &mut wrong);
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_implementation_and_preset_makes_nothing_but_light_of_every_hard_scene() {
    // Some twenty minutes: beside the shared scenes' renders.
    if shared("scenes").is_none() {
        return;
    }
    let mut wrong = Vec::new();
    for case in all() {
        for preset in [Preset::Default, Preset::Paper, Preset::Gltf] {
            in_turn(case, preset, &mut wrong);
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn closed_rooms_keep_their_energy_through_the_whole_street() {
    let mut wrong = Vec::new();
    for case in all().iter().filter(|case| case.closed) {
        let settings = RenderSettings { spp: 8, ..settings(64) };
        let mut pipeline = pipeline(case, &settings);
        let mut losses = Vec::new();
        for seed in 1..=3 {
            pipeline.change(&RenderSettings { seed, ..settings.clone() }).unwrap();
            losses.push(measured(case, &mut pipeline).energy_lost.unwrap());
        }
        let mean = losses.iter().sum::<f64>() / losses.len() as f64;
        let spread = losses.iter().map(|l| (l - mean).powi(2)).sum::<f64>() / (losses.len() - 1) as f64;
        let error = (spread / losses.len() as f64).sqrt();
        println!("{:16} {:.3} % +- {:.3} %", case.name, 100.0 * mean, 100.0 * error);
        // The bar is 1 %; three runs say how much of what is seen is noise.
        if mean.abs() > 0.01 + 3.0 * error || error > 0.005 {
            wrong.push(format!("{}: {mean:.4} +- {error:.4} of the energy is lost", case.name));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn what_is_no_light_is_counted() {
    // The counter itself: a frame of a good scene has none, and a NaN put into its copy would be one.
    let case = case("room_1m");
    let mut pipeline = pipeline(case, &settings(32));
    let rendered = pipeline.render().unwrap();
    assert!(strange::of(pipeline.gpu(), &rendered).unwrap().is_none());
    let size = rendered.color.size();
    let poison = [half::f16::NAN, half::f16::NEG_INFINITY, half::f16::from_f32(-1.0), half::f16::ONE];
    let texels = vec![poison; (size[0] * size[1]) as usize];
    pipeline.gpu().queue.write_texture(
        rendered.color.texture.as_image_copy(),
        bytemuck::cast_slice(&texels),
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(8 * size[0]), rows_per_image: None },
        wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
    );
    let found = strange::of(pipeline.gpu(), &rendered).unwrap();
    let pixels = u64::from(size[0] * size[1]);
    // Minus infinity is below 0, too.
    assert_eq!((found.nan_count, found.inf_count, found.negative_count), (pixels, pixels, 2 * pixels));
}
