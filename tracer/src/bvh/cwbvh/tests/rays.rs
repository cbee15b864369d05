//! What rays meet.

use super::super::Quality;
use super::super::tree::{boxes, cwbvh};
use super::fixture::Fixture;
use crate::bvh::tests::fixture::{Random, Stage, ray};
use crate::bvh::{BLOCKED, FREE, MOST_VISITS, SHEETS};
use crate::gather::reference::intersect;
use crate::rays::{Met, Ray};
use glam::Vec3;
use obvhs::ray::{Ray as ObvhsRay, RayHit};
use scene::{Alpha, Scene};

const SCENES: [&str; 3] = ["courtyard", "cornell", "spheres"];
const NONE: u32 = Ray::NOTHING;

#[test]
fn rays_meet_what_f64_says() {
    for name in SCENES {
        let fixture = Fixture::scene(name);
        for (kind, rays) in
            [("random", fixture.random_rays(1000, 1)), ("awkward", fixture.awkward_rays(1000, 2))]
        {
            let hits = fixture.met(&rays);
            let met = rays.iter().zip(&hits).filter(|(ray, hit)| fixture.check(ray, hit)).count();
            println!("{name}: {met} of {} {kind} rays met what f64 says", rays.len());
            // The scenes are open, so that some rays leave; and f64 does not meet what is seen from its edge.
            assert!(met > 300, "{name}: {met}");
        }
    }
}

#[test]
fn limits_and_skips_are_kept() {
    let fixture = Fixture::scene("cornell");
    let rays = fixture.random_rays(1000, 4);
    let hits = fixture.met(&rays);
    let met: Vec<_> = rays.iter().zip(&hits).filter(|(_, hit)| hit.primitive != NONE).collect();
    assert!(met.len() > 400, "{}", met.len());
    let changed = |change: &dyn Fn(&Ray, f32, u32) -> Ray| {
        let rays: Vec<_> = met.iter().map(|(ray, hit)| change(ray, hit.distance, hit.primitive)).collect();
        (fixture.met(&rays), fixture.blocked(&rays), rays)
    };
    // A limit exactly at the triangle still meets it, the next float before it does not.
    let (at, at_blocked, _) = changed(&|ray, distance, _| Ray { t_max: distance, ..*ray });
    assert!(at_blocked.iter().all(|answer| *answer != FREE));
    for (now, (ray, before)) in at.iter().zip(&met) {
        assert_eq!(
            (now.primitive, now.distance, now.weights),
            (before.primitive, before.distance, before.weights),
            "{ray:?}"
        );
    }
    let (short, short_blocked, _) = changed(&|ray, distance, _| Ray { t_max: distance.next_down(), ..*ray });
    assert!(short_blocked.iter().all(|answer| *answer == FREE));
    for (now, (ray, _)) in short.iter().zip(&met) {
        assert_eq!(now.primitive, NONE, "{ray:?}");
    }
    let (behind, _, skipping) = changed(&|ray, _, triangle| Ray { skip: triangle, ..*ray });
    for (now, ray) in behind.iter().zip(&skipping) {
        fixture.check(ray, now);
    }
}

#[test]
fn of_equal_distances_the_lower_number_wins() {
    let wall = |z: f32| [Vec3::new(-1.0, -1.0, z), Vec3::new(3.0, -1.0, z), Vec3::new(-1.0, 3.0, z)];
    // 1,000 times the same triangle, which no box tells apart, behind one that is skipped.
    let triangles: Vec<_> = (0..1001).map(|i| wall(if i == 0 { 1.0 } else { 2.0 })).collect();
    let fixture = Fixture::soup(&triangles);
    println!("{} nodes, depth {}", fixture.cwbvh.bvh.node_count, fixture.cwbvh.depth);
    let ray = ray(Vec3::ZERO, Vec3::Z);
    let rays = [ray, Ray { skip: 0, ..ray }, Ray { t_max: 1.5, skip: 0, ..ray }];
    let hits = fixture.met(&rays);
    let seen: Vec<_> = hits.iter().map(|hit| (hit.primitive, hit.distance)).collect();
    assert_eq!(seen, [(0, 1.0), (1, 2.0), (NONE, 1.5)]);
    assert_eq!(fixture.blocked(&rays), [BLOCKED, BLOCKED, FREE]);
    // Corners two and three, from the position (0, 0) = 1/2 a + 1/4 b + 1/4 c.
    assert_eq!(hits[0].weights, [0.25, 0.25]);
}

#[test]
fn the_device_walks_as_the_twin_does() {
    for name in SCENES {
        let fixture = Fixture::scene(name);
        let twin = fixture.twin();
        let rays = fixture.random_rays(4000, 5);
        let hits = fixture.met(&rays);
        let (mut same, mut same_visits, mut visits) = (0, 0, [0_u64; 2]);
        for (ray, hit) in rays.iter().zip(&hits) {
            let cpu = twin.closest(ray.origin.into(), ray.direction.into(), ray.t_max, ray.skip);
            same += usize::from(cpu.triangle == hit.primitive);
            same_visits += usize::from(cpu.visits == hit.visits);
            visits[0] += u64::from(hit.visits);
            visits[1] += u64::from(cpu.visits);
            assert_eq!((hit.cut, cpu.cut), (0, false));
            // A few roundings, fused or not.
            if cpu.triangle == hit.primitive && hit.primitive != NONE {
                let allowed = fixture.allowed(ray, hit.primitive as usize);
                let error = f64::from((cpu.distance - hit.distance).abs());
                assert!(error <= allowed, "{ray:?}: {hit:?} against {cpu:?}");
                let (ours, theirs) = (cpu.weights, glam::Vec2::from(hit.weights));
                assert!(ours.is_finite() && theirs.is_finite(), "{ray:?}: {hit:?} against {cpu:?}");
            }
        }
        let count = rays.len();
        println!("{name}: {same} same, {same_visits} same visits of {count}; {visits:?} visits");
        // Fused products change a distance's last bit, and with it now and then which of two neighbours is met.
        assert!(100 * same >= 99 * count && 100 * same_visits >= 99 * count, "{name}: {same}, {same_visits}");
        let ratio = visits[0] as f64 / visits[1] as f64;
        assert!((0.95..1.05).contains(&ratio), "{name}: {ratio}");
    }
}

#[test]
fn the_builder_s_own_walk_finds_the_same() {
    let fixture = Fixture::scene("courtyard");
    let count = fixture.geometry.triangles.len();
    let corners: Vec<_> = (0..count).map(|i| fixture.corners(i)).collect();
    let tree = cwbvh(&boxes(&corners), Quality::Medium);
    let rays = fixture.random_rays(4000, 6);
    let mut same = 0;
    for (ray, hit) in rays.iter().zip(fixture.met(&rays)) {
        let (origin, direction) = (Vec3::from(ray.origin).as_dvec3(), Vec3::from(ray.direction).as_dvec3());
        let mut theirs = RayHit::none();
        tree.ray_traverse(
            ObvhsRay::new_inf(ray.origin.into(), ray.direction.into()),
            &mut theirs,
            |_, place| {
                let corners = corners[tree.primitive_indices[place] as usize];
                intersect(origin, direction, corners).map_or(f32::INFINITY, |(distance, _)| distance as f32)
            },
        );
        let distance = if hit.primitive == NONE { f32::INFINITY } else { hit.distance };
        let allowed = if hit.primitive == NONE { 0.0 } else { fixture.allowed(ray, hit.primitive as usize) };
        same += usize::from(theirs.t == distance || f64::from((theirs.t - distance).abs()) <= allowed);
    }
    println!("{same} of {} the same", rays.len());
    // It ignores boxes nearer than 0.1 mm, and rays that pass within rounding of an edge may go either way.
    assert!(1000 * same >= 998 * rays.len(), "{same}");
}

#[test]
fn shadows_agree_with_the_closest_hit() {
    let mut scene = Scene::load("courtyard").unwrap();
    for material in &mut scene.materials {
        material.alpha = Alpha::Opaque;
        material.transmission = 0.0;
    }
    let diagonal = scene.bounds().diagonal();
    let limited = |fixture: &Fixture, seed| {
        let mut random = Random::new(seed);
        let mut rays = fixture.random_rays(4000, seed);
        rays.iter_mut().for_each(|ray| ray.t_max = random.unit() * diagonal);
        rays
    };
    let fixture = Fixture::new(Stage::new(&scene, scene.rest().clone()));
    assert!(fixture.uploaded.sheets.iter().all(|sheet| !sheet));
    let rays = limited(&fixture, 9);
    let answers = |fixture: &Fixture| -> Vec<(Met, u32)> {
        fixture.met(&rays).into_iter().zip(fixture.blocked(&rays)).collect()
    };
    let mut seen = [0; 3];
    for (ray, (hit, blocked)) in rays.iter().zip(answers(&fixture)) {
        let expected = if hit.primitive == NONE { FREE } else { BLOCKED };
        assert_eq!(blocked, expected, "{ray:?}: {hit:?}");
        seen[blocked as usize] += 1;
    }
    assert!(seen[FREE as usize] > 400 && seen[BLOCKED as usize] > 400, "{seen:?}");

    // Half of the materials let light through.
    scene.materials.iter_mut().step_by(2).for_each(|material| material.alpha = Alpha::Blend);
    let fixture = Fixture::new(Stage::new(&scene, scene.rest().clone()));
    let (mut seen, mut same) = ([0; 3], 0);
    for (ray, (hit, blocked)) in rays.iter().zip(answers(&fixture)) {
        assert_eq!(hit.primitive == NONE, blocked == FREE, "{ray:?}: {hit:?}");
        let (origin, direction) = (Vec3::from(ray.origin).as_dvec3(), Vec3::from(ray.direction).as_dvec3());
        let meets = |i: &usize| {
            intersect(origin, direction, fixture.corners(*i)).is_some_and(|(t, _)| t <= f64::from(ray.t_max))
        };
        let is_sheet = |i: usize| fixture.uploaded.sheets[fixture.geometry.triangles[i].material as usize];
        let met = (0..fixture.geometry.triangles.len()).filter(meets);
        let expected = met.map(|i| if is_sheet(i) { SHEETS } else { BLOCKED });
        // BLOCKED is the lower number: one such triangle is enough.
        let expected = expected.min().unwrap_or(FREE);
        same += usize::from(blocked == expected);
        seen[blocked as usize] += 1;
    }
    println!("{seen:?} free, blocked, sheets; {same} as f64 says");
    assert!(seen.iter().all(|n| *n > 100), "{seen:?}");
    // Rays within rounding of an edge or of the limit may go either way.
    assert!(1000 * same >= 998 * rays.len(), "{same}");
}

#[test]
fn a_ray_that_would_visit_too_many_nodes_is_cut() {
    // Half squares behind each other; the ray passes through the empty halves of their boxes.
    let corner = |i: u32| Vec3::new(0.0, 0.0, i as f32 * 0.01);
    let triangles: Vec<_> =
        (0..120_000).map(|i| [corner(i), corner(i) + Vec3::X, corner(i) + Vec3::Y]).collect();
    let fixture = Fixture::soup(&triangles);
    let ray = ray(Vec3::new(0.9, 0.9, -1.0), Vec3::Z);
    let short = Ray { t_max: 50.0, ..ray };
    let hits = fixture.met(&[ray, short]);
    println!("{} nodes, depth {}: {hits:?}", fixture.cwbvh.bvh.node_count, fixture.cwbvh.depth);
    assert_eq!((hits[0].primitive, hits[0].cut), (NONE, 1));
    assert!(hits[0].visits <= MOST_VISITS);
    assert_eq!((hits[1].primitive, hits[1].cut), (NONE, 0));
    let twin = fixture.twin().closest(ray.origin.into(), ray.direction.into(), ray.t_max, NONE);
    assert_eq!((twin.visits, twin.cut), (MOST_VISITS, true));
}
