//! Light samples and chance find the same light, whatever stands between: in closed form where all that is seen glows.

use super::fixture::{Fixture, Model, Traced, at, cells, statistics};
use super::twin::{fixture, room};
use crate::path::{PathBuild, PathSettings};
use frame::surface::Surface;
use glam::{Vec2, Vec3};
use scene::Sky;

const DARK: Sky = Sky::Constant(Vec3::ZERO);

/// Black, and as bright as everything else.
fn glowing() -> Surface {
    Surface { base: Vec3::ZERO, emission: Vec3::ONE, contour: 0.5, ..Surface::default() }
}

/// All loses and all gives nothing: clear, white, smooth.
fn clear() -> Surface {
    Surface { transmission: 1.0, f0: 0.04, base: Vec3::ONE, roughness: Vec2::ZERO, ..Surface::default() }
}

/// What may stand in a room of 16 cells between the camera, the floor and the ceiling.
fn furniture() -> Vec<(&'static str, Model)> {
    let empty = || {
        let mut model = Model::new(16);
        model.room(|_| glowing());
        model
    };
    let sheet = |surface: &Surface| {
        let mut model = empty();
        for cell in cells([3, 6, 3], [13, 7, 13]) {
            model.set(cell, &Surface { normal: Vec3::Y, ..*surface });
        }
        model
    };
    let block = |surface: &Surface| {
        let mut model = empty();
        model.block([4, 2, 4], [10, 9, 10], surface);
        model
    };
    vec![
        ("nothing", empty()),
        ("a pane", sheet(&Surface { thin: true, ..clear() })),
        (
            "something half there",
            sheet(&Surface { coverage: 7.0 / 15.0, transmission: 0.0, f0: 1.0, ..clear() }),
        ),
        ("glass", block(&clear())),
        ("metal", block(&Surface { metalness: 1.0, transmission: 0.0, ..clear() })),
    ]
}

fn traced(fixture: &Fixture, model: &Model, contours: u32, next_event: bool, spp: u32) -> Traced {
    let mut voxels = model.build();
    voxels.grid.grid.contours = contours;
    let texels = fixture.gbuffer(&voxels);
    let build = PathBuild { next_event, ..PathBuild::default() };
    fixture.traced(&voxels, &texels, &PathSettings { spp, bounces: None, build, ..PathSettings::default() })
}

/// Mean of `on - off` over pixels, and its standard error: pixels see different places.
fn apart(on: &Traced, off: &Traced, lobe: usize) -> (f64, f64) {
    statistics(on.lobes[lobe].iter().zip(&off.lobes[lobe]).map(|(a, b)| f64::from(a[1] - b[1])))
}

#[test]
fn where_all_glows_whatever_is_clear_or_white_is_as_bright() {
    // From above and beside the sheet, so that the floor is seen through it and beside it.
    let fixture = Fixture::new(DARK, None, &[], at(13.5, 10.0, 14.0), at(6.0, 3.0, 5.0));
    let (furniture, cases) = (furniture(), [(true, 0), (true, 1), (false, 0), (false, 1)]);
    let images: Vec<Vec<Traced>> = cases
        .iter()
        .map(|(next_event, contours)| {
            furniture.iter().map(|(_, model)| traced(&fixture, model, *contours, *next_event, 8)).collect()
        })
        .collect();
    for (index, (name, _)) in furniture.iter().enumerate() {
        for contours in 0..2 {
            let [on, off] = [&images[contours][index], &images[2 + contours][index]];
            for lobe in 0..2 {
                let (mean, error) = apart(on, off, lobe);
                println!(
                    "{name}, contours {contours}, lobe {lobe}: light samples differ by {mean:.4} +- {error:.4}"
                );
                // Half floats cut off, twice 5e-4.
                assert!(mean.abs() <= 3.0 * error + 1e-3, "{name}, lobe {lobe}: {mean} +- {error}");
            }
            // Each surface here has one lobe, the other one is black. Cubes alone lose light at edges, which look one way.
            if contours == 1 {
                let [diffuse, specular] = &on.lobes;
                let light = diffuse.iter().zip(specular).map(|(d, s)| f64::from(d[1] + s[1]));
                let (mean, error) = statistics(light);
                println!("{name}: {mean:.4} +- {error:.4}");
                assert!((mean - 1.0).abs() <= 3.0 * error + 1e-3, "{name}: {mean} +- {error}");
                assert!(error < 0.01, "a test that could not fail: {error}");
            }
        }
    }
}

#[test]
fn a_lamp_seen_past_what_is_half_there_loses_that_half() {
    let coverage = 7.0 / 15.0;
    let light = |with_sheet: bool, contours: u32| {
        let fixture = Fixture::new(DARK, None, &[], at(12.0, 6.0, 13.0), at(12.0, 4.0, 12.0));
        let mut model = Model::new(24);
        for cell in cells([0, 3, 0], [24, 4, 24]) {
            model.set(cell, &Surface { normal: Vec3::Y, ..Surface::default() });
        }
        for cell in cells([10, 20, 10], [13, 21, 13]) {
            model.set(
                cell,
                &Surface { normal: Vec3::NEG_Y, emission: Vec3::splat(8.0), ..Surface::default() },
            );
        }
        for cell in cells([0, 10, 0], [24, 11, 24]).filter(|_| with_sheet) {
            model.set(cell, &Surface { normal: Vec3::Y, coverage, ..Surface::default() });
        }
        let mut voxels = model.build();
        let texels = fixture.gbuffer(&voxels);
        voxels.grid.grid.contours = contours;
        fixture.traced(
            &voxels,
            &texels,
            &PathSettings { spp: 16, bounces: Some(1), ..PathSettings::default() },
        )
    };
    for contours in [0, 1] {
        let [open, past] = [false, true].map(|with_sheet| light(with_sheet, contours));
        let wanted = f64::from(1.0 - coverage);
        let shares = open.lobes[0].iter().zip(&past.lobes[0]).map(|(a, b)| f64::from(b[1] / a[1]));
        let (share, error) = statistics(shares);
        println!("contours {contours}: {share} +- {error} of {wanted}");
        // The mean of ratios is off by the square of the noise, below 1e-3; half floats cut off, 1e-3.
        assert!((share - wanted).abs() <= 3.0 * error + 2e-3, "contours {contours}: {share} +- {error}");
        assert!(error < 0.01, "a test that could not fail: {error}");
    }
}

#[test]
fn light_samples_find_what_chance_finds_behind_glass_panes_and_what_is_half_there() {
    let mut fixture = fixture(DARK, None, &[]);
    fixture.frame.trace_size = [48, 32];
    let [on, off] =
        [(true, 32), (false, 256)].map(|(next_event, spp)| traced(&fixture, &room(), 0, next_event, spp));
    for lobe in 0..2 {
        let (mean, error) = apart(&on, &off, lobe);
        let (light, _) = off.mean(lobe);
        println!("lobe {lobe}: {light}, light samples differ by {mean} +- {error}");
        assert!(mean.abs() <= 3.0 * error + 2e-3 * light, "lobe {lobe}: {mean} +- {error} of {light}");
        assert!(error < 0.05 * light, "a test that could not fail: {error} of {light}");
    }
}
