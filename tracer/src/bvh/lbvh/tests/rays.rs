//! What rays meet: against double precision, against all triangles, and nothing lost between two of them.

use super::fixture::{Random, Stage, random_triangles, ray, ray_through, soup, sphere};
use crate::bvh::{BLOCKED, FREE, SHEETS};
use crate::rays::{Met, Ray};
use glam::{DVec3, Vec3};
use std::path::Path;

/// Distance, and how far inside the triangle the point is, as a share of its height over the nearest edge.
fn meet(corners: [Vec3; 3], ray: &Ray) -> Option<(f64, f64)> {
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    let [origin, direction] = [ray.origin, ray.direction].map(|v| DVec3::from(v.map(f64::from)));
    let (ab, ac) = (b - a, c - a);
    let p = direction.cross(ac);
    let det = ab.dot(p);
    if det == 0.0 {
        return None;
    }
    let s = origin - a;
    let q = s.cross(ab);
    let [v, w, t] = [s.dot(p), direction.dot(q), ac.dot(q)].map(|x| x / det);
    (t > 0.0).then_some((t, v.min(w).min(1.0 - v - w)))
}

/// How far a hit in floats may be off: corners are rounded once when the origin is taken off, and twice when sheared;
/// so 2^-22 of the farthest corner L in all. Areas are sums of products of such: off by 2^-21 L^2. The weights are off
/// by that over the area that the ray sees, the distance by the weights times the corners' depths.
fn rounding(corners: [Vec3; 3], ray: &Ray) -> (f64, f64) {
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    let [origin, direction] = [ray.origin, ray.direction].map(|v| DVec3::from(v.map(f64::from)));
    let farthest = [a, b, c].map(|p| (p - origin).length()).into_iter().fold(origin.length(), f64::max);
    let seen = (b - a).cross(c - a).dot(direction).abs();
    let weights = farthest * farthest / 2_097_152.0 / seen;
    (weights, 3.0 * farthest * weights + farthest / 2_097_152.0)
}

fn random_rays(stage: &Stage, count: usize, seed: u32) -> Vec<Ray> {
    let bounds = stage.geometry.bounds();
    let mut random = Random(seed);
    (0..count).map(|_| ray(bounds.min + bounds.size() * random.point(), random.direction())).collect()
}

/// Asserts that a hit is the nearest one but for rounding.
fn check(stage: &Stage, ray: &Ray, met: &Met) {
    let mut nearest: Option<(u32, f64)> = None;
    for number in 0..stage.geometry.triangles.len() as u32 {
        let corners = stage.corners(number);
        let Some((t, inside)) = meet(corners, ray) else { continue };
        let (weights, distance) = rounding(corners, ray);
        if number == met.primitive {
            assert!(inside >= -weights, "{ray:?}: outside of the triangle met by {inside}");
            assert!((t - f64::from(met.distance)).abs() <= distance, "{ray:?}: {t} against {}", met.distance);
        }
        // A hit so near an edge that rounding may lose it does not count.
        if inside > weights && t - distance > 0.0 && nearest.is_none_or(|(_, least)| t + distance < least) {
            nearest = Some((number, t + distance));
        }
    }
    if let Some((number, least)) = nearest {
        assert!(f64::from(met.distance) <= least, "{ray:?}: {met:?}, but {number} is at {least}");
    }
}

#[test]
fn meets_what_double_precision_meets() {
    for name in ["courtyard", "cornell", "spheres"] {
        let stage = Stage::scene(name);
        let rays = random_rays(&stage, 1000, 17);
        let met = stage.met(&rays);
        rays.iter().zip(&met).for_each(|(ray, met)| check(&stage, ray, met));
        let hits = met.iter().filter(|met| met.primitive != Ray::NOTHING).count();
        assert!(hits > 200, "{name}: {hits} hits");
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
        let stage = Stage::scene(name);
        let mut random = Random(23);
        let mut rays = random_rays(&stage, aims, 29);
        let axes = [Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z];
        for i in 0..aims {
            let [a, b, c] = stage.corners(random.index(stage.geometry.triangles.len()) as u32);
            let origin = [a, 0.5 * (a + b), (a + b + c) / 3.0][i % 3];
            let axis = axes[random.index(6)];
            let level = random.direction() * Vec3::new(1.0, 0.0, 1.0);
            let in_plane = (b - a).try_normalize().unwrap_or(Vec3::X);
            rays.extend([axis, level, in_plane, random.direction()].map(|direction| ray(origin, direction)));
            // Towards it from afar, exactly along an axis and not.
            rays.extend([
                ray(origin - 8.0 * axis, axis),
                ray_through(origin + 3.0 * random.direction(), origin),
            ]);
        }
        rays.retain(|ray| Vec3::from(ray.direction).is_normalized());
        let hits = stage.compare(&rays);
        println!("{name}: {hits} of {} rays meet something", rays.len());
        assert!(hits > rays.len() / 4);

        let met = stage.met(&rays);
        let hit: Vec<_> = rays.iter().zip(&met).filter(|(_, met)| met.primitive != Ray::NOTHING).collect();
        let skipping: Vec<_> = hit.iter().map(|(ray, met)| Ray { skip: met.primitive, ..**ray }).collect();
        stage.compare(&skipping);
        for (next, (_, met)) in stage.met(&skipping).iter().zip(&hit) {
            assert!(next.primitive != met.primitive && next.distance >= met.distance);
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
    let stage = Stage::scene("cornell");
    assert!(stage.uploaded.sheets.iter().all(|is_sheet| !is_sheet));
    let mut rays = random_rays(&stage, 4000, 31);
    rays.iter_mut().for_each(|ray| ray.t_max = 0.5);
    let met = stage.met(&rays);
    for (blocked, met) in stage.blocked(&rays).into_iter().zip(&met) {
        assert_eq!(blocked, if met.primitive == Ray::NOTHING { FREE } else { BLOCKED });
    }
    assert!(
        met.iter().any(|met| met.primitive == Ray::NOTHING)
            && met.iter().any(|met| met.primitive != Ray::NOTHING)
    );

    let mixed = Stage::of(soup(&random_triangles(60, 0.6), 2));
    let rays = random_rays(&mixed, 2000, 37);
    mixed.compare(&rays);
    let answers = mixed.blocked(&rays);
    assert!([FREE, BLOCKED, SHEETS].iter().all(|answer| answers.contains(answer)));
}

/// From inside a closed ball, aimed at corners and at points of edges: none finds a gap.
#[test]
fn lets_no_ray_out_of_a_closed_mesh() {
    let center = Vec3::new(3.1, -2.7, 0.4);
    let stage = Stage::soup(&sphere(center, 1.3, 40));
    let mut random = Random(41);
    let aimed = |random: &mut Random| {
        let [a, b, c] = stage.corners(random.index(stage.geometry.triangles.len()) as u32);
        let [a, b] = [[a, b], [b, c], [c, a]][random.index(3)];
        let share = [0.0, 0.5, random.next()][random.index(3)];
        // The flattest facet lies cos^2(pi / 80) = 0.998 of the radius from the centre.
        ray_through(center + 1.25 * random.next() * random.direction(), a + share * (b - a))
    };
    let rays: Vec<_> = (0..100_000).map(|_| aimed(&mut random)).collect();
    let escaped = stage.met(&rays).iter().filter(|met| met.primitive == Ray::NOTHING).count();
    assert_eq!(escaped, 0);
    assert!(stage.blocked(&rays).iter().all(|&answer| answer == BLOCKED));
}

/// A real scene: no ray is cut, and what a ray costs is printed.
#[test]
fn searches_sponza() {
    if std::env::var_os("GRIDLIGHT_SHARED").is_none() {
        println!("skipped: GRIDLIGHT_SHARED is not set (cargo xtask test --shared)");
        return;
    }
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/scenes/sponza"));
    let files = folder.read_dir().into_iter().flatten().flatten().map(|entry| entry.path());
    let is_scene = |path: &std::path::PathBuf| path.extension().is_some_and(|e| e == "gltf" || e == "glb");
    let Some(file) = files.into_iter().find(is_scene) else {
        println!("skipped: no scene in {}", folder.display());
        return;
    };
    let stage = Stage::scene(file.to_str().unwrap());
    let rays = random_rays(&stage, 200_000, 43);
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
