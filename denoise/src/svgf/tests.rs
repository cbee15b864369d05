//! What time does to noise, what must be forgotten, and what must not change.
#![allow(clippy::unwrap_used, clippy::panic)]

use super::{Settings, Svgf};
use crate::Denoiser;
use crate::fixture::{Shot, gpu, halves, noise, pack_motion, random, read};
use frame::cpu::Image;
use frame::surface::{Surface, face_normal_pack};
use frame::{FrameLog, Gpu, set_knob};
use glam::{Vec2, Vec3};
use half::f16;

mod twin;

/// Frames that each pixel of the diffuse lobe has been followed.
fn frames_of(gpu: &Gpu, log: &FrameLog) -> Vec<u32> {
    read::<u32>(gpu, log, "denoise/svgf/frames").into_iter().map(|packed| packed & 0xffff).collect()
}

fn variance_of(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let count = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / count;
    values.map(|v| (v - mean).powi(2)).sum::<f64>() / count
}

/// Pixels that share no surface: each at a depth of its own.
fn loners(size: [u32; 2]) -> Shot {
    let mut shot = Shot::wall(size, 1.0);
    shot.distance = Image::from_fn(size, |x, y| (12.0 * random(99, size[0] * y + x)).exp2());
    shot
}

#[test]
fn noise_falls_with_the_frames_as_predicted() {
    let (gpu, size) = (gpu(), [32, 32]);
    let still = loners(size);
    // Uniform between 0 and 2: a variance of 1/3. What is left of it after 32 frames: all alike, 1/32; with a share a of
    // each new frame beyond the fifth, near a / (2 - a) = 1/9.
    for (alpha, left) in [("0", 1.0 / 32.0), ("0.2", 1.0 / 9.0)] {
        let mut denoiser = Svgf::new(&gpu).unwrap();
        set_knob(&mut denoiser.knobs(), "alpha_color", alpha).unwrap();
        set_knob(&mut denoiser.knobs(), "sigma_z", "0.01").unwrap();
        denoiser.resize(&gpu, size, true).unwrap();
        let mut last = None;
        for index in 0..32 {
            let mut shot = still.sequel(index);
            shot.noisy.diffuse = noise(size, index);
            last = Some(shot.next(&gpu, &mut denoiser));
        }
        let (clean, log) = last.unwrap();
        assert!(frames_of(&gpu, &log).iter().all(|n| *n == 32));
        let found = variance_of(clean.diffuse.iter().map(|t| t[0].to_f64()));
        // A variance from 1,024 pixels is known to 4.4 %: three deviations.
        let ratio = found / (left / 3.0);
        assert!((0.867..1.133).contains(&ratio), "alpha {alpha}: {ratio} of what was predicted");
    }
}

#[test]
fn a_wall_gets_quiet_and_keeps_its_energy() {
    let (gpu, size) = (gpu(), [96, 80]);
    let mut denoiser = Svgf::new(&gpu).unwrap();
    denoiser.resize(&gpu, size, true).unwrap();
    let still = Shot::wall(size, 1.0);
    let mut left = Vec::new();
    for index in 0..32 {
        let mut shot = still.sequel(index);
        shot.noisy.diffuse = noise(size, index);
        let (clean, _) = shot.next(&gpu, &mut denoiser);
        left.push(variance_of(clean.diffuse.iter().map(|t| t[0].to_f64())));
        if index == 31 {
            let mean = clean.diffuse.iter().map(|t| t[0].to_f64()).sum::<f64>() / clean.diffuse.len() as f64;
            // The last five frames or so count: 38,400 draws with a deviation of 58 % of the mean, 0.3 %. The luminance
            // weight is even about the mean of light that is, so nothing is lost.
            assert!((mean - 1.0).abs() < 0.005, "mean {mean}");
        }
    }
    // Of 1/3, the wavelet alone leaves less than a hundredth, and 1/9 of that remains once history is long.
    assert!(left[0] < 0.01 / 3.0 && left[31] < 0.25 * left[0], "{} at first, {} at last", left[0], left[31]);
}

#[test]
fn a_camera_that_moves_along_a_wall_takes_history_with_it() {
    let (gpu, size) = (gpu(), [48, 32]);
    let mut denoiser = Svgf::new(&gpu).unwrap();
    denoiser.resize(&gpu, size, true).unwrap();
    let still = Shot::wall(size, 2.0);
    // Three pixels to the right per frame: the picture moves three to the left.
    let pixel = 2.0 * 2.0 * (0.5 * still.frame.camera.vfov).tan() / size[1] as f32;
    let mut frames = Vec::new();
    for index in 0..4 {
        let mut shot = still.sequel(index);
        let move_to = |camera: &mut scene::Camera, index: u32| {
            let offset = Vec3::X * 3.0 * pixel * index as f32;
            camera.eye += offset;
            camera.target += offset;
        };
        move_to(&mut shot.frame.camera, index);
        move_to(&mut shot.frame.previous_camera, index.saturating_sub(1));
        shot.others = Image::filled(size, [0, pack_motion(Vec2::new(-3.0, 0.0)), 1]);
        shot.noisy.diffuse = noise(size, index);
        frames = frames_of(&gpu, &shot.next(&gpu, &mut denoiser).1);
    }
    for (i, found) in (0..).zip(&frames) {
        // Each frame uncovers three columns at the right, and one beyond them finds its neighbour in the 3x3 search.
        let age = (size[0] - 1 - i % size[0]) / 3;
        let expected = (age + 1).min(4);
        assert!(
            (expected..=(expected + 1).min(4)).contains(found),
            "pixel {i}: followed for {found}, there for {expected}"
        );
    }
    assert!(frames.contains(&1) && frames.contains(&4));
}

/// Fills in what the camera of `shot.frame` sees of the plane through `point`, and how that has moved.
fn look_at_plane(shot: &mut Shot, point: Vec3, normal: Vec3) {
    let now = shot.frame.uniform();
    let mut frame = shot.frame.clone();
    frame.camera = frame.previous_camera.clone();
    let before = frame.uniform();
    let size = shot.surface.size();
    let extent = Vec2::new(size[0] as f32, size[1] as f32);
    let hit = |x: u32, y: u32| {
        let place = Vec2::new(x as f32, y as f32) + 0.5 + Vec2::from(now.jitter);
        let ndc = (place / extent) * Vec2::new(2.0, -2.0) + Vec2::new(-1.0, 1.0);
        let [forward, right, up, eye] = [now.forward, now.right, now.up, now.eye].map(Vec3::from);
        let ray = forward + ndc.x * right + ndc.y * up;
        (place, eye + normal.dot(point - eye) / normal.dot(ray) * ray)
    };
    shot.distance = Image::from_fn(size, |x, y| hit(x, y).1.distance(Vec3::from(now.eye)));
    shot.surface = Image::filled(size, Surface { normal, ..Surface::default() }.pack_gbuffer(0));
    shot.others = Image::from_fn(size, |x, y| {
        let (place, position) = hit(x, y);
        let [forward, right, up, eye] = [before.forward, before.right, before.up, before.eye].map(Vec3::from);
        let seen = position - eye;
        let along = |axis: Vec3| seen.dot(axis) / axis.length_squared() / seen.dot(forward);
        let place_before = (Vec2::new(along(right), -along(up)) * 0.5 + 0.5) * extent;
        [face_normal_pack(normal), pack_motion(place - place_before), 1]
    });
}

#[test]
fn a_camera_that_turns_and_nears_a_slanted_plane_follows_every_pixel() {
    let (gpu, size) = (gpu(), [50, 38]);
    let mut denoiser = Svgf::new(&gpu).unwrap();
    denoiser.resize(&gpu, size, true).unwrap();
    // 0.6 mm at 2 m, a thirtieth of what is usual. The camera comes 8 cm nearer, so depth itself differs by 4 %; motions
    // of a few pixels, as half floats, are right to 2e-3 px, 0.1 mm.
    set_knob(&mut denoiser.knobs(), "history_plane", "0.0003").unwrap();
    let base = Shot::wall(size, 2.0);
    let normal = Vec3::new(0.5, -0.3, 1.0).normalize();
    let point = base.frame.camera.eye - 2.0 * Vec3::Z;
    let camera = |index: u32| {
        let mut camera = base.frame.camera.clone();
        camera.eye += index as f32 * Vec3::new(0.03, 0.01, -0.08);
        camera.target += index as f32 * Vec3::new(0.06, -0.02, -0.08);
        camera
    };
    let jitters = [[0.3, -0.2], [-0.4, 0.1], [0.2, 0.45]];
    for index in 0..3 {
        let mut shot = base.sequel(index);
        shot.frame.camera = camera(index);
        shot.frame.previous_camera = camera(index.saturating_sub(1));
        shot.frame.jitter = jitters[index as usize];
        shot.frame.previous_jitter = jitters[index.saturating_sub(1) as usize];
        look_at_plane(&mut shot, point, normal);
        shot.noisy.diffuse = noise(size, index);
        let frames = frames_of(&gpu, &shot.next(&gpu, &mut denoiser).1);
        // Motion is a few pixels a frame: what lies farther from the border than that was in the picture before.
        let inside = |i: u32| (12..38).contains(&(i % 50)) && (12..26).contains(&(i / 50));
        let lost = (0..).zip(&frames).filter(|(i, n)| inside(*i) && **n != index + 1).count();
        assert_eq!(lost, 0, "frame {index}: pixels that were not followed");
    }
}

#[test]
fn what_was_hidden_begins_at_one() {
    let (gpu, size) = (gpu(), [40, 30]);
    let wall = Shot::wall(size, 4.0);
    // What uncovers the wall: another object; the same object nearer; the same place, turned away.
    let covered: [fn(&mut Shot, i32, i32); 3] = [
        |shot, x, y| shot.others.get_mut(x, y).unwrap()[2] = 7,
        |shot, x, y| *shot.distance.get_mut(x, y).unwrap() *= 0.9,
        |shot, x, y| {
            let turned = Surface { normal: Vec3::new(1.0, 0.0, 1.0).normalize(), ..Surface::default() };
            *shot.surface.get_mut(x, y).unwrap() = turned.pack_gbuffer(0);
        },
    ];
    for (case, cover) in covered.into_iter().enumerate() {
        let mut denoiser = Svgf::new(&gpu).unwrap();
        denoiser.resize(&gpu, size, true).unwrap();
        let mut frames = Vec::new();
        for index in 0..6 {
            let mut shot = wall.sequel(index);
            shot.noisy.diffuse = noise(size, index);
            if index < 5 {
                for (x, y) in (10..20).flat_map(|x| (10..20).map(move |y| (x, y))) {
                    cover(&mut shot, x, y);
                }
            }
            frames = frames_of(&gpu, &shot.next(&gpu, &mut denoiser).1);
        }
        for (i, found) in (0..).zip(frames) {
            let (x, y) = (i % 40, i / 40);
            let was_hidden = |inset: i32| {
                let range = 10 + inset..20 - inset;
                range.contains(&x) && range.contains(&y)
            };
            // On the rim the 3x3 search finds wall that was there before.
            if was_hidden(1) {
                assert_eq!(found, 1, "case {case}, pixel {x}, {y}");
            } else if !was_hidden(0) {
                assert_eq!(found, 6, "case {case}, pixel {x}, {y}");
            }
        }
    }
}

#[test]
fn edges_stay_sharp() {
    let (gpu, size) = (gpu(), [32, 32]);
    let half_lit = Image::from_fn(size, |x, _| if x < 16 { [1.0; 4] } else { [0.0, 0.0, 0.0, 8.0] });
    let mut behind = Shot::wall(size, 1.0);
    // A row at 1 m spans 26 mm; half a metre behind is 19 rows: exp(-19) of the light is below the least half float.
    behind.distance = Image::from_fn(size, |x, y| {
        behind.distance.get(x as i32, y as i32).unwrap() * (1.0 + 0.5 * (x / 16) as f32)
    });
    let mut angle = Shot::wall(size, 1.0);
    // 45 degrees apart: cos^128 is 5e-20.
    let facing = |normal| Surface { normal, ..Surface::default() }.pack_gbuffer(0);
    let tilted = Vec3::new(1.0, 0.0, 1.0).normalize();
    angle.surface = Image::from_fn(size, |x, _| facing(if x < 16 { tilted } else { Vec3::Z }));
    for (what, mut shot) in [("behind", behind), ("angle", angle)] {
        shot.noisy.diffuse = half_lit.clone();
        let mut denoiser = Svgf::new(&gpu).unwrap();
        // Only geometry may tell them apart.
        set_knob(&mut denoiser.knobs(), "sigma_l", "100").unwrap();
        assert!(shot.denoise(&gpu, &mut denoiser).0.diffuse == halves(&half_lit), "{what}");
    }
}

#[test]
fn untraced_pixels_are_filled_or_keep_their_history() {
    let (gpu, size) = (gpu(), [24, 24]);
    let mut denoiser = Svgf::new(&gpu).unwrap();
    let mut shot = Shot::wall(size, 1.0);
    shot.noisy.diffuse =
        Image::from_fn(size, |x, y| if (x + y).is_multiple_of(2) { [2.0, 2.0, 2.0, 5.0] } else { [0.0; 4] });
    shot.noisy.samples = Image::from_fn(size, |x, y| u32::from((x + y).is_multiple_of(2)));
    let (clean, log) = shot.denoise(&gpu, &mut denoiser);
    let all_two = |texels: &[[f16; 4]]| texels.iter().all(|t| t.map(f16::to_f32) == [2.0, 2.0, 2.0, 5.0]);
    assert!(all_two(&clean.diffuse), "filled");
    let half: u32 = frames_of(&gpu, &log).iter().sum();
    assert_eq!(half, 24 * 24 / 2, "what was filled has no frames");
    let mut dark = shot.sequel(1);
    dark.noisy.diffuse = Image::filled(size, [0.0; 4]);
    dark.noisy.samples = Image::filled(size, 0);
    let (clean, log) = dark.next(&gpu, &mut denoiser);
    assert!(all_two(&clean.diffuse), "kept");
    assert!(frames_of(&gpu, &log).iter().all(|n| *n <= 1), "and grew no older");
}

#[test]
fn the_history_it_reports_is_what_it_allocates() {
    let gpu = gpu();
    let before = gpu.memory(frame::Room::History).live;
    let mut denoiser = Svgf::new(&gpu).unwrap();
    denoiser.resize(&gpu, [64, 48], true).unwrap();
    assert_eq!(gpu.memory(frame::Room::History).live - before, denoiser.history_bytes());
    // Twice edges 16, moments 16 and frames 4; lobes 8 + 8.
    assert_eq!(denoiser.history_bytes(), 64 * 48 * (2 * (16 + 16 + 4) + 16));
    assert_eq!(Settings::default(), denoiser.settings);
}
