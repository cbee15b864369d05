//! Stages that find, filter and lift light, and how they are swapped while the world stays.

use super::knobs::KnobValues;
use super::{Pipeline, find};
use crate::Error;
use crate::settings::RenderSettings;
use denoise::Denoiser;
use frame::scene_gpu::GpuScene;
use frame::{FrameInfo, Gpu};
use tracer::{PathSettings, Tracer};
use upsample::Upsampler;
use voxel::grid::Layout;

/// The stages that find, filter and lift light, and what they remember. Two of them can take turns with one pipeline's
/// world: a split screen builds nothing twice.
pub struct Street {
    pub(super) settings: RenderSettings,
    pub(super) tracer: Box<dyn Tracer>,
    pub(super) denoiser: Box<dyn Denoiser>,
    pub(super) upsampler: Box<dyn Upsampler>,
    pub(super) paths: PathSettings,
    pub(super) previous: Option<FrameInfo>,
    pub(super) frame_index: u32,
}

impl Street {
    pub(super) fn new(gpu: &Gpu, settings: &RenderSettings) -> Result<Self, Error> {
        Ok(Self {
            settings: settings.clone(),
            tracer: find("tracer", &settings.tracer, tracer::all())?(gpu)?,
            denoiser: find("denoiser", &settings.denoiser, denoise::all())?(gpu)?,
            upsampler: find("upsampler", &settings.upsampler, upsample::all())?(gpu)?,
            paths: PathSettings { spp: settings.spp, bounces: settings.bounces, ..Default::default() },
            previous: None,
            frame_index: 0,
        })
    }

    /// Allocates for both sizes, once the knobs are set.
    pub(super) fn resize(&mut self, gpu: &Gpu, world: &GpuScene) -> Result<(), Error> {
        let RenderSettings { trace_size, display_size, .. } = self.settings;
        let specular = world.needs.specular;
        self.tracer.resize(gpu, world, trace_size, &self.paths)?;
        self.denoiser.resize(gpu, trace_size, specular)?;
        self.upsampler.resize(gpu, trace_size, display_size, specular)?;
        Ok(())
    }
}

impl Pipeline {
    /// Swaps stages, knobs, samples, bounces, seed, view, time or grid for what `settings` say, and restarts. What stays
    /// the same is kept, the scene, its reading and the sizes among it: about those, `settings` must repeat what the
    /// pipeline was made with.
    ///
    /// # Errors
    /// A name that is not in its list, a kernel the driver refuses, or memory is out. The pipeline may then be half
    /// changed: make another.
    pub fn change(&mut self, settings: &RenderSettings) -> Result<(), Error> {
        let before = std::mem::replace(&mut self.street.settings, settings.clone());
        let another = [
            before.tracer != settings.tracer,
            before.denoiser != settings.denoiser,
            before.upsampler != settings.upsampler,
        ];
        let knobs_before = self.knob_values();
        let gpu = &self.gpu;
        if before.tessellator != settings.tessellator {
            self.tessellator = find("tessellator", &settings.tessellator, tessellate::all())?(gpu)?;
        }
        if another[0] {
            self.street.tracer = find("tracer", &settings.tracer, tracer::all())?(gpu)?;
        }
        if another[1] {
            self.street.denoiser = find("denoiser", &settings.denoiser, denoise::all())?(gpu)?;
        }
        if another[2] {
            self.street.upsampler = find("upsampler", &settings.upsampler, upsample::all())?(gpu)?;
        }
        self.note_defaults();
        self.street.paths.spp = settings.spp;
        self.street.paths.bounces = settings.bounces;
        self.apply_knobs()?;
        let knobs = self.knob_values();
        let turned = |id: &str| {
            let of = |values: &KnobValues| {
                values.iter().filter(|((i, _), _)| *i == id).cloned().collect::<Vec<_>>()
            };
            of(&knobs_before) != of(&knobs)
        };
        if before.grid != settings.grid
            || before.tessellator != settings.tessellator
            || turned("voxel")
            || turned(self.tessellator.name())
        {
            let most = self.gpu.device.limits().max_texture_dimension_2d;
            let bounds = self.tessellator.bounds(&self.world);
            self.voxel_size = Layout::fit(bounds, settings.grid, most)?.voxel_size;
            self.searches.forget_grid();
        }
        if turned(self.tessellator.name()) {
            self.searches.moved();
        }
        let specular = self.world.needs.specular;
        if turned("gather") {
            self.gather.resize(&self.gpu, &[settings.trace_size, settings.display_size])?;
        }
        if another[0] || turned("voxel") || turned("tracer") || turned(self.street.tracer.name()) {
            self.street.tracer.resize(&self.gpu, &self.world, settings.trace_size, &self.street.paths)?;
        }
        if another[1] || turned(self.street.denoiser.name()) {
            self.street.denoiser.resize(&self.gpu, settings.trace_size, specular)?;
        }
        if another[2] || turned(self.street.upsampler.name()) {
            self.street.upsampler.resize(&self.gpu, settings.trace_size, settings.display_size, specular)?;
        }
        self.restart();
        Ok(())
    }

    /// Makes a second street through the same world, for [`Pipeline::exchange`]; about everything but tracer, denoiser,
    /// upsampler, their knobs, samples, bounces and seed, `settings` must repeat what the pipeline shows.
    ///
    /// # Errors
    /// As [`Pipeline::change`].
    pub fn street(&mut self, settings: &RenderSettings) -> Result<Street, Error> {
        let mut street = Street::new(&self.gpu, settings)?;
        self.exchange(&mut street);
        self.note_defaults();
        let applied = self.apply_knobs();
        self.exchange(&mut street);
        applied?;
        street.resize(&self.gpu, &self.world)?;
        Ok(street)
    }

    /// Puts another street's stages in place; `street` then holds those that were there.
    pub fn exchange(&mut self, street: &mut Street) {
        std::mem::swap(&mut self.street, street);
    }
}
