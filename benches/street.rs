//! What every bench stands on: a view, a pipeline, and times read off its frames.

use frame::{FrameLog, Gpu};
use gridlight::pipeline::Pipeline;
use gridlight::settings::Case;
use gridlight::{Progress, RenderSettings};
use std::time::Instant;

/// A view that benches share, and its name in their paths.
#[derive(Clone)]
pub struct View {
    /// First part of a path: `sponza_day`.
    pub name: String,
    /// Scene, camera, sky and sun; sizes too.
    pub settings: RenderSettings,
}

impl View {
    /// The row of the shared references named by `GRIDLIGHT_BENCH_CASE`, else the scene named by
    /// `GRIDLIGHT_BENCH_SCENE`, else `courtyard`, which needs no file.
    pub fn chosen() -> Self {
        let variable = |name| std::env::var(name).ok();
        let mut settings =
            RenderSettings { trace_size: [320, 240], display_size: [320, 240], ..Default::default() };
        if let Some(case) = variable("GRIDLIGHT_BENCH_CASE") {
            match Case::find(&case) {
                Ok(found) => found.apply(&mut settings),
                Err(e) => stop(&e.to_string()),
            }
            settings.bounces = RenderSettings::default().bounces;
            return Self { name: case, settings };
        }
        if let Some(scene) = variable("GRIDLIGHT_BENCH_SCENE") {
            settings.scene = scene;
        }
        let file = settings.scene.rsplit('/').next().unwrap_or_default();
        let name = file.split('.').next().unwrap_or_default().to_owned();
        Self { name, settings }
    }

    /// `sponza_day/320x240/grid256/spp4`.
    pub fn path(&self, settings: &RenderSettings) -> String {
        let [width, height] = settings.trace_size;
        format!("{}/{width}x{height}/grid{}/spp{}", self.name, settings.grid, settings.spp)
    }
}

/// A pipeline that renders frame after frame.
pub struct Street {
    pipeline: Pipeline,
}

impl Street {
    /// Everything made ready, and one frame rendered: the driver compiles at first dispatch.
    pub fn new(gpu: &Gpu, settings: &RenderSettings) -> Self {
        let made = Pipeline::new(gpu.clone(), settings, Progress::default());
        let mut street = Self { pipeline: made.unwrap_or_else(|e| stop(&e.to_string())) };
        street.frame();
        street
    }

    /// Other stages or settings in the same world, warmed up. Its frames begin anew.
    pub fn change(&mut self, settings: &RenderSettings) {
        if let Err(e) = self.pipeline.change(settings) {
            stop(&e.to_string());
        }
        self.frame();
    }

    /// Renders the next frame.
    pub fn frame(&mut self) -> FrameLog {
        match self.pipeline.render() {
            Ok(rendered) => rendered.log,
            Err(e) => stop(&e.to_string()),
        }
    }

    /// Nanoseconds of `frames` frames: of the passes that `of` picks by their names, by the adapter's clock.
    pub fn gpu_ns(&mut self, frames: u64, of: impl Fn(&str) -> bool) -> f64 {
        let mut sum = 0.0;
        for _ in 0..frames {
            let log = self.frame();
            sum += log.passes.iter().filter(|p| of(&p.name)).filter_map(|p| p.gpu_ms).sum::<f64>() * 1e6;
        }
        sum
    }

    /// Nanoseconds of `frames` whole frames by the host's clock.
    pub fn wall_ns(&mut self, frames: u64) -> f64 {
        let begun = Instant::now();
        (0..frames).for_each(|_| drop(self.frame()));
        begun.elapsed().as_nanos() as f64
    }
}

/// A bench that cannot run is left out, never invented: nothing after it would be measured right either.
pub fn stop(message: &str) -> ! {
    eprintln!("error: {message}");
    std::process::exit(1)
}
