//! The edge-avoiding a-trous wavelet: a five-tap spline whose taps move apart, with weights that stop at edges.
//!
//! Source: Dammertz, Sewtz, Hanika and Lensch 2010, "Edge-Avoiding A-Trous Wavelet Transform for fast Global
//! Illumination Filtering". The voxel paper has no such stage; this is one to compare its blur with.
//!
//! In: light at trace size ([`RadianceImage`]); the G-buffer's `surface`, `distance` and `face_normal`. Out: the same
//! light, less noisy. For levels i = 0..levels, taps q = p + 2^i (a, b), a and b in -2..2 trace rows:
//!
//! ```text
//! out = sum_q k_q mix(L_p, L_q, w_c),   k_q = h_a h_b w_q / sum_q h_a h_b w_q,   h = 1/16, 1/4, 3/8, 1/4, 1/16
//!                                       (or 1/4, 1/2, 1/4)
//! w   = w_n w_x                                      and w_r for the specular lobe (see `edge`)
//! w_c = exp(-(2^i |L_q - L_p| / (sigma_color max(|L_p|, |L_q|)))^2)
//! w_n = exp(-(|n_q - n_p| / sigma_normal)^2)         shading normals
//! w_x = exp(-(d(p, q) / sigma_plane)^2)              distance from the pixel's plane, rows (see `edge`)
//! ```
//!
//! Both lobes are filtered in one pass with the same edges. What is left alone, and what counts as a valid 0, is told in
//! [`crate::edge`]. A pixel that takes but has no light of its own is filled from its neighbours; it never gives. The
//! mean hit distance in a is filtered by the same weights over the taps that have one. Constant light stays constant to
//! the bit: sums are f32, the pictures between levels half floats. Taps beyond the border are mirrored.
//!
//! Departs from its source: what the colour weight rejects is replaced by the pixel's own light instead of left out of the
//! sum, so that what one pixel gives another gets and no light is lost (the source loses most of a bright sample); colours
//! are compared relative to the brighter one, because light here has no upper end; positions by their distance from the
//! pixel's plane, because distances between points cut walls that lie far off or aslant; three taps an axis by default, which
//! err less; taps are spaced in rows, so that footprints are square on the display ([`FrameInfo::columns_per_row`]).

pub mod reference;
mod settings;

pub use settings::Settings;

use crate::edge::{self, EdgePacker, EdgeParams};
use crate::lobes::{self, Turns};
use crate::{Denoiser, Guides, Need};
use frame::info::{Frame, FrameInfo};
use frame::{
    Bind, GBuffer, Gpu, GpuError, Kernel, Knob, RadianceImage, Recorder, Room, Texture, Uniform, gpu_struct,
};
use wgpu::BindingResource::TextureView as View;

gpu_struct! {
    /// See `atrous.wgsl`.
    pub struct AtrousParams {
        /// Pixels to the first tap along x and y.
        pub first_tap: [i32; 2],
        /// Pixels to the second tap along x and y.
        pub second_tap: [i32; 2],
        /// Relative, at this level.
        pub sigma_color: f32,
        /// Radians, roughly.
        pub sigma_normal: f32,
        /// Rows.
        pub sigma_plane: f32,
        /// Share of the specular lobe's tangent.
        pub lobe_spread: f32,
        /// Relative.
        pub roughness_fraction: f32,
        /// Trace rows per pixel along a row.
        pub rows_per_column: f32,
        /// 1 or 2.
        pub reach: i32,
        /// To 48 bytes.
        pub _pad: u32,
        /// Of the centre, the first and the second tap.
        pub kernel: [f32; 3],
        /// To 64 bytes.
        pub _end: u32,
    }
}

/// The wavelet.
pub struct Atrous {
    settings: Settings,
    packer: EdgePacker,
    /// Without and with a specular lobe.
    level_kernels: [Kernel; 2],
    edge: Texture,
    turns: Turns,
}

impl Atrous {
    /// Compiles its kernels.
    ///
    /// # Errors
    /// A kernel was refused.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let level_kernel = |has_specular: bool| {
            lobes::kernel(
                gpu,
                "denoise/atrous/level",
                "atrous_level",
                &[include_str!("atrous.wgsl")],
                &[
                    Bind::uniform::<Frame>(0, 0, "frame"),
                    Bind::uniform::<AtrousParams>(0, 1, "params"),
                    Bind::texture_uint(2, 0, "in_edge"),
                    Bind::texture(2, 1, "in_diffuse"),
                    Bind::texture(2, 2, "in_specular"),
                    Bind::storage_texture(3, 0, "out_diffuse", RadianceImage::FORMAT),
                    Bind::storage_texture(3, 1, "out_specular", RadianceImage::FORMAT),
                ],
                &[("has_specular", f64::from(has_specular))],
            )
        };
        Ok(Self {
            settings: Settings::default(),
            packer: EdgePacker::new(gpu, "denoise/atrous/edge")?,
            level_kernels: [level_kernel(false)?, level_kernel(true)?],
            edge: lobes::picture(gpu, Room::Radiance, "Atrous::edge", [1, 1], edge::FORMAT)?,
            turns: Turns::new(gpu, "Atrous::lobes", [1, 1], false)?,
        })
    }
}

impl Denoiser for Atrous {
    fn name(&self) -> &'static str {
        "atrous"
    }

    fn knobs(&mut self) -> Vec<Knob<'_>> {
        self.settings.knobs()
    }

    fn guides(&self) -> Guides {
        Guides {
            surface: Need::Required,
            distance: Need::Required,
            face_normal: Need::Required,
            motion_id: Need::Unused,
        }
    }

    fn history_bytes(&self) -> u64 {
        0
    }

    fn energy_bound(&self) -> f32 {
        // Rounding of half floats in five passes.
        0.005
    }

    fn resize(&mut self, gpu: &Gpu, size: [u32; 2], specular: bool) -> Result<(), GpuError> {
        self.edge = lobes::picture(gpu, Room::Radiance, "Atrous::edge", size, edge::FORMAT)?;
        self.turns = Turns::new(gpu, "Atrous::lobes", size, specular)?;
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
        let edges = EdgeParams::new(self.settings.roughness_min, noisy.specular.is_some(), false);
        self.packer.pack(recorder, uniform, &edges, guides, noisy, &self.edge);
        let levels = self.settings.levels as usize;
        let light = self.turns.chain(lobes::of(noisy), 0, levels, |level, from, to| {
            let params = recorder.uniform(&self.settings.params(level as u32, frame.columns_per_row()));
            recorder.compute(
                &format!("denoise/atrous/level{level}"),
                &self.level_kernels[usize::from(noisy.specular.is_some())],
                &[
                    uniform.binding(),
                    params.binding(),
                    View(self.edge.view()),
                    View(from[0].view()),
                    View(from[1].view()),
                    View(to[0].view()),
                    View(to[1].view()),
                ],
                lobes::workgroups(noisy.size()),
            );
        });
        lobes::clean(recorder, "atrous", noisy, light)
    }
}

#[cfg(test)]
mod tests;
