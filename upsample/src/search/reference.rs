//! The CPU half: the same functions as `search.inc.wgsl`, in the same order, in f32 like the shader.

use super::Settings;
use crate::modulate::reference::{Inputs, inside, load, rgb};
use frame::brdf;
use frame::surface::Surface;
use glam::{IVec2, UVec2, Vec2, Vec3};

/// A display pixel and what it needs from elsewhere.
pub(crate) struct Wanted {
    pub(crate) surface: Surface,
    /// From the eye, m.
    pub(crate) position: Vec3,
    pub(crate) distance: f32,
    /// Diffuse, specular.
    pub(crate) needs: [bool; 2],
    pub(crate) is_same_size: bool,
}

/// A trace pixel as a display pixel sees it.
#[derive(Clone, Copy)]
pub(crate) struct Tap {
    pub(crate) pixel: UVec2,
    /// Whether it says something about the lobe: diffuse, specular.
    pub(crate) has: [bool; 2],
    pub(crate) facing: f32,
    /// Metres.
    pub(crate) off_plane: f32,
}

/// What a search holds.
#[derive(Clone, Copy)]
pub(crate) struct Candidate {
    pub(crate) pixel: UVec2,
    facing: f32,
    pub(crate) is_accepted: bool,
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

/// `search_pixel`.
pub(crate) fn wanted(inputs: &Inputs<'_>, pixel: UVec2) -> Wanted {
    let distance = load(&inputs.display.distance, pixel);
    let surface = Surface::unpack_gbuffer(load(&inputs.display.surface, pixel));
    let is_same_size = inputs.frame.trace_size == inputs.frame.display_size;
    let needs = distance > 0.0 && !is_same_size;
    Wanted {
        position: distance * inputs.display_direction(pixel),
        distance,
        needs: [
            needs && has_diffuse(&surface),
            needs && inputs.light.specular.is_some() && brdf::has_specular(&surface),
        ],
        surface,
        is_same_size,
    }
}

/// `search_place`.
pub(crate) fn place(inputs: &Inputs<'_>, pixel: UVec2) -> Vec2 {
    let frame = &inputs.frame;
    let size = |size: [u32; 2]| UVec2::from(size).as_vec2();
    (pixel.as_vec2() + 0.5) * size(frame.trace_size) / size(frame.display_size)
        - 0.5
        - Vec2::from(frame.jitter)
}

/// `search_tap`; none outside.
pub(crate) fn tap(inputs: &Inputs<'_>, wanted: &Wanted, p: IVec2) -> Option<Tap> {
    let pixel = inside(p, inputs.frame.trace_size)?;
    let distance = load(&inputs.trace.distance, pixel);
    let counts = distance > 0.0 && load(&inputs.light.samples, pixel) != 0;
    let surface = Surface::unpack_gbuffer(load(&inputs.trace.surface, pixel));
    let point = pixel.as_vec2() + 0.5 + Vec2::from(inputs.frame.jitter);
    let position = distance * inputs.view_direction(point, inputs.frame.trace_size);
    Some(Tap {
        pixel,
        has: [counts && has_diffuse(&surface), counts && brdf::has_specular(&surface)],
        facing: wanted.surface.normal.dot(surface.normal),
        off_plane: wanted.surface.normal.dot(position - wanted.position).abs(),
    })
}

/// `search_outward`.
pub(crate) fn outward(
    settings: &Settings,
    offsets: &[[i32; 2]],
    inputs: &Inputs<'_>,
    wanted: &Wanted,
    centre: UVec2,
    needs: [bool; 2],
) -> [Candidate; 2] {
    let mut found = [Candidate { pixel: centre, facing: -2.0, is_accepted: false }; 2];
    for &offset in offsets {
        if (0..2).all(|lobe| found[lobe].is_accepted || !needs[lobe]) {
            break;
        }
        let Some(tap) = tap(inputs, wanted, centre.as_ivec2() + IVec2::from(offset)) else { continue };
        let is_on_plane = !settings.plane_test || tap.off_plane <= settings.plane_distance * wanted.distance;
        let is_accepted = tap.facing >= settings.least_cosine && is_on_plane;
        for (candidate, has) in found.iter_mut().zip(tap.has) {
            if has {
                candidate.offer(Candidate { pixel: tap.pixel, facing: tap.facing, is_accepted });
            }
        }
    }
    found
}

/// rgb of one lobe at a trace pixel: 0 diffuse, 1 specular.
pub(crate) fn lobe(inputs: &Inputs<'_>, lobe: usize, pixel: UVec2) -> Vec3 {
    match lobe {
        0 => rgb(&inputs.light.diffuse, pixel),
        _ => inputs.light.specular.as_ref().map_or(Vec3::ZERO, |image| rgb(image, pixel)),
    }
}
