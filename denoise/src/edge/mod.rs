//! What filters that stop at edges ask about a pixel, packed once per frame; shared by all of them.
//!
//! In: the G-buffer and the noisy light. Out: 16 bytes a pixel, `rgba32uint`:
//!
//! | word | meaning |
//! | --- | --- |
//! | x | depth along the view direction, m, as f32 bits; 0 = nothing was hit |
//! | y | shading normal 24 bits (octahedral), roughness code 8: the higher of the surface's two |
//! | z | normal of the triangle, octahedral 16 + 16 |
//! | w | object 28 bits; then diffuse takes, diffuse gives, specular takes, specular gives |
//!
//! - A lobe **takes** light from its neighbours where the surface has it and it is not a mirror's: the diffuse lobe counts
//!   as roughness 1, the specular one needs [`EdgeParams::specular_code_min`]. What does not take is left alone.
//! - A lobe **gives** where it takes, something was traced and the numbers are valid ([`crate::light`]). A traced pixel whose lobe drew no
//!   sample gives its 0 (see the crate's page).
//!
//! The weights that filters share (`edge.inc.wgsl`), for a pixel p and its tap q:
//!
//! ```text
//! plane  d(p, q) = |g_p . (x_q - x_p)| / f_p      in rows: x positions (m), g the triangle's normal,
//!                                                 f_p = z_p 2 |up| / height, what a row spans at p's depth
//! lobe   w_r = exp(-|q - p|^2 / (2 r^2)) max(0, 1 - |R_q - R_p| / (fraction R_p))
//!        r = spread R_p^2 height / (2 |up|)       in rows
//! ```
//!
//! The distance from p's plane replaces differences of depth and distances between points: neither needs screen
//! gradients, which are wrong at silhouettes, and a wall seen at a grazing angle counts as one surface. r is the specular
//! lobe's rule: a GGX lobe of roughness R has a slope of R^2, so that many radians is how sharp a reflection can be, and a
//! kernel should span a share of it. A mirror's r is 0.

pub mod reference;

use crate::lobes;
use frame::info::Frame;
use frame::{
    Bind, Buffer, GBuffer, Gpu, GpuError, Kernel, RadianceImage, Recorder, Room, Texture, Uniform, gpu_struct,
};
use wgpu::TextureFormat;

/// Functions `edge_…`; after [`frame::info::WGSL`] and [`frame::surface::WGSL`].
pub const WGSL: &str = include_str!("edge.inc.wgsl");

/// Of the packed picture.
pub const FORMAT: TextureFormat = TextureFormat::Rgba32Uint;

pub(crate) const LOBE_SPREAD_DOC: &str = "share of the specular lobe's slope (roughness squared) that its kernel spans on the \
     screen; higher blurs reflections, lower leaves their noise. Ours: a quarter, as what is reflected lies behind the \
     surface and seems half as wide";
pub(crate) const ROUGHNESS_FRACTION_DOC: &str = "how far the roughness of a specular tap may differ from the pixel's, \
     relative to it; higher mixes unlike reflections, lower splits textured ones. Ours: a half";
pub(crate) const ROUGHNESS_MIN_DOC: &str = "least roughness that the specular lobe is filtered at; below lie mirrors and \
     clear glass, which keep their pictures. Ours: as in five_phase, 0.02";

const NO_SPECULAR: u32 = 256;
const OBJECT_MASK: u32 = 0x0fff_ffff;

gpu_struct! {
    /// See `pack.wgsl`.
    pub struct EdgeParams {
        /// Least roughness code that the specular lobe is filtered at; above 255: not at all.
        pub specular_code_min: u32,
        /// The object bits that are kept.
        pub object_mask: u32,
        /// To 16 bytes.
        pub _pad: [u32; 2],
    }
}

impl EdgeParams {
    /// The first of the 256 codes that reaches `roughness_min` (0.001 code forgives its own rounding); `has_objects` false
    /// leaves the object bits 0, and `motion_id` may hold anything.
    pub fn new(roughness_min: f32, has_specular: bool, has_objects: bool) -> Self {
        let code = (255.0 * roughness_min - 1e-3).ceil().max(0.0) as u32;
        Self {
            specular_code_min: if has_specular { code } else { NO_SPECULAR },
            object_mask: if has_objects { OBJECT_MASK } else { 0 },
            _pad: [0; 2],
        }
    }
}

/// Pixels from the centre to the first and the second tap of a five-tap kernel, along x and y, `level` doublings on. Rows
/// are what a level counts in; along a row times `columns_per_row`, to the nearest pixel, so that footprints are square on
/// the display.
pub fn taps(level: u32, columns_per_row: f32) -> [[i32; 2]; 2] {
    [1, 2].map(|tap| {
        let rows = tap << level;
        [(rows as f32 * columns_per_row + 0.5).floor() as i32, rows]
    })
}

/// Packs the edges.
pub struct EdgePacker {
    pass: String,
    kernel: Kernel,
    invalid: Buffer,
}

impl EdgePacker {
    /// Compiles the kernel; `name` is that of its pass.
    ///
    /// # Errors
    /// It was refused.
    pub fn new(gpu: &Gpu, name: &str) -> Result<Self, GpuError> {
        let bindings = [
            Bind::uniform::<Frame>(0, 0, "frame"),
            Bind::uniform::<EdgeParams>(0, 1, "params"),
            Bind::texture_uint(2, 0, "in_surface"),
            Bind::texture(2, 1, "in_distance"),
            Bind::texture_uint(2, 2, "in_face_normal"),
            Bind::texture_uint(2, 3, "in_motion_id"),
            Bind::texture(2, 4, "in_diffuse"),
            Bind::texture(2, 5, "in_specular"),
            Bind::texture_uint(2, 6, "in_samples"),
            Bind::storage_texture(3, 0, "out_edge", FORMAT),
            Bind::storage(3, 1, "out_invalid"),
        ];
        let kernel = lobes::kernel(gpu, name, "edge_pack", &[include_str!("pack.wgsl")], &bindings, &[])?;
        let invalid = gpu.storage(Room::Radiance, "EdgePacker::invalid", &[0u32; 2])?;
        Ok(Self { pass: name.into(), kernel, invalid })
    }

    /// Records the pass; pixels whose light is not valid are counted as `denoise_invalid`.
    pub fn pack(
        &self,
        recorder: &mut Recorder<'_>,
        uniform: &Uniform,
        params: &EdgeParams,
        guides: &GBuffer,
        noisy: &RadianceImage,
        edge: &Texture,
    ) {
        use wgpu::BindingResource::TextureView as View;
        recorder.clear(&self.invalid);
        let params = recorder.uniform(params);
        recorder.compute(
            &self.pass,
            &self.kernel,
            &[
                uniform.binding(),
                params.binding(),
                View(guides.surface.view()),
                View(guides.distance.view()),
                View(guides.face_normal.view()),
                View(guides.motion_id.view()),
                // What stands in for a missing lobe changes nothing: no pixel takes it.
                View(lobes::of(noisy)[0].view()),
                View(lobes::of(noisy)[1].view()),
                View(noisy.samples.view()),
                View(edge.view()),
                self.invalid.as_entire_binding(),
            ],
            lobes::workgroups(noisy.size()),
        );
        recorder.counter("denoise_invalid", &self.invalid, 0);
    }
}
