//! The three kernels of the filter, besides the one that packs the edges.

use super::{FRAMES, MOMENTS, ReprojectParams, SvgfParams, VARIANCE};
use crate::edge;
use frame::info::{self, Frame};
use frame::{Bind, Gpu, GpuError, HALF_WGSL, Kernel, KernelDesc, RadianceImage, brdf, surface};

/// See the shaders of the same names.
pub(super) struct Kernels {
    pub(super) reproject: Kernel,
    pub(super) variance: Kernel,
    pub(super) level: Kernel,
}

impl Kernels {
    /// Compiles them.
    pub(super) fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let kernel = |name: &str, entry: &str, last: &[&str], bindings: &[Bind]| {
            let shared = [info::WGSL, surface::WGSL, brdf::WGSL, HALF_WGSL, edge::WGSL];
            let sources: Vec<&str> = shared.iter().chain(last).copied().collect();
            let frame = Bind::uniform::<Frame>(0, 0, "frame");
            let bindings: Vec<Bind> = std::iter::once(frame).chain(bindings.iter().copied()).collect();
            let workgroup = edge::WORKGROUP;
            let desc =
                KernelDesc { name, sources: &sources, entry, workgroup, bindings: &bindings, constants: &[] };
            Kernel::new(gpu, &desc)
        };
        let lobes_out = [
            Bind::storage_texture(3, 0, "out_diffuse", RadianceImage::FORMAT),
            Bind::storage_texture(3, 1, "out_specular", RadianceImage::FORMAT),
        ];
        let svgf = include_str!("svgf.inc.wgsl");
        let svgf_params = Bind::uniform::<SvgfParams>(0, 1, "params");
        let reproject = kernel(
            "denoise/svgf/reproject",
            "reproject",
            &[include_str!("reproject.wgsl")],
            &[
                Bind::uniform::<ReprojectParams>(0, 1, "params"),
                Bind::texture_uint(2, 0, "in_edge"),
                Bind::texture_uint(2, 1, "in_motion_id"),
                Bind::texture(2, 2, "in_diffuse"),
                Bind::texture(2, 3, "in_specular"),
                Bind::texture_uint(2, 4, "in_edge_before"),
                Bind::texture(2, 5, "in_diffuse_before"),
                Bind::texture(2, 6, "in_specular_before"),
                Bind::texture(2, 7, "in_moments_before"),
                Bind::texture_uint(2, 8, "in_frames_before"),
                lobes_out[0],
                lobes_out[1],
                Bind::storage_texture(3, 2, "out_moments", MOMENTS),
                Bind::storage_texture(3, 3, "out_frames", FRAMES),
            ],
        )?;
        let variance = kernel(
            "denoise/svgf/variance",
            "variance",
            &[svgf, include_str!("variance.wgsl")],
            &[
                svgf_params,
                Bind::texture_uint(2, 0, "in_edge"),
                Bind::texture(2, 1, "in_moments"),
                Bind::texture_uint(2, 2, "in_frames"),
                Bind::storage_texture(3, 0, "out_variance", VARIANCE),
            ],
        )?;
        let level = kernel(
            "denoise/svgf/level",
            "level",
            &[svgf, include_str!("level.wgsl")],
            &[
                svgf_params,
                Bind::texture_uint(2, 0, "in_edge"),
                Bind::texture(2, 1, "in_diffuse"),
                Bind::texture(2, 2, "in_specular"),
                Bind::texture_uint(2, 3, "in_variance"),
                lobes_out[0],
                lobes_out[1],
                Bind::storage_texture(3, 2, "out_variance", VARIANCE),
            ],
        )?;
        Ok(Self { reproject, variance, level })
    }
}
