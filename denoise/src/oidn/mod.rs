//! Open Image Denoise: a trained network, as the ceiling of quality to measure the others by.
//!
//! Source: Áfra, "Intel Open Image Denoise". Only with the cargo feature `oidn`; the library itself is looked for when
//! pictures are allocated: `libOpenImageDenoise` of version 2 where the system finds it, or the file that the environment
//! variable [`LIBRARY_VARIABLE`] names. Nothing is downloaded.
//!
//! In: light at trace size ([`RadianceImage`]), `surface` and `distance` of the G-buffer. Out: the same light, less noisy.
//! The lobes are filtered one after the other on the CPU, each modulated as the picture will be (the diffuse one by
//! max(albedo, 0.01), the specular one by nothing), with albedo and shading normal as clean guides, and divided again. What
//! was not hit, and a mirror's specular light (roughness below `roughness_min`), stays as it is; light that is not valid is
//! mended first and counted ([`crate::light`]).
//!
//! It is exempt from some rules of this crate: constant light comes back constant to 2 %, not to the bit, its passes have no
//! times on the GPU, and it waits for the device to read the light back. Should the library fail in a frame (memory), that
//! frame's light passes by unfiltered.

mod library;

use crate::light::reference::{is_valid, mended};
use crate::lobes;
use crate::{Denoiser, Guides, Need, edge};
use frame::cpu::Image;
use frame::info::FrameInfo;
use frame::surface::Surface;
use frame::{Buffer, GBuffer, Gpu, GpuError, Knob, RadianceImage, Recorder, Room, Texture, Uniform};
use glam::IVec2;
use half::f16;
use library::{Images, Library};

/// Environment variable that names the library's file.
pub const LIBRARY_VARIABLE: &str = "GRIDLIGHT_OIDN";

/// Least albedo that light is divided by.
const ALBEDO_MIN: f32 = 0.01;
/// In the order of [`QUALITIES`], as the library numbers them.
const QUALITY_CODES: [i32; 3] = [6, 5, 4];
/// The network's effort.
pub const QUALITIES: &[&str] = &["high", "balanced", "fast"];

/// Why the library is of no use.
#[derive(Debug, thiserror::Error)]
pub enum OidnError {
    /// No file of its names, or one without its functions.
    #[error("Open Image Denoise is not installed ({message}); install version 2 or set {LIBRARY_VARIABLE}")]
    NotFound {
        /// The loader's words.
        message: String,
    },
    /// Another generation.
    #[error("Open Image Denoise has version {found}, version {wanted} is needed")]
    Version {
        /// Its major number.
        found: i32,
        /// Ours.
        wanted: i32,
    },
    /// Pictures that do not fit together.
    #[error("a picture has {found} pixels, the others {wanted}")]
    Length {
        /// Its pixels.
        found: usize,
        /// Width times height.
        wanted: usize,
    },
    /// Its own words.
    #[error("Open Image Denoise: {message}")]
    Refused {
        /// What it says.
        message: String,
    },
}

/// The network.
pub struct Oidn {
    quality: u32,
    has_clean_guides: bool,
    roughness_min: f32,
    library: Option<Library>,
    invalid: Buffer,
    output: [Texture; 2],
}

impl Oidn {
    /// Looks for nothing yet: lists of what there is work without the library.
    ///
    /// # Errors
    /// Out of memory.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        Ok(Self {
            quality: 0,
            has_clean_guides: true,
            roughness_min: 0.02,
            library: None,
            invalid: gpu.storage(Room::Radiance, "Oidn::invalid", &[0u32; 2])?,
            output: lobes::pair(gpu, Room::Radiance, "Oidn::output", [1, 1], false)?,
        })
    }

    /// One lobe, mended and filtered; `None` where reading or the library failed.
    fn filtered(
        &self,
        light: &Image<[f32; 4]>,
        surfaces: &[Option<Surface>],
        is_diffuse: bool,
    ) -> Option<Vec<[f16; 4]>> {
        let library = self.library.as_ref()?;
        let [width, _] = light.size();
        let clean: Vec<[f32; 4]> = (0..surfaces.len() as u32)
            .map(|i| mended(light, IVec2::new((i % width) as i32, (i / width) as i32)))
            .collect();
        let albedo = |surface: &Option<Surface>| surface.as_ref().map_or([0.0; 3], |s| s.base.to_array());
        let modulator = |surface: &Option<Surface>| {
            if is_diffuse { albedo(surface).map(|v| v.max(ALBEDO_MIN)) } else { [1.0; 3] }
        };
        let color: Vec<[f32; 3]> = clean
            .iter()
            .zip(surfaces)
            .map(|(texel, surface)| {
                let m = modulator(surface);
                [texel[0] * m[0], texel[1] * m[1], texel[2] * m[2]]
            })
            .collect();
        let albedos: Vec<_> = surfaces.iter().map(albedo).collect();
        let normals: Vec<[f32; 3]> =
            surfaces.iter().map(|s| s.as_ref().map_or([0.0; 3], |s| s.normal.to_array())).collect();
        let images = Images { color: &color, albedo: &albedos, normal: &normals, size: light.size() };
        let quality = QUALITY_CODES.get(self.quality as usize).copied().unwrap_or(QUALITY_CODES[0]);
        let found = library.filter(&images, self.has_clean_guides, quality).ok()?;
        let stays = |surface: &Surface| {
            !is_diffuse && surface.roughness.max_element() < self.roughness_min
                || is_diffuse && surface.base.max_element() <= 0.0
        };
        Some(
            clean
                .iter()
                .zip(surfaces)
                .zip(found)
                .map(|((before, surface), rgb)| {
                    let passes = surface.as_ref().is_none_or(stays);
                    let m = modulator(surface);
                    let [r, g, b] = [0, 1, 2].map(|c| (rgb[c] / m[c]).clamp(0.0, 65504.0));
                    (if passes { *before } else { [r, g, b, before[3]] }).map(f16::from_f32)
                })
                .collect(),
        )
    }
}

/// A lobe, read back.
fn read(gpu: &Gpu, texture: &Texture) -> Option<Image<[f32; 4]>> {
    let texels = gpu.read_texture::<[f16; 4]>(texture).ok()?;
    let texels = texels.into_iter().map(|texel| texel.map(f16::to_f32)).collect();
    Image::from_texels([texture.width(), texture.height()], texels)
}

fn write(gpu: &Gpu, texture: &Texture, texels: &[[f16; 4]]) {
    let layout = wgpu::TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(8 * texture.width()),
        rows_per_image: Some(texture.height()),
    };
    gpu.queue.write_texture(texture.as_image_copy(), bytemuck::cast_slice(texels), layout, texture.size());
}

impl Denoiser for Oidn {
    fn name(&self) -> &'static str {
        "oidn"
    }

    fn knobs(&mut self) -> Vec<Knob<'_>> {
        vec![
            Knob::choice(
                "quality",
                &mut self.quality,
                QUALITIES,
                "the network's effort; fast takes about a quarter of high's time. high: it is here as a ceiling",
            ),
            Knob::bool(
                "clean_guides",
                &mut self.has_clean_guides,
                "whether albedo and normal are free of noise, as a rasterised G-buffer's are: on",
            ),
            Knob::float("roughness_min", &mut self.roughness_min, 0.0..=1.0, "", edge::ROUGHNESS_MIN_DOC),
        ]
    }

    fn guides(&self) -> Guides {
        Guides { surface: Need::Required, distance: Need::Required, ..Guides::default() }
    }

    fn history_bytes(&self) -> u64 {
        0
    }

    fn energy_bound(&self) -> f32 {
        // A network promises nothing; a firefly it takes for noise.
        1.0
    }

    fn resize(&mut self, gpu: &Gpu, size: [u32; 2], specular: bool) -> Result<(), GpuError> {
        if self.library.is_none() {
            let library = Library::open(std::env::var_os(LIBRARY_VARIABLE));
            self.library = Some(library.map_err(|e| GpuError::Library { message: e.to_string() })?);
        }
        self.output = lobes::pair(gpu, Room::Radiance, "Oidn::output", size, specular)?;
        Ok(())
    }

    fn denoise(
        &mut self,
        recorder: &mut Recorder<'_>,
        _frame: &FrameInfo,
        _uniform: &Uniform,
        guides: &GBuffer,
        noisy: &RadianceImage,
    ) -> RadianceImage {
        let gpu = recorder.gpu();
        recorder.flush();
        let run = || -> Option<(Vec<Vec<[f16; 4]>>, u32)> {
            let distances: Vec<f32> = gpu.read_texture(&guides.distance).ok()?;
            let packed: Vec<[u32; 4]> = gpu.read_texture(&guides.surface).ok()?;
            let is_hit = |distance: f32| distance > 0.0 && distance.is_finite();
            let surfaces: Vec<Option<Surface>> = packed
                .into_iter()
                .zip(distances)
                .map(|(words, distance)| is_hit(distance).then(|| Surface::unpack_gbuffer(words)))
                .collect();
            let diffuse = read(gpu, &noisy.diffuse)?;
            let specular = noisy.specular.as_ref().map(|texture| read(gpu, texture));
            let lobes: Vec<Image<[f32; 4]>> =
                std::iter::once(Some(diffuse)).chain(specular).collect::<Option<_>>()?;
            let invalid =
                (0..surfaces.len()).filter(|i| lobes.iter().any(|lobe| !is_valid(lobe.texels()[*i]))).count();
            let filter =
                |(lobe, light): (usize, &Image<[f32; 4]>)| self.filtered(light, &surfaces, lobe == 0);
            Some((lobes.iter().enumerate().map(filter).collect::<Option<_>>()?, invalid as u32))
        };
        match run() {
            Some((lobes, invalid)) => {
                for (texels, texture) in lobes.iter().zip(&self.output) {
                    write(gpu, texture, texels);
                }
                gpu.queue.write_buffer(&self.invalid, 0, bytemuck::bytes_of(&[invalid, 0]));
                recorder.counter("denoise_invalid", &self.invalid, 0);
                lobes::clean(recorder, "oidn", noisy, self.output.each_ref())
            }
            None => noisy.clone(),
        }
    }
}

#[cfg(test)]
mod tests;
