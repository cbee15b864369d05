//! GPU against CPU, what must not leak, and the order of the search.
#![allow(clippy::unwrap_used, clippy::panic)]

use super::{BestCandidate, Settings, reference};
use crate::Upsampler;
use crate::nearest::Nearest;
use crate::tests::{DISPLAY, Shot, Stand, TRACE, World, corner, is_close, roughen};
use frame::cpu::Image;
use frame::surface::Surface;
use frame::{FrameLog, set_knob};
use glam::{Vec2, Vec3};
use half::f16;

fn run(stand: &Stand, shot: &Shot, knobs: &[(&str, &str)]) -> (Vec<[f16; 4]>, FrameLog) {
    let mut upsampler = BestCandidate::new(&stand.gpu).unwrap();
    for (name, value) in knobs {
        set_knob(&mut upsampler.knobs(), name, value).unwrap();
    }
    stand.upsample(&mut upsampler, shot)
}

#[test]
fn the_gpu_does_what_the_twin_does() {
    let stand = Stand::new();
    let mut upsampler = BestCandidate::new(&stand.gpu).unwrap();
    for (seed, plane_test) in [(20, true), (40, false)] {
        upsampler.settings.plane_test = plane_test;
        let mut shot = Shot::of(corner, TRACE, DISPLAY).with_random_light(seed);
        shot.frame.jitter = [0.3, -0.1];
        roughen(&mut shot.trace, seed);
        roughen(&mut shot.display, seed + 10);
        let (picture, log) = stand.upsample(&mut upsampler, &shot);
        let (twin, fallbacks) =
            stand.twin(&shot, |inputs| reference::best_candidate(&upsampler.settings, inputs));
        let pairs = picture.iter().zip(twin.texels());
        let count = pairs.filter(|(found, expected)| !is_close(**found, Vec3::from_slice(*expected))).count();
        // Two normals or a distance on the edge of being accepted may fall to either side: a handful.
        assert!(count <= 5, "{count} of {} pixels differ", picture.len());
        let counted = log.counts["upsample_fallbacks"];
        assert!((counted - fallbacks as f64).abs() <= 5.0, "{counted} fallbacks, the twin has {fallbacks}");
        assert!(fallbacks > 100, "{fallbacks} fallbacks are too few to tell");
    }
}

/// Light 1 on trace pixels for which `is_lit` says so, 0 on the others.
fn lit(mut shot: Shot, is_lit: fn(&Surface, f32) -> bool) -> Shot {
    shot.light.specular = None;
    shot.light.diffuse = Image::from_fn(TRACE, |x, y| {
        let words = shot.trace.surface.get(x as i32, y as i32).unwrap();
        let distance = shot.trace.distance.get(x as i32, y as i32).unwrap();
        [f32::from(u8::from(is_lit(&Surface::unpack_gbuffer(words), distance))); 4]
    });
    shot
}

/// Display pixels whose light is not what `is_lit` says.
fn leaks(stand: &Stand, shot: &Shot, picture: &[[f16; 4]], is_lit: fn(&Surface, f32) -> bool) -> usize {
    let wrong = shot.pixels().zip(picture).zip(shot.display.distance.texels()).filter(
        |(((pixel, is_hit), found), d)| {
            let light = Vec3::splat(f32::from(u8::from(is_lit(&shot.display_surface(*pixel), **d))));
            *is_hit && !is_close(**found, stand.modulated(shot, *pixel, light, Vec3::ZERO))
        },
    );
    wrong.count()
}

#[test]
fn light_does_not_leak_over_an_edge() {
    let stand = Stand::new();
    let is_lit = |s: &Surface, _: f32| s.normal.z > 0.5;
    let shot = lit(Shot::of(corner, TRACE, DISPLAY), is_lit);
    let (picture, log) = run(&stand, &shot, &[("plane_test", "off")]);
    assert_eq!(leaks(&stand, &shot, &picture, is_lit), 0);
    assert_eq!(log.counts["upsample_fallbacks"], 0.0);
    let (picture, _) = stand.upsample(&mut Nearest::new(&stand.gpu).unwrap(), &shot);
    assert!(leaks(&stand, &shot, &picture, is_lit) > 20, "the edge must be one that leaks without a search");
}

#[test]
fn the_plane_test_keeps_parallel_walls_apart() {
    let world: World = |direction| {
        let wall = if direction.x > 0.06 { 6.0 } else { 3.0 };
        Some((wall / -direction.z, Surface::default()))
    };
    let stand = Stand::new();
    // Rays lean less than 45 degrees: the near wall ends before 4.5 m.
    let is_lit = |_: &Surface, distance: f32| distance < 4.5;
    let shot = lit(Shot::of(world, TRACE, DISPLAY), is_lit);
    let found = |knob| leaks(&stand, &shot, &run(&stand, &shot, &[("plane_test", knob)]).0, is_lit);
    assert_eq!(found("on"), 0);
    assert!(found("off") > 20, "the step must be one that leaks by normals alone");
}

#[test]
fn what_finds_nothing_takes_the_best_and_is_counted() {
    let world: World = |direction| Some((3.0 / -direction.z, Surface::default()));
    let stand = Stand::new();
    let mut shot = Shot::of(world, TRACE, DISPLAY);
    shot.light.specular = None;
    // No trace pixel faces like the wall; one column in four faces better than the others and says by its light which.
    let facing = |normal: Vec3| Surface { normal: normal.normalize(), ..Surface::default() }.pack_gbuffer(0);
    let (better, worse) = (facing(Vec3::new(1.0, 0.0, 1.0)), facing(Vec3::new(1.0, 0.0, 0.1)));
    shot.trace.surface = Image::from_fn(TRACE, |x, _| if x % 4 == 0 { better } else { worse });
    shot.light.diffuse = Image::from_fn(TRACE, |x, _| [if x % 4 == 0 { 1.0 + x as f32 } else { 0.0 }; 4]);
    let (picture, log) = run(&stand, &shot, &[]);
    for ((pixel, _), found) in shot.pixels().zip(&picture) {
        // Of 64 columns the last good one is 60; of two equally near the left one comes first.
        let column = stand.twin(&shot, |inputs| inputs.trace_pixel(pixel)).x;
        let nearest = (4 * ((column + 1) / 4)).min(60);
        assert!(
            is_close(*found, Vec3::splat(1.0 + nearest as f32)),
            "at {pixel}: {found:?}, not column {nearest}"
        );
    }
    assert_eq!(log.counts["upsample_fallbacks"], picture.len() as f64);
}

#[test]
fn pixels_that_say_nothing_are_passed_over() {
    let world: World =
        |direction| Some((3.0 / -direction.z, Surface { base: Vec3::splat(0.5), ..Surface::default() }));
    let stand = Stand::new();
    let mut shot = Shot::of(world, TRACE, DISPLAY);
    // Columns in turn: a good one, one not traced, a miss, one without a diffuse lobe. Only the first is lit like it.
    let metal = Surface { metalness: 1.0, ..Surface::default() }.pack_gbuffer(0);
    let column = |x: u32| x % 4;
    shot.light.diffuse = Image::from_fn(TRACE, |x, _| if column(x) == 0 { [2.0; 4] } else { [7.0; 4] });
    shot.light.samples = Image::from_fn(TRACE, |x, _| if column(x) == 1 { 0 } else { 1 });
    shot.trace.distance = Image::from_fn(TRACE, |x, y| match column(x) {
        2 => 0.0,
        _ => shot.trace.distance.get(x as i32, y as i32).unwrap(),
    });
    shot.trace.surface = Image::from_fn(TRACE, |x, y| match column(x) {
        3 => metal,
        _ => shot.trace.surface.get(x as i32, y as i32).unwrap(),
    });
    let (picture, log) = run(&stand, &shot, &[]);
    for ((pixel, _), found) in shot.pixels().zip(&picture) {
        let expected = stand.modulated(&shot, pixel, Vec3::splat(2.0), Vec3::ZERO);
        assert!(is_close(*found, expected), "at {pixel}: {found:?}, expected {expected}");
    }
    assert_eq!(log.counts["upsample_fallbacks"], 0.0);
}

#[test]
fn a_mirror_copies_and_lambert_takes_nothing_specular() {
    let world: World = |direction| {
        let mirror = Surface { metalness: 1.0, roughness: Vec2::ZERO, ..Surface::default() };
        Some((3.0 / -direction.z, if direction.x > 0.0 { mirror } else { Surface::default() }))
    };
    let stand = Stand::new();
    let mut shot = Shot::of(world, TRACE, DISPLAY);
    shot.light.specular = Some(Image::from_fn(TRACE, |x, y| [(x + 64 * y) as f32; 4]));
    let (picture, _) = run(&stand, &shot, &[]);
    let copies: Vec<f32> = (0..TRACE[0] * TRACE[1]).map(|i| i as f32).collect();
    for ((pixel, _), found) in shot.pixels().zip(&picture) {
        let surface = shot.display_surface(pixel);
        if surface.metalness == 0.0 {
            assert_eq!(found[0], f16::ZERO, "at {pixel}");
            continue;
        }
        // The light of one trace pixel, not a mean of several: rings reach three pixels at most.
        let centre = stand.twin(&shot, |inputs| inputs.trace_pixel(pixel)).as_ivec2();
        let near = copies.iter().filter(|i| {
            let (x, y) = (**i as i32 % 64, **i as i32 / 64);
            (x - centre.x).abs() <= 3 && (y - centre.y).abs() <= 3
        });
        let is_copy = |i: &f32| is_close(*found, stand.modulated(&shot, pixel, Vec3::ZERO, Vec3::splat(*i)));
        assert!(near.copied().any(|i| is_copy(&i)), "at {pixel}: {found:?}");
    }
}

#[test]
fn the_search_goes_outward_on_the_display() {
    let offsets = Settings::default().offsets(TRACE, DISPLAY);
    assert_eq!(offsets.len(), 49);
    let length = |[x, y]: [i32; 2]| Vec2::new(3.0 * x as f32, 2.25 * y as f32).length();
    assert!(offsets.windows(2).all(|pair| length(pair[0]) <= length(pair[1])), "{offsets:?}");
    // A row is 2.25 display pixels, a column 3; of two that are equally near, the upper or left one first.
    assert_eq!(offsets[..5], [[0, 0], [0, -1], [0, 1], [-1, 0], [1, 0]]);
    for rings in 0..3 {
        let settings = Settings { rings, ..Settings::default() };
        assert_eq!(settings.offsets(TRACE, DISPLAY).len(), (2 * rings as usize + 1).pow(2));
    }
}
