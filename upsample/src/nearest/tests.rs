//! GPU against CPU.
#![allow(clippy::unwrap_used, clippy::panic)]

use super::{Nearest, reference};
use crate::tests::{DISPLAY, Shot, Stand, TRACE, corner, is_close};
use glam::Vec3;

#[test]
fn the_gpu_does_what_the_twin_does() {
    let stand = Stand::new();
    let shot = Shot::of(corner, TRACE, DISPLAY).with_random_light(10);
    let (picture, _) = stand.upsample(&mut Nearest::new(&stand.gpu).unwrap(), &shot);
    let twin = stand.twin(&shot, reference::nearest);
    for (i, (found, expected)) in picture.iter().zip(twin.texels()).enumerate() {
        assert!(is_close(*found, Vec3::from_slice(expected)), "texel {i}: {found:?}, expected {expected:?}");
    }
}
