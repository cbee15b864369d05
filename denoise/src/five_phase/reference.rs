//! The CPU half: the same functions as `guide.wgsl` and `five_phase.wgsl`, in the same order, in f32 like the shaders.

use super::{GuideParams, PhaseParams, Settings};
use frame::brdf;
use frame::cpu::Image;
use frame::info::Frame;
use frame::surface::{Surface, normal_unpack};
use glam::{IVec2, Vec2, Vec3};
use half::f16;

const RADIUS_MAX: i32 = 64;
const HALF_MAX: f32 = 65504.0;

/// Light of both lobes at trace size, as [`frame::RadianceImage`] holds it.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// rgb, and metres.
    pub diffuse: Image<[f32; 4]>,
    /// rgb, and metres.
    pub specular: Option<Image<[f32; 4]>>,
    /// Samples: diffuse in the low half, specular in the high half.
    pub samples: Image<u32>,
}

/// The texel outside the picture: no tap asks for one.
const OUTSIDE: &str = "a tap inside the picture";

fn at<T: Copy>(image: &Image<T>, p: IVec2) -> T {
    image.get(p.x, p.y).expect(OUTSIDE)
}

fn size_of(size: [u32; 2]) -> IVec2 {
    IVec2::new(size[0] as i32, size[1] as i32)
}

fn is_finite(light: [f32; 4]) -> bool {
    light.iter().all(|x| x.is_finite())
}

fn phases(params: &GuideParams, code: u32) -> u32 {
    let mut phases = 0;
    for k in 0..4 {
        phases |= u32::from(code >= params.thresholds[k]) << k;
    }
    phases | (u32::from(code >= params.last_threshold) << 4)
}

fn view_direction(frame: &Frame, point: Vec2, size: Vec2) -> Vec3 {
    let ndc = Vec2::new(2.0, -2.0) * (point / size) + Vec2::new(-1.0, 1.0);
    (Vec3::from(frame.forward) + ndc.x * Vec3::from(frame.right) + ndc.y * Vec3::from(frame.up)).normalize()
}

/// What every tap asks about a pixel: position relative to the eye, and the bits that `super` lists. The second
/// result counts the pixels whose light is not finite.
pub fn guide_pack(
    params: &GuideParams,
    frame: &Frame,
    surface: &Image<[u32; 4]>,
    distance: &Image<f32>,
    noisy: &Light,
) -> (Image<(Vec3, u32)>, u64) {
    let size = size_of(surface.size());
    let mut non_finite = 0;
    let guide = Image::from_fn(surface.size(), |x, y| {
        let p = IVec2::new(x as i32, y as i32);
        let distance = at(distance, p);
        let diffuse_is_finite = is_finite(at(&noisy.diffuse, p));
        let specular_is_finite = noisy.specular.as_ref().is_none_or(|specular| is_finite(at(specular, p)));
        if !diffuse_is_finite || !specular_is_finite {
            non_finite += 1;
        }
        let is_hit = distance > 0.0;
        if !is_hit {
            return (Vec3::ZERO, 0);
        }

        let words = at(surface, p);
        let surface = Surface::unpack_gbuffer(words);
        let is_traced = at(&noisy.samples, p) != 0;
        let mut bits = words[0] & 0xff_ffff;
        if params.has_specular != 0 && brdf::has_specular(&surface) {
            let code = (words[3] & 0xff).max((words[3] >> 8) & 0xff);
            bits |= phases(params, code) << 24;
            bits |= u32::from(is_traced && specular_is_finite) << 29;
        }
        let albedo = surface.base * (1.0 - surface.metalness) * (1.0 - surface.transmission);
        if albedo.max_element() > 0.0 {
            bits |= 1 << 30;
            bits |= u32::from(is_traced && diffuse_is_finite) << 31;
        }
        let point = p.as_vec2() + 0.5 + Vec2::from(frame.jitter);
        (distance * view_direction(frame, point, size.as_vec2()), bits)
    });
    (guide, non_finite)
}

#[derive(Default)]
struct LobeSum {
    rgb: Vec3,
    weight: f32,
    length: f32,
    length_weight: f32,
}

impl LobeSum {
    fn add(&mut self, [r, g, b, a]: [f32; 4], weight: f32) {
        let length_weight = if a > 0.0 { weight } else { 0.0 };
        self.rgb += weight * Vec3::new(r, g, b);
        self.weight += weight;
        self.length += length_weight * a;
        self.length_weight += length_weight;
    }

    fn mean(&self) -> [f32; 4] {
        let rgb = if self.weight > 0.0 { self.rgb / self.weight } else { Vec3::ZERO };
        let length = if self.length_weight > 0.0 { self.length / self.length_weight } else { 0.0 };
        rgb.extend(length).min(glam::Vec4::splat(HALF_MAX)).to_array()
    }
}

fn untouched(light: [f32; 4]) -> [f32; 4] {
    if is_finite(light) { light } else { [0.0; 4] }
}

/// Each number as a half float stores it.
fn stored(light: [f32; 4]) -> [f32; 4] {
    light.map(|x| f16::from_f32(x).to_f32())
}

/// One phase along one axis.
pub fn filter_phase(params: &PhaseParams, guide: &Image<(Vec3, u32)>, input: &Light) -> Light {
    let size = size_of(guide.size());
    let step = IVec2::from(params.step);
    let mut output = input.clone();
    for (y, x) in (0..size.y).flat_map(|y| (0..size.x).map(move |x| (y, x))) {
        let p = IVec2::new(x, y);
        let (position, bits) = at(guide, p);
        let is_diffuse = (bits >> 30) & 1 == 1;
        let is_specular = input.specular.is_some() && (bits >> (24 + params.phase)) & 1 == 1;

        let normal = normal_unpack(bits);
        let growth = (position.length() / params.growth_step).floor();
        let rows = params.kernel_radius + (params.radius_growth * growth).min(params.radius_growth_max);
        let cutoff = params.radial_cutoff + (params.cutoff_growth * growth).min(params.cutoff_growth_max);
        let mut radius = ((rows * params.radius_scale + 0.5).floor() as i32).min(RADIUS_MAX);
        if !is_diffuse && !is_specular {
            radius = -1;
        }
        let falloff = if params.is_triangular == 1 && radius > 0 { 1.0 / (radius + 1) as f32 } else { 0.0 };

        let along = p.dot(step);
        let last = (size - 1).dot(step);
        let mut diffuse = LobeSum::default();
        let mut specular = LobeSum::default();
        for j in (-radius).max(-along)..=radius.min(last - along) {
            let q = p + j * step;
            let (tap_position, tap_bits) = at(guide, q);
            let offset = tap_position - position;
            let facing = normal.dot(normal_unpack(tap_bits));
            if facing <= 0.0 || offset.length_squared() > cutoff * cutoff {
                continue;
            }
            let weight = facing * (1.0 - falloff * j.abs() as f32);
            if is_diffuse && tap_bits >> 31 == 1 {
                diffuse.add(at(&input.diffuse, q), weight);
            }
            let is_bracket = params.same_bracket == 0 || (tap_bits >> (24 + params.phase)) & 1 == 1;
            if let Some(light) = &input.specular
                && is_specular
                && is_bracket
                && (tap_bits >> 29) & 1 == 1
            {
                specular.add(at(light, q), weight);
            }
        }

        let write = |image: &mut Image<[f32; 4]>, light| *image.get_mut(x, y).expect(OUTSIDE) = stored(light);
        let light = if is_diffuse { diffuse.mean() } else { untouched(at(&input.diffuse, p)) };
        write(&mut output.diffuse, light);
        if let (Some(image), Some(before)) = (&mut output.specular, &input.specular) {
            write(image, if is_specular { specular.mean() } else { untouched(at(before, p)) });
        }
    }
    output
}

/// The whole denoiser.
pub fn denoise(
    settings: &Settings,
    frame: &Frame,
    columns_per_row: f32,
    surface: &Image<[u32; 4]>,
    distance: &Image<f32>,
    noisy: &Light,
) -> Light {
    let params = settings.guide_params(noisy.specular.is_some());
    let (guide, _) = guide_pack(&params, frame, surface, distance, noisy);
    settings.schedule().into_iter().fold(noisy.clone(), |light, (phase, axis)| {
        filter_phase(&settings.phase_params(phase, axis, columns_per_row), &guide, &light)
    })
}
