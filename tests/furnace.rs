//! Is energy kept? A closed room of albedo a and emission e, where radiance is e / (1 - a) everywhere.

use crate::support::{frame_of, mean, pipeline, pipeline_of, render};
use gridlight::RenderSettings;
use gridlight::pipeline::Pipeline;
use gridlight::settings::View;

/// The built-in furnace: a = e = 1/2 before they are stored.
fn furnace(camera: usize, seed: u32) -> RenderSettings {
    RenderSettings {
        scene: "furnace".into(),
        view: View::Camera(camera),
        trace_size: [32, 32],
        display_size: [32, 32],
        grid: 32,
        denoiser: "identity".into(),
        upsampler: "nearest".into(),
        bounces: None,
        spp: 8,
        seed,
        ..Default::default()
    }
}

/// Mean of the picture over frames of independent numbers, and its standard error.
fn mean_of(mut pipeline: Pipeline) -> (f64, f64) {
    let means: Vec<f64> = (0..8).map(|_| mean(&frame_of(&mut pipeline).0)[1]).collect();
    let count = means.len() as f64;
    let of_all = means.iter().sum::<f64>() / count;
    let variance = means.iter().map(|m| (m - of_all).powi(2)).sum::<f64>() / (count - 1.0);
    (of_all, (variance / count).sqrt())
}

#[test]
fn every_wall_has_the_radiance_of_the_closed_form() {
    for camera in 0..6 {
        let (found, standard_error) = mean_of(pipeline(&furnace(camera, 1)));
        // Albedo is stored with an exact mean, emission as RGB9E5 exactly (a power of two). Three standard errors, and
        // the half floats of the picture.
        let allowed = 3.0 * standard_error + 1.0 / 2048.0;
        println!("camera {camera}: {found:.5} +- {standard_error:.5}");
        assert!((found - 1.0).abs() < allowed, "camera {camera}: {found} is not 1 within {allowed}");
    }
}

#[test]
fn dark_and_bright_walls_keep_their_share_at_every_bounce() {
    for albedo in [0.2f32, 0.5, 0.9] {
        let emission = 0.25;
        let expected = f64::from(emission / (1.0 - albedo));
        let (found, standard_error) =
            mean_of(pipeline_of(scene::built_in::furnace(albedo, emission), &furnace(0, 1)));
        let allowed = 3.0 * standard_error + expected / 2048.0;
        println!("albedo {albedo}: {found:.5} +- {standard_error:.5}, closed form {expected:.5}");
        assert!(
            (found - expected).abs() < allowed,
            "albedo {albedo}: {found} is not {expected} within {allowed}"
        );
    }
}

/// Balls of every roughness and metalness in a white sky, their base colours white and none of them glowing.
fn white_balls() -> scene::Scene {
    let mut scene = scene::Scene::load("spheres").unwrap();
    for (i, material) in scene.materials.iter_mut().enumerate() {
        material.base_color = glam::Vec4::ONE;
        material.emission = glam::Vec3::ZERO;
        material.anisotropy = if i % 2 == 0 { 0.0 } else { 0.8 };
    }
    scene
}

#[test]
fn white_balls_vanish_in_a_white_sky() {
    let settings = RenderSettings {
        trace_size: [84, 63],
        display_size: [84, 63],
        tracer: "bvh_cwbvh".into(),
        spp: 16,
        ..furnace(0, 1)
    };
    let picture = frame_of(&mut pipeline_of(white_balls(), &settings)).0;
    // Columns of balls are columns of roughness.
    for column in 0..7 {
        let of_column = picture.texels().iter().enumerate().filter(|(i, _)| i % 84 / 12 == column);
        let values: Vec<f64> = of_column.map(|(_, p)| f64::from(p[1])).collect();
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        let error = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>().sqrt() / count;
        println!("roughness {:.2}: {mean:.4} +- {error:.4}", column as f64 / 6.0);
        // Half a percent, and three standard errors.
        assert!((mean - 1.0).abs() < 0.005 + 3.0 * error, "column {column}: {mean} +- {error}");
    }
}

#[test]
fn the_same_seed_gives_the_same_bits_and_another_does_not() {
    let [first, again, other] = [1, 1, 2].map(|seed| render(&furnace(0, seed)));
    assert_eq!(first.texels(), again.texels());
    assert_ne!(first.texels(), other.texels());
}
