//! The images that travel: G-buffer, light, picture.

use crate::{Gpu, GpuError, Room, Texture};
use wgpu::{TextureFormat, TextureUsages};

/// Functions `half_rounded` and `half_is_finite`, for whoever stores into these images.
pub const HALF_WGSL: &str = include_str!("half.inc.wgsl");

// Copied from to look at them, copied to where somebody else drew them.
const SAMPLED: TextureUsages =
    TextureUsages::TEXTURE_BINDING.union(TextureUsages::COPY_SRC).union(TextureUsages::COPY_DST);

/// What the camera sees, per pixel: the paper's "same information" that voxels hold, from its gather pass.
///
/// | field | format | meaning |
/// | --- | --- | --- |
/// | `surface` | `rgba32uint` | [`crate::surface`], G-buffer form |
/// | `distance` | `r32float` | along the camera ray, m; 0 where nothing was hit |
/// | `face_normal` | `r32uint` | of the triangle, turned to the viewer; octahedral 16 + 16 |
/// | `motion_id` | `rg32uint` | x: two packed half floats, this pixel minus where it was last frame, in pixels of this image; y: object + 1, 0 = nothing, top bit: its back is seen |
#[derive(Clone)]
pub struct GBuffer {
    /// Packed surface.
    pub surface: Texture,
    /// Metres along the ray.
    pub distance: Texture,
    /// Packed normal of the triangle.
    pub face_normal: Texture,
    /// Packed motion and object.
    pub motion_id: Texture,
}

impl GBuffer {
    /// The formats in target order: exactly the 32 bytes and 4 targets of the default limits.
    pub const FORMATS: [TextureFormat; 4] =
        [TextureFormat::Rgba32Uint, TextureFormat::R32Float, TextureFormat::R32Uint, TextureFormat::Rg32Uint];

    /// Allocates all four.
    ///
    /// # Errors
    /// Too large, or out of memory.
    pub fn new(gpu: &Gpu, size: [u32; 2]) -> Result<Self, GpuError> {
        let usage = SAMPLED | TextureUsages::RENDER_ATTACHMENT | TextureUsages::STORAGE_BINDING;
        let make = |label, format| gpu.texture(Room::GBuffer, label, [size[0], size[1], 1], 1, format, usage);
        Ok(Self {
            surface: make("GBuffer::surface", Self::FORMATS[0])?,
            distance: make("GBuffer::distance", Self::FORMATS[1])?,
            face_normal: make("GBuffer::face_normal", Self::FORMATS[2])?,
            motion_id: make("GBuffer::motion_id", Self::FORMATS[3])?,
        })
    }

    /// Pixels.
    pub fn size(&self) -> [u32; 2] {
        [self.surface.width(), self.surface.height()]
    }
}

/// Demodulated light at trace size.
///
/// rgb is radiance times the scene's `radiance_scale`, with the first hit's modulator left out; a is the mean length of
/// the lobe's first segments in metres (misses and longer ones count as the scene's diagonal; 0 = no sample).
#[derive(Clone)]
pub struct RadianceImage {
    /// `rgba16float`.
    pub diffuse: Texture,
    /// `rgba16float`; absent where no surface of the scene has a specular lobe.
    pub specular: Option<Texture>,
    /// `r32uint`: samples of the diffuse lobe in the low half, of the specular one in the high half.
    pub samples: Texture,
}

impl RadianceImage {
    /// Format of both lobes.
    pub const FORMAT: TextureFormat = TextureFormat::Rgba16Float;

    /// Allocates the lobes and the sample counts.
    ///
    /// # Errors
    /// Too large, or out of memory.
    pub fn new(gpu: &Gpu, size: [u32; 2], specular: bool) -> Result<Self, GpuError> {
        Ok(Self {
            diffuse: Self::lobe(gpu, "RadianceImage::diffuse", size)?,
            specular: specular.then(|| Self::lobe(gpu, "RadianceImage::specular", size)).transpose()?,
            samples: gpu.texture(
                Room::Radiance,
                "RadianceImage::samples",
                [size[0], size[1], 1],
                1,
                TextureFormat::R32Uint,
                SAMPLED | TextureUsages::STORAGE_BINDING,
            )?,
        })
    }

    /// One lobe's texture: stages that filter allocate theirs with this.
    ///
    /// # Errors
    /// Too large, or out of memory.
    pub fn lobe(gpu: &Gpu, label: &str, size: [u32; 2]) -> Result<Texture, GpuError> {
        let usage = SAMPLED | TextureUsages::STORAGE_BINDING;
        gpu.texture(Room::Radiance, label, [size[0], size[1], 1], 1, Self::FORMAT, usage)
    }

    /// Pixels.
    pub fn size(&self) -> [u32; 2] {
        [self.diffuse.width(), self.diffuse.height()]
    }
}

/// The picture: linear radiance times `radiance_scale` after modulation, display size, `rgba16float`, a = 1.
#[derive(Clone)]
pub struct ColorImage {
    /// The texture.
    pub texture: Texture,
}

impl ColorImage {
    /// Its format.
    pub const FORMAT: TextureFormat = TextureFormat::Rgba16Float;

    /// Allocates it.
    ///
    /// # Errors
    /// Too large, or out of memory.
    pub fn new(gpu: &Gpu, size: [u32; 2]) -> Result<Self, GpuError> {
        let usage = SAMPLED | TextureUsages::STORAGE_BINDING;
        let label = "ColorImage::texture";
        let texture = gpu.texture(Room::Radiance, label, [size[0], size[1], 1], 1, Self::FORMAT, usage)?;
        Ok(Self { texture })
    }

    /// Pixels.
    pub fn size(&self) -> [u32; 2] {
        [self.texture.width(), self.texture.height()]
    }
}
