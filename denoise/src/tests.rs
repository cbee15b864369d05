//! Promises of every denoiser, and the pictures that tests of this crate are made on.
#![allow(clippy::unwrap_used, clippy::panic)]

use crate::{Denoiser, Guides, Need, all};
use frame::cpu::Image;
use frame::info::FrameInfo;
use frame::surface::{Surface, face_normal_pack, hash};
use frame::{FrameLog, GBuffer, Gpu, RadianceImage, Recorder, Room, Texture};
use glam::{Vec2, Vec3};
use half::f16;
use wgpu::{TextureFormat, TextureUsages};

pub(crate) type Light = crate::five_phase::reference::Light;

/// In [0, 1), from two numbers.
pub(crate) fn random(seed: u32, index: u32) -> f32 {
    (hash(hash(seed) ^ index) >> 8) as f32 / 16_777_216.0
}

/// A picture as a half float stores it.
pub(crate) fn halves(image: &Image<[f32; 4]>) -> Vec<[f16; 4]> {
    image.texels().iter().map(|texel| texel.map(f16::from_f32)).collect()
}

/// One frame's input, on the CPU.
#[derive(Clone)]
pub(crate) struct Shot {
    pub(crate) frame: FrameInfo,
    pub(crate) surface: Image<[u32; 4]>,
    pub(crate) distance: Image<f32>,
    /// Face normal, then motion and object.
    pub(crate) others: Image<[u32; 3]>,
    pub(crate) noisy: Light,
}

/// One frame's output, on the CPU: bits of both lobes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Clean {
    pub(crate) diffuse: Vec<[f16; 4]>,
    pub(crate) specular: Option<Vec<[f16; 4]>>,
}

impl Clean {
    pub(crate) fn is_finite(&self) -> bool {
        self.diffuse.iter().chain(self.specular.iter().flatten()).flatten().all(|x| x.is_finite())
    }
}

impl Shot {
    /// A white rough wall across the view at `z` metres, with light that the caller fills in; every pixel has one
    /// sample in each lobe.
    pub(crate) fn wall(size: [u32; 2], z: f32) -> Self {
        let camera = scene::Camera {
            name: String::new(),
            eye: Vec3::new(3.0, -2.0, 5.0),
            target: Vec3::new(3.0, -2.0, 4.0),
            up: Vec3::Y,
            vfov: 0.8,
        };
        let frame = FrameInfo {
            previous_camera: camera.clone(),
            camera,
            trace_size: size,
            display_size: size,
            jitter: [0.0; 2],
            previous_jitter: [0.0; 2],
            frame_index: 0,
            seed: 1,
            time: 0.0,
            dt: 0.0,
            radiance_scale: 1.0,
            diagonal: 10.0,
            restart: true,
            sun_elsewhere: false,
        };
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
    pub(crate) fn random(size: [u32; 2], seed: u32) -> Self {
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
    pub(crate) fn next(&self, gpu: &Gpu, denoiser: &mut dyn Denoiser) -> (Clean, FrameLog) {
        let (guides, noisy) = self.upload(gpu);
        let mut recorder = Recorder::new(gpu);
        let uniform = recorder.uniform(&self.frame.uniform());
        let clean = denoiser.denoise(&mut recorder, &self.frame, &uniform, &guides, &noisy);
        let log = recorder.finish().unwrap();
        let read = |texture: &Texture| gpu.read_texture::<[f16; 4]>(texture).unwrap();
        (Clean { diffuse: read(&clean.diffuse), specular: clean.specular.as_ref().map(read) }, log)
    }

    /// Runs a denoiser once.
    pub(crate) fn denoise(&self, gpu: &Gpu, denoiser: &mut dyn Denoiser) -> (Clean, FrameLog) {
        denoiser.resize(gpu, self.surface.size(), self.noisy.specular.is_some()).unwrap();
        self.next(gpu, denoiser)
    }
}

/// As `motion_id.x` has it.
pub(crate) fn pack_motion(motion: Vec2) -> u32 {
    let [x, y] = [motion.x, motion.y].map(|v| u32::from(f16::from_f32(v).to_bits()));
    x | (y << 16)
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

fn each(mut check: impl FnMut(&Gpu, &str, &mut dyn Denoiser)) {
    let gpu = Gpu::new(None).expect("tests need an adapter, a software one will do");
    for (name, make) in all() {
        check(&gpu, name, make(&gpu).unwrap().as_mut());
    }
}

#[test]
fn names_are_those_of_the_list() {
    each(|_, name, denoiser| {
        assert_eq!(denoiser.name(), name);
        let mut knobs: Vec<_> = denoiser.knobs().into_iter().map(|knob| knob.name).collect();
        knobs.sort_unstable();
        assert!(knobs.windows(2).all(|pair| pair[0] != pair[1]), "{name}: a knob twice in {knobs:?}");
    });
}

#[test]
fn constant_light_stays_constant_to_the_bit() {
    let mut shot = Shot::random([45, 33], 1);
    let constant = [0.7, 0.001, 1234.5, 2.5].map(|x| f16::from_f32(x).to_f32());
    shot.noisy.diffuse = Image::filled([45, 33], constant);
    shot.noisy.specular = Some(shot.noisy.diffuse.clone());
    // Every pixel traced: what was not may be filled, and then only from neighbours that face it.
    shot.noisy.samples = Image::filled([45, 33], 0x1_0001);
    each(|gpu, name, denoiser| {
        let (clean, _) = shot.denoise(gpu, denoiser);
        assert!(clean.diffuse == halves(&shot.noisy.diffuse), "{name}");
        assert!(clean.specular == Some(halves(&shot.noisy.diffuse)), "{name}");
    });
}

#[test]
fn channels_called_unused_do_not_change_a_bit() {
    let shot = Shot::random([45, 33], 2);
    each(|gpu, name, denoiser| {
        let Guides { surface, distance, face_normal, motion_id } = denoiser.guides();
        let mut poisoned = shot.clone();
        // A quiet NaN as f32, a NaN in both halves as packed half floats.
        let poison = 0x7fc0_7e00;
        if face_normal == Need::Unused {
            poisoned.others = poisoned.others.map(|[_, motion, object]| [poison, motion, object]);
        }
        if motion_id == Need::Unused {
            poisoned.others = poisoned.others.map(|[face_normal, ..]| [face_normal, poison, poison]);
        }
        if surface == Need::Unused {
            poisoned.surface = poisoned.surface.map(|_| [poison; 4]);
        }
        if distance == Need::Unused {
            poisoned.distance = poisoned.distance.map(|_| f32::NAN);
        }
        assert!(poisoned.denoise(gpu, denoiser).0 == shot.denoise(gpu, denoiser).0, "{name}");
    });
}

#[test]
fn the_same_frame_gives_the_same_bits() {
    let shot = Shot::random([64, 48], 3);
    each(|gpu, name, denoiser| {
        let (first, _) = shot.denoise(gpu, denoiser);
        assert!(shot.denoise(gpu, denoiser).0 == first, "{name}");
    });
}

#[test]
fn the_smallest_pictures_and_one_lobe_alone_work() {
    each(|gpu, name, denoiser| {
        for size in [[1, 1], [1, 17], [17, 1], [3, 2]] {
            let mut shot = Shot::random(size, 4);
            let (clean, _) = shot.denoise(gpu, denoiser);
            assert_eq!(clean.diffuse.len(), (size[0] * size[1]) as usize, "{name} at {size:?}");
            shot.noisy.specular = None;
            let (alone, _) = shot.denoise(gpu, denoiser);
            assert_eq!(alone.specular, None, "{name} at {size:?}");
            assert!(alone.diffuse == clean.diffuse, "{name} at {size:?}: the lobes do not touch each other");
        }
    });
}

#[test]
fn any_bits_in_never_come_out_as_nan() {
    let size = [33, 21];
    let word = |x: u32, y: u32, what: u32| hash(hash(what) ^ (y * size[0] + x));
    // Half floats of any bits, and words of any bits, some of them NaN and infinite on purpose.
    let number = |x, y, what| match word(x, y, what) {
        w if w.is_multiple_of(7) => {
            [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 65504.0, 3e38, 1e-40, -1.0][(w / 7 % 7) as usize]
        }
        w => f32::from_bits(w),
    };
    let light = |what: u32| {
        Image::from_fn(size, move |x, y| {
            [0, 1, 2, 3].map(|c| f16::from_bits(word(x, y, 10 * what + c) as u16).to_f32())
        })
    };
    each(|gpu, name, denoiser| {
        denoiser.resize(gpu, size, true).unwrap();
        for turn in 0..4 {
            let salt = 1000 * turn;
            let mut shot = Shot::wall(size, 2.0);
            shot.frame.restart = turn == 0;
            shot.surface = Image::from_fn(size, |x, y| [1, 2, 3, 4].map(|c| word(x, y, salt + c)));
            shot.distance = Image::from_fn(size, |x, y| number(x, y, salt + 5));
            shot.others = Image::from_fn(size, |x, y| {
                let motion = if x % 2 == 0 { word(x, y, salt + 7) } else { pack_motion(Vec2::ONE) };
                [word(x, y, salt + 6), motion, word(x, y, salt + 8) % 3]
            });
            shot.noisy.diffuse = light(salt + 20);
            shot.noisy.specular = Some(light(salt + 30));
            shot.noisy.samples = Image::from_fn(size, |x, y| word(x, y, salt + 9) % 4);
            let (clean, _) = shot.next(gpu, denoiser);
            // The denoiser that does nothing does nothing about this either.
            assert!(name == "identity" || clean.is_finite(), "{name}, frame {turn}");
        }
    });
}
