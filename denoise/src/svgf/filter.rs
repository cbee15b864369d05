//! The spatial half: how noisy the accumulated light is, and the wavelet that this guides.

use super::{Settings, SvgfParams, VARIANCE};
use crate::lobes::{self, Turns};
use crate::temporal::{Input, Temporal};
use frame::info::Frame;
use frame::{Bind, Gpu, GpuError, Kernel, RadianceImage, Recorder, Room, Texture};
use wgpu::BindingResource::TextureView as View;

/// Variance and wavelet; [`crate::asvgf`] has the same.
pub struct Filter {
    name: String,
    variance_kernel: Kernel,
    level_kernel: Kernel,
    turns: Turns,
    /// Written in turn: of both lobes.
    variances: [Texture; 2],
}

impl Filter {
    /// Compiles its kernels; passes are called `denoise/NAME/…`.
    ///
    /// # Errors
    /// A kernel was refused.
    pub fn new(gpu: &Gpu, name: &str) -> Result<Self, GpuError> {
        let svgf = include_str!("svgf.inc.wgsl");
        let uniforms = [Bind::uniform::<Frame>(0, 0, "frame"), Bind::uniform::<SvgfParams>(0, 1, "params")];
        let variance_kernel = lobes::kernel(
            gpu,
            &format!("denoise/{name}/variance"),
            "variance",
            &[svgf, include_str!("variance.wgsl")],
            &[
                uniforms[0],
                uniforms[1],
                Bind::texture_uint(2, 0, "in_edge"),
                Bind::texture(2, 1, "in_moments"),
                Bind::texture_uint(2, 2, "in_frames"),
                Bind::storage_texture(3, 0, "out_variance", VARIANCE),
            ],
            &[],
        )?;
        let level_kernel = lobes::kernel(
            gpu,
            &format!("denoise/{name}/level"),
            "level",
            &[svgf, include_str!("level.wgsl")],
            &[
                uniforms[0],
                uniforms[1],
                Bind::texture_uint(2, 0, "in_edge"),
                Bind::texture(2, 1, "in_diffuse"),
                Bind::texture(2, 2, "in_specular"),
                Bind::texture_uint(2, 3, "in_variance"),
                Bind::storage_texture(3, 0, "out_diffuse", RadianceImage::FORMAT),
                Bind::storage_texture(3, 1, "out_specular", RadianceImage::FORMAT),
                Bind::storage_texture(3, 2, "out_variance", VARIANCE),
            ],
            &[],
        )?;
        Ok(Self {
            name: name.into(),
            variance_kernel,
            level_kernel,
            turns: Turns::new(gpu, "svgf::Filter", [1, 1], false)?,
            variances: Self::variances(gpu, [1, 1])?,
        })
    }

    fn variances(gpu: &Gpu, size: [u32; 2]) -> Result<[Texture; 2], GpuError> {
        let one = || lobes::picture(gpu, Room::Radiance, "svgf::Filter::variance", size, VARIANCE);
        Ok([one()?, one()?])
    }

    /// Allocates its pictures.
    ///
    /// # Errors
    /// Too large, or out of memory.
    pub fn resize(&mut self, gpu: &Gpu, size: [u32; 2], has_specular: bool) -> Result<(), GpuError> {
        self.turns = Turns::new(gpu, "svgf::Filter", size, has_specular)?;
        self.variances = Self::variances(gpu, size)?;
        Ok(())
    }

    /// Where the accumulated light goes.
    pub fn input(&self) -> [&Texture; 2] {
        self.turns.output(0)
    }

    /// Filters [`Filter::input`]; the first level's output, the next frame's history, goes to `history`.
    pub fn record<'a>(
        &'a self,
        recorder: &mut Recorder<'_>,
        input: &Input<'_>,
        settings: &Settings,
        temporal: &Temporal,
        history: [&'a Texture; 2],
    ) -> [&'a Texture; 2] {
        let workgroups = lobes::workgroups(input.noisy.size());
        let columns_per_row = input.frame.columns_per_row();
        let params = recorder.uniform(&settings.level_params(0, columns_per_row));
        recorder.compute(
            &format!("denoise/{}/variance", self.name),
            &self.variance_kernel,
            &[
                input.uniform.binding(),
                params.binding(),
                View(temporal.edge().view()),
                View(temporal.moments().view()),
                View(temporal.frames().view()),
                View(self.variances[0].view()),
            ],
            workgroups,
        );
        let mut level = |index: usize, from: [&Texture; 2], to: [&Texture; 2]| {
            let params = recorder.uniform(&settings.level_params(index as u32, columns_per_row));
            recorder.compute(
                &format!("denoise/{}/level{index}", self.name),
                &self.level_kernel,
                &[
                    input.uniform.binding(),
                    params.binding(),
                    View(temporal.edge().view()),
                    View(from[0].view()),
                    View(from[1].view()),
                    View(self.variances[index % 2].view()),
                    View(to[0].view()),
                    View(to[1].view()),
                    View(self.variances[1 - index % 2].view()),
                ],
                workgroups,
            );
        };
        level(0, self.input(), history);
        self.turns
            .chain(history, 0, settings.levels as usize - 1, |index, from, to| level(index + 1, from, to))
    }
}
