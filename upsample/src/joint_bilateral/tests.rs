//! GPU against CPU, no leaks, and smoothness where the surface is one.
#![allow(clippy::unwrap_used, clippy::panic)]

use super::{JointBilateral, Settings, reference};
use crate::tests::{DISPLAY, Shot, Stand, TRACE, corner, is_close, roughen};
use frame::cpu::Image;
use frame::surface::Surface;
use glam::{Vec2, Vec3};

#[test]
fn the_gpu_does_what_the_twin_does() {
    let stand = Stand::new();
    let mut shot = Shot::of(corner, TRACE, DISPLAY).with_random_light(20);
    shot.frame.jitter = [0.3, -0.1];
    roughen(&mut shot.trace, 20);
    roughen(&mut shot.display, 30);
    let (picture, log) = stand.upsample(&mut JointBilateral::new(&stand.gpu).unwrap(), &shot);
    let (twin, searches, fallbacks) =
        stand.twin(&shot, |inputs| reference::joint_bilateral(&Settings::default(), inputs));
    let pairs = picture.iter().zip(twin.texels());
    // Powers and exponentials differ by a few units in the last place, and the largest light is 4.
    let near = |found: Vec3, expected: Vec3| {
        (found - expected).abs().max_element() <= 4e-3 * (1.0 + expected.length())
    };
    let count = pairs
        .filter(|(found, expected)| {
            !near(Vec3::new(found[0].into(), found[1].into(), found[2].into()), Vec3::from_slice(*expected))
        })
        .count();
    // Weights, normals and distances on the edge of a decision may fall to either side: a handful.
    assert!(count <= 8, "{count} of {} pixels differ", picture.len());
    for (name, expected) in [("upsample_searches", searches), ("upsample_fallbacks", fallbacks)] {
        let counted = log.counts[name];
        assert!((counted - expected as f64).abs() <= 8.0, "{name}: {counted}, the twin has {expected}");
        assert!(expected > 100, "{expected} {name} are too few to tell");
    }
}

#[test]
fn light_does_not_leak_over_an_edge() {
    let stand = Stand::new();
    let is_lit = |s: &Surface| s.normal.z > 0.5;
    let mut shot = Shot::of(corner, TRACE, DISPLAY);
    shot.light.specular = None;
    shot.light.diffuse =
        shot.trace.surface.map(|w| [f32::from(u8::from(is_lit(&Surface::unpack_gbuffer(w)))); 4]);
    let (picture, _) = stand.upsample(&mut JointBilateral::new(&stand.gpu).unwrap(), &shot);
    for ((pixel, _), found) in shot.pixels().zip(&picture).filter(|((_, is_hit), _)| *is_hit) {
        let light = Vec3::splat(f32::from(u8::from(is_lit(&shot.display_surface(pixel)))));
        let expected = stand.modulated(&shot, pixel, light, Vec3::ZERO);
        // Perpendicular walls: what is left of the other's weight is below 1e-6^32.
        assert!(is_close(*found, expected), "at {pixel}: {found:?}, expected {expected}");
    }
}

#[test]
fn a_ramp_of_light_on_one_wall_stays_a_ramp() {
    let stand = Stand::new();
    let mut shot = Shot::of(|d| Some((3.0 / -d.z, Surface::default())), TRACE, DISPLAY);
    shot.light.specular = None;
    shot.light.diffuse = Image::from_fn(TRACE, |x, y| [(2 * x + y) as f32; 4]);
    let (picture, log) = stand.upsample(&mut JointBilateral::new(&stand.gpu).unwrap(), &shot);
    for ((pixel, _), found) in shot.pixels().zip(&picture) {
        let x = (pixel.as_vec2() + 0.5) / Vec2::new(3.0, 2.25) - 0.5;
        let x = x.clamp(Vec2::ZERO, Vec2::new(63.0, 47.0));
        let error = (found[0].to_f32() - (2.0 * x.x + x.y)).abs();
        // Distances are f32 of some metres: off the plane by 1e-6 of 0.03 m; light up to 173 in steps of 1/8.
        assert!(error <= 0.1, "at {pixel}: {found:?}, expected {}", 2.0 * x.x + x.y);
    }
    assert_eq!(log.counts["upsample_searches"], 0.0);
}
