//! Does a frame that comes again cost the device no memory, however often it comes?

use crate::support::pipeline;
use gridlight::RenderSettings;
use gridlight::pipeline::Pipeline;
use gridlight::settings::View;

/// Environment variable: how many frames `memory_is_flat` renders; 10,000 take minutes.
const FRAMES: &str = "GRIDLIGHT_STEADY_FRAMES";

fn tiny() -> RenderSettings {
    RenderSettings {
        scene: "cornell".into(),
        view: View::Camera(0),
        trace_size: [16, 12],
        display_size: [32, 18],
        grid: 32,
        spp: 1,
        bounces: Some(1),
        ..Default::default()
    }
}

fn frames(pipeline: &mut Pipeline, count: u32) -> u64 {
    for _ in 0..count {
        pipeline.render().unwrap();
    }
    pipeline.gpu().allocations()
}

#[test]
fn a_steady_frame_allocates_nothing_whatever_the_stages_are() {
    let mut settings = tiny();
    let mut pipeline = pipeline(&settings);
    let upsamplers: Vec<_> = upsample::all().iter().map(|(id, _)| (*id).to_owned()).collect();
    let denoisers = denoise::all().iter().map(|(id, _)| (*id).to_owned());
    // Every denoiser and every upsampler, and not each with each: what one allocates does not depend on the other. Open
    // Image Denoise filters on the CPU and is read back to.
    for (k, denoiser) in denoisers.filter(|id| id != "oidn").enumerate() {
        settings.upsampler.clone_from(&upsamplers[k % upsamplers.len()]);
        settings.denoiser = denoiser;
        pipeline.change(&settings).unwrap();
        // Histories take turns in two textures, jitter in up to 16: sets of bindings come again after two frames.
        let begun = frames(&mut pipeline, 3);
        let ended = frames(&mut pipeline, 4);
        assert_eq!(ended, begun, "{} and {}", settings.denoiser, settings.upsampler);
    }
    for tracer in ["bvh_lbvh", "bvh_cwbvh"] {
        settings.tracer = tracer.into();
        pipeline.change(&settings).unwrap();
        let begun = frames(&mut pipeline, 3);
        assert_eq!(frames(&mut pipeline, 4), begun, "{tracer}");
    }
}

#[test]
fn memory_is_flat() {
    let count = std::env::var(FRAMES).ok().map_or(60, |n| n.parse().unwrap());
    let mut pipeline = pipeline(&RenderSettings { denoiser: "svgf".into(), ..tiny() });
    // The driver and the allocator take some frames to fill what they keep.
    frames(&mut pipeline, 40);
    let (before, on_device) = (resident(), pipeline.gpu().allocations());
    assert_eq!(frames(&mut pipeline, count), on_device);
    let Some((before, after)) = before.zip(resident()) else {
        println!("left out: this system does not say how much memory is in use");
        return;
    };
    println!("{count} frames: {before} kB, then {after} kB");
    // Allocators hand memory back in pages and keep some: 4 MB, and no more for more frames.
    assert!(after <= before + 4096, "{count} frames took {} kB", after - before);
}

/// Memory of this process, kB; where Linux says it.
fn resident() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    line.split_whitespace().next()?.parse().ok()
}
