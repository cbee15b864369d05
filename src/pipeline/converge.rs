//! The same world without the street: searched by whoever asks, or by paths whose sums converge.

use super::Pipeline;
use crate::Error;
use crate::reference::{Moments, batch_end};
use crate::settings::open;
use crate::world::Site;
use frame::{FrameInfo, Gpu, Recorder, surface};
use std::ops::Range;
use tracer::{Converger, Search, World};

impl Pipeline {
    /// Builds `searches` for the next frame and lends them out with what it would be rendered with.
    ///
    /// # Errors
    /// They do not fit the adapter, or `visit`'s own.
    pub fn with_world<R>(
        &mut self,
        searches: &[Search],
        visit: impl FnOnce(&Gpu, &FrameInfo, World<'_>) -> Result<R, Error>,
    ) -> Result<R, Error> {
        let frame = self.next_frame()?;
        let mut recorder = Recorder::new(&self.gpu);
        let mesh = self.tessellator.tessellate(&mut recorder, &frame, self.voxel_size, &self.world);
        let site = Site {
            scene: &self.world,
            mesh: &mesh,
            bounds: self.tessellator.bounds(&self.world),
            grid: self.street.settings.grid,
            eye: frame.camera.eye,
            cache: self.street.paths.build.cache,
        };
        for search in searches {
            self.searches.build(&mut recorder, *search, site)?;
        }
        let mut log = recorder.finish()?;
        self.searches.settle(&mut log);
        visit(&self.gpu, &frame, self.searches.world(&self.world, &mesh))
    }

    /// Whether `frames` frames in a row show the same: nothing moves, and the camera neither.
    ///
    /// # Errors
    /// The settings name a camera that the scene does not have.
    pub fn stands_still(&self, frames: u32) -> Result<bool, Error> {
        let settings = &self.street.settings;
        let camera = |index| open::camera(settings, &self.scene, settings.frame_time(index));
        let first = camera(0)?;
        let mut still = !self.moves();
        for index in 1..frames {
            still = still && camera(index)? == first;
        }
        Ok(still)
    }

    /// Makes what [`Pipeline::sample`] needs: paths through one structure, at display size.
    ///
    /// # Errors
    /// The driver refuses a kernel, the size is too large for the adapter, or memory is out.
    pub fn sampler(&self, search: Search) -> Result<Converger, Error> {
        let size = self.street.settings.display_size;
        Ok(Converger::new(&self.gpu, &self.world, search, size, &self.street.paths)?)
    }

    /// Adds samples number `samples` of the converged image to `moments`: one batch, or what is left of it.
    ///
    /// # Errors
    /// The device was lost or ran out of memory.
    pub fn sample(
        &mut self,
        sampler: &mut Converger,
        samples: Range<u32>,
        moments: &mut Moments,
    ) -> Result<(), Error> {
        let mut frame = self.next_frame()?;
        frame.trace_size = self.street.settings.display_size;
        frame.jitter = [0.0; 2];
        frame.previous_jitter = [0.0; 2];
        // Not the numbers of a render with this seed, and other ones in every batch: their stratification starts anew.
        let batch = batch_end(samples.start);
        frame.seed = surface::hash(surface::hash(frame.seed ^ 0x7265_6673) ^ batch);
        if self.pose(&frame) {
            // Whatever moments lie between: following what moved is for frames in a row.
            self.searches.moved();
            self.searches.forget_grid();
        }
        for band in sampler.bands() {
            let mut recorder = Recorder::new(&self.gpu);
            let uniform = recorder.uniform(&frame.uniform());
            let mesh = self.tessellator.tessellate(&mut recorder, &frame, self.voxel_size, &self.world);
            let site = Site {
                scene: &self.world,
                mesh: &mesh,
                bounds: self.tessellator.bounds(&self.world),
                grid: self.street.settings.grid,
                eye: frame.camera.eye,
                cache: false,
            };
            for search in sampler.searches() {
                self.searches.build(&mut recorder, search, site)?;
            }
            let world = self.searches.world(&self.world, &mesh);
            sampler.record(&mut recorder, &uniform, world, &self.street.paths, &band, samples.clone());
            recorder.finish()?;
            moments.add(&band, &sampler.moments(&self.gpu, &band)?, self.world.radiance_scale);
        }
        moments.counted(samples.end - samples.start);
        Ok(())
    }
}
