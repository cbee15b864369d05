//! Rays with a known answer.
#![allow(clippy::unwrap_used)]

use super::rays::{about, random};
use super::run;
use crate::pipeline::Pipeline;
use crate::settings::View;
use crate::{Progress, RenderSettings};
use frame::Gpu;
use glam::Vec3;

#[test]
fn directions_are_about_their_normal_by_the_cosine() {
    let normal = Vec3::new(0.3, -0.8, 0.5).normalize();
    let count = 20_000;
    let directions: Vec<Vec3> = (0..count).map(|i| about(normal, random(7, i))).collect();
    assert!(directions.iter().all(|d| d.is_normalized() && d.dot(normal) >= -1e-6));
    // Means under a density of cosine over pi: 2/3 for the cosine, 1/2 for its square, standard errors 0.0017 and 0.002.
    let mean = |of: fn(f32) -> f32| {
        directions.iter().map(|d| f64::from(of(d.dot(normal)))).sum::<f64>() / f64::from(count)
    };
    assert!((mean(|c| c) - 2.0 / 3.0).abs() < 0.007 && (mean(|c| c * c) - 0.5).abs() < 0.008);
}

#[test]
fn in_a_closed_room_every_ray_of_every_structure_hits() {
    let settings = RenderSettings {
        scene: "furnace".into(),
        view: View::Camera(0),
        trace_size: [40, 30],
        display_size: [40, 30],
        grid: 32,
        ..Default::default()
    };
    let gpu = Gpu::new(None).expect("this test needs an adapter; a software one will do");
    let mut pipeline = Pipeline::new(gpu, &settings, Progress::default()).unwrap();
    let race = run(&mut pipeline).unwrap();
    assert_eq!((race.grid, race.primary.rays, race.secondary.rays), (32, 1200, 1200));
    for heat in [&race.primary, &race.secondary] {
        let names: Vec<&str> = heat.entrants.iter().map(|e| e.structure.as_str()).collect();
        assert_eq!(names, ["voxel", "bvh_cwbvh", "bvh_lbvh"]);
        assert!(heat.entrants.iter().all(|e| e.hit_share == 1.0 && e.visits_per_ray >= 1.0), "{heat:?}");
    }
}
