//! Closed forms, and what must hold for any pair. Figures of others' implementations are in the street's tests.

#![allow(clippy::unwrap_used, clippy::panic)]

use super::flip::{PIXELS_PER_DEGREE, flip_map, hdr_flip_map};
use super::*;

type Picture = Image<[f32; 3]>;

/// Smooth colours with some range: 0.01 to 3.
fn scenery(size: [u32; 2]) -> Picture {
    Image::from_fn(size, |x, y| {
        let wave = |frequency: f32, phase: f32| {
            1.0 + (frequency * x as f32 + 0.3 * y as f32 + phase).sin() * (0.2 * y as f32 + phase).cos()
        };
        [0.01 + 1.4 * wave(0.3, 0.0), 0.01 + wave(0.2, 1.0), 0.01 + 0.7 * wave(0.45, 2.0)]
    })
}

/// The same with a checkerboard over it.
fn checkered(picture: &Picture) -> Picture {
    Image::from_fn(picture.size(), |x, y| {
        let factor = if (x / 2 + y / 2) % 2 == 0 { 1.3 } else { 0.8 };
        picture.get(x as i32, y as i32).unwrap().map(|v| v * factor)
    })
}

fn constant(size: [u32; 2], value: f32) -> Picture {
    Image::filled(size, [value; 3])
}

#[track_caller]
fn close(found: f64, expected: f64, relative: f64) {
    assert!((found - expected).abs() <= relative * expected.abs(), "{found} is not {expected}");
}

#[test]
fn a_picture_is_itself() {
    let picture = scenery([33, 20]);
    let none = Counts::default();
    let expected = Errors {
        rmse: 0.0,
        rel_mse: 0.0,
        smape: 0.0,
        psnr: None,
        ssim: Some(1.0),
        flip: 0.0,
        hdr_flip: 0.0,
        bias: [Some(1.0); 3],
        worst_tile: 0.0,
        counts: none,
    };
    assert_eq!(Errors::between(&picture, &picture), Ok(expected));
}

#[test]
fn constant_pictures_have_the_closed_forms() {
    let (r, t) = (constant([16, 16], 0.25), constant([16, 16], 0.5));
    let errors = Errors::between(&r, &t).unwrap();
    close(errors.rmse, 0.25, 1e-12);
    close(errors.rel_mse, 0.0625 / 0.0725, 1e-12);
    close(errors.worst_tile, errors.rel_mse, 1e-12);
    close(errors.smape, 0.5 / 0.76, 1e-12);
    assert_eq!(errors.bias, [Some(2.0); 3]);
    // Through the sRGB curve: codes 0.537099 and 0.735357 (IEC 61966-2-1).
    let (a, b) = (0.537_099f64, 0.735_357f64);
    close(errors.psnr.unwrap(), -20.0 * (b - a).log10(), 1e-5);
    // Without variance only the means are left. f32 moments.
    close(errors.ssim.unwrap(), (2.0 * a * b + 1e-4) / (a * a + b * b + 1e-4), 1e-4);
    // Gray has no chroma, so HyAB is the difference of lightness: L* 57.0754 and 76.0693; no features. The largest
    // difference is that of green and blue: 203.3017. The square root of what f32 leaves of the features of a flat picture
    // raises the rest by up to 3e-4.
    let expected = 0.95 / 0.4 * ((76.0693f64 - 57.0754) / 203.3017).powf(0.7);
    close(errors.flip, expected, 5e-4);
}

#[test]
fn exposure_acts_on_the_display_picture_alone() {
    let (r, t) = (scenery([24, 16]), checkered(&scenery([24, 16])));
    let darker = |p: &Picture| p.map(|texel| texel.map(|v| 0.25 * v));
    let exposed = Errors::between_exposed(&r, &t, -2.0).unwrap();
    let expected = Errors::between(&darker(&r), &darker(&t)).unwrap();
    let plain = Errors::between(&r, &t).unwrap();
    assert_eq!((exposed.psnr, exposed.ssim, exposed.flip), (expected.psnr, expected.ssim, expected.flip));
    assert_eq!(
        (exposed.rmse, exposed.rel_mse, exposed.hdr_flip),
        (plain.rmse, plain.rel_mse, plain.hdr_flip)
    );
    // A quarter is exact, so HDR-FLIP finds the same sweep two stops up: f32 logarithms.
    close(expected.hdr_flip, plain.hdr_flip, 1e-4);
}

#[test]
fn what_is_symmetric_is_so_and_maps_stay_between_0_and_1() {
    let (r, t) = (scenery([40, 30]), checkered(&scenery([40, 30])));
    assert_eq!(rmse(&r, &t), rmse(&t, &r));
    assert_eq!(smape(&r, &t), smape(&t, &r));
    assert_eq!(psnr(&r, &t, 0.0), psnr(&t, &r, 0.0));
    close(ssim(&r, &t, 0.0).unwrap().unwrap(), ssim(&t, &r, 0.0).unwrap().unwrap(), 1e-12);
    let map = |a, b| flip_map(a, b, 0.0, PIXELS_PER_DEGREE).unwrap();
    assert_eq!(map(&r, &t), map(&t, &r));
    assert_ne!(rel_mse(&r, &t), rel_mse(&t, &r));
    // The most different there is: black and white, green and blue, and radiance without bound.
    let [black, white] = [0.0, f32::MAX].map(|v| constant([12, 12], v));
    let [green, blue] = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|c| Image::filled([12, 12], c));
    let board = Image::from_fn([12, 12], |x, y| [if (x + y) % 2 == 0 { 1.0 } else { 0.0 }; 3]);
    for (a, b) in
        [(&r, &t)].into_iter().chain([(&black, &white), (&white, &black), (&green, &blue), (&board, &blue)])
    {
        for map in [map(a, b), hdr_flip_map(a, b, PIXELS_PER_DEGREE).unwrap()] {
            assert!(map.texels().iter().all(|v| (0.0..=1.0 + 1e-6).contains(v)), "{:?}", map.texels());
        }
    }
    // By its definition the largest colour difference.
    close(f64::from(map(&green, &blue).texels()[0]), 1.0, 1e-5);
}

#[test]
fn hdr_flip_sees_at_every_exposure_what_the_display_clips() {
    // Two lamps beyond white that differ, in a dark room.
    let room =
        |lamp: f32| Image::from_fn([32, 32], |x, y| [if x / 8 == 1 && y / 8 == 1 { lamp } else { 0.02 }; 3]);
    let (r, t) = (room(40.0), room(20.0));
    assert_eq!(flip::flip(&r, &t, 0.0), Ok(0.0));
    assert!(flip::hdr_flip(&r, &t).unwrap() > 0.02);
}

#[test]
fn ssim_needs_its_window() {
    let (small, enough) = (constant([10, 40], 0.5), constant([11, 11], 0.5));
    assert_eq!(ssim(&small, &small, 0.0), Ok(None));
    assert_eq!(ssim(&enough, &enough, 0.0), Ok(Some(1.0)));
    let pixel = Errors::between(&constant([1, 1], 1.0), &constant([1, 1], 0.5)).unwrap();
    assert_eq!((pixel.ssim, pixel.rmse), (None, 0.5));
}

#[test]
fn a_broken_tile_in_a_hundred_is_not_the_worst_and_two_are() {
    let reference = constant([160, 160], 1.0);
    let broken = |tiles: u32| {
        Image::from_fn([160, 160], |x, y| if y < 16 && x < 16 * tiles { [11.0; 3] } else { [1.0; 3] })
    };
    assert_eq!(worst_tile(&reference, &broken(1)), Ok(0.0));
    close(worst_tile(&reference, &broken(2)).unwrap(), 100.0 / 1.01, 1e-12);
    // What is left at the border is a tile too.
    let lone = Image::from_fn([17, 16], |x, _| [if x == 16 { 2.0 } else { 1.0 }; 3]);
    close(worst_tile(&constant([17, 16], 1.0), &lone).unwrap(), 1.0 / 1.01, 1e-12);
}

#[test]
fn excess_leaves_out_what_noise_explains() {
    let (r, t) = (constant([8, 8], 1.0), constant([8, 8], 1.5));
    let [none, s_r, s_t] = [0.0, 0.3, 0.4].map(|s| constant([8, 8], s));
    close(excess_rel_mse(&r, &t, &none, &none).unwrap(), rel_mse(&r, &t).unwrap(), 1e-12);
    // 0.5^2 = 0.3^2 + 0.4^2; the standard errors are f32.
    assert!(excess_rel_mse(&r, &t, &s_r, &s_t).unwrap().abs() < 1e-7);
    assert!(excess_rel_mse(&r, &t, &s_t, &s_t).unwrap() < 0.0);
}

#[test]
fn a_channel_without_light_has_no_ratio() {
    let red = Image::filled([4, 4], [1.0, 0.0, 0.0]);
    assert_eq!(bias(&red, &constant([4, 4], 0.5)), Ok([Some(0.5), None, None]));
    let errors = serde_json::to_value(Errors::between(&red, &red).unwrap()).unwrap();
    assert_eq!(errors["bias"], serde_json::json!([1.0, null, null]));
    assert!(errors["psnr"].is_null());
}

#[test]
fn pictures_that_cannot_be_compared_are_refused_with_both_values() {
    let (small, large) = (constant([2, 2], 1.0), constant([3, 2], 1.0));
    let message = Errors::between(&small, &large).unwrap_err().to_string();
    assert!(message.contains("2x2") && message.contains("3x2"), "{message}");
    for refused in [rmse(&small, &large), flip::flip(&small, &large, 0.0), flip::hdr_flip(&small, &large)] {
        assert!(matches!(refused, Err(MetricError::SizesDiffer { .. })), "{refused:?}");
    }
    let empty = constant([0, 7], 1.0);
    assert_eq!(Errors::between(&empty, &empty), Err(MetricError::Empty { size: [0, 7] }));
}

#[test]
fn nan_and_infinity_are_counted_and_refused_negative_is_only_counted() {
    let good = constant([3, 2], 1.0);
    let mut bad = good.clone();
    *bad.get_mut(2, 1).unwrap() = [f32::NAN, f32::NEG_INFINITY, -2.0];
    let counts = Counts { nan_count: 1, inf_count: 1, negative_count: 2 };
    let refused = |side| Err(MetricError::NotFinite { side, counts, first: [2, 1] });
    assert_eq!(Errors::between(&good, &bad), refused(Side::Test));
    assert_eq!(Errors::between(&bad, &good), refused(Side::Reference));
    *bad.get_mut(2, 1).unwrap() = [1.0, 1.0, -2.0];
    assert_eq!(
        Errors::between(&good, &bad).unwrap().counts,
        Counts { negative_count: 1, ..Default::default() }
    );
}
