//! Closed forms, and everything a height map may do to a mesh.
#![allow(clippy::unwrap_used, clippy::panic)]

use super::{Displace, reference};
use crate::Tessellator;
use crate::tests::{Made, Subject, ball, cube, frame, gpu, noise, picture, run, sheet};
use frame::{Gpu, Recorder, set_knob};
use glam::{DVec2, Quat, Vec2, Vec3};
use scene::{Geometry, Material, TextureSlot};
use std::f32::consts::TAU;

fn displaced(gpu: &Gpu, subject: &Subject, voxel_size: f32) -> Made {
    run(gpu, &mut Displace::new(gpu).unwrap(), subject, voxel_size).0
}

fn degrees(a: Vec3, b: Vec3) -> f32 {
    // By the sine: the cosine of a small angle is 1 in f32.
    a.cross(b).length().atan2(a.dot(b)).to_degrees()
}

#[test]
fn a_ball_at_constant_height_is_a_larger_ball() {
    let gpu = gpu();
    let subject = Subject::new(ball(1.0, [24, 12]), picture([4, 4], |_, _| 1.0), 0.25);
    let made = displaced(&gpu, &subject, 0.1);
    assert!(made.triangles.len() > 4 * subject.geometry.triangles.len());
    for v in made.used() {
        let position = made.positions[v];
        // The diagonals of the source's cells of 15 degrees lie up to 1 - cos(10.6 degrees) below the ball.
        assert!((position.length() - 1.25).abs() < 0.022, "{position}");
        // Octahedral codes: 16 bits a coordinate.
        let off = degrees(made.normals[v], position.normalize());
        assert!(off < 0.02, "{off} degrees at {position}");
    }
}

#[test]
fn a_fluted_column_has_its_analytic_normals() {
    const FLUTES: f32 = 6.0;
    const DEPTH: f32 = 0.05;
    let gpu = gpu();
    let mut geometry = Geometry::default();
    let at = |s: f32, t: f32| {
        let (sin, cos) = (TAU * s).sin_cos();
        (Vec3::new(cos, 0.5 * t, -sin), Vec3::new(cos, 0.0, -sin))
    };
    sheet(&mut geometry, [24, 2], at, Vec2::new);
    let heights = picture([512, 4], |u, _| 0.5 + 0.5 * (FLUTES * TAU * u).cos());
    let subject = Subject::new(geometry, heights, 2.0 * DEPTH);
    // 24 sides of 0.261 m cut in four: 96 around, 16 per flute.
    let made = displaced(&gpu, &subject, 0.261 / 4.0 / 0.7 + 1e-3);
    let mut worst = 0.0f32;
    for v in made.used() {
        let angle = TAU * made.uv[v].x;
        let (sin, cos) = angle.sin_cos();
        let (out, around) = (Vec3::new(cos, 0.0, -sin), Vec3::new(-sin, 0.0, -cos));
        let radius = 1.0 + DEPTH * (1.0 + (FLUTES * angle).cos());
        let slope = -DEPTH * FLUTES * (FLUTES * angle).sin();
        worst = worst.max(degrees(made.normals[v], (radius * out - slope * around).normalize()));
    }
    assert!(worst < 0.5, "{worst} degrees");
}

#[test]
fn the_gpu_does_what_the_twin_does() {
    let gpu = gpu();
    // One triangle, sheared and bent, so that its patch's weights can be told from its coordinates.
    let corners: [([f32; 3], [f32; 3], [f32; 2]); 3] = [
        ([0.0, 0.0, 0.0], [0.1, -0.2, 1.0], [0.2, 0.1]),
        ([1.0, 0.1, 0.2], [0.3, 0.0, 1.0], [1.4, 0.3]),
        ([0.2, 0.9, -0.1], [-0.2, 0.2, 1.0], [0.5, 1.3]),
    ];
    let mut geometry = quad(|uv| uv);
    geometry.triangles.truncate(1);
    geometry.objects[0].triangles.end = 1;
    geometry.triangles[0].vertices = [0, 1, 2];
    for (v, (position, normal, uv)) in corners.iter().enumerate() {
        geometry.positions[v] = Vec3::from(*position);
        geometry.normals[v] = Vec3::from(*normal).normalize();
        geometry.uv0[v] = Vec2::from(*uv);
    }
    let image = picture([64, 32], |u, v| 0.5 + 0.2 * (9.0 * u).sin() + 0.25 * (TAU * (u + 2.0 * v)).cos());
    let texels = image.rgba.iter().map(|texel| f64::from(texel[0]) / 255.0).collect();
    let map = reference::Map::new([64, 32], texels, 0.1);
    let made = displaced(&gpu, &Subject::new(geometry.clone(), image, 0.1), 0.15);
    let corner = |v: usize| reference::Corner {
        position: geometry.positions[v].as_dvec3(),
        normal: geometry.normals[v].as_dvec3(),
        place: geometry.uv0[v].as_dvec2(),
    };
    let corners = [0, 1, 2].map(corner);
    let [ab, ac] = [1, 2].map(|i: usize| corners[i].place - corners[0].place);
    // 1.02 m, the longest side but one, in parts of 0.105 m is 10; the third of 1.17 m is 12 rows.
    let rows = 12;
    for v in made.used() {
        let place = made.uv[v].as_dvec2() - corners[0].place;
        let weights = DVec2::new(place.perp_dot(ac), ab.perp_dot(place)) / ab.perp_dot(ac);
        let expected = reference::normal(&map, corners, rows, weights).as_vec3();
        // Heights in f32, slopes from their differences over 1/64: 1e-5.
        assert!(
            degrees(made.normals[v], expected) < 0.05,
            "at {weights}: {} is not {expected}",
            made.normals[v]
        );
    }
}

#[test]
fn every_face_of_a_box_moves_by_the_height() {
    let gpu = gpu();
    let subject = Subject::new(cube(1.0, 2), picture([4, 4], |_, _| 1.0), 0.1);
    let made = displaced(&gpu, &subject, 0.2);
    for v in made.used() {
        let largest = made.positions[v].abs().max_element();
        // Sums and a quotient of f32 about 1.
        assert!((largest - 0.6).abs() < 1e-5, "{}", made.positions[v]);
    }
    assert_eq!(made.open_edges(), 0);
    assert!(made.previous == made.positions, "what stands still was where it is, to the bit");
}

#[test]
fn depth_is_height_downwards() {
    let gpu = gpu();
    let mut subject = Subject::new(cube(1.0, 2), noise(16), 0.03);
    let up = displaced(&gpu, &subject, 0.1);
    if let Some(height) = &mut subject.material.height {
        (height.is_depth, height.scale) = (true, -0.03);
    }
    let down = displaced(&gpu, &subject, 0.1);
    assert!(up.positions == down.positions);
}

/// A quad of 1 m whose texture coordinates a matrix has moved.
fn quad(uv: impl Fn(Vec2) -> Vec2) -> Geometry {
    let mut geometry = Geometry::default();
    sheet(&mut geometry, [2, 2], |s, t| (Vec3::new(s, t, 0.0), Vec3::Z), |s, t| uv(Vec2::new(s, t)));
    geometry
}

#[test]
fn mirrored_turned_and_sheared_coordinates_shade_alike() {
    let gpu = gpu();
    // A hill that looks the same mirrored, turned by a quarter, and anywhere a sheared picture can show it.
    let wave = |x: f32| 0.25 - 0.25 * (TAU * x.rem_euclid(1.0).min(1.0 - x.rem_euclid(1.0))).cos();
    let hill = |u: f32, v: f32| wave(u) + wave(v);
    let plain = Subject::new(quad(|uv| uv), picture([64, 64], hill), 0.1);
    let plain = displaced(&gpu, &plain, 0.05);
    type Placed = fn(Vec2) -> Vec2;
    let others: [(&str, Placed); 3] = [
        ("mirrored", |uv| Vec2::new(1.0 - uv.x, uv.y)),
        ("turned", |uv| Vec2::new(uv.y, -uv.x)),
        ("twice mirrored", |uv| -uv),
    ];
    for (name, uv) in others {
        let made = displaced(&gpu, &Subject::new(quad(uv), picture([64, 64], hill), 0.1), 0.05);
        for v in plain.used() {
            // Heights from other taps: 8 bits interpolated in f32.
            assert!(
                made.positions[v].distance(plain.positions[v]) < 1e-6,
                "{name} at {}",
                plain.positions[v]
            );
            assert!(degrees(made.normals[v], plain.normals[v]) < 0.01, "{name} at {}", plain.positions[v]);
        }
    }
    // Sheared: the picture itself is drawn for the shear.
    let sheared = picture([256, 256], |u, v| hill(u - v, v));
    let made = displaced(&gpu, &Subject::new(quad(|uv| uv + Vec2::X * uv.y), sheared, 0.1), 0.05);
    for v in plain.used() {
        // Another picture of the same hill: codes of 0.1 m / 255, slopes of two of them over 1/64 m.
        assert!(made.positions[v].distance(plain.positions[v]) < 1e-3, "at {}", plain.positions[v]);
        assert!(degrees(made.normals[v], plain.normals[v]) < 1.5, "at {}", plain.positions[v]);
    }
}

#[test]
fn the_tangent_follows_the_surface_and_keeps_its_side() {
    let gpu = gpu();
    let mut geometry = quad(|uv| uv);
    geometry.tangents.iter_mut().for_each(|t| *t = Vec3::X.extend(-1.0));
    let made = displaced(&gpu, &Subject::new(geometry, picture([64, 64], |u, _| u.min(1.0 - u)), 0.5), 0.05);
    let mut tilted = 0;
    for v in made.used() {
        assert_eq!(made.tangents[v].w, -1.0);
        // A slope of 1/2 along x: the tangent climbs it, and b stays y.
        let tangent = made.tangents[v].truncate();
        assert!(tangent.y.abs() < 1e-3, "{tangent}");
        tilted += usize::from((tangent.z.abs() - 0.4472).abs() < 0.01);
    }
    assert!(tilted > made.used().len() / 2, "{tilted} of {} on the slopes", made.used().len());
}

#[test]
fn a_neighbour_without_a_map_stays_flat_and_joined() {
    let gpu = gpu();
    let mut geometry = cube(1.0, 2);
    // One side of six has no map.
    for triangle in &mut geometry.triangles[..8] {
        triangle.material = 1;
    }
    let made = displaced(&gpu, &Subject::new(geometry, picture([4, 4], |_, _| 1.0), 0.1), 0.15);
    assert_eq!(made.open_edges(), 0);
    for t in made.triangles.iter().filter(|t| t[3] & 0xffff == 1) {
        for v in &t[..3] {
            assert_eq!(made.positions[*v as usize].z, 0.5, "the flat side moved");
        }
    }
}

#[test]
fn hard_cases_crack_nothing_and_turn_nothing() {
    let gpu = gpu();
    let mut degenerate = ball(1.0, [12, 7]);
    degenerate.uv0.iter_mut().for_each(|uv| *uv = Vec2::splat(0.3));
    let mut one_line = cube(1.0, 3);
    one_line.uv0.iter_mut().for_each(|uv| uv.y = 0.0);
    let mut some = cube(1.0, 3);
    some.uv0[..16].iter_mut().for_each(|uv| *uv = Vec2::ZERO);
    let mut wild = cube(1.0, 3);
    wild.uv0.iter_mut().for_each(|uv| *uv = 1000.0 * *uv - 500.25);
    let mut opposed = ball(1.0, [12, 7]);
    opposed.normals.iter_mut().step_by(3).for_each(|n| *n = -*n);
    let cases = [
        ("coordinates at one point", degenerate, 0.1),
        ("coordinates on one line", one_line, 0.1),
        ("coordinates at one point on one side", some, 0.02),
        ("coordinates far away", wild, 0.02),
        ("over-steep heights", cube(1.0, 3), 0.3),
        ("heights beyond the centre", ball(1.0, [12, 7]), -3.0),
        ("opposed normals", opposed, 0.05),
    ];
    for (what, geometry, scale) in cases {
        let made = displaced(&gpu, &Subject::new(geometry, noise(16), scale), 0.1);
        assert!(!made.triangles.is_empty(), "{what}");
        assert_eq!(made.open_edges(), 0, "{what}");
        if what != "opposed normals" {
            made.check_frames(what);
        }
        assert!(
            made.used().iter().all(|&v| made.positions[v].is_finite() && made.normals[v].is_finite()),
            "{what}"
        );
    }
}

#[test]
fn where_a_map_says_nothing_a_mesh_stays_as_it_was() {
    let gpu = gpu();
    let mut geometry = cube(1.0, 3);
    geometry.uv0.iter_mut().for_each(|uv| *uv = Vec2::ZERO);
    let subject = Subject::new(geometry, picture([4, 4], |_, _| 1.0), 1.0);
    let made = displaced(&gpu, &subject, 0.1);
    assert_eq!(made.triangles.len(), subject.geometry.triangles.len());
    assert!(made.used().iter().all(|&v| made.positions[v].abs().max_element() <= 0.5));
}

#[test]
fn frames_stay_where_a_normal_map_tells_the_relief() {
    let gpu = gpu();
    let mut subject = Subject::new(quad(|uv| uv), noise(16), 0.1);
    subject.material.normal_texture = subject.material.height.map(|h| TextureSlot { ..h.texture });
    let tilted = |made: &Made| made.used().iter().filter(|&&v| made.normals[v].z < 0.999).count();
    let run_with = |value: &str, subject: &Subject| {
        let mut tessellator = Displace::new(&gpu).unwrap();
        set_knob(&mut tessellator.knobs(), "frames", value).unwrap();
        run(&gpu, &mut tessellator, subject, 0.1).0
    };
    assert_eq!(tilted(&run_with("auto", &subject)), 0);
    assert!(tilted(&run_with("rebuilt", &subject)) > 20);
    subject.material.normal_texture = None;
    assert!(tilted(&run_with("auto", &subject)) > 20);
    assert_eq!(tilted(&run_with("kept", &subject)), 0);
}

#[test]
fn normals_alone_move_nothing() {
    let gpu = gpu();
    let mut tessellator = Displace::new(&gpu).unwrap();
    set_knob(&mut tessellator.knobs(), "relief", "normals").unwrap();
    let (made, _) = run(&gpu, &mut tessellator, &Subject::new(quad(|uv| uv), noise(16), 0.1), 0.1);
    assert!(made.used().iter().all(|&v| made.positions[v].z == 0.0));
    assert!(made.used().iter().any(|&v| made.normals[v].z < 0.9));
}

#[test]
fn what_moves_knows_where_it_was() {
    let gpu = gpu();
    let mut subject = Subject::new(cube(1.0, 2), noise(16), 0.05);
    subject.geometry.objects[0].moving = true;
    let mut scene = subject.upload(&gpu);
    let mut tessellator = Displace::new(&gpu).unwrap();
    let mut before: Option<Made> = None;
    for step in 0..3 {
        let turn = Quat::from_rotation_y(0.2 * step as f32);
        let mut posed = subject.geometry.clone();
        posed.positions.iter_mut().for_each(|p| *p = turn * *p + Vec3::X * step as f32);
        posed.normals.iter_mut().for_each(|n| *n = turn * *n);
        posed.tangents.iter_mut().for_each(|t| *t = (turn * t.truncate()).extend(t.w));
        if step > 0 {
            scene.update(&gpu, &posed);
        }
        let mut recorder = Recorder::new(&gpu);
        let mesh = tessellator.tessellate(&mut recorder, &frame(&subject.geometry), 0.1, &scene);
        let log = recorder.finish().unwrap();
        let made = Made::read(&gpu, &mesh);
        assert_eq!(made.static_triangles, 0);
        assert_eq!(made.open_edges(), 0, "after {step} steps");
        let is_topology_made = log.passes.iter().any(|pass| pass.name.ends_with("/factor"));
        assert_eq!(is_topology_made, step == 0, "factors are those of the first moment");
        let was = before.as_ref().map_or(&made.positions, |before| &before.positions);
        for v in made.used() {
            // The same positions by another kernel: a few units in the last place of about 3 m.
            assert!(
                made.previous[v].distance(was[v]) < 2e-6,
                "step {step}: {} was {}",
                made.previous[v],
                was[v]
            );
        }
        before = Some(made);
    }
}

#[test]
fn with_the_screen_what_is_far_is_coarser() {
    let gpu = gpu();
    let mut geometry = Geometry::default();
    sheet(
        &mut geometry,
        [4, 40],
        |s, t| (Vec3::new(s, 0.0, -40.0 * t), Vec3::Y),
        |s, t| Vec2::new(s, 40.0 * t),
    );
    let subject = Subject::new(geometry, noise(16), 0.05);
    let mut tessellator = Displace::new(&gpu).unwrap();
    let (all, _) = run(&gpu, &mut tessellator, &subject, 0.05);
    set_knob(&mut tessellator.knobs(), "screen", "on").unwrap();
    let (near, _) = run(&gpu, &mut tessellator, &subject, 0.05);
    assert!(
        near.triangles.len() < all.triangles.len() / 2,
        "{} of {}",
        near.triangles.len(),
        all.triangles.len()
    );
    assert_eq!(near.static_triangles, 0);
    assert_eq!(all.static_triangles as usize, all.triangles.len());
}

#[test]
fn a_step_too_fine_for_memory_grows() {
    let gpu = gpu();
    let mut subject = Subject::new(cube(1.0, 24), picture([4, 4], |_, _| 1.0), 0.01);
    subject.material = Material { ..subject.material };
    // Factors of 64 would be 28 million triangles.
    let (made, _) = run(&gpu, &mut Displace::new(&gpu).unwrap(), &subject, 1e-5);
    assert!(made.triangles.len() > 2_000_000 && made.triangles.len() <= 1 << 24, "{}", made.triangles.len());
}
