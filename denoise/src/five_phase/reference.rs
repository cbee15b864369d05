//! The CPU half: the same functions as `guide.wgsl` and `five_phase.wgsl`, in the same order, in f32 like the shaders.

use super::{GuideParams, PhaseParams, Settings};
use crate::light::reference::{Light, LightSum, at, is_valid, mended, mirrored, size_of};
use frame::brdf;
use frame::cpu::Image;
use frame::info::{Frame, FrameInfo};
use frame::surface::{Surface, normal_unpack};
use glam::{IVec2, Vec2, Vec3};

const RADIUS_MAX: i32 = 64;

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
/// result counts the pixels whose light is not valid.
pub fn guide_pack(
    params: &GuideParams,
    frame: &Frame,
    surface: &Image<[u32; 4]>,
    distance: &Image<f32>,
    noisy: &Light,
) -> (Image<(Vec3, u32)>, u64) {
    let size = size_of(surface);
    let mut invalid = 0;
    let guide = Image::from_fn(surface.size(), |x, y| {
        let p = IVec2::new(x as i32, y as i32);
        let distance = at(distance, p);
        let diffuse_is_valid = is_valid(at(&noisy.diffuse, p));
        let specular_is_valid = noisy.specular.as_ref().is_none_or(|specular| is_valid(at(specular, p)));
        if !diffuse_is_valid || !specular_is_valid {
            invalid += 1;
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
            bits |= u32::from(is_traced && specular_is_valid) << 29;
        }
        let albedo = surface.base * (1.0 - surface.metalness) * (1.0 - surface.transmission);
        if albedo.max_element() > 0.0 {
            bits |= 1 << 30;
            bits |= u32::from(is_traced && diffuse_is_valid) << 31;
        }
        let point = p.as_vec2() + 0.5 + Vec2::from(frame.jitter);
        (distance * view_direction(frame, point, size.as_vec2()), bits)
    });
    (guide, invalid)
}

/// One phase along one axis.
pub fn filter_phase(params: &PhaseParams, guide: &Image<(Vec3, u32)>, input: &Light) -> Light {
    let size = size_of(guide);
    let step = IVec2::from(params.step);
    let mut output = input.clone();
    for (y, x) in (0..size.y).flat_map(|y| (0..size.x).map(move |x| (y, x))) {
        let p = IVec2::new(x, y);
        let (position, bits) = at(guide, p);
        let is_diffuse = (bits >> 30) & 1 == 1;
        let is_specular = input.specular.is_some() && (bits >> (24 + params.phase)) & 1 == 1;

        let normal = normal_unpack(bits);
        let viewer = position.length();
        let growth = (viewer / params.growth_step).floor();
        let rows = params.kernel_radius + (params.radius_growth * growth).min(params.radius_growth_max);
        let cutoff = params.radial_cutoff + (params.cutoff_growth * growth).min(params.cutoff_growth_max);
        let mut radius = ((rows * params.radius_scale + 0.5).floor() as i32).min(RADIUS_MAX);
        if !is_diffuse && !is_specular {
            radius = -1;
        }
        let falloff = if params.is_triangular == 1 && radius > 0 { 1.0 / (radius + 1) as f32 } else { 0.0 };

        let along = p.dot(step);
        let last = (size - 1).dot(step);
        let mut diffuse = LightSum::default();
        let mut specular = LightSum::default();
        let steps = match params.is_mirrored {
            0 => (-radius).max(-along)..=radius.min(last - along),
            _ => -radius..=radius,
        };
        for j in steps {
            let q = mirrored(p + j * step, size);
            let (tap_position, tap_bits) = at(guide, q);
            let offset = tap_position - position;
            let facing = normal.dot(normal_unpack(tap_bits));
            let apart = match params.by_depth {
                0 => offset.length(),
                _ => (tap_position.length() - viewer).abs(),
            };
            if facing <= 0.0 || apart > cutoff {
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

        let write = |image: &mut Image<[f32; 4]>, before: &Image<[f32; 4]>, takes: bool, sum: LightSum| {
            let before = mended(before, p);
            *image.get_mut(x, y).expect("a pixel inside the picture") =
                if takes { sum.mean(before) } else { before };
        };
        write(&mut output.diffuse, &input.diffuse, is_diffuse, diffuse);
        if let (Some(image), Some(before)) = (&mut output.specular, &input.specular) {
            write(image, before, is_specular, specular);
        }
    }
    output
}

/// The whole denoiser.
pub fn denoise(
    settings: &Settings,
    frame: &FrameInfo,
    surface: &Image<[u32; 4]>,
    distance: &Image<f32>,
    noisy: &Light,
) -> Light {
    let settings = settings.effective();
    let params = settings.guide_params(noisy.specular.is_some());
    let (guide, _) = guide_pack(&params, &frame.uniform(), surface, distance, noisy);
    settings.schedule().into_iter().fold(noisy.clone(), |light, (phase, axis)| {
        filter_phase(&settings.phase_params(phase, axis, frame), &guide, &light)
    })
}
