//! How much light leaks through closed walls of one, two and three voxels.
//!
//! In: nothing but a device and the voxels' settings; the boxes are [`scene::built_in::sealed`]'s, turned at random but
//! always alike. Out: per thickness the mean radiance that paths find inside, seen from the centre, over that of the lit
//! box from outside. A wall of one voxel holds both its sides in one or two layers of cells, and paths that start one
//! elevation off a corner may start within the other wall and leave it on the far side; thicker walls stop them.

use super::plain;
use crate::pipeline::Pipeline;
use crate::settings::View;
use crate::{Error, Progress, RenderSettings};
use frame::Gpu;
use frame::surface::hash;
use glam::Quat;
use scene::built_in::sealed::{GRID, MOST_TURNS, WALLS, sealed_boxes};

/// Pixels a side.
const SIZE: u32 = 32;

/// Radiance inside over outside, for each of [`WALLS`].
///
/// # Errors
/// The device was lost or is out of memory.
pub fn run(gpu: &Gpu, settings: &RenderSettings) -> Result<[f64; WALLS.len()], Error> {
    let turns: Vec<Quat> = (0..MOST_TURNS as u32).map(turn).collect();
    let base = RenderSettings {
        tessellator: "identity".into(),
        trace_size: [SIZE; 2],
        display_size: [SIZE; 2],
        grid: GRID,
        view: View::Camera(0),
        bounces: Some(3),
        moving_share: None,
        time: 0.0,
        ..plain(settings, "voxel")
    };
    let mut pipeline = Pipeline::of_scene(gpu.clone(), sealed_boxes(&turns), &base, Progress::default())?;
    let mut leaked = [0.0; WALLS.len()];
    for (row, leaked) in leaked.iter_mut().enumerate() {
        let mut sums = [0.0; 2];
        for column in 0..turns.len() {
            for (place, sum) in sums.iter_mut().enumerate() {
                let camera = 2 * (row * turns.len() + column) + place;
                let settings = RenderSettings { view: View::Camera(camera), ..base.clone() };
                *sum += super::luminance_of(&mut pipeline, &settings)?;
            }
        }
        *leaked = if sums[1] > 0.0 { sums[0] / sums[1] } else { 0.0 };
    }
    Ok(leaked)
}

/// A rotation, uniform over all of them (Shoemake 1992).
fn turn(index: u32) -> Quat {
    let random = |k: u32| hash(3 * index + k) as f32 * (1.0 / 4_294_967_296.0);
    let (u, [a, b]) = (random(0), [1, 2].map(|k| std::f32::consts::TAU * random(k)));
    let (inner, outer) = ((1.0 - u).max(0.0).sqrt(), u.sqrt());
    Quat::from_xyzw(inner * a.sin(), inner * a.cos(), outer * b.sin(), outer * b.cos()).normalize()
}
