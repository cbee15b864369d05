//! GPU against CPU.
#![allow(clippy::unwrap_used, clippy::panic)]

use super::{Identity, reference};
use crate::fixture::{Shot, gpu, halves};

#[test]
fn valid_light_passes_by_and_the_rest_is_mended_as_the_twin_does() {
    let gpu = gpu();
    let mut shot = Shot::random([45, 33], 10);
    shot.break_pixels(10);
    let (clean, log) = shot.denoise(&gpu, &mut Identity::new(&gpu).unwrap());
    let twin = reference::denoise(&shot.noisy);
    assert!(clean.diffuse == halves(&twin.diffuse));
    assert!(clean.specular == Some(halves(twin.specular.as_ref().unwrap())));
    assert_eq!(log.counts["denoise_invalid"], 10.0);
}
