//! GPU against CPU over several frames, what many frames bring, and what must not be kept.
#![allow(clippy::unwrap_used, clippy::panic)]

use super::{Settings, Temporal, jitter, reference};
use crate::Upsampler;
use crate::tests::{DISPLAY, Shot, Stand, TRACE, World, corner, random_light};
use frame::cpu::Image;
use frame::surface::Surface;
use glam::{Vec2, Vec3};
use half::f16;

fn rgb(texel: &[f16; 4]) -> Vec3 {
    Vec3::new(texel[0].into(), texel[1].into(), texel[2].into())
}

/// Frame `index` of a world from a camera that stands `aside` metres to the right of the last frame's.
fn frame(world: World, index: u32, aside: f32) -> Shot {
    let mut shot = Shot::of_jittered(world, TRACE, DISPLAY, jitter(index, TRACE, DISPLAY));
    shot.frame.frame_index = index;
    shot.frame.restart = index == 0;
    shot.frame.previous_camera.eye.x -= aside;
    shot.frame.previous_camera.target.x -= aside;
    // A point at distance d in front moves aside / d of half a picture's height per tan(vfov / 2).
    let focal = 0.5 * DISPLAY[1] as f32 / (0.5 * shot.frame.camera.vfov).tan();
    shot.motion = Image::from_fn(DISPLAY, |x, y| {
        let distance = shot.display.distance.get(x as i32, y as i32).unwrap();
        let direction = shot.direction(Vec2::new(x as f32, y as f32) + 0.5, DISPLAY);
        let depth = -direction.z * distance;
        ([if depth > 0.0 { -aside * focal / depth } else { 0.0 }, 0.0], 7)
    });
    shot
}

#[test]
fn the_gpu_does_what_the_twin_does() {
    let stand = Stand::new();
    let mut upsampler = Temporal::new(&stand.gpu).unwrap();
    let settings = Settings::default();
    let mut history = None;
    for index in 0..4 {
        let mut shot = frame(corner, index, if index == 3 { 0.01 } else { 0.0 });
        shot.light = random_light(TRACE, 20 + index);
        let (picture, _) = if index == 0 {
            stand.upsample(&mut upsampler, &shot)
        } else {
            stand.upsample_next(&mut upsampler, &shot)
        };
        // Motion as half floats have it.
        let motion = shot.motion.map(|(m, object)| (m.map(|x| f16::from_f32(x).to_f32()), object));
        let params = settings.params(&shot.frame, index > 0);
        let (twin, kept) = stand.twin(&shot, |inputs| {
            let before = reference::Before { history: history.as_ref(), params: &params, motion: &motion };
            reference::temporal(&settings, inputs, &before)
        });
        history = Some(kept);
        let off = picture.iter().zip(twin.texels()).filter(|(found, expected)| {
            let expected = Vec3::from_slice(*expected);
            // What is kept is rounded to half floats each frame: 2^-11 of at most 4, on weights as well.
            ((rgb(found) - expected).abs() / (1.0 + expected)).max_element() > 8e-3
        });
        // Weights and planes on the edge of a decision may fall to either side.
        let off = off.count();
        assert!(off <= 30, "frame {index}: {off} of {} pixels differ", picture.len());
    }
}

/// A wall whose light is a sharp pattern of stripes, finer than trace pixels.
fn striped(index: u32, is_jittered: bool) -> Shot {
    let world: World = |direction| Some((3.0 / -direction.z, Surface::default()));
    let mut shot = frame(world, index, 0.0);
    if !is_jittered {
        shot = Shot { frame: shot.frame.clone(), ..Shot::of(world, TRACE, DISPLAY) };
        shot.frame.jitter = [0.0; 2];
    }
    shot.light.specular = None;
    let offset = shot.frame.jitter[0];
    shot.light.diffuse =
        Image::from_fn(TRACE, |x, _| [stripes((x as f32 + 0.5 + offset) / TRACE[0] as f32); 4]);
    shot
}

/// Of a place 0..1 along the picture: 24 periods, so that a trace pixel spans 3/8 of one.
fn stripes(place: f32) -> f32 {
    1.0 + (24.0 * std::f32::consts::TAU * place).sin()
}

fn error_after(stand: &Stand, frames: u32, is_jittered: bool) -> f32 {
    let mut upsampler = Temporal::new(&stand.gpu).unwrap();
    let mut picture = stand.upsample(&mut upsampler, &striped(0, is_jittered)).0;
    for index in 1..frames {
        picture = stand.upsample_next(&mut upsampler, &striped(index, is_jittered)).0;
    }
    let errors = (0..).zip(&picture).map(|(i, found)| {
        let place = ((i % DISPLAY[0]) as f32 + 0.5) / DISPLAY[0] as f32;
        (found[0].to_f32() - stripes(place)).powi(2)
    });
    (errors.sum::<f32>() / picture.len() as f32).sqrt()
}

#[test]
fn jittered_frames_bring_detail_that_one_lacks() {
    let stand = Stand::new();
    let first = error_after(&stand, 1, true);
    let many = error_after(&stand, 32, true);
    let still = error_after(&stand, 32, false);
    // A stripe's deviation is 0.71. What is left is the Gaussian's width and the clamp.
    assert!(many < 0.5 * first, "{many} after 32 frames, {first} after one");
    assert!(many < 0.5 * still, "{many} with jitter, {still} without");
}

#[test]
fn what_was_kept_of_other_light_is_pulled_in() {
    let stand = Stand::new();
    let world: World = |direction| Some((3.0 / -direction.z, Surface::default()));
    let mut upsampler = Temporal::new(&stand.gpu).unwrap();
    let lit = |index: u32, light: f32| {
        let mut shot = frame(world, index, 0.0);
        shot.light.specular = None;
        shot.light.diffuse = Image::filled(TRACE, [light; 4]);
        shot
    };
    stand.upsample(&mut upsampler, &lit(0, 8.0));
    (1..8).for_each(|index| drop(stand.upsample_next(&mut upsampler, &lit(index, 8.0))));
    let (picture, _) = stand.upsample_next(&mut upsampler, &lit(8, 1.0));
    for found in &picture {
        // Constant light has no spread: 2 % of the new light is allowed.
        assert!((found[0].to_f32() - 1.0).abs() <= 0.03, "{found:?}");
    }
}

#[test]
fn a_restart_another_object_or_another_plane_keeps_nothing() {
    let stand = Stand::new();
    let world: World = |direction| Some((3.0 / -direction.z, Surface::default()));
    let nearer: World = |direction| Some((2.5 / -direction.z, Surface::default()));
    let alone = |shot: &Shot| stand.upsample(&mut Temporal::new(&stand.gpu).unwrap(), shot).0;
    let after = |shot: &Shot| {
        let mut upsampler = Temporal::new(&stand.gpu).unwrap();
        stand.upsample(&mut upsampler, &frame(world, 0, 0.0).with_random_light(1));
        stand.upsample_next(&mut upsampler, shot).0
    };
    let restart = |mut shot: Shot| {
        shot.frame.restart = true;
        shot
    };
    let mut other = frame(world, 1, 0.0).with_random_light(2);
    assert!(after(&other) != alone(&restart(other.clone())), "the frame before must count where it may");
    assert!(after(&restart(other.clone())) == alone(&restart(other.clone())));
    other.motion = other.motion.map(|(motion, _)| (motion, 8));
    assert!(after(&other) == alone(&restart(other.clone())));
    let other = frame(nearer, 1, 0.0).with_random_light(2);
    assert!(after(&other) == alone(&restart(other.clone())));
}

#[test]
fn jitter_covers_the_pixel_evenly_and_is_none_at_equal_sizes() {
    let period = 54; // 8 * 3 * 2.25
    let all: Vec<_> = (0..period).map(|i| Vec2::from(jitter(i, TRACE, DISPLAY))).collect();
    assert!(all.iter().all(|j| j.abs().max_element() <= 0.5));
    let mean = all.iter().sum::<Vec2>() / period as f32;
    // Halton's discrepancy: about log(n)^2 / n.
    assert!(mean.length() < 0.05, "{mean}");
    assert_eq!(jitter(period, TRACE, DISPLAY), jitter(0, TRACE, DISPLAY));
    assert_eq!(jitter(3, TRACE, TRACE), [0.0; 2]);
    let stand = Stand::new();
    let mut upsampler = Temporal::new(&stand.gpu).unwrap();
    upsampler.resize(&stand.gpu, TRACE, DISPLAY, true).unwrap();
    // Two lobes of 8 bytes and guides of 8, twice.
    assert_eq!(upsampler.history_bytes(), 48 * u64::from(DISPLAY[0] * DISPLAY[1]));
}
