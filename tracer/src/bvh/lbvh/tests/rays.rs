//! What rays meet: against double precision and against all triangles.

use super::fixture::{Planted, random_triangles};
use crate::bvh::tests::fixture::{Stage, soup};
use crate::bvh::{BLOCKED, FREE, SHEETS};
use crate::rays::{Met, Ray};

#[test]
fn meets_what_double_precision_meets() {
    for name in ["courtyard", "cornell", "spheres"] {
        let stage = Planted::scene(name);
        let rays = stage.random_rays(1000, 17);
        let met = stage.met(&rays);
        let hits = rays.iter().zip(&met).filter(|(ray, met)| stage.check(ray, met)).count();
        // The scenes are open, so that some rays leave.
        assert!(hits > 400, "{name}: {hits} hits");
        let visits: u32 = met.iter().map(|met| met.visits).sum();
        println!(
            "{name}: {} triangles, {} visits per ray",
            stage.geometry.triangles.len(),
            visits as f32 / 1e3
        );
    }
}

/// Boxes hide nothing: along axes, in planes of triangles, from corners and edges, with limits and skipped triangles.
#[test]
fn meets_what_a_search_without_boxes_meets() {
    for (name, aims) in [("courtyard", 200), ("cornell", 400), ("spheres", 60)] {
        let stage = Planted::scene(name);
        let mut rays = stage.random_rays(aims, 29);
        rays.extend(stage.awkward_rays(6 * aims, 23));
        let hits = stage.compare(&rays);
        println!("{name}: {hits} of {} rays meet something", rays.len());
        assert!(hits > rays.len() / 4);

        let met = stage.met(&rays);
        let hit: Vec<_> = rays.iter().zip(&met).filter(|(_, met)| met.primitive != Ray::NOTHING).collect();
        let skipping: Vec<_> = hit.iter().map(|(ray, met)| Ray { skip: met.primitive, ..**ray }).collect();
        stage.compare(&skipping);
        for (next, (_, met)) in stage.met(&skipping).iter().zip(&hit) {
            assert_ne!(next.primitive, met.primitive);
        }
        // The limit itself is still met, the float before it not.
        let reaching: Vec<_> = hit.iter().map(|(ray, met)| Ray { t_max: met.distance, ..**ray }).collect();
        let short: Vec<_> =
            hit.iter().map(|(ray, met)| Ray { t_max: met.distance.next_down(), ..**ray }).collect();
        assert_eq!(stage.compare(&reaching), hit.len());
        assert_eq!(stage.compare(&short), 0);
    }
}

/// In a scene without sheets light is blocked where something is met; with sheets, all three answers occur.
#[test]
fn is_blocked_where_something_is_met() {
    let stage = Planted::scene("cornell");
    assert!(stage.uploaded.sheets.iter().all(|is_sheet| !is_sheet));
    let mut rays = stage.random_rays(4000, 31);
    rays.iter_mut().for_each(|ray| ray.t_max = 0.5);
    let met = stage.met(&rays);
    for (blocked, met) in stage.blocked(&rays).into_iter().zip(&met) {
        assert_eq!(blocked, if met.primitive == Ray::NOTHING { FREE } else { BLOCKED });
    }
    assert!(
        met.iter().any(|met| met.primitive == Ray::NOTHING)
            && met.iter().any(|met| met.primitive != Ray::NOTHING)
    );

    let mixed = Planted::new(Stage::of(soup(&random_triangles(60, 0.6), 2)));
    let rays = mixed.random_rays(2000, 37);
    mixed.compare(&rays);
    let answers = mixed.blocked(&rays);
    assert!([FREE, BLOCKED, SHEETS].iter().all(|answer| answers.contains(answer)));
}

/// A real scene: no ray is cut, and what a ray costs is printed.
#[test]
fn searches_sponza() {
    let Some(stage) = Stage::sponza() else { return };
    let stage = Planted::new(stage);
    let rays = stage.random_rays(200_000, 43);
    let traced = stage.tree.closest(&stage.gpu, &stage.lbvh.resources(), &rays).unwrap();
    let visits = |met: &Met| f64::from(met.visits);
    let mean = traced.answers.iter().map(visits).sum::<f64>() / rays.len() as f64;
    let most = traced.answers.iter().map(visits).fold(0.0, f64::max);
    println!(
        "{} triangles: build {:?} ms; {} rays: {mean:.1} visits each, {most} at most, {:?} ms",
        stage.geometry.triangles.len(),
        stage.log.total_ms(),
        rays.len(),
        traced.gpu_ms
    );
    for pass in &stage.log.passes {
        println!("  {}: {:?} ms", pass.name, pass.gpu_ms);
    }
    assert!(traced.answers.iter().all(|met| met.cut == 0));
}
