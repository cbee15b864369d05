//! Averages over time and nothing else: what following pixels is worth alone.
//!
//! Source: none; NRD has the like under the name of a reference. The voxel paper has no such stage.
//!
//! In: light at trace size ([`RadianceImage`]) and the whole G-buffer. Out: the mean of the light of all frames that a
//! pixel has been followed, or of the last ones; per lobe, kept as f32, rounded to half floats at the end. How pixels are followed is told in [`crate::temporal`], which is
//! all of it: the CPU half is there, too. Mirrors, clear glass and the sky pass by ([`crate::edge`]).
//!
//! A still picture converges as the tracer does; a moving one keeps the noise of what was just uncovered, and light that
//! changes stays behind: with the default every frame counts alike.

use crate::edge;
use crate::lobes;
use crate::temporal::{Input, Needs, Settings, Temporal};
use crate::{Denoiser, Guides, Need};
use frame::info::FrameInfo;
use frame::{Bind, GBuffer, Gpu, GpuError, Kernel, Knob, RadianceImage, Recorder, Room, Texture, Uniform};
use wgpu::BindingResource::TextureView as View;
use wgpu::TextureFormat;

/// The average over time.
pub struct Accumulate {
    settings: Settings,
    roughness_min: f32,
    temporal: Temporal,
    round_kernel: Kernel,
    /// Of this frame and the last, by `now`; f32.
    history: [[Texture; 2]; 2],
    now: usize,
    output: [Texture; 2],
}

fn history(gpu: &Gpu, size: [u32; 2], has_specular: bool) -> Result<[[Texture; 2]; 2], GpuError> {
    let label = "Accumulate::history";
    let one = || lobes::pair_as(gpu, Room::History, label, size, has_specular, TextureFormat::Rgba32Float);
    Ok([one()?, one()?])
}

fn output(gpu: &Gpu, size: [u32; 2], has_specular: bool) -> Result<[Texture; 2], GpuError> {
    lobes::pair(gpu, Room::Radiance, "Accumulate::output", size, has_specular)
}

impl Accumulate {
    /// Compiles its kernels.
    ///
    /// # Errors
    /// A kernel was refused.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        Ok(Self {
            settings: Settings { alpha_color: 0.0, history_max: 1024, ..Settings::default() },
            roughness_min: 0.02,
            temporal: Temporal::new(gpu, "accumulate", Needs { precise: true, ..Needs::default() })?,
            round_kernel: lobes::kernel(
                gpu,
                "denoise/accumulate/round",
                "round_lobes",
                &[include_str!("round.wgsl")],
                &[
                    Bind::texture(2, 0, "in_diffuse"),
                    Bind::texture(2, 1, "in_specular"),
                    Bind::storage_texture(3, 0, "out_diffuse", RadianceImage::FORMAT),
                    Bind::storage_texture(3, 1, "out_specular", RadianceImage::FORMAT),
                ],
                &[],
            )?,
            history: history(gpu, [1, 1], false)?,
            now: 0,
            output: output(gpu, [1, 1], false)?,
        })
    }
}

impl Denoiser for Accumulate {
    fn name(&self) -> &'static str {
        "accumulate"
    }

    fn knobs(&mut self) -> Vec<Knob<'_>> {
        let Settings { alpha_color, history_max, history_plane, history_normal, .. } = &mut self.settings;
        let mut knobs = vec![
            Knob::float(
                "alpha_color",
                alpha_color,
                0.0..=1.0,
                "",
                "least share of a new frame; higher follows changes of light, lower leaves less noise. 0: all frames alike, \
                 up to history_max",
            ),
            Knob::int(
                "history_max",
                history_max,
                1..=65535,
                "frames",
                "frames that a pixel remembers having; with more, a new one's share stays one over this. Ours: 1,024, the \
                 samples of a reference",
            ),
        ];
        knobs.extend(Settings::surface_knobs(history_plane, history_normal));
        let roughness_min = &mut self.roughness_min;
        knobs.push(Knob::float("roughness_min", roughness_min, 0.0..=1.0, "", edge::ROUGHNESS_MIN_DOC));
        knobs
    }

    fn guides(&self) -> Guides {
        Guides {
            surface: Need::Required,
            distance: Need::Required,
            face_normal: Need::Required,
            motion_id: Need::Required,
        }
    }

    fn history_bytes(&self) -> u64 {
        self.temporal.bytes() + self.history.as_flattened().iter().map(Texture::bytes).sum::<u64>()
    }

    fn energy_bound(&self) -> f32 {
        // Half floats round once.
        0.001
    }

    fn resize(&mut self, gpu: &Gpu, size: [u32; 2], specular: bool) -> Result<(), GpuError> {
        self.temporal.resize(gpu, size)?;
        self.history = history(gpu, size, specular)?;
        self.output = output(gpu, size, specular)?;
        Ok(())
    }

    fn denoise(
        &mut self,
        recorder: &mut Recorder<'_>,
        frame: &FrameInfo,
        uniform: &Uniform,
        guides: &GBuffer,
        noisy: &RadianceImage,
    ) -> RadianceImage {
        let input = Input { frame, uniform, guides, noisy };
        let [mean, before] = [self.now, 1 - self.now].map(|index| self.history[index].each_ref());
        self.temporal.pack(recorder, &input, self.roughness_min);
        self.temporal.accumulate(recorder, &input, &self.settings, before, None, mean);
        recorder.output("denoise/accumulate/frames", self.temporal.frames());
        let output = self.output.each_ref();
        recorder.compute(
            "denoise/accumulate/round",
            &self.round_kernel,
            &[View(mean[0].view()), View(mean[1].view()), View(output[0].view()), View(output[1].view())],
            lobes::workgroups(noisy.size()),
        );
        let clean = lobes::clean(recorder, "accumulate", noisy, output);
        self.temporal.turn();
        self.now = 1 - self.now;
        clean
    }
}

#[cfg(test)]
mod tests;
