//! The same random numbers on both sides: the same paths, but where rounding flips a decision.

use super::fixture::{Fixture, Model, Traced, at, cells, twin_mean};
use crate::path::reference::{Pixel, Texel};
use crate::path::{PathBuild, PathSettings, SampleRule};
use frame::surface::Surface;
use glam::{Vec2, Vec3};
use scene::{PunctualKind, PunctualLight, Sky, SkyMap, Sun};

fn wall(n: Vec3) -> Surface {
    let base = match (n.x > 0.5, n.x < -0.5) {
        (true, _) => Vec3::new(0.6, 0.1, 0.1),
        (_, true) => Vec3::new(0.1, 0.5, 0.1),
        _ => Vec3::splat(0.7),
    };
    let f0 = if n.y > 0.5 { 0.04 } else { 0.0 };
    Surface { base, f0, roughness: Vec2::new(0.3, 0.5), ..Surface::default() }
}

/// A room with a lamp, a hole to the sky, metal, glass, a pane, and something half there.
pub(super) fn room() -> Model {
    let mut model = Model::new(24);
    model.room(wall);
    let down = Surface { normal: Vec3::NEG_Y, ..Surface::default() };
    for cell in cells([8, 23, 8], [14, 24, 14]) {
        model.set(cell, &Surface { emission: Vec3::new(9.0, 8.0, 6.0), ..down });
    }
    let metal = Surface { base: Vec3::new(0.9, 0.7, 0.4), metalness: 1.0, ..Surface::default() };
    model.block([4, 1, 5], [9, 8, 10], &Surface { roughness: Vec2::new(0.2, 0.6), ..metal });
    let glass = Surface {
        transmission: 1.0,
        f0: 0.04,
        base: Vec3::new(0.9, 1.0, 0.95),
        absorption: Vec3::new(0.5, 0.1, 0.2),
        roughness: Vec2::ZERO,
        ..Surface::default()
    };
    model.block([13, 1, 5], [19, 7, 11], &glass);
    model.block([4, 1, 13], [8, 6, 17], &Surface { roughness: Vec2::splat(0.4), ..glass });
    let pane = Surface { thin: true, absorption: Vec3::ZERO, normal: Vec3::Z, ..glass };
    for cell in cells([12, 1, 16], [18, 10, 17]) {
        model.set(cell, &pane);
    }
    let half = Surface { coverage: 7.0 / 15.0, normal: Vec3::Y, two_sided: true, ..Surface::default() };
    for cell in cells([3, 15, 3], [12, 16, 12]) {
        model.set(cell, &half);
    }
    model
}

fn sky() -> Sky {
    let texel = |i: u32| Vec3::new(0.2 + (i % 7) as f32 * 0.1, 0.5, 0.1 * (i / 16) as f32);
    Sky::Map(SkyMap { width: 16, height: 8, radiance: (0..128).map(texel).collect() })
}

fn lights() -> [PunctualLight; 2] {
    let spot = PunctualLight {
        kind: PunctualKind::Spot { inner: 0.3, outer: 0.9 },
        position: at(12.0, 20.0, 12.0),
        direction: Vec3::new(0.2, -1.0, -0.3).normalize(),
        intensity: Vec3::new(2.0, 2.0, 3.0),
        range: 8.0,
    };
    let point = PunctualLight { kind: PunctualKind::Point, position: at(4.0, 10.0, 18.0), ..spot };
    [spot, point]
}

/// Without light samples: emitters and the sky are found by chance.
fn chance() -> PathBuild {
    PathBuild { next_event: false, ..PathBuild::default() }
}

/// From a corner of the room, into it.
pub(super) fn fixture(sky: Sky, sun: Option<Sun>, punctual: &[PunctualLight]) -> Fixture {
    let mut fixture = Fixture::new(sky, sun, punctual, at(17.0, 14.0, 21.0), at(10.0, 4.0, 6.0));
    fixture.frame.trace_size = [96, 64];
    fixture
}

/// Shares of pixels that agree and the ratio of the means, per lobe.
fn compare(traced: &Traced, twin: &[Pixel]) {
    for lobe in 0..2 {
        let mean = twin_mean(twin, lobe);
        let pairs = traced.lobes[lobe].iter().zip(twin.iter().map(|p| p.lobes[lobe].to_array()));
        let same = |(a, b): &(&[f32; 4], [f64; 4])| {
            // The last bit of a half float is at most 2^-10 = 9.8e-4 of it, and an adapter may cut it off instead of
            // rounding; the rest is f32 against f64 over a few bounces. A share of the mean stands in where a pixel is
            // nearly black.
            let close = |(a, b): (&f32, &f64)| (f64::from(*a) - b).abs() <= 1.2e-3 * b.abs().max(0.01 * mean);
            a.iter().zip(b).all(close)
        };
        let agree = pairs.clone().filter(same).count() as f64 / twin.len() as f64;
        // Paths that took another branch: a cell's edge or a probability met within rounding.
        assert!(agree >= 0.99, "lobe {lobe}: only {agree} of the pixels agree");
        // They are as likely brighter as darker: their sum is a random walk. The software adapter cuts half floats off,
        // which takes half of 2^-10 at most from the mean.
        let apart = pairs.map(|(a, b)| (0..3).map(|c| (f64::from(a[c]) - b[c]) / 3.0).sum::<f64>());
        let walk = apart.map(|d| d * d).sum::<f64>().sqrt() / twin.len() as f64;
        let found = traced.mean(lobe).0;
        println!("lobe {lobe}: {:.2} % agree, mean {found} +- {walk} against {mean}", 100.0 * agree);
        assert!(
            (found - mean).abs() <= 3.0 * walk + 5e-4 * mean,
            "lobe {lobe}: {found} +- {walk}, twin {mean}"
        );
        assert!(walk < 1e-2 * mean, "a test that could not fail: {walk}");
    }
    let samples: Vec<u32> = twin.iter().map(|p| p.samples[0] | (p.samples[1] << 16)).collect();
    let agree = traced.samples.iter().zip(&samples).filter(|(a, b)| a == b).count();
    assert!(agree as f64 >= 0.99 * samples.len() as f64, "sample counts: {agree} of {}", samples.len());
}

#[test]
fn the_shader_agrees_with_its_twin_in_a_closed_room() {
    let fixture = fixture(Sky::Constant(Vec3::ZERO), None, &lights());
    let mut voxels = room().build();
    let texels = fixture.gbuffer(&voxels);
    for (contours, settings) in [0, 1].into_iter().zip([
        PathSettings { spp: 4, build: chance(), ..PathSettings::default() },
        PathSettings { spp: 2, bounces: None, roulette_from: 3, build: chance(), ..PathSettings::default() },
    ]) {
        voxels.grid.grid.contours = contours;
        let traced = fixture.traced(&voxels, &texels, &settings);
        let (twin, tally) = fixture.twin(&voxels, &texels, &settings);
        compare(&traced, &twin);
        assert_eq!(traced.log.counts["cut_rays"], 0.0);
        assert_eq!(traced.log.counts["clamped"], 0.0);
        assert_eq!(traced.log.counts["paths"], tally.paths as f64);
        // Branches that flipped end earlier or later.
        for (name, count) in [("rays", tally.rays), ("iterations", tally.iterations)] {
            let ratio = traced.log.counts[name] / count as f64;
            assert!((ratio - 1.0).abs() < 2e-3, "{name}: {ratio} times the twin's");
        }
    }
}

#[test]
fn the_shader_agrees_with_its_twin_under_sky_and_sun() {
    let sun = Sun {
        direction: Vec3::new(0.3, -1.0, -0.2).normalize(),
        irradiance: Vec3::new(9.0, 8.0, 7.0),
        angle: 0.1,
    };
    let mut fixture = fixture(sky(), Some(sun), &lights());
    let mut model = room();
    model.retain(|cell| cell.y < 23 && cell.z < 23);
    let voxels = model.build();
    let texels = fixture.gbuffer(&voxels);
    let settings =
        PathSettings { spp: 6, samples: SampleRule::Roughness, build: chance(), ..PathSettings::default() };
    fixture.frame.frame_index = 5;
    for sun_elsewhere in [false, true] {
        fixture.frame.sun_elsewhere = sun_elsewhere;
        let traced = fixture.traced(&voxels, &texels, &settings);
        compare(&traced, &fixture.twin(&voxels, &texels, &settings).0);
        assert_eq!(traced.log.counts["cut_rays"], 0.0);
    }
}

#[test]
fn seeds_and_frames_decide_the_bits_and_segments_per_dispatch_do_not() {
    let mut fixture = fixture(sky(), None, &lights());
    let voxels = room().build();
    let texels = fixture.gbuffer(&voxels);
    let settings = PathSettings { spp: 2, ..PathSettings::default() };
    let first = fixture.traced(&voxels, &texels, &settings);
    for segments in [1, 2, 3, 8] {
        fixture.tracer.borrow_mut().paths.most_segments = segments;
        let again = fixture.traced(&voxels, &texels, &settings);
        assert!(
            first.bits == again.bits && first.samples == again.samples,
            "{segments} segments per dispatch"
        );
        assert_eq!(first.log.counts, again.log.counts, "{segments} segments per dispatch");
    }
    fixture.frame.frame_index = 1;
    let next = fixture.traced(&voxels, &texels, &settings);
    fixture.frame.frame_index = 0;
    fixture.frame.seed = 2;
    let other = fixture.traced(&voxels, &texels, &settings);
    for (name, bits) in [("frame", &next.bits), ("seed", &other.bits)] {
        for (lobe, (first, bits)) in first.bits.iter().zip(bits).enumerate() {
            // Pixels that began a path in this lobe both times (a choice between two lamps may fall alike), and not in
            // smooth glass, where nothing is random but few such choices.
            let is_rough = |i: usize| Surface::unpack_gbuffer(texels.texels()[i].surface).roughness.x > 0.0;
            let pairs = first.iter().zip(bits).enumerate();
            let pairs = pairs.filter(|(i, (a, b))| a[3] > 0 && b[3] > 0 && is_rough(*i));
            let (all, same) = (pairs.clone().count(), pairs.filter(|(_, (a, b))| a == b).count());
            assert!(
                all > 200 && same * 100 < all,
                "another {name}, lobe {lobe}: {same} of {all} pixels are the same"
            );
        }
    }
}

#[test]
fn any_bits_in_records_and_pixels_give_light_that_is_finite() {
    let mut counter = 0;
    let mut random = || {
        counter += 1;
        frame::surface::hash(counter)
    };
    let fixture = fixture(sky(), None, &lights());
    // Anything at all, then with reflectance and light tamed so that nothing may reach the largest half float.
    for (light, clear) in [(u32::MAX, u32::MAX), (0x7fff_ffff, 0xff3f_ffff)] {
        let mut model = Model::new(24);
        let record =
            |random: &mut dyn FnMut() -> u32| [random(), random(), random() & light, random() & clear];
        for cell in cells([0; 3], [24; 3]) {
            let is_wall = cell.min_element() == 0 || cell.max_element() == 23;
            if is_wall || random() % 20 == 0 {
                model.set_record(cell, record(&mut random));
            }
        }
        for cell in cells([14, 11, 18], [20, 17, 24]) {
            model.clear(cell);
        }
        let voxels = model.build();
        let mut texels = fixture.gbuffer(&voxels);
        texels = texels.map(|t| Texel {
            surface: record(&mut random),
            motion_id: [0, random()],
            face_normal: if random() % 2 == 0 { random() } else { t.face_normal },
            ..t
        });
        let settings = PathSettings { spp: 4, bounces: Some(6), ..PathSettings::default() };
        let traced = fixture.traced(&voxels, &texels, &settings);
        for value in traced.lobes.iter().flatten().flatten() {
            assert!(value.is_finite() && *value >= 0.0, "{value}");
        }
        assert!(traced.mean(0).0 > 0.0 && traced.mean(1).0 > 0.0, "and there is light");
        assert_eq!(traced.log.counts["cut_rays"], 0.0);
        if clear != u32::MAX {
            assert_eq!(traced.log.counts["clamped"], 0.0, "a number was not finite");
        }
    }
}

#[test]
fn smooth_pixels_get_one_path_and_rough_ones_six() {
    let fixture = fixture(sky(), None, &[]);
    let voxels = room().build();
    let mut texels = fixture.gbuffer(&voxels);
    let mut column = 0;
    // Roughness rises from left to right: 0, 1/95, .. 1.
    texels = texels.map(|t| {
        let roughness = (column % 96) as f32 / 95.0;
        column += 1;
        let surface = Surface { roughness: Vec2::new(roughness, 0.0), ..Surface::unpack_gbuffer(t.surface) };
        Texel { surface: surface.pack_gbuffer(0), ..t }
    });
    let settings =
        PathSettings { spp: 64, samples: SampleRule::Roughness, bounces: Some(1), ..PathSettings::default() };
    let traced = fixture.traced(&voxels, &texels, &settings);
    let mut total = 0;
    for (index, samples) in traced.samples.iter().enumerate() {
        let count = (samples & 0xffff) + (samples >> 16);
        let roughness = ((index % 96) as f32 / 95.0 * 255.0).round() / 255.0;
        assert_eq!(count, 1 + (5.0 * roughness + 0.5) as u32, "roughness {roughness}");
        total += count;
    }
    assert_eq!(traced.log.counts["paths"], f64::from(total));
    // The mean over uniform roughness is 3.5 (half of the first and of the last step are cut off).
    assert!((f64::from(total) / traced.samples.len() as f64 - 3.5).abs() < 0.05);
    let few = PathSettings { spp: 1, ..settings };
    assert_eq!(fixture.traced(&voxels, &texels, &few).samples, traced.samples, "whatever spp says");
}
