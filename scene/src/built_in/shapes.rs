//! Shapes that built-in scenes are made of. Every front faces outward, or as its corners say.

use super::part::{Corner, Part};
use glam::{Quat, Vec2, Vec3};
use std::f32::consts::{PI, TAU};

impl Part {
    /// The same as [`Part::quad`], however thin.
    pub fn strip(&mut self, corners: [Vec3; 4]) {
        let first = self.positions.len() as u32;
        let triangles = self.triangles.len();
        self.quad(corners);
        self.triangles.truncate(triangles);
        self.triangles.extend([[0, 1, 2], [0, 2, 3]].map(|t: [u32; 3]| t.map(|v| first + v)));
    }

    /// A flat quadrilateral, corners counter-clockwise from the front; u runs along its first side.
    pub fn quad(&mut self, corners: [Vec3; 4]) {
        self.quad_along((corners[1] - corners[0]).normalize(), corners);
    }

    /// A flat quadrilateral, corners counter-clockwise from the front. Texture coordinates are metres along the unit
    /// vector `along`, which lies in its plane, and perpendicular to it, from the origin: neighbours in one plane
    /// continue each other.
    pub fn quad_along(&mut self, along: Vec3, corners: [Vec3; 4]) {
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
        let up = normal.cross(along);
        let repeats = self.repeats_per_m;
        let uvs = corners.map(|p| repeats * Vec2::new(p.dot(along), -p.dot(up)));
        let numbers = [0, 1, 2, 3].map(|i| {
            let (position, uv) = (corners[i], uvs[i]);
            self.corner(Corner { position, normal, along_u: along, uv, handedness: 1.0 })
        });
        self.pair(numbers);
    }

    /// A curved sheet over the unit square, `columns` by `rows` cells; the front is where cross(d/ds, d/dt)
    /// points. Texture coordinates run `repeats` times along s and, downward, along t.
    pub fn patch(&mut self, [columns, rows]: [u32; 2], repeats: Vec2, at: impl Fn(f32, f32) -> [Vec3; 3]) {
        let first = self.positions.len() as u32;
        for j in 0..=rows {
            for i in 0..=columns {
                let (s, t) = (i as f32 / columns as f32, j as f32 / rows as f32);
                let [position, normal, along_u] = at(s, t);
                let uv = repeats * Vec2::new(s, 1.0 - t);
                self.corner(Corner { position, normal, along_u, uv, handedness: 1.0 });
            }
        }
        for j in 0..rows {
            for i in 0..columns {
                let low = first + j * (columns + 1) + i;
                let high = low + columns + 1;
                self.pair([low, low + 1, high + 1, high]);
            }
        }
    }

    /// A [`Part::patch`] whose normals come from differences of `at`, which must be smooth and a little beyond the
    /// unit square too.
    pub fn sheet(&mut self, cells: [u32; 2], repeats: Vec2, at: impl Fn(f32, f32) -> Vec3) {
        // Of the unit square: far below a cell, and far above the rounding of positions of some metres.
        const STEP: f32 = 1.0 / 512.0;
        self.patch(cells, repeats, |s, t| {
            let along_s = at(s + STEP, t) - at(s - STEP, t);
            let along_t = at(s, t + STEP) - at(s, t - STEP);
            [at(s, t), along_s.cross(along_t).normalize_or(Vec3::Y), along_s]
        });
    }

    /// A ball, poles up and down.
    pub fn ball(&mut self, centre: Vec3, radius: f32, cells: [u32; 2]) {
        let repeats = self.repeats_per_m * radius * Vec2::new(TAU, PI);
        self.patch(cells, repeats, |s, t| {
            let (sin, cos) = (s * TAU).sin_cos();
            let (across, up) = ((t * PI).sin(), -(t * PI).cos());
            let normal = Vec3::new(across * cos, up, -across * sin).normalize();
            [centre + radius * normal, normal, Vec3::new(-sin, 0.0, -cos)]
        });
    }

    /// A curve of (radius, height), bottom to top, turned about the vertical through `foot`; open at both ends.
    pub fn turned(&mut self, foot: Vec3, cells: [u32; 2], curve: impl Fn(f32) -> Vec2) {
        let height = curve(1.0).y - curve(0.0).y;
        let repeats = self.repeats_per_m * Vec2::new(TAU * curve(0.5).x, height);
        self.sheet(cells, repeats, |s, t| {
            let (sin, cos) = (s * TAU).sin_cos();
            let Vec2 { x: radius, y: up } = curve(t);
            foot + Vec3::new(radius * cos, up, -radius * sin)
        });
    }

    /// A closed box of this size, turned about the vertical by `yaw` radians, counter-clockwise from above.
    pub fn block(&mut self, centre: Vec3, size: Vec3, yaw: f32) {
        let turn = Quat::from_rotation_y(yaw);
        let [x, y, z] =
            [Vec3::X * size.x, Vec3::Y * size.y, Vec3::Z * size.z].map(|side| turn * (0.5 * side));
        // Outward, to the right and up for an observer who faces that side; `right` x `up` = `out`.
        for (out, right, up) in [(x, -z, y), (-x, z, y), (z, x, y), (-z, -x, y), (y, x, -z), (-y, x, z)] {
            let middle = centre + out;
            self.quad([middle - right - up, middle + right - up, middle + right + up, middle - right + up]);
        }
    }

    /// A closed box between two corners.
    pub fn block_between(&mut self, low: Vec3, high: Vec3) {
        self.block(0.5 * (low + high), high - low, 0.0);
    }

    /// Two triangles over four vertices, counter-clockwise from the front.
    pub fn pair(&mut self, [a, b, c, d]: [u32; 4]) {
        self.triangle([a, b, c]);
        self.triangle([a, c, d]);
    }
}
