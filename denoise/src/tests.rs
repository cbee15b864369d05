//! Promises of every denoiser.
#![allow(clippy::unwrap_used, clippy::panic)]

use crate::fixture::{Shot, gpu, halves, noise, pack_motion};
use crate::{Denoiser, Guides, Need, all};
use frame::Gpu;
use frame::cpu::Image;
use frame::surface::{Surface, hash};
use glam::Vec2;
use half::f16;

fn each(mut check: impl FnMut(&Gpu, &str, &mut dyn Denoiser)) {
    let gpu = gpu();
    // The network keeps its own promises, see its folder.
    for (name, make) in all().iter().filter(|(name, _)| *name != "oidn") {
        check(&gpu, name, make(&gpu).unwrap().as_mut());
    }
}

#[test]
fn names_are_those_of_the_list() {
    each(|_, name, denoiser| {
        assert_eq!(denoiser.name(), name);
        let mut knobs: Vec<_> = denoiser.knobs().into_iter().map(|knob| knob.name).collect();
        knobs.sort_unstable();
        assert!(knobs.windows(2).all(|pair| pair[0] != pair[1]), "{name}: a knob twice in {knobs:?}");
    });
}

#[test]
fn constant_light_stays_constant_to_the_bit() {
    let mut shot = Shot::random([45, 33], 1);
    let constant = [0.7, 0.001, 1234.5, 2.5].map(|x| f16::from_f32(x).to_f32());
    shot.noisy.diffuse = Image::filled([45, 33], constant);
    shot.noisy.specular = Some(shot.noisy.diffuse.clone());
    // Every pixel traced: what was not may be filled, and then only from neighbours that face it.
    shot.noisy.samples = Image::filled([45, 33], 0x1_0001);
    each(|gpu, name, denoiser| {
        let (clean, _) = shot.denoise(gpu, denoiser);
        assert!(clean.diffuse == halves(&shot.noisy.diffuse), "{name}");
        assert!(clean.specular == Some(halves(&shot.noisy.diffuse)), "{name}");
    });
}

#[test]
fn channels_called_unused_do_not_change_a_bit() {
    let shot = Shot::random([45, 33], 2);
    each(|gpu, name, denoiser| {
        let Guides { surface, distance, face_normal, motion_id } = denoiser.guides();
        let mut poisoned = shot.clone();
        // A quiet NaN as f32, a NaN in both halves as packed half floats.
        let poison = 0x7fc0_7e00;
        if face_normal == Need::Unused {
            poisoned.others = poisoned.others.map(|[_, motion, object]| [poison, motion, object]);
        }
        if motion_id == Need::Unused {
            poisoned.others = poisoned.others.map(|[face_normal, ..]| [face_normal, poison, poison]);
        }
        if surface == Need::Unused {
            poisoned.surface = poisoned.surface.map(|_| [poison; 4]);
        }
        if distance == Need::Unused {
            poisoned.distance = poisoned.distance.map(|_| f32::NAN);
        }
        assert!(poisoned.denoise(gpu, denoiser).0 == shot.denoise(gpu, denoiser).0, "{name}");
    });
}

#[test]
fn the_smallest_pictures_and_one_lobe_alone_work() {
    each(|gpu, name, denoiser| {
        for size in [[1, 1], [1, 17], [17, 1], [3, 2]] {
            let mut shot = Shot::random(size, 4);
            let (clean, _) = shot.denoise(gpu, denoiser);
            assert_eq!(clean.diffuse.len(), (size[0] * size[1]) as usize, "{name} at {size:?}");
            shot.noisy.specular = None;
            let (alone, _) = shot.denoise(gpu, denoiser);
            assert_eq!(alone.specular, None, "{name} at {size:?}");
            assert!(alone.diffuse == clean.diffuse, "{name} at {size:?}: the lobes do not touch each other");
        }
    });
}

#[test]
fn any_bits_in_never_come_out_as_nan() {
    let size = [33, 21];
    let word = |x: u32, y: u32, what: u32| hash(hash(what) ^ (y * size[0] + x));
    // Half floats of any bits, and words of any bits, some of them NaN and infinite on purpose.
    let number = |x, y, what| match word(x, y, what) {
        w if w.is_multiple_of(7) => {
            [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 65504.0, 3e38, 1e-40, -1.0][(w / 7 % 7) as usize]
        }
        w => f32::from_bits(w),
    };
    let light = |what: u32| {
        Image::from_fn(size, move |x, y| {
            [0, 1, 2, 3].map(|c| f16::from_bits(word(x, y, 10 * what + c) as u16).to_f32())
        })
    };
    each(|gpu, name, denoiser| {
        denoiser.resize(gpu, size, true).unwrap();
        for turn in 0..4 {
            let salt = 1000 * turn;
            let mut shot = Shot::wall(size, 2.0);
            shot.frame.restart = turn == 0;
            shot.surface = Image::from_fn(size, |x, y| [1, 2, 3, 4].map(|c| word(x, y, salt + c)));
            shot.distance = Image::from_fn(size, |x, y| number(x, y, salt + 5));
            shot.others = Image::from_fn(size, |x, y| {
                let motion = if x % 2 == 0 { word(x, y, salt + 7) } else { pack_motion(Vec2::ONE) };
                [word(x, y, salt + 6), motion, word(x, y, salt + 8) % 3]
            });
            shot.noisy.diffuse = light(salt + 20);
            shot.noisy.specular = Some(light(salt + 30));
            shot.noisy.samples = Image::from_fn(size, |x, y| word(x, y, salt + 9) % 4);
            let (clean, _) = shot.next(gpu, denoiser);
            assert!(clean.is_finite(), "{name}, frame {turn}");
        }
    });
}

/// A wall whose every pixel has both lobes, filtered as roughness 1.
fn glossy_wall(size: [u32; 2]) -> Shot {
    let mut shot = Shot::wall(size, 1.0);
    let rough = Surface { f0: 0.04, roughness: Vec2::ONE, ..Surface::default() };
    shot.surface = Image::filled(size, rough.pack_gbuffer(0));
    shot
}

fn sum(texels: &[[f16; 4]]) -> f64 {
    texels.iter().map(|texel| texel[0].to_f64()).sum()
}

#[test]
fn a_firefly_keeps_the_light_within_the_bound() {
    let size = [64, 48];
    each(|gpu, name, denoiser| {
        for (x, y) in [(32, 24), (0, 0), (63, 20), (5, 47)] {
            let mut shot = glossy_wall(size);
            let lengths = noise(size, 4);
            shot.noisy.diffuse = noise(size, 3).map(|[r, g, b, _]| [0.5 * r, g, b, 0.0]);
            shot.noisy.diffuse = Image::from_fn(size, |x, y| {
                let [x, y] = [x as i32, y as i32];
                let [r, g, b, _] = shot.noisy.diffuse.get(x, y).unwrap();
                [r, g, b, 4.0 * lengths.get(x, y).unwrap()[0]]
            });
            *shot.noisy.diffuse.get_mut(x, y).unwrap() = [1e4, 1e4, 1e4, 1.0];
            shot.noisy.specular = Some(shot.noisy.diffuse.clone());
            let before = sum(&halves(&shot.noisy.diffuse));
            let (clean, _) = shot.denoise(gpu, denoiser);
            for (lobe, texels) in
                [("diffuse", &clean.diffuse), ("specular", clean.specular.as_ref().unwrap())]
            {
                let change = (sum(texels) / before - 1.0).abs() as f32;
                println!("{name}, {lobe} at {x}, {y}: {change:.5} (bound {})", denoiser.energy_bound());
                assert!(change <= denoiser.energy_bound(), "{name}, {lobe} at {x}, {y}: {change}");
            }
        }
    });
}

#[test]
fn what_is_no_light_is_no_tap_is_filled_and_counted() {
    let size = [40, 40];
    let mut shot = glossy_wall(size);
    let constant = [0.5, 0.25, 2.0, 3.0];
    shot.noisy.diffuse = Image::filled(size, constant);
    shot.noisy.specular = Some(shot.noisy.diffuse.clone());
    let clean = halves(&shot.noisy.diffuse);
    shot.break_pixels(50);
    each(|gpu, name, denoiser| {
        denoiser.resize(gpu, size, true).unwrap();
        // The second frame has a past, and nothing broken may have got into it.
        for index in 0..2 {
            let (found, log) = shot.sequel(index).next(gpu, denoiser);
            assert!(found.diffuse == clean, "{name}, frame {index}");
            assert!(found.specular.as_ref() == Some(&clean), "{name}, frame {index}");
            assert_eq!(log.counts["denoise_invalid"], 50.0, "{name}, frame {index}");
        }
    });
}

#[test]
fn half_floats_hold_from_the_least_to_the_largest() {
    let size = [19, 13];
    each(|gpu, name, denoiser| {
        for value in [65504.0, 6e-8, 6.2e-5, 1.0 / 3.0] {
            let mut shot = glossy_wall(size);
            shot.noisy.diffuse = Image::filled(size, [f16::from_f32(value).to_f32(); 4]);
            shot.noisy.specular = Some(shot.noisy.diffuse.clone());
            denoiser.resize(gpu, size, true).unwrap();
            for index in 0..2 {
                let (clean, _) = shot.sequel(index).next(gpu, denoiser);
                assert!(clean.diffuse == halves(&shot.noisy.diffuse), "{name}: {value}, frame {index}");
                assert!(clean.specular == Some(clean.diffuse), "{name}: {value}, frame {index}");
            }
        }
    });
}

#[test]
fn a_restart_forgets_all_of_it() {
    let size = [45, 33];
    let shot = Shot::random(size, 6);
    each(|gpu, name, denoiser| {
        let (alone, _) = shot.denoise(gpu, denoiser);
        for index in 1..4 {
            let mut other = shot.sequel(index);
            other.noisy = Shot::random(size, 60 + index).noisy;
            other.next(gpu, denoiser);
        }
        assert!(shot.next(gpu, denoiser).0 == alone, "{name}");
    });
}

#[test]
fn the_same_frames_give_the_same_bits() {
    let size = [45, 33];
    each(|gpu, name, denoiser| {
        let mut run = || {
            denoiser.resize(gpu, size, true).unwrap();
            let shots = (0..4).map(|index| Shot::random(size, 70 + index).sequel(index));
            shots.map(|shot| shot.next(gpu, denoiser).0).collect::<Vec<_>>()
        };
        assert!(run() == run(), "{name}");
    });
}

#[test]
fn mirrors_and_sky_stay_as_they_are() {
    let size = [45, 33];
    let base = Shot::random(size, 5);
    each(|gpu, name, denoiser| {
        denoiser.resize(gpu, size, true).unwrap();
        for index in 0..2 {
            let mut shot = base.sequel(index);
            let light = Shot::random(size, 50 + index).noisy;
            (shot.noisy.diffuse, shot.noisy.specular) = (light.diffuse, light.specular);
            let clean = shot.next(gpu, denoiser).0;
            let (diffuse, specular) =
                (halves(&shot.noisy.diffuse), halves(shot.noisy.specular.as_ref().unwrap()));
            let clean_specular = clean.specular.unwrap();
            let (mut mirrors, mut misses) = (0, 0);
            for (i, words) in shot.surface.texels().iter().enumerate() {
                if shot.distance.texels()[i] == 0.0 {
                    misses += 1;
                    let found = (clean.diffuse[i], clean_specular[i]);
                    assert_eq!(found, (diffuse[i], specular[i]), "{name}: miss {i}");
                } else if Surface::unpack_gbuffer(*words).roughness.max_element() < 0.02 {
                    mirrors += 1;
                    assert_eq!(clean_specular[i], specular[i], "{name}: mirror {i}");
                }
            }
            assert!(mirrors > 50 && misses > 30, "{mirrors} mirrors and {misses} misses are too few to tell");
        }
    });
}
