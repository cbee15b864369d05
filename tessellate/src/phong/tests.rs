//! Rounder than before, and flat where it was flat.
#![allow(clippy::unwrap_used, clippy::panic)]

use super::Phong;
use crate::tests::{Subject, ball, cube, gpu, noise, run};

#[test]
fn a_ball_becomes_rounder() {
    let gpu = gpu();
    let subject = Subject::new(ball(1.0, [16, 8]), noise(4), 0.0);
    let (made, _) = run(&gpu, &mut Phong::new(&gpu).unwrap(), &subject, 0.05);
    let least = |points: Vec<glam::Vec3>| points.iter().map(|p| p.length()).fold(f32::INFINITY, f32::min);
    let middles = |t: &[u32; 4]| (0..3).map(|k| made.positions[t[k] as usize]).sum::<glam::Vec3>() / 3.0;
    let after = least(made.triangles.iter().map(middles).collect());
    let corners = subject.geometry.triangles.iter().map(|t| subject.geometry.corners(t));
    let before = least(corners.map(|c| c.into_iter().sum::<glam::Vec3>() / 3.0).collect());
    // Three quarters of the way to the tangent planes: a chord's sagitta shrinks to about a quarter.
    assert!(1.0 - after < 0.4 * (1.0 - before), "{after} after, {before} before");
}

#[test]
fn a_box_stays_the_same_triangles() {
    let gpu = gpu();
    let subject = Subject::new(cube(1.0, 3), noise(4), 0.0);
    let (made, log) = run(&gpu, &mut Phong::new(&gpu).unwrap(), &subject, 0.05);
    assert_eq!(made.triangles.len(), subject.geometry.triangles.len());
    assert!(log.passes.is_empty(), "nothing is curved, nothing runs");
}
