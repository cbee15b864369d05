//! GPU against CPU, and a ramp of light, which stays a ramp.
#![allow(clippy::unwrap_used, clippy::panic)]

use super::{Bilinear, reference};
use crate::tests::{DISPLAY, Shot, Stand, TRACE, corner, is_close};
use frame::cpu::Image;
use frame::surface::Surface;
use glam::Vec3;

#[test]
fn the_gpu_does_what_the_twin_does() {
    let stand = Stand::new();
    let mut shot = Shot::of(corner, TRACE, DISPLAY).with_random_light(10);
    shot.frame.jitter = [0.3, -0.2];
    let (picture, _) = stand.upsample(&mut Bilinear::new(&stand.gpu).unwrap(), &shot);
    let twin = stand.twin(&shot, reference::bilinear);
    for (i, (found, expected)) in picture.iter().zip(twin.texels()).enumerate() {
        assert!(is_close(*found, Vec3::from_slice(expected)), "texel {i}: {found:?}, expected {expected:?}");
    }
}

#[test]
fn a_ramp_of_light_stays_a_ramp() {
    let stand = Stand::new();
    let mut shot = Shot::of(|d| Some((3.0 / -d.z, Surface::default())), TRACE, DISPLAY);
    shot.light.specular = None;
    shot.light.diffuse = Image::from_fn(TRACE, |x, y| [(2 * x + y) as f32; 4]);
    let (picture, _) = stand.upsample(&mut Bilinear::new(&stand.gpu).unwrap(), &shot);
    for ((pixel, _), found) in shot.pixels().zip(&picture) {
        let x = (pixel.as_vec2() + 0.5) / glam::Vec2::new(3.0, 2.25) - 0.5;
        // Beyond the outermost centres there is nothing to mix with.
        let x = x.clamp(glam::Vec2::ZERO, glam::Vec2::new(63.0, 47.0));
        assert!(is_close(*found, Vec3::splat(2.0 * x.x + x.y)), "at {pixel}: {found:?}");
    }
}
