//! Promises of every upsampler, and the pictures that tests of this crate are made on.
#![allow(clippy::unwrap_used, clippy::panic)]

use crate::modulate::reference::{Guides, Inputs, Light};
use crate::{Upsampler, all};
use frame::brdf::{self, BrdfTable};
use frame::cpu::Image;
use frame::info::{Frame, FrameInfo};
use frame::scene_gpu::{GpuScene, SceneOptions};
use frame::surface::{Surface, hash};
use frame::{FrameLog, GBuffer, Gpu, RadianceImage, Recorder, Room, Texture};
use glam::{UVec2, Vec2, Vec3};
use half::f16;
use scene::{Scene, Sky, SkyMap};
use wgpu::{TextureFormat, TextureUsages};

/// 3 by 2.25 display pixels to a trace pixel, as the paper's sizes.
pub(crate) const TRACE: [u32; 2] = [64, 48];
pub(crate) const DISPLAY: [u32; 2] = [192, 108];

/// In [0, 1), from two numbers.
pub(crate) fn random(seed: u32, index: u32) -> f32 {
    (hash(hash(seed) ^ index) >> 8) as f32 / 16_777_216.0
}

/// A device with a scene on it: of the scene only the sky and the table are looked at.
pub(crate) struct Stand {
    pub(crate) gpu: Gpu,
    pub(crate) scene: GpuScene,
    table: BrdfTable,
    sky: Sky,
}

impl Stand {
    pub(crate) fn new() -> Self {
        let gpu = Gpu::new(None).expect("tests need an adapter, a software one will do");
        let mut world = Scene::load("cornell").unwrap();
        let radiance = (0..32).map(|i| Vec3::new(random(1, i), random(2, i), random(3, i))).collect();
        let sky = Sky::Map(SkyMap { width: 8, height: 4, radiance });
        world.sky = sky.clone();
        let (scene, _) = GpuScene::new(&gpu, &world, world.rest(), &SceneOptions::default()).unwrap();
        Self { gpu, scene, table: BrdfTable::new(), sky }
    }

    /// Radiance of the sky times `radiance_scale`.
    pub(crate) fn sky(&self, direction: Vec3) -> Vec3 {
        self.scene.radiance_scale * self.sky.radiance(direction)
    }

    /// Runs an upsampler once.
    pub(crate) fn upsample(&self, upsampler: &mut dyn Upsampler, shot: &Shot) -> (Vec<[f16; 4]>, FrameLog) {
        let gpu = &self.gpu;
        let FrameInfo { trace_size, display_size, .. } = shot.frame;
        upsampler.resize(gpu, trace_size, display_size, shot.light.specular.is_some()).unwrap();
        self.upsample_next(upsampler, shot)
    }

    /// Runs it for a frame after others.
    pub(crate) fn upsample_next(
        &self,
        upsampler: &mut dyn Upsampler,
        shot: &Shot,
    ) -> (Vec<[f16; 4]>, FrameLog) {
        let gpu = &self.gpu;
        let light = shot.light.upload(gpu);
        let direct = shot.direct.as_ref().map(|direct| direct.upload(gpu));
        let mut recorder = Recorder::new(gpu);
        let uniform = recorder.uniform(&shot.frame.uniform());
        let picture = upsampler.upsample(
            &mut recorder,
            &shot.frame,
            &uniform,
            &self.scene,
            &shot.trace.upload(gpu, None),
            &light,
            &shot.display.upload(gpu, Some(&shot.motion)),
            direct.as_ref(),
        );
        let log = recorder.finish().unwrap();
        (gpu.read_texture(&picture.texture).unwrap(), log)
    }

    /// What a CPU twin makes of it.
    pub(crate) fn twin<T>(&self, shot: &Shot, twin: impl FnOnce(&Inputs<'_>) -> T) -> T {
        twin(&Inputs {
            frame: shot.frame.uniform(),
            trace: &shot.trace,
            light: &shot.light,
            display: &shot.display,
            direct: shot.direct.as_ref(),
            table: &self.table,
            sky: &|direction| self.sky(direction),
        })
    }

    /// The formula of the contract, for a pixel that hit something.
    pub(crate) fn modulated(&self, shot: &Shot, pixel: UVec2, diffuse: Vec3, specular: Vec3) -> Vec3 {
        let direction = self.twin(shot, |inputs| inputs.display_direction(pixel));
        let surface = shot.display_surface(pixel);
        let m = brdf::modulators(&surface, surface.normal.dot(-direction).into(), &self.table);
        m.diffuse.as_vec3() * diffuse + m.specular.as_vec3() * specular + surface.emission
    }
}

/// One frame's input, on the CPU.
#[derive(Clone)]
pub(crate) struct Shot {
    pub(crate) frame: FrameInfo,
    pub(crate) trace: Guides,
    pub(crate) light: Light,
    pub(crate) display: Guides,
    pub(crate) direct: Option<Light>,
    /// Motion (display pixels) and object of each display pixel.
    pub(crate) motion: Image<([f32; 2], u32)>,
}

/// What a view ray meets: metres and surface.
pub(crate) type World = fn(Vec3) -> Option<(f32, Surface)>;

fn direction(uniform: &Frame, point: Vec2, size: [u32; 2]) -> Vec3 {
    let ndc = Vec2::new(2.0, -2.0) * (point / UVec2::from(size).as_vec2()) + Vec2::new(-1.0, 1.0);
    let [forward, right, up] = [uniform.forward, uniform.right, uniform.up].map(Vec3::from);
    (forward + ndc.x * right + ndc.y * up).normalize()
}

/// A glossy wall across the view, a Lambert one along it to the right, and nothing above.
pub(crate) fn corner(direction: Vec3) -> Option<(f32, Surface)> {
    let across = Surface {
        base: Vec3::new(0.8, 0.4, 0.2),
        f0: 0.04,
        roughness: Vec2::new(0.5, 0.3),
        emission: Vec3::new(0.0, 0.25, 0.0),
        ..Surface::default()
    };
    let along = Surface { normal: Vec3::NEG_X, base: Vec3::new(0.1, 0.6, 0.9), ..Surface::default() };
    let to_across = 4.0 / -direction.z;
    let to_along = if direction.x > 0.0 { 1.0 / direction.x } else { f32::INFINITY };
    let nearest = if to_across < to_along { (to_across, across) } else { (to_along, along) };
    (direction.y < 0.25).then_some(nearest)
}

impl Shot {
    /// A world seen at both sizes; light 0, one sample in each lobe.
    pub(crate) fn of(world: World, trace_size: [u32; 2], display_size: [u32; 2]) -> Self {
        Self::of_jittered(world, trace_size, display_size, [0.0; 2])
    }

    /// The same, at trace size through jittered points.
    pub(crate) fn of_jittered(
        world: World,
        trace_size: [u32; 2],
        display_size: [u32; 2],
        jitter: [f32; 2],
    ) -> Self {
        let camera = scene::Camera {
            name: String::new(),
            eye: Vec3::new(1.0, 2.0, 3.0),
            target: Vec3::new(1.0, 2.0, 2.0),
            up: Vec3::Y,
            vfov: 0.9,
        };
        let frame = FrameInfo {
            previous_camera: camera.clone(),
            camera,
            trace_size,
            display_size,
            jitter,
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
        let uniform = frame.uniform();
        let guides = |size: [u32; 2], jitter: [f32; 2]| {
            let hit = |x: u32, y: u32| {
                let point = Vec2::new(x as f32, y as f32) + 0.5 + Vec2::from(jitter);
                world(direction(&uniform, point, size))
            };
            Guides {
                surface: Image::from_fn(size, |x, y| {
                    hit(x, y).map_or([0; 4], |(_, s)| s.pack_gbuffer(hash(x ^ y << 16)))
                }),
                distance: Image::from_fn(size, |x, y| hit(x, y).map_or(0.0, |(distance, _)| distance)),
            }
        };
        let light = Light {
            diffuse: Image::filled(trace_size, [0.0; 4]),
            specular: Some(Image::filled(trace_size, [0.0; 4])),
            samples: Image::filled(trace_size, 0x1_0001),
        };
        let motion = Image::filled(display_size, ([0.0; 2], 1));
        Self {
            frame,
            trace: guides(trace_size, jitter),
            light,
            display: guides(display_size, [0.0; 2]),
            direct: None,
            motion,
        }
    }

    /// Random light between 0 and 4, and every fifth pixel without a sample.
    pub(crate) fn with_random_light(mut self, seed: u32) -> Self {
        self.light = random_light(self.frame.trace_size, seed);
        self
    }

    /// Of the view ray through a point of a picture of this size.
    pub(crate) fn direction(&self, point: Vec2, size: [u32; 2]) -> Vec3 {
        direction(&self.frame.uniform(), point, size)
    }

    pub(crate) fn display_surface(&self, pixel: UVec2) -> Surface {
        Surface::unpack_gbuffer(self.display.surface.get(pixel.x as i32, pixel.y as i32).unwrap())
    }

    /// Display pixels with whether something was hit there.
    pub(crate) fn pixels(&self) -> impl Iterator<Item = (UVec2, bool)> + '_ {
        let width = self.frame.display_size[0];
        let pixel = move |i: u32| UVec2::new(i % width, i / width);
        (0..).zip(self.display.distance.texels()).map(move |(i, distance)| (pixel(i), *distance > 0.0))
    }
}

/// Tilts every normal a little, and changes every third surface to metal, glass or black.
pub(crate) fn roughen(guides: &mut Guides, seed: u32) {
    let size = guides.surface.size();
    let texels = guides.surface.texels().iter().enumerate().map(|(i, words)| {
        let draw = |what: u32| random(seed + what, i as u32);
        let mut surface = Surface::unpack_gbuffer(*words);
        let tilt = Vec3::new(draw(0), draw(1), draw(2)) - 0.5;
        surface.normal = (surface.normal + 0.7 * tilt).normalize();
        match (9.0 * draw(3)) as u32 {
            0 => surface.metalness = 1.0,
            1 => (surface.transmission, surface.f0) = (1.0, 0.04),
            2 => surface.base = Vec3::ZERO,
            _ => {}
        }
        surface.pack_gbuffer(i as u32)
    });
    guides.surface = Image::from_texels(size, texels.collect()).unwrap();
}

pub(crate) fn random_light(size: [u32; 2], seed: u32) -> Light {
    let lobe = |what: u32| {
        Image::from_fn(size, move |x, y| {
            let at = |channel| 4.0 * random(seed.wrapping_mul(31) + what + channel, y * size[0] + x);
            [at(0), at(1), at(2), at(3)].map(|v| f16::from_f32(v).to_f32())
        })
    };
    let samples = Image::from_fn(size, |x, y| u32::from(random(seed + 9, y * size[0] + x) > 0.2));
    Light { diffuse: lobe(0), specular: Some(lobe(4)), samples }
}

impl Light {
    fn upload(&self, gpu: &Gpu) -> RadianceImage {
        let lobe = |image: &Image<[f32; 4]>| {
            let texels: Vec<_> = image.texels().iter().map(|texel| texel.map(f16::from_f32)).collect();
            upload(gpu, image.size(), RadianceImage::FORMAT, &texels)
        };
        RadianceImage {
            diffuse: lobe(&self.diffuse),
            specular: self.specular.as_ref().map(lobe),
            samples: upload(gpu, self.samples.size(), TextureFormat::R32Uint, self.samples.texels()),
        }
    }
}

impl Guides {
    fn upload(&self, gpu: &Gpu, motion: Option<&Image<([f32; 2], u32)>>) -> GBuffer {
        let size = self.distance.size();
        let packed = |([x, y], object): ([f32; 2], u32)| {
            [u32::from(f16::from_f32(x).to_bits()) | (u32::from(f16::from_f32(y).to_bits()) << 16), object]
        };
        let motion_id = motion.map_or(Image::filled(size, [0; 2]), |motion| motion.map(packed));
        GBuffer {
            surface: upload(gpu, size, TextureFormat::Rgba32Uint, self.surface.texels()),
            distance: upload(gpu, size, TextureFormat::R32Float, self.distance.texels()),
            face_normal: upload(gpu, size, TextureFormat::R32Uint, self.distance.map(|_| 0u32).texels()),
            motion_id: upload(gpu, size, TextureFormat::Rg32Uint, motion_id.texels()),
        }
    }
}

fn upload<T: bytemuck::NoUninit>(
    gpu: &Gpu,
    [width, height]: [u32; 2],
    format: TextureFormat,
    texels: &[T],
) -> Texture {
    let usage = TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST;
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

/// Equal to a step of a half float: half of one from rounding, the rest for f32 against f64 on the way to it.
pub(crate) fn is_close(found: [f16; 4], expected: Vec3) -> bool {
    let close = |f: f16, e: f32| (f.to_f32() - e).abs() <= 2f32.powi(-10) * e.abs() + 2f32.powi(-24);
    let [r, g, b, a] = found;
    close(r, expected.x) && close(g, expected.y) && close(b, expected.z) && a == f16::ONE
}

fn each(mut check: impl FnMut(&Stand, &str, &mut dyn Upsampler)) {
    let stand = Stand::new();
    for (name, make) in all() {
        check(&stand, name, make(&stand.gpu).unwrap().as_mut());
    }
}

#[test]
fn names_are_those_of_the_list() {
    each(|_, name, upsampler| {
        assert_eq!(upsampler.name(), name);
        let mut knobs: Vec<_> = upsampler.knobs().into_iter().map(|knob| knob.name).collect();
        knobs.sort_unstable();
        assert!(knobs.windows(2).all(|pair| pair[0] != pair[1]), "{name}: a knob twice in {knobs:?}");
    });
}

#[test]
fn at_equal_sizes_each_pixel_gets_its_own_light() {
    let mut shot = Shot::of(corner, TRACE, TRACE).with_random_light(1);
    for direct in
        [None, Some(random_light(TRACE, 2)), Some(Light { specular: None, ..random_light(TRACE, 3) })]
    {
        shot.direct = direct;
        let light = |pixel: UVec2| {
            let at = |image: &Image<[f32; 4]>| {
                let [r, g, b, _] = image.get(pixel.x as i32, pixel.y as i32).unwrap();
                Vec3::new(r, g, b)
            };
            let [mut diffuse, mut specular] =
                [at(&shot.light.diffuse), at(shot.light.specular.as_ref().unwrap())];
            if let Some(direct) = &shot.direct {
                diffuse += at(&direct.diffuse);
                specular += direct.specular.as_ref().map_or(Vec3::ZERO, at);
            }
            (diffuse, specular)
        };
        each(|stand, name, upsampler| {
            let (picture, _) = stand.upsample(upsampler, &shot);
            for ((pixel, is_hit), found) in shot.pixels().zip(&picture).filter(|((_, is_hit), _)| *is_hit) {
                let (diffuse, specular) = light(pixel);
                let expected = stand.modulated(&shot, pixel, diffuse, specular);
                assert!(
                    is_close(*found, expected),
                    "{name} at {pixel}: {found:?}, expected {expected}, {is_hit}"
                );
            }
        });
    }
}

#[test]
fn constant_light_becomes_the_modulators() {
    let mut shot = Shot::of(corner, TRACE, DISPLAY);
    shot.light.diffuse = Image::filled(TRACE, [1.0, 2.0, 3.0, 1.0]);
    // Lambert surfaces get no specular light from elsewhere, so none is given where both kinds of surface are.
    shot.light.specular = None;
    each(|stand, name, upsampler| {
        // What enlarges a finished picture has that picture's surfaces, not the display's.
        if name == "fsr1" {
            return;
        }
        let (picture, _) = stand.upsample(upsampler, &shot);
        for ((pixel, _), found) in shot.pixels().zip(&picture).filter(|((_, is_hit), _)| *is_hit) {
            let expected = stand.modulated(&shot, pixel, Vec3::new(1.0, 2.0, 3.0), Vec3::ZERO);
            assert!(is_close(*found, expected), "{name} at {pixel}: {found:?}, expected {expected}");
        }
    });
}

#[test]
fn where_nothing_was_hit_there_is_sky() {
    let shot = Shot::of(corner, TRACE, DISPLAY).with_random_light(4);
    each(|stand, name, upsampler| {
        let (picture, _) = stand.upsample(upsampler, &shot);
        let mut misses = 0;
        for ((pixel, _), found) in shot.pixels().zip(&picture).filter(|((_, is_hit), _)| !is_hit) {
            let sky = stand.sky(stand.twin(&shot, |inputs| inputs.display_direction(pixel)));
            assert!(is_close(*found, sky), "{name} at {pixel}: {found:?}, expected {sky}");
            misses += 1;
        }
        assert!(misses > 1000, "{misses} misses are too few to tell");
    });
}

#[test]
fn the_picture_is_finite_and_in_range() {
    let mut shot = Shot::of(corner, TRACE, DISPLAY);
    let light = |value: f32| Image::filled(TRACE, [value; 4]);
    each(|stand, name, upsampler| {
        for value in [f32::NAN, f32::INFINITY, 65504.0] {
            shot.light.diffuse = light(value);
            shot.light.specular = Some(light(value));
            shot.direct = Some(Light { samples: Image::filled(DISPLAY, 1), ..light_everywhere(60_000.0) });
            let (picture, _) = stand.upsample(upsampler, &shot);
            let is_fine = |x: &f16| x.is_finite() && x.to_f32() >= 0.0;
            assert!(picture.as_flattened().iter().all(is_fine), "{name} with light {value}");
        }
    });
}

fn light_everywhere(value: f32) -> Light {
    let image = Image::filled(DISPLAY, [value; 4]);
    Light { diffuse: image.clone(), specular: Some(image), samples: Image::filled(DISPLAY, 0x1_0001) }
}

#[test]
fn the_same_frame_gives_the_same_bits() {
    let shot = Shot::of(corner, TRACE, DISPLAY).with_random_light(5);
    each(|stand, name, upsampler| {
        let (first, _) = stand.upsample(upsampler, &shot);
        assert!(stand.upsample(upsampler, &shot).0 == first, "{name}");
    });
}

#[test]
fn any_sizes_go_together() {
    each(|stand, name, upsampler| {
        for (trace, display) in [([1, 1], [3, 2]), ([7, 1], [1, 5]), ([9, 9], [3, 4]), ([13, 3], [13, 7])] {
            let shot = Shot::of(corner, trace, display).with_random_light(6);
            let (picture, _) = stand.upsample(upsampler, &shot);
            assert_eq!(
                picture.len(),
                (display[0] * display[1]) as usize,
                "{name} from {trace:?} to {display:?}"
            );
            assert!(picture.iter().all(|texel| texel[3] == f16::ONE), "{name} from {trace:?} to {display:?}");
        }
    });
}
