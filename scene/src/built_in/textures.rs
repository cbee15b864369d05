//! Pictures painted by code: wood, stone, bricks, checks. All repeat without a seam.
//!
//! A painter is a function of (u, v) in the unit square, v down, that gives 8-bit picture values as 0..1: sRGB for
//! colours, linear for heights. Randomness is an integer hash, so the same picture comes out everywhere.

use crate::Image;
use glam::{FloatExt, Vec3};
use std::f32::consts::TAU;

/// Floor boards, 16 across u, each with one joint along v and its own tint.
pub(super) fn planks() -> Image {
    const BOARDS: f32 = 16.0;
    paint("planks", 512, |u, v| {
        let board = (u * BOARDS) as u32;
        let across = (u * BOARDS).fract();
        let along = (v + chance(board, 0, 1)).fract();
        // Fine streaks along the board, and rings whose centre wanders.
        let streaks = noise([u, v], [256, 8], 2);
        let wander = noise([u, v], [16, 4], 3);
        let rings = 0.5 + 0.5 * (TAU * (2.0 * across + 3.0 * wander + chance(board, 1, 1))).sin();
        let wood =
            Vec3::new(0.40, 0.25, 0.15).lerp(Vec3::new(0.66, 0.46, 0.29), 0.55 * rings + 0.45 * streaks);
        let tint = Vec3::new(1.0, 0.97, 0.92).lerp(Vec3::new(0.72, 0.70, 0.72), chance(board, 2, 1));
        // A board is 32 texels wide and 512 long: gaps of one texel and a half on either side, joints of three.
        let gap = across.min(1.0 - across) < 0.05 || along.min(1.0 - along) < 0.003;
        wood * tint * if gap { 0.35 } else { 1.0 }
    })
}

/// Squared stone in 8 courses of 4, every other course shifted by half a block.
pub(super) fn ashlar() -> Image {
    paint("ashlar", 512, |u, v| {
        let Block { id, edge } = block([u, v], [4, 8]);
        let grain = clouds([u, v], 8, 5);
        let tint = Vec3::new(0.80, 0.75, 0.66).lerp(Vec3::new(0.70, 0.68, 0.65), chance(id, 0, 6));
        let stone = tint * (0.80 + 0.10 * chance(id, 1, 6) + 0.22 * grain);
        stone.lerp(Vec3::new(0.60, 0.57, 0.52) * (0.8 + 0.2 * grain), 1.0 - smoothstep(0.02, 0.035, edge))
    })
}

/// Smooth pale stone with soft veins.
pub(super) fn limestone() -> Image {
    paint("limestone", 256, |u, v| {
        let veins = (clouds([u, v], 4, 8) - 0.5).abs();
        let grain = clouds([u, v], 16, 9);
        Vec3::new(0.86, 0.82, 0.75) * (0.84 + 0.5 * veins.min(0.16) + 0.12 * grain)
    })
}

/// Bricks in 8 courses of 4: their colours, and how high they stand (0 in the mortar, up to 1).
pub(super) fn bricks() -> [Image; 2] {
    let color = paint("bricks", 512, |u, v| {
        let Block { id, edge } = block([u, v], [4, 8]);
        let grain = clouds([u, v], 16, 11);
        let clay = Vec3::new(0.62, 0.30, 0.22).lerp(Vec3::new(0.48, 0.26, 0.22), chance(id, 0, 12));
        let mortar = Vec3::new(0.66, 0.63, 0.58);
        mortar.lerp(clay, smoothstep(0.03, 0.05, edge)) * (0.8 + 0.3 * grain)
    });
    let height = paint("bricks_height", 512, |u, v| {
        let Block { id, edge } = block([u, v], [4, 8]);
        let stand = 0.75 + 0.2 * chance(id, 1, 12);
        Vec3::splat(smoothstep(0.03, 0.09, edge) * (stand - 0.15 * clouds([u, v], 16, 11)))
    });
    [color, height]
}

/// Two by two squares, white (0.75 linear) and dark (0.12).
pub(super) fn checks() -> Image {
    // sRGB codes of the two reflectances.
    paint("checks", 64, |u, v| Vec3::splat(if (u < 0.5) == (v < 0.5) { 0.8808 } else { 0.3813 }))
}

fn paint(name: &str, size: u16, at: impl Fn(f32, f32) -> Vec3) -> Image {
    let centre = |i: u16| (f32::from(i) + 0.5) / f32::from(size);
    let texel = |column, row| {
        let color = (at(centre(column), centre(row)).clamp(Vec3::ZERO, Vec3::ONE) * 255.0).round();
        [color.x as u8, color.y as u8, color.z as u8, 255]
    };
    let rgba = (0..size).flat_map(|row| (0..size).map(move |column| (column, row)));
    Image {
        name: name.into(),
        width: size.into(),
        height: size.into(),
        rgba: rgba.map(|(column, row)| texel(column, row)).collect(),
    }
}

/// Where a point lies in a bond of blocks.
struct Block {
    /// Which block.
    id: u32,
    /// Distance to the block's nearest edge, in heights of a course.
    edge: f32,
}

fn block([u, v]: [f32; 2], [across, courses]: [u32; 2]) -> Block {
    let course = (v * courses as f32) as u32;
    let x = u * across as f32 + if course.is_multiple_of(2) { 0.0 } else { 0.5 };
    let (along, up) = (x.fract(), (v * courses as f32).fract());
    let width = courses as f32 / across as f32;
    let edge = (along.min(1.0 - along) * width).min(up.min(1.0 - up));
    Block { id: course * across + x as u32 % across, edge }
}

/// Four octaves of [`noise`], 0..1.
fn clouds(at: [f32; 2], cells: u32, seed: u32) -> f32 {
    let octave = |k: u32| noise(at, [cells << k; 2], seed + 31 * k) / (1u32 << k) as f32;
    (octave(0) + octave(1) + octave(2) + octave(3)) / 1.875
}

/// Smooth value noise on a lattice of `cells` that repeats over the unit square, 0..1.
fn noise([u, v]: [f32; 2], [columns, rows]: [u32; 2], seed: u32) -> f32 {
    let (x, y) = (u * columns as f32, v * rows as f32);
    let (i, j) = (x as u32, y as u32);
    let corner = |di: u32, dj: u32| chance((i + di) % columns, (j + dj) % rows, seed);
    let (s, t) = (smoothstep(0.0, 1.0, x.fract()), smoothstep(0.0, 1.0, y.fract()));
    corner(0, 0).lerp(corner(1, 0), s).lerp(corner(0, 1).lerp(corner(1, 1), s), t)
}

/// A number in 0..1 that depends on nothing but its arguments.
fn chance(x: u32, y: u32, seed: u32) -> f32 {
    let mut h = x.wrapping_mul(0x9e37_79b9) ^ y.wrapping_mul(0x85eb_ca6b) ^ seed.wrapping_mul(0xc2b2_ae35);
    for _ in 0..2 {
        h = (h ^ (h >> 16)).wrapping_mul(0x7feb_352d);
        h = (h ^ (h >> 15)).wrapping_mul(0x846c_a68b);
    }
    ((h ^ (h >> 16)) >> 8) as f32 / 16_777_216.0
}

/// The cubic step from 0 at `low` to 1 at `high`.
fn smoothstep(low: f32, high: f32, x: f32) -> f32 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
