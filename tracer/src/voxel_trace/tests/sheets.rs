//! Voxels of one surface, and the rays that leave it.

use super::super::reference::CpuVoxels;
use super::fixture::{Model, at};
use crate::path::reference::{NO_OWN, Ray, Structure, Tally};
use frame::surface::{Surface, hash};
use glam::{IVec3, Vec3};

const SIZE: i32 = 60;
const MIDDLE: f32 = 30.1;

/// One voxel per column along the dominant axis of the normal, as rasterising leaves them: `solve` gives points of a
/// surface, with their normals, on a column's centre line.
fn rasterised(solve: impl Fn(usize, Vec3) -> Vec<(f32, Vec3)>) -> CpuVoxels {
    let mut model = Model::new(SIZE);
    for axis in 0..3 {
        for (u, v) in (0..SIZE).flat_map(|u| (0..SIZE).map(move |v| (u, v))) {
            let mut cell = IVec3::ZERO;
            (cell[(axis + 1) % 3], cell[(axis + 2) % 3]) = (u, v);
            for (depth, normal) in solve(axis, cell.as_vec3() + 0.5 - MIDDLE) {
                cell[axis] = (MIDDLE + depth).floor() as i32;
                let height = MIDDLE + depth - cell[axis] as f32 - 0.5;
                let is_dominant = normal[axis].abs() >= normal.abs().max_element() - 1e-6;
                if is_dominant && (0..SIZE).contains(&cell[axis]) {
                    let contour = normal[axis] * height;
                    model.set(cell, &Surface { normal, contour, ..Surface::default() });
                }
            }
        }
    }
    model.build()
}

fn ball(radius: f32) -> CpuVoxels {
    rasterised(|axis, mut p| {
        p[axis] = 0.0;
        let height_2 = radius * radius - p.length_squared();
        let heights = if height_2 < 0.0 { vec![] } else { vec![-height_2.sqrt(), height_2.sqrt()] };
        let point = |h: f32| {
            p[axis] = h;
            (h, p.normalize())
        };
        heights.into_iter().map(point).collect()
    })
}

fn plane(normal: Vec3) -> CpuVoxels {
    let n = normal.normalize();
    rasterised(|axis, mut p| {
        p[axis] = 0.0;
        if n[axis] == 0.0 { vec![] } else { vec![(-n.dot(p) / n[axis], n)] }
    })
}

/// A direction per counter, uniform.
fn direction(counter: &mut u32) -> Vec3 {
    let mut number = || {
        *counter += 1;
        (hash(*counter) >> 8) as f32 / 16_777_216.0
    };
    let z = 1.0 - 2.0 * number();
    let (sin, cos) = (std::f32::consts::TAU * number()).sin_cos();
    let radius = (1.0 - z * z).max(0.0).sqrt();
    Vec3::new(radius * cos, radius * sin, z)
}

/// Share of rays by the cosine about a voxel's normal that meet its own convex surface again.
fn met_again(voxels: &CpuVoxels) -> f64 {
    let (mut counter, mut tally) = (0, Tally::default());
    let middle = at(MIDDLE, MIDDLE, MIDDLE);
    let (mut all, mut met) = (0, 0);
    while all < 10_000 {
        let origin = middle + 24.0 * direction(&mut counter);
        let towards = (middle + 3.0 * direction(&mut counter) - origin).normalize();
        let ray = Ray { origin, direction: towards, distance: 1e3, own: NO_OWN };
        let Some(hit) = voxels.trace(&ray, &mut tally) else { continue };
        // Grazing rays may meet a ball's voxels from behind.
        if hit.surface.normal.dot(towards) > 0.0 {
            continue;
        }
        all += 1;
        let wi = (hit.face + direction(&mut counter)).normalize();
        let start = voxels.leave(origin + hit.distance * towards, &hit, wi);
        let ray = Ray { origin: start, direction: wi, distance: 1e3, own: hit.leaves(wi) };
        met += u32::from(voxels.trace(&ray, &mut tally).is_some());
    }
    f64::from(met) / f64::from(all)
}

#[test]
fn a_ray_leaves_the_sheet_it_starts_in() {
    let balls = [4.0, 8.0, 27.0].map(|radius| (format!("ball of {radius} voxels"), ball(radius)));
    let slopes = [Vec3::Y, Vec3::new(0.3, 1.0, 0.0), Vec3::new(0.7, 1.0, 0.4), Vec3::new(1.0, 1.0, 1.001)];
    let planes = slopes.map(|normal| (format!("plane {normal}"), plane(normal)));
    for (name, voxels) in balls.into_iter().chain(planes) {
        let met = met_again(&voxels);
        println!("{name}: {:.3} % meet it again", 100.0 * met);
        // On a ball of four voxels planes of cells two voxels apart are half a voxel off each other's points.
        assert!(met < 3e-3, "{name}: {met}");
    }
}
