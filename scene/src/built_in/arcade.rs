//! Columns and the wall of round arches that they carry.

use super::part::Part;
use glam::{Vec2, Vec3};
use std::f32::consts::PI;

/// Height of a column: the impost, where arches spring.
pub(super) const IMPOST_M: f32 = 2.2;
/// Middle of one column to the middle of the next.
pub(super) const BAY_M: f32 = 2.4;
/// Bottom of the arches' wall to its top.
pub(super) const WALL_M: f32 = 1.3;
/// Front of the arches' wall to its back.
pub(super) const DEPTH_M: f32 = 0.4;
/// Of the round arches.
const RADIUS_M: f32 = 0.95;
/// Straight pieces of one arch.
const PIECES: u32 = 24;

/// A column that stands on `foot`: plinth, base, shaft, capital, abacus.
pub(super) fn column(part: &mut Part, foot: Vec3) {
    const SEGMENTS: u32 = 24;
    let slab = |part: &mut Part, low: f32, high: f32, width: f32| {
        part.block(foot + Vec3::Y * (0.5 * (low + high)), Vec3::new(width, high - low, width), 0.0);
    };
    slab(part, 0.0, 0.14, 0.5);
    part.turned(foot, [SEGMENTS, 6], |t| Vec2::new(0.18 + 0.05 * (PI * t).sin(), 0.14 + 0.12 * t));
    part.turned(foot, [SEGMENTS, 8], |t| Vec2::new(0.18 - 0.025 * t * t, 0.26 + 1.58 * t));
    part.turned(foot, [SEGMENTS, 6], |t| Vec2::new(0.155 + 0.085 * t * t, 1.84 + 0.24 * t));
    slab(part, 2.08, IMPOST_M, 0.5);
}

/// A wall of `bays` arches from `start` (at the impost, middle of its depth) along the unit vector `along`; seen from
/// its front, `along` points to the right. Its two ends are left open: they meet other walls.
pub(super) fn arches(part: &mut Part, start: Vec3, along: Vec3, bays: u16) {
    let front = along.cross(Vec3::Y);
    let at = |x: f32, y: f32, side: f32| start + x * along + y * Vec3::Y + (0.5 * DEPTH_M * side) * front;
    let repeats = part.repeats_per_m;
    // A stretch of both faces between x0 and x1, from the given heights up to the top.
    let faces = |part: &mut Part, [x0, y0]: [f32; 2], [x1, y1]: [f32; 2]| {
        part.quad_along(along, [at(x0, y0, 1.0), at(x1, y1, 1.0), at(x1, WALL_M, 1.0), at(x0, WALL_M, 1.0)]);
        part.quad_along(
            -along,
            [at(x1, y1, -1.0), at(x0, y0, -1.0), at(x0, WALL_M, -1.0), at(x1, WALL_M, -1.0)],
        );
    };
    for bay in 0..bays {
        let left = f32::from(bay) * BAY_M;
        let middle = left + 0.5 * BAY_M;
        let arch = |t: f32| [middle - RADIUS_M * (PI * t).cos(), RADIUS_M * (PI * t).sin()];
        for [x0, x1] in [[left, middle - RADIUS_M], [middle + RADIUS_M, left + BAY_M]] {
            faces(part, [x0, 0.0], [x1, 0.0]);
            part.quad([at(x0, 0.0, -1.0), at(x1, 0.0, -1.0), at(x1, 0.0, 1.0), at(x0, 0.0, 1.0)]);
        }
        for piece in 0..PIECES {
            let [from, to] = [piece, piece + 1].map(|end| arch(end as f32 / PIECES as f32));
            faces(part, from, to);
        }
        // The inside of the arch: s from front to back, t from left to right over the crown.
        part.patch([2, PIECES], repeats * Vec2::new(DEPTH_M, PI * RADIUS_M), |s, t| {
            let [x, y] = arch(t);
            let inward = (middle - x) * along - y * Vec3::Y;
            [at(x, y, 1.0 - 2.0 * s), inward.normalize(), -front]
        });
    }
    let end = f32::from(bays) * BAY_M;
    part.quad([at(0.0, WALL_M, 1.0), at(end, WALL_M, 1.0), at(end, WALL_M, -1.0), at(0.0, WALL_M, -1.0)]);
}
