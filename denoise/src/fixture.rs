//! The pictures that tests of this crate are made on, and how they are run and compared.
#![allow(clippy::unwrap_used, clippy::panic)]

use crate::Denoiser;
use crate::light::reference::Light;
use frame::cpu::Image;
use frame::info::FrameInfo;
use frame::surface::{Surface, face_normal_pack, hash};
use frame::{FrameLog, GBuffer, Gpu, RadianceImage, Recorder, Room, Texture};
use glam::{Vec2, Vec3};
use half::f16;
use wgpu::{TextureFormat, TextureUsages};

/// Tests need an adapter; a software one will do.
pub fn gpu() -> Gpu {
    Gpu::new(None).expect("tests need an adapter, a software one will do")
}

/// Channels that differ by more than `steps` steps of a half float, relative and next to 0.
pub fn outliers(gpu: &[[f16; 4]], cpu: &Image<[f32; 4]>, steps: f32) -> usize {
    let tolerance = |value: f32| steps * (2f32.powi(-10) * value.abs() + 2f32.powi(-24));
    let pairs = gpu.as_flattened().iter().zip(cpu.texels().as_flattened());
    let far = |gpu: f32, cpu: f32| !gpu.is_finite() || (gpu - cpu).abs() > tolerance(cpu);
    pairs.filter(|(gpu, cpu)| far(gpu.to_f32(), **cpu)).count()
}

/// In [0, 1), from two numbers.
pub fn random(seed: u32, index: u32) -> f32 {
    (hash(hash(seed) ^ index) >> 8) as f32 / 16_777_216.0
}

/// A picture as a half float stores it.
pub fn halves(image: &Image<[f32; 4]>) -> Vec<[f16; 4]> {
    image.texels().iter().map(|texel| texel.map(f16::from_f32)).collect()
}

/// One frame's input, on the CPU.
#[derive(Clone)]
pub struct Shot {
    pub frame: FrameInfo,
    pub surface: Image<[u32; 4]>,
    pub distance: Image<f32>,
    /// Face normal, then motion and object.
    pub others: Image<[u32; 3]>,
    pub noisy: Light,
}

/// One frame's output, on the CPU: bits of both lobes.
#[derive(Clone, Debug, PartialEq)]
pub struct Clean {
    pub diffuse: Vec<[f16; 4]>,
    pub specular: Option<Vec<[f16; 4]>>,
}

impl Clean {
    pub fn is_finite(&self) -> bool {
        self.diffuse.iter().chain(self.specular.iter().flatten()).flatten().all(|x| x.is_finite())
    }
}

impl Shot {
    /// A white rough wall across the view at `z` metres, with light that the caller fills in; every pixel has one
    /// sample in each lobe.
    pub fn wall(size: [u32; 2], z: f32) -> Self {
        let camera = scene::Camera {
            name: String::new(),
            eye: Vec3::new(3.0, -2.0, 5.0),
            target: Vec3::new(3.0, -2.0, 4.0),
            up: Vec3::Y,
            vfov: 0.8,
        };
        let frame = FrameInfo { diagonal: 10.0, ..FrameInfo::still(camera, size) };
        let tan = (0.5 * frame.camera.vfov).tan();
        let aspect = size[0] as f32 / size[1] as f32;
        let distance = Image::from_fn(size, |x, y| {
            let ndc = Vec2::new(x as f32 + 0.5, y as f32 + 0.5) / Vec2::new(size[0] as f32, size[1] as f32)
                * 2.0
                - 1.0;
            z * Vec3::new(ndc.x * tan * aspect, ndc.y * tan, 1.0).length()
        });
        Self {
            frame,
            surface: Image::filled(size, Surface::default().pack_gbuffer(0)),
            distance,
            // Towards the viewer, at rest, the first object.
            others: Image::filled(size, [0, 0, 1]),
            noisy: Light {
                diffuse: Image::filled(size, [0.0; 4]),
                specular: Some(Image::filled(size, [0.0; 4])),
                samples: Image::filled(size, 0x1_0001),
            },
        }
    }

    /// Anything goes: normals, distances, materials, misses, pixels without samples; light between 0 and 4.
    pub fn random(size: [u32; 2], seed: u32) -> Self {
        let mut shot = Self::wall(size, 2.0);
        shot.frame.display_size = [3 * size[0], (9 * size[1]).div_ceil(4)];
        shot.frame.jitter = [0.2, -0.3];
        let draw =
            |x: u32, y: u32, what: u32| random(seed.wrapping_mul(31).wrapping_add(what), y * size[0] + x);
        shot.surface = Image::from_fn(size, |x, y| {
            let tilt = Vec3::new(draw(x, y, 0), draw(x, y, 1), draw(x, y, 2)) - 0.5;
            let kind = draw(x, y, 3);
            let roughness = Vec2::new(draw(x, y, 4), draw(x, y, 5));
            Surface {
                normal: (Vec3::Z + 2.0 * tilt).normalize(),
                base: Vec3::new(draw(x, y, 6), 0.5, 0.25),
                metalness: if kind < 0.3 { 1.0 } else { 0.0 },
                transmission: if kind > 0.9 { 1.0 } else { 0.0 },
                f0: if kind < 0.7 { 0.04 } else { 0.0 },
                roughness: if draw(x, y, 7) < 0.1 { Vec2::ZERO } else { roughness },
                ..Surface::default()
            }
            .pack_gbuffer(hash(x ^ y << 16))
        });
        shot.distance = Image::from_fn(size, |x, y| match draw(x, y, 8) {
            kind if kind < 0.05 => 0.0,
            _ => 2.0 + 0.3 * draw(x, y, 9) + if x > size[0] / 2 { 3.0 } else { 0.0 },
        });
        shot.others = Image::from_fn(size, |x, y| {
            let tilt = Vec3::new(draw(x, y, 40), draw(x, y, 41), draw(x, y, 42)) - 0.5;
            let motion = Vec2::new(draw(x, y, 43), draw(x, y, 44)) - 0.5;
            let object = if draw(x, y, 45) < 0.8 { 1 } else { 2 };
            [face_normal_pack((Vec3::Z + tilt).normalize()), pack_motion(4.0 * motion), object]
        });
        let lobe = |what: u32| {
            Image::from_fn(size, move |x, y| {
                let length = if draw(x, y, what + 4) < 0.2 { 0.0 } else { draw(x, y, what + 3) };
                let light = [draw(x, y, what), draw(x, y, what + 1), draw(x, y, what + 2), length];
                light.map(|v| f16::from_f32(4.0 * v).to_f32())
            })
        };
        shot.noisy = Light {
            diffuse: lobe(10),
            specular: Some(lobe(20)),
            samples: Image::from_fn(size, |x, y| [0, 1, 0x1_0000, 0x2_0003][(4.0 * draw(x, y, 30)) as usize]),
        };
        shot
    }

    /// Makes `count` pixels' light, two lobes in turn, no light: NaN, infinite, above the format's range, negative.
    pub fn break_pixels(&mut self, count: u32) {
        let [width, height] = self.surface.size();
        let kinds = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e5, -1.0];
        for k in 0..count {
            // No two in one place: 7 and the width share no factor where it matters, and 7 * count stays below the area.
            let place = (3 + 7 * k) % (width * height);
            let (x, y) = ((place % width) as i32, (place / width) as i32);
            let kind = kinds[k as usize % kinds.len()];
            let lobe = match &mut self.noisy.specular {
                Some(specular) if k % 2 == 1 => specular,
                _ => &mut self.noisy.diffuse,
            };
            // As a half float stores it: what lies above the range becomes infinite.
            lobe.get_mut(x, y).unwrap()[k as usize % 4] = f16::from_f32(kind).to_f32();
        }
    }

    /// The same picture as frame number `index`, which begins a sequence if it is 0.
    pub fn sequel(&self, index: u32) -> Self {
        let mut next = self.clone();
        next.frame.restart = index == 0;
        next.frame.frame_index = index;
        next
    }

    fn upload(&self, gpu: &Gpu) -> (GBuffer, RadianceImage) {
        let size = self.surface.size();
        let guides = GBuffer {
            surface: upload(gpu, size, TextureFormat::Rgba32Uint, self.surface.texels()),
            distance: upload(gpu, size, TextureFormat::R32Float, self.distance.texels()),
            face_normal: upload(gpu, size, TextureFormat::R32Uint, self.others.map(|t| t[0]).texels()),
            motion_id: upload(gpu, size, TextureFormat::Rg32Uint, self.others.map(|t| [t[1], t[2]]).texels()),
        };
        let lobe = |image| upload(gpu, size, RadianceImage::FORMAT, &halves(image));
        let noisy = RadianceImage {
            diffuse: lobe(&self.noisy.diffuse),
            specular: self.noisy.specular.as_ref().map(lobe),
            samples: upload(gpu, size, TextureFormat::R32Uint, self.noisy.samples.texels()),
        };
        (guides, noisy)
    }

    /// Runs a denoiser without a resize before: its history stays.
    pub fn next(&self, gpu: &Gpu, denoiser: &mut dyn Denoiser) -> (Clean, FrameLog) {
        let (guides, noisy) = self.upload(gpu);
        let mut recorder = Recorder::new(gpu);
        let uniform = recorder.uniform(&self.frame.uniform());
        let clean = denoiser.denoise(&mut recorder, &self.frame, &uniform, &guides, &noisy);
        let log = recorder.finish().unwrap();
        let read = |texture: &Texture| gpu.read_texture::<[f16; 4]>(texture).unwrap();
        (Clean { diffuse: read(&clean.diffuse), specular: clean.specular.as_ref().map(read) }, log)
    }

    /// Runs a denoiser once.
    pub fn denoise(&self, gpu: &Gpu, denoiser: &mut dyn Denoiser) -> (Clean, FrameLog) {
        denoiser.resize(gpu, self.surface.size(), self.noisy.specular.is_some()).unwrap();
        self.next(gpu, denoiser)
    }
}

/// As `motion_id.x` has it.
pub fn pack_motion(motion: Vec2) -> u32 {
    let [x, y] = [motion.x, motion.y].map(|v| u32::from(f16::from_f32(v).to_bits()));
    x | (y << 16)
}

/// A picture that an earlier frame wrote.
pub fn read<T: bytemuck::Pod>(gpu: &Gpu, log: &FrameLog, name: &str) -> Vec<T> {
    let (_, texture) = log.outputs.iter().find(|(known, _)| known == name).unwrap();
    gpu.read_texture::<T>(texture).unwrap()
}

/// Independent light for each frame, uniform between 0 and 2.
pub fn noise(size: [u32; 2], seed: u32) -> Image<[f32; 4]> {
    Image::from_fn(size, |x, y| {
        let red = f16::from_f32(2.0 * random(seed, size[0] * y + x)).to_f32();
        [red, 0.0, 0.0, 1.0]
    })
}

fn upload<T: bytemuck::NoUninit>(
    gpu: &Gpu,
    [width, height]: [u32; 2],
    format: TextureFormat,
    texels: &[T],
) -> Texture {
    let usage = TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST | TextureUsages::COPY_SRC;
    let texture = gpu.texture(Room::Frame, "tests::upload", [width, height, 1], 1, format, usage).unwrap();
    gpu.queue.write_texture(
        texture.as_image_copy(),
        bytemuck::cast_slice(texels),
        wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(width * size_of::<T>() as u32),
            rows_per_image: Some(height),
        },
        texture.size(),
    );
    texture
}
