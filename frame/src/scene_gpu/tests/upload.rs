//! What a scene becomes: scale, lights, emitters, moving tail.

use super::*;
use glam::Vec3;
use scene::{PunctualKind, PunctualLight, Sky, Sun};

#[test]
fn the_scale_is_a_power_of_two_that_puts_the_brightest_below_1024() {
    for brightest in [1e-12, 0.3, 1.0, 1023.0, 1024.0, 1025.0, 7e4, 1e20] {
        let mut scene = scene("cornell");
        scene.materials.iter_mut().for_each(|m| m.emission = Vec3::ZERO);
        scene.sky = Sky::Constant(Vec3::new(0.0, brightest, 0.0));
        let RadianceScale { scale, lost } = RadianceScale::of(&scene, scene.rest());
        assert_eq!(scale.log2().fract(), 0.0, "{scale} is no power of two");
        assert!(
            scale * brightest <= 1024.0 && 2.0 * scale * brightest > 1024.0,
            "{brightest} becomes {}",
            scale * brightest
        );
        assert_eq!(lost, 0);
    }
}

#[test]
fn what_the_scale_cannot_save_is_counted() {
    let mut scene = scene("cornell");
    scene.sky = Sky::Constant(Vec3::new(1e12, 1.0, 0.0));
    // 1e12 becomes about 500 to 1024, so 1 becomes 1e-9 at most, below 2^-24 = 6e-8; so does the lamp. 0 is not lost.
    let lamp = scene.materials.iter().flat_map(|m| m.emission.to_array()).filter(|e| *e > 0.0).count();
    assert_eq!(RadianceScale::of(&scene, scene.rest()).lost, 1 + lamp);
    let gpu = gpu();
    let (_, warnings) = GpuScene::new(&gpu, &scene, scene.rest(), &SceneOptions::default()).unwrap();
    assert!(warnings.iter().any(|w| w.contains("smallest step")), "{warnings:?}");
}

#[test]
fn a_dark_scene_keeps_scale_1() {
    let mut scene = scene("cornell");
    scene.materials.iter_mut().for_each(|m| m.emission = Vec3::ZERO);
    scene.sky = Sky::Constant(Vec3::ZERO);
    assert_eq!(RadianceScale::of(&scene, scene.rest()), RadianceScale { scale: 1.0, lost: 0 });
}

#[test]
fn the_sun_comes_first_and_lights_are_scaled() {
    let mut scene = scene("cornell");
    scene.sun = Some(Sun { direction: Vec3::NEG_Y, irradiance: Vec3::splat(2.0), angle: 0.01 });
    let mut geometry = scene.rest().clone();
    let spot = PunctualKind::Spot { inner: 0.1, outer: 0.5 };
    geometry.lights.push(PunctualLight {
        kind: spot,
        position: Vec3::ONE,
        direction: Vec3::X,
        intensity: Vec3::splat(3.0),
        range: f32::INFINITY,
    });
    let gpu = gpu();
    let (uploaded, _) = GpuScene::new(&gpu, &scene, &geometry, &SceneOptions::default()).unwrap();
    let lights: Vec<Light> = gpu.read_buffer(&uploaded.lights).unwrap();
    assert_eq!((uploaded.light_count, lights.len()), (2, 2));
    assert_eq!((lights[0].kind, lights[1].kind), (0, 3));
    assert_eq!(lights[0].intensity[0], 2.0 * uploaded.radiance_scale);
    assert_eq!(lights[0].cos_inner, 0.005_f32.cos());
    assert_eq!((lights[1].cos_inner, lights[1].cos_outer), (0.1_f32.cos(), 0.5_f32.cos()));
    assert!(lights[1].range.is_finite());
}

#[test]
fn an_emitter_s_power_is_area_times_radiance_times_pi() {
    let scene = scene("cornell");
    let gpu = gpu();
    let uploaded = uploaded(&gpu, &scene);
    let [lamp] = &uploaded.emitters[..] else { panic!("{:?}", uploaded.emitters) };
    let emission = scene.materials.iter().find(|m| m.emits()).unwrap().emission;
    // The lamp is 130 mm x 105 mm at ten times the size: 1.3 m x 1.05 m.
    let power = 1.3 * 1.05 * cpu::luminance(emission.to_array()) * std::f32::consts::PI;
    // Corners are decimal numbers in f32.
    assert!((lamp.power / power - 1.0).abs() < 1e-4, "{} against {power}", lamp.power);
    assert_eq!(scene.rest().objects[lamp.object as usize].triangles, lamp.triangles);
}

#[test]
fn too_many_materials_are_refused_with_both_numbers() {
    let mut scene = scene("cornell");
    scene.materials.resize(70_000, scene.materials[0].clone());
    let result = GpuScene::new(&gpu(), &scene, scene.rest(), &SceneOptions::default());
    let message = result.err().unwrap().to_string();
    assert!(message.contains("70000") && message.contains("65535"), "{message}");
}

#[test]
fn lambert_leaves_out_all_but_colour_masks_and_emission() {
    let gpu = gpu();
    let scene = scene("spheres");
    let options = SceneOptions { model: Model::Lambert, ..SceneOptions::default() };
    let (lambert, _) = GpuScene::new(&gpu, &scene, scene.rest(), &options).unwrap();
    let materials: Vec<Material> = gpu.read_buffer(&lambert.materials).unwrap();
    assert!(materials.iter().all(|m| m.f0 == 0.0 && m.metalness == 0.0 && m.transmission == 0.0));
    assert!(scene.needs().specular && !lambert.needs.specular && lambert.needs.emission);
}

#[test]
fn what_the_references_ignore_of_glass_is_left_out_for_them() {
    let gpu = gpu();
    let mut scene = scene("cornell");
    let volume = scene::Volume { attenuation_distance: 0.1, attenuation_color: glam::Vec3::splat(0.5) };
    let glass =
        scene::Material { transmission: 1.0, metallic: 1.0, roughness: 0.5, ..scene.materials[0].clone() };
    scene.materials[0] = scene::Material { volume: Some(volume), ..glass.clone() };
    scene.materials[1] = scene::Material { volume: None, ..glass.clone() };
    scene.materials[2] = scene::Material { volume: Some(volume), transmission: 0.5, ..glass };
    let options = SceneOptions { as_references: true, ..SceneOptions::default() };
    let of = |options: &SceneOptions| -> Vec<(f32, f32, bool)> {
        let (uploaded, _) = GpuScene::new(&gpu, &scene, scene.rest(), options).unwrap();
        let materials: Vec<Material> = gpu.read_buffer(&uploaded.materials).unwrap();
        materials[..3].iter().map(|m| (m.metalness, m.roughness, m.absorption[0] > 0.0)).collect()
    };
    assert_eq!(of(&options), [(0.0, 0.5, false), (0.0, 0.0, false), (1.0, 0.5, false)]);
    assert_eq!(of(&SceneOptions::default()), [(1.0, 0.5, true), (1.0, 0.5, false), (1.0, 0.5, true)]);
}

#[test]
fn a_new_moment_rewrites_the_moving_tail_and_keeps_the_last_one() {
    let gpu = gpu();
    let mut scene = scene("spheres");
    scene.set_moving(0.5);
    let mut geometry = scene.rest().clone();
    let mut uploaded = uploaded(&gpu, &scene);
    let first = geometry.static_vertex_count() as usize;
    assert!(first > 0 && first < geometry.positions.len(), "the scene should be half moving");

    let positions = |geometry: &Geometry| geometry.positions.iter().map(|p| p.to_array()).collect::<Vec<_>>();
    let stored = |uploaded: &GpuScene| {
        let words: Vec<u32> = gpu.read_buffer(&uploaded.mesh.vertices).unwrap();
        words
            .chunks_exact(uploaded.mesh.layout.stride as usize)
            .map(|v| [v[0], v[1], v[2]].map(f32::from_bits))
            .collect::<Vec<_>>()
    };
    let previous = |uploaded: &GpuScene| gpu.read_buffer::<[f32; 3]>(&uploaded.mesh.previous).unwrap();
    assert_eq!(stored(&uploaded), positions(&geometry));
    let mut before = positions(&geometry);
    assert_eq!(previous(&uploaded), before);
    for time in [0.3, 0.6, 0.6] {
        scene.pose(time, &mut geometry);
        uploaded.update(&gpu, &geometry);
        assert_eq!(stored(&uploaded), positions(&geometry), "now, at {time} s");
        assert_eq!(previous(&uploaded), before, "before, at {time} s");
        before = positions(&geometry);
    }
}
