//! What is known without a twin: furnaces, a sun on a floor, and what stands between.

use super::fixture::{Fixture, Model, Traced, at, cells, statistics};
use crate::path::reference::{Texel, view_direction};
use crate::path::{PathBuild, PathSettings};
use frame::brdf::{self, BrdfTable};
use frame::cpu::Image;
use frame::surface::{Surface, linear_from_srgb};
use glam::{DVec3, UVec2, Vec2, Vec3};
use scene::{Sky, Sun};
use std::f64::consts::PI;

const DARK: Sky = Sky::Constant(Vec3::ZERO);
const WHITE: Sky = Sky::Constant(Vec3::ONE);

/// A colour that eight bits hold exactly, so that its record is not rounded at random.
fn exact(albedo: f32) -> f32 {
    linear_from_srgb((frame::surface::srgb_from_linear(albedo) * 255.0).round() / 255.0)
}

/// A floor of cells from border to border, seen from above.
fn floor(surface: &Surface) -> Model {
    let mut model = Model::new(24);
    for cell in cells([0, 3, 0], [24, 4, 24]) {
        model.set(cell, &Surface { normal: Vec3::Y, ..*surface });
    }
    model
}

/// Looks down at the middle of the floor; all pixels see it.
fn above(sky: Sky, sun: Option<Sun>) -> Fixture {
    Fixture::new(sky, sun, &[], at(12.0, 10.0, 13.0), at(12.0, 4.0, 12.0))
}

/// Direct light alone.
fn direct(spp: u32) -> PathSettings {
    PathSettings { spp, bounces: Some(1), ..PathSettings::default() }
}

/// Asserts one value in every pixel and channel of a lobe, to the last bit of a half float (2^-10, which adapters may cut off) and f32's.
fn assert_everywhere(traced: &Traced, lobe: usize, wanted: f64) {
    for (index, texel) in traced.lobes[lobe].iter().enumerate() {
        for value in &texel[..3] {
            assert!(
                (f64::from(*value) - wanted).abs() <= 1.1e-3 * wanted,
                "pixel {index}: {value}, not {wanted}"
            );
        }
    }
}

/// `M_d diffuse + M_s specular` of each pixel: mean over channels.
fn modulated<'a>(
    fixture: &'a Fixture,
    texels: &'a Image<Texel>,
    traced: &'a Traced,
) -> impl Iterator<Item = f64> + Clone + 'a {
    let uniform = fixture.frame.uniform();
    let width = texels.size()[0];
    texels.texels().iter().enumerate().map(move |(index, texel)| {
        let pixel = UVec2::new(index as u32 % width, index as u32 / width);
        let surface = Surface::unpack_gbuffer(texel.surface);
        let mu = f64::from(surface.normal.dot(-view_direction(&uniform, pixel)).max(0.0));
        let m = brdf::modulators(&surface, mu, &fixture.table);
        let light = [0, 1].map(|lobe| {
            let [r, g, b, _] = traced.lobes[lobe][index].map(f64::from);
            DVec3::new(r, g, b)
        });
        (m.diffuse * light[0] + m.specular * light[1]).element_sum() / 3.0
    })
}

#[test]
fn a_closed_furnace_glows_as_the_geometric_series() {
    let fixture = Fixture::new(DARK, None, &[], at(8.0, 8.0, 13.0), at(6.0, 3.0, 2.0));
    for (albedo, spp) in [(0.2, 4), (0.5, 4), (0.9, 8)] {
        let albedo = exact(albedo);
        let base = Vec3::splat(albedo);
        let mut model = Model::new(16);
        model.room(|_| Surface { base, emission: Vec3::ONE, ..Surface::default() });
        let voxels = model.build();
        let texels = fixture.gbuffer(&voxels);
        let settings = PathSettings { spp, bounces: None, ..PathSettings::default() };
        let traced = fixture.traced(&voxels, &texels, &settings);
        let wanted = 1.0 / (1.0 - f64::from(albedo));
        let (mean, error) = traced.mean(0);
        println!("albedo {albedo}: {mean} +- {error}, wanted {wanted}");
        // Before roulette sets in nothing is random but directions, and they all see the same.
        assert!(
            (mean - wanted).abs() <= 3.0 * error + 1e-3 * wanted,
            "albedo {albedo}: {mean} +- {error}, not {wanted}"
        );
        assert!(error < 0.02 * wanted, "a test that could not fail: {error}");
        assert_everywhere(&traced, 1, 0.0);
    }
}

#[test]
fn light_samples_find_the_light_that_chance_finds_and_less_noise() {
    let fixture = Fixture::new(DARK, None, &[], at(8.0, 8.0, 13.0), at(6.0, 3.0, 2.0));
    let mut model = Model::new(16);
    let glossy = Surface { roughness: Vec2::splat(0.4), f0: 0.5, ..Surface::default() };
    model.room(|_| Surface { base: Vec3::splat(exact(0.5)), ..glossy });
    // A lamp in the ceiling, and a block in its light.
    for cell in cells([5, 15, 5], [9, 16, 9]) {
        let lamp = Surface { base: Vec3::ZERO, emission: Vec3::splat(5.0), ..Surface::default() };
        model.set(cell, &Surface { normal: Vec3::NEG_Y, ..lamp });
    }
    model.block([3, 1, 3], [7, 5, 7], &glossy);
    let voxels = model.build();
    let texels = fixture.gbuffer(&voxels);
    let [on, off] = [(true, 16), (false, 256)].map(|(next_event, spp)| {
        let settings = PathSettings {
            spp,
            bounces: Some(4),
            build: PathBuild { next_event, ..PathBuild::default() },
            ..PathSettings::default()
        };
        fixture.traced(&voxels, &texels, &settings)
    });
    for lobe in 0..2 {
        // Pixels see different places: their differences' spread is what the mean difference is judged by.
        let differences = on.lobes[lobe].iter().zip(&off.lobes[lobe]).map(|(a, b)| f64::from(a[1] - b[1]));
        let (mean, error) = statistics(differences);
        let (light, _) = off.mean(lobe);
        println!("lobe {lobe}: {light}, light samples differ by {mean} +- {error}");
        assert!(mean.abs() <= 3.0 * error + 2e-3 * light, "lobe {lobe}: {mean} +- {error} of {light}");
        assert!(error < 0.03 * light, "a test that could not fail: {error}");
    }
}

#[test]
fn no_bounces_no_light_and_one_bounce_finds_the_sky() {
    let fixture = above(WHITE, None);
    let scale = f64::from(fixture.frame.radiance_scale);
    let voxels = floor(&Surface { base: Vec3::splat(0.3), ..Surface::default() }).build();
    let texels = fixture.gbuffer(&voxels);
    let none = fixture.traced(&voxels, &texels, &PathSettings { bounces: Some(0), ..direct(2) });
    assert!(none.lobes.iter().flatten().all(|p| *p == [0.0; 4]) && none.samples.iter().all(|s| *s == 0));
    let one = fixture.traced(&voxels, &texels, &direct(2));
    assert_everywhere(&one, 0, scale);
    assert_everywhere(&one, 1, 0.0);
    // Nothing is met: the length is the scene's diagonal.
    assert!(one.lobes[0].iter().all(|p| (p[3] - fixture.frame.diagonal).abs() < 0.01));
    assert!(one.samples.iter().all(|s| *s == 2));
}

#[test]
fn a_sun_lights_a_floor_by_the_cosine_and_what_is_between_takes_its_share() {
    let irradiance = Vec3::splat(3.0);
    for degrees in [0.0f32, 30.0, 60.0] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let sun = Sun { direction: Vec3::new(0.6 * sin, -cos, 0.8 * sin), irradiance, angle: 0.0 };
        let fixture = above(DARK, Some(sun));
        let scale = f64::from(fixture.frame.radiance_scale);
        let wanted = scale * 3.0 * f64::from(cos) / PI;
        let open = floor(&Surface::default());
        let texels = fixture.gbuffer(&open.build());
        let lit = fixture.traced(&open.build(), &texels, &direct(2));
        assert_everywhere(&lit, 0, wanted);

        // A roof over all of it, wide enough for every shadow ray.
        let roofed = |surface: &Surface| {
            let mut model = open.clone();
            for cell in cells([0, 7, 0], [24, 8, 24]) {
                model.set(cell, &Surface { normal: Vec3::Y, ..*surface });
            }
            fixture.traced(&model.build(), &texels, &direct(2))
        };
        assert_everywhere(&roofed(&Surface::default()), 0, 0.0);
        let coverage = 7.0 / 15.0;
        // However many cells of the sheet a slanted ray crosses, it crosses the sheet once.
        let half = roofed(&Surface { coverage, ..Surface::default() });
        assert_everywhere(&half, 0, wanted * f64::from(1.0 - coverage));
        // A pane: Fresnel of both faces and all there is between them.
        let f = fresnel(f64::from(cos));
        let pane = Surface { transmission: 1.0, thin: true, f0: 0.04, ..Surface::default() };
        assert_everywhere(&roofed(&pane), 0, wanted * (1.0 - f) / (1.0 + f));
    }
}

/// Of an index of refraction of 1.5.
fn fresnel(cosine: f64) -> f64 {
    let refracted = (1.0 - (1.0 - cosine * cosine) / 2.25).sqrt();
    let s = (cosine - 1.5 * refracted) / (cosine + 1.5 * refracted);
    let p = (refracted - 1.5 * cosine) / (refracted + 1.5 * cosine);
    0.5 * (s * s + p * p)
}

#[test]
fn white_metal_in_a_white_furnace_returns_what_the_table_says() {
    let fixture = above(WHITE, None);
    for roughness in [0.0, 0.3, 0.7, 1.0] {
        let metal = Surface { metalness: 1.0, roughness: Vec2::splat(roughness), ..Surface::default() };
        let voxels = floor(&metal).build();
        let texels = fixture.gbuffer(&voxels);
        let traced = fixture.traced(&voxels, &texels, &direct(16));
        let scale = f64::from(fixture.frame.radiance_scale);
        let (mean, error) = statistics(modulated(&fixture, &texels, &traced).map(|v| v / scale));
        let (table, _) = statistics(expected(&fixture, &texels));
        println!("roughness {roughness}: {mean} +- {error}, table {table}");
        // The table is bilinear and in half floats, and the adapter may cut off the light's last bit.
        assert!(
            (mean - table).abs() <= 3.0 * error + 3e-3,
            "roughness {roughness}: {mean} +- {error}, not {table}"
        );
        assert_everywhere(&traced, 0, 0.0);
    }
}

/// M_s of white metal, which is the lobe's reflectance.
fn expected<'a>(fixture: &'a Fixture, texels: &'a Image<Texel>) -> impl Iterator<Item = f64> + Clone + 'a {
    let uniform = fixture.frame.uniform();
    let width = texels.size()[0];
    let table: &BrdfTable = &fixture.table;
    texels.texels().iter().enumerate().map(move |(index, texel)| {
        let pixel = UVec2::new(index as u32 % width, index as u32 / width);
        let surface = Surface::unpack_gbuffer(texel.surface);
        let mu = f64::from(surface.normal.dot(-view_direction(&uniform, pixel)));
        brdf::modulators(&surface, mu, table).specular.x
    })
}

#[test]
fn clear_glass_neither_adds_light_nor_takes_it() {
    let glass = Surface { transmission: 1.0, f0: 0.04, roughness: Vec2::ZERO, ..Surface::default() };
    let mut slab = Model::new(24);
    for cell in cells([0, 3, 0], [24, 9, 24]).filter(|c| c.y == 3 || c.y == 8) {
        slab.set(
            cell,
            &Surface { normal: if cell.y == 8 { Vec3::Y } else { Vec3::NEG_Y }, contour: 0.5, ..glass },
        );
    }
    let mut block = Model::new(24);
    block.block([6, 4, 6], [18, 14, 18], &glass);
    let mut fixture = Fixture::new(WHITE, None, &[], Vec3::ZERO, Vec3::ONE);
    for (name, model, eye) in [("slab", slab, at(12.0, 14.0, 16.0)), ("block", block, at(5.0, 22.0, 23.0))] {
        fixture.look(eye, at(12.0, 8.0, 12.0));
        let voxels = model.build();
        let texels = fixture.gbuffer(&voxels);
        let settings = PathSettings { spp: 8, bounces: None, ..PathSettings::default() };
        let traced = fixture.traced(&voxels, &texels, &settings);
        let scale = f64::from(fixture.frame.radiance_scale);
        let light: Vec<f64> = modulated(&fixture, &texels, &traced).map(|v| v / scale).collect();
        let seen = texels.texels().iter().zip(&light).filter(|(t, _)| t.distance > 0.0).map(|(_, l)| *l);
        let (mean, error) = statistics(seen);
        println!("{name}: {mean} +- {error}");
        // The slab's sides are open, and paths that leave through them have not crossed a second face: 0.3 %.
        assert!((mean - 1.0).abs() <= 3.0 * error + 5e-3, "{name}: {mean} +- {error}");
    }
}
