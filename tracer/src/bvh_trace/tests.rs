//! The same image through both structures, and images that are known in closed form.
#![allow(clippy::unwrap_used, clippy::panic)]

use super::*;
use crate::Gather;
use crate::LightList;
use crate::bvh::cwbvh::Cwbvh;
use crate::bvh::lbvh::Lbvh;
use crate::bvh::tests::fixture::{Stage, soup};
use frame::brdf::{self, BrdfTable};
use frame::surface::{Surface, linear_from_srgb, srgb_from_linear};
use glam::Vec3;
use half::f16;
use scene::{Camera, Material, Scene, Sky};

const SIZE: [u32; 2] = [48, 32];

/// A scene with both structures and what its camera sees.
struct Seen {
    stage: Stage,
    frame: FrameInfo,
    gbuffer: GBuffer,
    lbvh: Lbvh,
    cwbvh: Cwbvh,
}

/// Bits of the half floats of both lobes; one where the scene has no gloss.
type Lobes = Vec<Vec<[u16; 4]>>;

impl Seen {
    /// By the scene's own camera.
    fn scene(scene: &Scene) -> Self {
        Self::new(Stage::new(scene, scene.rest().clone()), scene.cameras[0].clone())
    }

    fn new(stage: Stage, camera: Camera) -> Self {
        let frame = FrameInfo {
            previous_camera: camera.clone(),
            camera,
            trace_size: SIZE,
            display_size: SIZE,
            jitter: [0.0; 2],
            previous_jitter: [0.0; 2],
            frame_index: 0,
            seed: 5,
            time: 0.0,
            dt: 0.0,
            radiance_scale: stage.uploaded.radiance_scale,
            diagonal: stage.geometry.bounds().diagonal(),
            restart: true,
            sun_elsewhere: false,
        };
        let mut gather = Gather::new(&stage.gpu, &stage.uploaded).unwrap();
        gather.resize(&stage.gpu, &[SIZE]).unwrap();
        let gbuffer = GBuffer::new(&stage.gpu, SIZE).unwrap();
        let mut recorder = Recorder::new(&stage.gpu);
        let uniform = recorder.uniform(&frame.uniform());
        gather.gather(&mut recorder, "gather", &uniform, &stage.uploaded, &stage.uploaded.mesh, &gbuffer);
        recorder.finish().unwrap();
        Self { frame, gbuffer, lbvh: stage.lbvh(), cwbvh: stage.cwbvh(), stage }
    }

    fn traced(&self, search: Search, settings: &PathSettings) -> Lobes {
        let Stage { gpu, uploaded, .. } = &self.stage;
        let mut tracer = BvhTracer::new(search);
        tracer.resize(gpu, uploaded, SIZE, settings).unwrap();
        let mut recorder = Recorder::new(gpu);
        let uniform = recorder.uniform(&self.frame.uniform());
        let lights = LightList::of_triangles(gpu, uploaded, &uploaded.mesh).unwrap();
        // Only what is asked for is there.
        let world = World {
            scene: uploaded,
            mesh: &uploaded.mesh,
            grid: None,
            lbvh: (search == Search::Lbvh).then_some(&*self.lbvh),
            cwbvh: (search == Search::Cwbvh).then_some(&self.cwbvh.bvh),
            grid_lights: None,
            cache: None,
            triangle_lights: Some(&lights),
        };
        let light = tracer.trace(&mut recorder, &self.frame, &uniform, world, &self.gbuffer, settings);
        recorder.finish().unwrap();
        [Some(&light.diffuse), light.specular.as_ref()]
            .into_iter()
            .flatten()
            .map(|lobe| gpu.read_texture(lobe).unwrap())
            .collect()
    }

    /// Through both structures, which must not differ.
    fn image(&self, settings: &PathSettings) -> Vec<Vec<[f32; 4]>> {
        let [lbvh, cwbvh] = [Search::Lbvh, Search::Cwbvh].map(|search| self.traced(search, settings));
        for (lobe, (ours, theirs)) in lbvh.iter().zip(&cwbvh).enumerate() {
            let differing = ours.iter().zip(theirs).filter(|(a, b)| a != b).count();
            assert_eq!(differing, 0, "pixels of lobe {lobe} of {}", ours.len());
        }
        assert_eq!(lbvh.len(), cwbvh.len());
        let float = |texel: &[u16; 4]| texel.map(|bits| f16::from_bits(bits).to_f32());
        let lobes: Vec<Vec<_>> = lbvh.iter().map(|lobe| lobe.iter().map(float).collect()).collect();
        assert!(lobes.iter().flatten().flatten().all(|x| x.is_finite() && *x >= 0.0));
        lobes
    }
}

/// Mean over pixels and channels, and its standard error from the spread over pixels.
fn statistics(lobe: &[[f32; 4]]) -> (f64, f64) {
    let count = lobe.len() as f64;
    let values: Vec<_> = lobe.iter().map(|[r, g, b, _]| f64::from(r + g + b) / 3.0).collect();
    let mean = values.iter().sum::<f64>() / count;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (count - 1.0);
    (mean, (variance / count).sqrt())
}

#[test]
fn both_structures_give_the_same_image_to_the_bit() {
    // Sun, sky, cloth, a pane and solid glass; a lamp under roulette alone.
    for (name, spp, bounces) in [("courtyard", 2, Some(3)), ("cornell", 4, None)] {
        let settings = PathSettings { spp, bounces, ..PathSettings::default() };
        let lobes = Seen::scene(&Scene::load(name).unwrap()).image(&settings);
        let lit = lobes[0].iter().filter(|[r, ..]| *r > 0.0).count();
        println!("{name}: {} lobes, {lit} of {} pixels lit", lobes.len(), lobes[0].len());
        // Otherwise nothing was compared.
        assert!(lit > 100, "{name}: {lit}");
    }
}

#[test]
fn a_closed_furnace_glows_as_the_geometric_series() {
    for (albedo, emission) in [(0.2, 1.0), (0.9, 0.25)] {
        let seen = Seen::scene(&scene::built_in::furnace(albedo, emission));
        let settings = PathSettings { spp: 8, bounces: None, ..PathSettings::default() };
        let (mean, error) = statistics(&seen.image(&settings)[0]);
        let wanted = f64::from(emission / (1.0 - albedo) * seen.frame.radiance_scale);
        println!("albedo {albedo}: {mean} +- {error}, wanted {wanted}");
        // Half floats, whose last bit adapters may cut off.
        let allowed = 3.0 * error + wanted / 1024.0;
        assert!((mean - wanted).abs() <= allowed, "albedo {albedo}: {mean} is not {wanted} within {allowed}");
        assert!(error < 0.02 * wanted, "a test that could not fail: {error}");
    }
}

#[test]
fn a_matte_floor_under_a_white_sky_has_the_radiance_of_its_albedo() {
    // A colour that eight bits hold exactly.
    let albedo = linear_from_srgb((srgb_from_linear(0.3) * 255.0).round() / 255.0);
    let mut scene = Scene::load("cornell").unwrap();
    scene.materials = vec![Material::lambert("floor", Vec3::splat(albedo))];
    scene.sky = Sky::Constant(Vec3::ONE);
    let [a, b, c, d] =
        [[-9.0, -9.0], [-9.0, 9.0], [9.0, 9.0], [9.0, -9.0]].map(|[x, z]| Vec3::new(x, 0.3, z));
    let floor = Stage::new(&scene, soup(&[[a, b, c], [a, c, d]], 0));
    let camera = Camera {
        eye: Vec3::new(1.0, 3.0, 2.0),
        target: Vec3::new(0.2, 0.3, 0.4),
        vfov: 0.8,
        ..scene.cameras[0].clone()
    };
    let seen = Seen::new(floor, camera);
    let lobes = seen.image(&PathSettings { spp: 2, bounces: Some(1), ..PathSettings::default() });
    assert_eq!(lobes.len(), 1, "nothing glosses");
    let surfaces: Vec<[u32; 4]> = seen.stage.gpu.read_texture(&seen.gbuffer.surface).unwrap();
    let table = BrdfTable::new();
    for (texel, light) in surfaces.into_iter().zip(&lobes[0]) {
        let factor = brdf::modulators(&Surface::unpack_gbuffer(texel), 1.0, &table).diffuse;
        let radiance = factor.x * f64::from(light[0] / seen.frame.radiance_scale);
        // No path meets anything, so that nothing is random: the half float's last bit, and the albedo's rounding in f32.
        assert!((radiance / f64::from(albedo) - 1.0).abs() < 1.1e-3, "{radiance}, not {albedo}");
    }
    let none = seen.image(&PathSettings { spp: 2, bounces: Some(0), ..PathSettings::default() });
    assert!(none[0].iter().all(|texel| *texel == [0.0; 4]));
}
