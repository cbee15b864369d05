//! The CPU half: the same functions as `best_candidate.wgsl`, in the same order, in f32 like the shader.

use super::Settings;
use crate::modulate::reference::{Inputs, inside, load, rgb};
use frame::brdf;
use frame::cpu::Image;
use frame::surface::Surface;
use glam::{IVec2, UVec2, Vec2, Vec3};

#[derive(Clone, Copy)]
struct Candidate {
    pixel: UVec2,
    facing: f32,
    is_accepted: bool,
}

impl Candidate {
    fn offer(&mut self, offered: Self) {
        if !self.is_accepted && (offered.is_accepted || offered.facing > self.facing) {
            *self = offered;
        }
    }
}

fn has_diffuse(s: &Surface) -> bool {
    (s.base * (1.0 - s.metalness) * (1.0 - s.transmission)).max_element() > 0.0
}

/// The picture, and the number of pixels that had to do with less than an accepted candidate.
pub fn best_candidate(settings: &Settings, inputs: &Inputs<'_>) -> (Image<[f32; 4]>, u64) {
    let frame = &inputs.frame;
    let offsets = settings.offsets(frame.trace_size, frame.display_size);
    let is_same_size = frame.trace_size == frame.display_size;
    let mut fallbacks = 0;
    let picture = inputs.picture(|pixel| {
        let distance = load(&inputs.display.distance, pixel);
        let surface = Surface::unpack_gbuffer(load(&inputs.display.surface, pixel));
        let position = distance * inputs.display_direction(pixel);
        let centre = inputs.trace_pixel(pixel);

        let mut diffuse = Candidate { pixel: centre, facing: -2.0, is_accepted: false };
        let mut specular = diffuse;
        let is_searched = distance > 0.0 && !is_same_size;
        let needs_diffuse = is_searched && has_diffuse(&surface);
        let needs_specular = is_searched && inputs.light.specular.is_some() && brdf::has_specular(&surface);
        for &offset in &offsets {
            if (diffuse.is_accepted || !needs_diffuse) && (specular.is_accepted || !needs_specular) {
                break;
            }
            let Some(q) = inside(centre.as_ivec2() + IVec2::from(offset), frame.trace_size) else { continue };
            let q_distance = load(&inputs.trace.distance, q);
            let says_something = q_distance > 0.0 && load(&inputs.light.samples, q) != 0;
            if !says_something {
                continue;
            }
            let q_surface = Surface::unpack_gbuffer(load(&inputs.trace.surface, q));
            let facing = surface.normal.dot(q_surface.normal);
            let point = q.as_vec2() + 0.5 + Vec2::from(frame.jitter);
            let q_position = q_distance * inputs.view_direction(point, frame.trace_size);
            let off_plane = surface.normal.dot(q_position - position).abs();
            let is_on_plane = !settings.plane_test || off_plane <= settings.plane_distance * distance;
            let is_accepted = facing >= settings.least_cosine && is_on_plane;
            let offered = Candidate { pixel: q, facing, is_accepted };
            if has_diffuse(&q_surface) {
                diffuse.offer(offered);
            }
            if brdf::has_specular(&q_surface) {
                specular.offer(offered);
            }
        }
        if (needs_diffuse && !diffuse.is_accepted) || (needs_specular && !specular.is_accepted) {
            fallbacks += 1;
        }

        let mut light = [Vec3::ZERO; 2];
        if needs_diffuse || is_same_size {
            light[0] = rgb(&inputs.light.diffuse, diffuse.pixel);
        }
        if let Some(image) = &inputs.light.specular
            && (needs_specular || is_same_size)
        {
            light[1] = rgb(image, specular.pixel);
        }
        inputs.modulate(pixel, light[0], light[1])
    });
    (picture, fallbacks)
}
