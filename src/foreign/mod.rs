//! Denoises pictures that another renderer wrote: layers of an OpenEXR file in, the filtered picture out.
//!
//! In: a file whose layers [`layers`] finds by their common names: the picture, normals, depth, and optionally albedo,
//! roughness, emission and motion. Out: linear radiance.
//!
//! One lobe: the picture less its emission, divided by max(albedo, 0.01), is filtered as diffuse light where no roughness is
//! given, as specular light of that roughness where it is, and modulated again afterwards. Files of ours (`light.exr`) hold
//! two lobes that were never modulated, and the picture is put together from both as far as the file knows how (see
//! [`Light`]). Where nothing was hit the picture passes by unchanged.
//!
//! Stored light is scaled by a power of two, so that half floats hold its brightest pixel.

pub mod layers;
pub mod view;

pub use layers::Picture;
pub use view::{DepthKind, View};

use crate::Error;
use denoise::Denoiser;
use frame::cpu::{Image, luminance};
use frame::surface::{Surface, face_normal_pack};
use frame::{FrameInfo, FrameLog, GBuffer, Gpu, RadianceImage, Recorder, Texture};
use glam::{Vec2, Vec3};
use half::f16;
use std::time::Instant;

/// Least albedo that light is divided by.
const ALBEDO_MIN: f32 = 0.01;

/// Half floats hold up to 65,504; sums of a filter get some room.
const LARGEST: f32 = 32768.0;

/// Light of a picture as filters take it.
pub struct Light {
    /// Diffuse and specular, unscaled; either may be missing.
    lobes: [Option<Image<[f32; 4]>>; 2],
    scale: f32,
}

impl Light {
    /// Divides by the albedo and finds the scale.
    pub fn of(picture: &Picture) -> Self {
        let lobes = match &picture.lobes {
            Some(lobes) => lobes.clone().map(Some),
            None => {
                let light = Image::from_fn(picture.size, |x, y| {
                    let [x, y] = [x as i32, y as i32];
                    let color = picture.color.get(x, y).unwrap_or_default();
                    let emission = picture.emission.as_ref().and_then(|e| e.get(x, y)).unwrap_or_default();
                    let albedo = picture.albedo_at(x, y);
                    let light = |c: usize| (color[c] - emission[c]).max(0.0) / albedo[c].max(ALBEDO_MIN);
                    // `max` would hide what is no number.
                    let rgb = [0, 1, 2].map(|c| if color[c].is_nan() { f32::NAN } else { light(c) });
                    [rgb[0], rgb[1], rgb[2], 0.0]
                });
                match picture.roughness {
                    Some(_) => [None, Some(light)],
                    None => [Some(light), None],
                }
            }
        };
        let finite =
            |texel: &[f32; 4]| texel[..3].iter().copied().filter(|v| v.is_finite()).fold(0.0, f32::max);
        let texels = || lobes.iter().flatten().flat_map(Image::texels);
        let largest = texels().map(finite).fold(0.0f32, f32::max);
        let count = texels().count().max(1);
        let mean =
            texels().map(|[r, g, b, _]| luminance([*r, *g, *b])).filter(|y| y.is_finite()).sum::<f32>()
                / count as f32;
        // The brightest pixel fits, unless that would leave the mean fewer than ten bits.
        let exponent = (LARGEST / largest.max(f32::MIN_POSITIVE)).log2().floor();
        let least = (2f32.powi(-10) / mean.max(f32::MIN_POSITIVE)).log2().ceil();
        Self { lobes, scale: exponent.max(least).clamp(-60.0, 0.0).exp2() }
    }

    /// Whether there is a specular lobe.
    pub fn has_specular(&self) -> bool {
        self.lobes[1].is_some()
    }

    /// Power of two that stored light is multiplied with.
    pub fn scale(&self) -> f32 {
        self.scale
    }
}

/// A denoiser with the textures of one size.
pub struct Bench {
    gpu: Gpu,
    denoiser: Box<dyn Denoiser>,
    guides: GBuffer,
    noisy: RadianceImage,
}

/// One run.
pub struct Filtered {
    /// Passes and counts.
    pub log: FrameLog,
    /// From the first command recorded to the last one done, files and transfers left out.
    pub wall_ms: f64,
    result: RadianceImage,
}

impl Bench {
    /// Allocates for pictures of this kind.
    ///
    /// # Errors
    /// Too large, or out of memory.
    pub fn new(
        gpu: Gpu,
        mut denoiser: Box<dyn Denoiser>,
        size: [u32; 2],
        has_specular: bool,
    ) -> Result<Self, Error> {
        denoiser.resize(&gpu, size, has_specular)?;
        let (guides, noisy) = (GBuffer::new(&gpu, size)?, RadianceImage::new(&gpu, size, has_specular)?);
        Ok(Self { gpu, denoiser, guides, noisy })
    }

    /// Whether there is a specular lobe.
    pub fn has_specular(&self) -> bool {
        self.noisy.specular.is_some()
    }

    /// Hands a picture and its light to the device.
    pub fn upload(&self, picture: &Picture, view: &View, light: &Light) {
        let size = picture.size;
        let has = [light.lobes[0].is_some(), light.lobes[1].is_some()];
        let surfaces = Image::from_fn(size, |x, y| {
            let [x, y] = [x as i32, y as i32];
            let roughness = picture.roughness.as_ref().and_then(|r| r.get(x, y)).unwrap_or([1.0; 2]);
            let normal = picture.normal.as_ref().and_then(|n| n.get(x, y)).unwrap_or_default();
            let reflects =
                picture.albedo_at(x, y).iter().any(|c| *c >= ALBEDO_MIN) || picture.lobes.is_some();
            let albedo = Vec3::from(picture.albedo_at(x, y));
            Surface {
                normal: Vec3::from(normal).try_normalize().unwrap_or(Vec3::Z),
                // What there is no light of takes no part; what reflects nothing shines by itself, and passes by.
                base: if has[0] && reflects { albedo.clamp(Vec3::ZERO, Vec3::ONE) } else { Vec3::ZERO },
                f0: if has[1] && reflects { 0.04 } else { 0.0 },
                roughness: Vec2::from(roughness).clamp(Vec2::ZERO, Vec2::ONE),
                ..Surface::default()
            }
            .pack_gbuffer(0)
        });
        let motion = Image::from_fn(size, |x, y| {
            let motion = picture.motion.as_ref().and_then(|m| m.get(x as i32, y as i32)).unwrap_or([0.0; 2]);
            let [right, down] = motion.map(|v| u32::from(f16::from_f32(v).to_bits()));
            [right | down << 16, 1]
        });
        let face_normals = view.normals.map(|n| face_normal_pack(Vec3::from(n)));
        self.write(&self.guides.surface, surfaces.texels());
        self.write(&self.guides.distance, view.distance.texels());
        self.write(&self.guides.face_normal, face_normals.texels());
        self.write(&self.guides.motion_id, motion.texels());
        for (lobe, texture) in
            light.lobes.iter().zip([Some(&self.noisy.diffuse), self.noisy.specular.as_ref()])
        {
            let Some(texture) = texture else { continue };
            let dark = Image::filled(size, [0.0; 4]);
            let stored = lobe.as_ref().unwrap_or(&dark).map(|texel| stored(texel, light.scale));
            self.write(texture, stored.texels());
        }
        self.write(&self.noisy.samples, Image::filled(size, 0x1_0001u32).texels());
    }

    fn write<T: bytemuck::NoUninit>(&self, texture: &Texture, texels: &[T]) {
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(texture.width() * size_of::<T>() as u32),
            rows_per_image: Some(texture.height()),
        };
        let bytes = bytemuck::cast_slice(texels);
        self.gpu.queue.write_texture(texture.as_image_copy(), bytes, layout, texture.size());
    }

    /// Filters what was uploaded.
    ///
    /// # Errors
    /// The device was lost or ran out of memory.
    pub fn run(&mut self, frame: &FrameInfo) -> Result<Filtered, Error> {
        // What was handed over is not the filter's time.
        Recorder::new(&self.gpu).finish()?;
        let begin = Instant::now();
        let mut recorder = Recorder::new(&self.gpu);
        let uniform = recorder.uniform(&frame.uniform());
        let result = self.denoiser.denoise(&mut recorder, frame, &uniform, &self.guides, &self.noisy);
        let log = recorder.finish()?;
        Ok(Filtered { log, wall_ms: 1e3 * begin.elapsed().as_secs_f64(), result })
    }

    /// The filtered picture: what was divided out is multiplied back, what passed by is what it was.
    ///
    /// # Errors
    /// Reading back fails.
    pub fn picture(
        &self,
        filtered: &Filtered,
        picture: &Picture,
        view: &View,
        light: &Light,
    ) -> Result<[Image<[f32; 3]>; 2], Error> {
        let read =
            |texture: &Texture| -> Result<Vec<[f16; 4]>, Error> { Ok(self.gpu.read_texture(texture)?) };
        let diffuse = read(&filtered.result.diffuse)?;
        let specular = filtered.result.specular.as_ref().map(read).transpose()?;
        let [width, _] = picture.size;
        let lobe = |texels: &[[f16; 4]], x: u32, y: u32| {
            let texel = texels.get((y * width + x) as usize).copied().unwrap_or_default();
            [0, 1, 2].map(|c| texel[c].to_f32() / light.scale)
        };
        let out = |texels: Option<&[[f16; 4]]>, both: bool| {
            Image::from_fn(picture.size, |x, y| {
                let [px, py] = [x as i32, y as i32];
                if picture.lobes.is_some() {
                    return texels.map_or([0.0; 3], |texels| lobe(texels, x, y));
                }
                let color = picture.color.get(px, py).unwrap_or_default();
                let is_hit = view.distance.get(px, py).is_some_and(|d| d > 0.0);
                if !both || !is_hit && color.iter().all(|v| v.is_finite()) {
                    return color;
                }
                let albedo = picture.albedo_at(px, py);
                let emission = picture.emission.as_ref().and_then(|e| e.get(px, py)).unwrap_or_default();
                let [d, s] = [lobe(&diffuse, x, y), specular.as_ref().map_or([0.0; 3], |s| lobe(s, x, y))];
                [0, 1, 2].map(|c| (d[c] + s[c]) * albedo[c].max(ALBEDO_MIN) + emission[c])
            })
        };
        Ok([out(Some(&diffuse), true), out(specular.as_deref(), false)])
    }
}

/// As the contract stores light: scaled, and infinite above the range, which filters take for no light at all.
fn stored([r, g, b, length]: [f32; 4], scale: f32) -> [f16; 4] {
    [r * scale, g * scale, b * scale, length].map(f16::from_f32)
}

#[cfg(test)]
mod tests;
