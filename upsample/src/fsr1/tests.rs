//! GPU against CPU, and what an enlarged picture must not do.
#![allow(clippy::unwrap_used, clippy::panic)]

use super::{Fsr1, reference};
use crate::modulate::reference::Light;
use crate::nearest::Nearest;
use crate::tests::{DISPLAY, Shot, Stand, TRACE, corner, is_close, random_light};
use frame::cpu::Image;
use frame::surface::Surface;
use glam::Vec3;
use half::f16;

fn white_wall(direction: Vec3) -> Option<(f32, Surface)> {
    Some((3.0 / -direction.z, Surface::default()))
}

#[test]
fn the_gpu_does_what_the_twin_does() {
    let stand = Stand::new();
    let mut shot = Shot::of(corner, TRACE, DISPLAY).with_random_light(3);
    shot.direct = Some(Light { samples: Image::filled(DISPLAY, 1), ..random_light(DISPLAY, 4) });
    let (picture, log) = stand.upsample(&mut Fsr1::new(&stand.gpu).unwrap(), &shot);
    let color: Vec<[f16; 4]> = stand.gpu.read_texture(log.output("upsample/nearest").unwrap()).unwrap();
    let color = Image::from_texels(TRACE, color.into_iter().map(|c| c.map(f16::to_f32)).collect()).unwrap();
    let scale = shot.frame.radiance_scale;
    let twin = reference::rcas(&reference::easu(&color, DISPLAY, scale), (-0.2f32).exp2(), scale);
    let mut worst = 0.0f32;
    for (((pixel, is_hit), found), expected) in shot.pixels().zip(&picture).zip(twin.texels()) {
        let direct = shot.direct.as_ref().unwrap();
        let at =
            |image: &Image<[f32; 4]>| Vec3::from_slice(&image.get(pixel.x as i32, pixel.y as i32).unwrap());
        let surface = shot.display_surface(pixel);
        let added = stand.modulated(&shot, pixel, at(&direct.diffuse), at(direct.specular.as_ref().unwrap()));
        let expected = if is_hit {
            Vec3::from_slice(expected) + added - surface.emission
        } else {
            stand.sky(stand.twin(&shot, |inputs| inputs.display_direction(pixel)))
        };
        let found = Vec3::new(found[0].into(), found[1].into(), found[2].into());
        worst = worst.max(((found - expected).abs() / (1.0 + expected)).max_element());
    }
    // Two roundings to half floats, sharpened up to four times.
    assert!(worst < 8e-3, "off by {worst}");
}

#[test]
fn a_constant_picture_stays_as_it_is() {
    let stand = Stand::new();
    let mut shot = Shot::of(white_wall, TRACE, DISPLAY);
    shot.light.specular = None;
    shot.light.diffuse = Image::filled(TRACE, [3.0, 0.5, 40.0, 1.0]);
    let (picture, _) = stand.upsample(&mut Fsr1::new(&stand.gpu).unwrap(), &shot);
    for found in &picture {
        let found = Vec3::new(found[0].into(), found[1].into(), found[2].into());
        // Tone mapping and back loses 1/(1 - 40/41) = 41 units in the last place of f32, twice, beside half floats.
        assert!((found / Vec3::new(3.0, 0.5, 40.0) - 1.0).abs().max_element() < 4e-3, "{found}");
    }
}

#[test]
fn an_edge_neither_rings_nor_moves() {
    let stand = Stand::new();
    let mut upsampler = Fsr1::new(&stand.gpu).unwrap();
    // Sharpening is meant to overshoot its neighbours; without it nothing may.
    upsampler.softness = 8.0;
    let mut shot = Shot::of(white_wall, TRACE, DISPLAY);
    shot.light.specular = None;
    shot.light.diffuse = Image::from_fn(TRACE, |x, _| if x < 32 { [0.2; 4] } else { [2.0; 4] });
    let (picture, _) = stand.upsample(&mut upsampler, &shot);
    for ((pixel, _), found) in shot.pixels().zip(&picture) {
        let value = found[0].to_f32();
        // What is left of the sharpening is 1/256 of at most 0.19 of four differences.
        assert!((0.19..=2.02).contains(&value), "at {pixel}: {value} rings");
        // Three display pixels a trace pixel: the edge is at 96, and its ramp at most two trace pixels wide.
        if pixel.x < 93 {
            assert!(value < 0.21, "at {pixel}: {value}");
        }
        if pixel.x >= 99 {
            assert!(value > 1.98, "at {pixel}: {value}");
        }
    }
}

#[test]
fn equal_sizes_pass_through_to_the_bit() {
    let stand = Stand::new();
    let shot = Shot::of(corner, TRACE, TRACE).with_random_light(5);
    let (picture, _) = stand.upsample(&mut Fsr1::new(&stand.gpu).unwrap(), &shot);
    let (nearest, _) = stand.upsample(&mut Nearest::new(&stand.gpu).unwrap(), &shot);
    assert!(picture == nearest);
    assert!(picture.iter().any(|texel| !is_close(*texel, Vec3::ONE)));
}
