//! What filters that stop at edges ask about a pixel, packed once per frame; shared by [`crate::atrous`] and
//! `svgf`.
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
//! - A lobe **gives** where it takes, something was traced and the numbers are finite. A traced pixel whose lobe drew no
//!   sample gives its 0 (see the crate's page).
//!
//! The weights that both filters share (`edge.inc.wgsl`), for a pixel p and its tap q:
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

use frame::info::Frame;
use frame::{
    Bind, Buffer, GBuffer, Gpu, GpuError, HALF_WGSL, Kernel, KernelDesc, RadianceImage, Recorder, Room,
    Texture, Uniform, brdf, gpu_struct, info, surface,
};
use wgpu::{TextureFormat, TextureUsages};

/// Functions `edge_…`; after [`info::WGSL`], [`surface::WGSL`] and [`HALF_WGSL`].
pub const WGSL: &str = include_str!("edge.inc.wgsl");

/// Of every kernel here.
pub const WORKGROUP: [u32; 3] = [8, 8, 1];

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

/// A picture of the edges.
///
/// # Errors
/// Too large, or out of memory.
pub fn texture(gpu: &Gpu, room: Room, label: &str, [width, height]: [u32; 2]) -> Result<Texture, GpuError> {
    let usage = TextureUsages::TEXTURE_BINDING | TextureUsages::STORAGE_BINDING | TextureUsages::COPY_SRC;
    gpu.texture(room, label, [width, height, 1], 1, TextureFormat::Rgba32Uint, usage)
}

/// Packs the edges.
pub struct EdgePacker {
    name: &'static str,
    kernel: Kernel,
    non_finite: Buffer,
}

impl EdgePacker {
    /// Compiles the kernel; `name` is that of its pass.
    ///
    /// # Errors
    /// It was refused.
    pub fn new(gpu: &Gpu, name: &'static str) -> Result<Self, GpuError> {
        let kernel = Kernel::new(
            gpu,
            &KernelDesc {
                name,
                sources: &[info::WGSL, surface::WGSL, brdf::WGSL, HALF_WGSL, WGSL, include_str!("pack.wgsl")],
                entry: "edge_pack",
                workgroup: WORKGROUP,
                bindings: &[
                    Bind::uniform::<Frame>(0, 0, "frame"),
                    Bind::uniform::<EdgeParams>(0, 1, "params"),
                    Bind::texture_uint(2, 0, "in_surface"),
                    Bind::texture(2, 1, "in_distance"),
                    Bind::texture_uint(2, 2, "in_face_normal"),
                    Bind::texture_uint(2, 3, "in_motion_id"),
                    Bind::texture(2, 4, "in_diffuse"),
                    Bind::texture(2, 5, "in_specular"),
                    Bind::texture_uint(2, 6, "in_samples"),
                    Bind::storage_texture(3, 0, "out_edge", TextureFormat::Rgba32Uint),
                    Bind::storage(3, 1, "out_non_finite"),
                ],
                constants: &[],
            },
        )?;
        let non_finite = gpu.storage(Room::Radiance, "EdgePacker::non_finite", &[0u32; 2])?;
        Ok(Self { name, kernel, non_finite })
    }

    /// Records the pass; pixels whose light is not finite are counted as `denoise_non_finite`.
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
        recorder.clear(&self.non_finite);
        let params = recorder.uniform(params);
        recorder.compute(
            self.name,
            &self.kernel,
            &[
                uniform.binding(),
                params.binding(),
                View(guides.surface.view()),
                View(guides.distance.view()),
                View(guides.face_normal.view()),
                View(guides.motion_id.view()),
                View(noisy.diffuse.view()),
                // What stands in for a missing lobe changes nothing: no pixel takes it.
                View(noisy.specular.as_ref().unwrap_or(&noisy.diffuse).view()),
                View(noisy.samples.view()),
                View(edge.view()),
                self.non_finite.as_entire_binding(),
            ],
            workgroups(noisy.size()),
        );
        recorder.counter("denoise_non_finite", &self.non_finite, 0);
    }
}

/// Groups of [`WORKGROUP`] that cover a picture.
pub fn workgroups([width, height]: [u32; 2]) -> [u32; 3] {
    [width.div_ceil(WORKGROUP[0]), height.div_ceil(WORKGROUP[1]), 1]
}
