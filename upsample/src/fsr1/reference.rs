//! The CPU half of `easu.wgsl` and `rcas.wgsl`, in f32 like the shaders, on pictures of linear radiance.

use frame::cpu::Image;
use glam::{IVec2, UVec2, Vec2, Vec3};

const LOBE_MOST: f32 = 0.1875;

fn mapped(color: Vec3, scale: f32) -> Vec3 {
    let c = color.max(Vec3::ZERO);
    c / (scale + c.max_element())
}

fn unmapped(mapped: Vec3, scale: f32) -> Vec3 {
    let c = mapped.clamp(Vec3::ZERO, Vec3::ONE);
    c * scale / (1.0 - c.max_element()).max(1e-5)
}

/// The tone-mapped pixel, that of the border outside.
fn load(picture: &Image<[f32; 4]>, p: IVec2, scale: f32) -> Vec3 {
    let q = p.clamp(IVec2::ZERO, UVec2::from(picture.size()).as_ivec2() - 1);
    let [r, g, b, _] = picture.get(q.x, q.y).unwrap_or_default();
    mapped(Vec3::new(r, g, b), scale)
}

fn luma(c: Vec3) -> f32 {
    c.y + 0.5 * (c.x + c.z)
}

/// Slope along an axis and how monotonic it is.
fn axis(low: f32, centre: f32, high: f32) -> (f32, f32) {
    let slope = high - low;
    let steepest = (high - centre).abs().max((centre - low).abs());
    let ratio = (slope.abs() / steepest.max(1e-8)).clamp(0.0, 1.0);
    (slope, ratio * ratio)
}

/// The twelve, row by row, from the pixel up and left of the place.
const TAPS: [[i32; 2]; 12] =
    [[0, -1], [1, -1], [-1, 0], [0, 0], [1, 0], [2, 0], [-1, 1], [0, 1], [1, 1], [2, 1], [0, 2], [1, 2]];

/// EASU: `picture` enlarged to `display_size`, `scale` the scene's `radiance_scale`.
pub fn easu(picture: &Image<[f32; 4]>, display_size: [u32; 2], scale: f32) -> Image<[f32; 4]> {
    let size = |size: [u32; 2]| UVec2::from(size).as_vec2();
    Image::from_fn(display_size, |x, y| {
        let pixel = UVec2::new(x, y).as_vec2();
        let place = (pixel + 0.5) * size(picture.size()) / size(display_size) - 0.5;
        let (at, part) = (place.floor().as_ivec2(), place - place.floor());
        let colors = TAPS.map(|step| load(picture, at + IVec2::from(step), scale));
        let l = colors.map(luma);
        // Share; up, left, centre, right, down of f, g, j, k.
        let crosses = [
            ((1.0 - part.x) * (1.0 - part.y), [0, 2, 3, 4, 7]),
            (part.x * (1.0 - part.y), [1, 3, 4, 5, 8]),
            ((1.0 - part.x) * part.y, [3, 6, 7, 8, 10]),
            (part.x * part.y, [4, 7, 8, 9, 11]),
        ];
        let (mut direction, mut strength) = (Vec2::ZERO, 0.0);
        for (share, [up, left, centre, right, down]) in crosses {
            let (slope_x, along_x) = axis(l[left], l[centre], l[right]);
            let (slope_y, along_y) = axis(l[up], l[centre], l[down]);
            direction += share * Vec2::new(slope_x, slope_y);
            strength += share * (along_x + along_y);
        }
        let length_2 = direction.length_squared();
        let direction = if length_2 >= 1.0 / 32768.0 { direction / length_2.sqrt() } else { Vec2::X };
        let straight = 0.25 * strength * strength;
        let diagonal = 1.0 / direction.abs().max_element();
        let stretch = Vec2::new(1.0 + (diagonal - 1.0) * straight, 1.0 - 0.5 * straight);
        let lobe = 0.5 - 0.29 * straight;
        let (mut sum, mut total) = (Vec3::ZERO, 0.0);
        for (step, color) in TAPS.iter().zip(colors) {
            let away = IVec2::from(*step).as_vec2() - part;
            let turned = Vec2::new(away.dot(direction), away.dot(direction.perp())) * stretch;
            let d2 = turned.length_squared().min(1.0 / lobe);
            let (base, window) = (0.4 * d2 - 1.0, lobe * d2 - 1.0);
            let weight = (1.5625 * base * base - 0.5625) * window * window;
            sum += weight * color;
            total += weight;
        }
        let nearest = [3, 4, 7, 8].map(|i: usize| colors[i]);
        let least = nearest.into_iter().fold(Vec3::INFINITY, Vec3::min);
        let most = nearest.into_iter().fold(Vec3::NEG_INFINITY, Vec3::max);
        unmapped((sum / total.max(1e-6)).clamp(least, most), scale).extend(1.0).to_array()
    })
}

/// RCAS: `picture` sharpened.
pub fn rcas(picture: &Image<[f32; 4]>, strength: f32, scale: f32) -> Image<[f32; 4]> {
    Image::from_fn(picture.size(), |x, y| {
        let p = UVec2::new(x, y).as_ivec2();
        let centre = load(picture, p, scale);
        let around =
            [IVec2::NEG_Y, IVec2::NEG_X, IVec2::X, IVec2::Y].map(|step| load(picture, p + step, scale));
        let least = around.into_iter().fold(Vec3::INFINITY, Vec3::min);
        let most = around.into_iter().fold(Vec3::NEG_INFINITY, Vec3::max);
        let to_black = least.min(centre) / (4.0 * most).max(Vec3::splat(1e-6));
        let to_white = (1.0 - most.max(centre)) / (4.0 - 4.0 * least).max(Vec3::splat(1e-6));
        let lobe = -strength * to_black.min(to_white).min_element().clamp(0.0, LOBE_MOST);
        let sharpened = (centre + lobe * around.into_iter().sum::<Vec3>()) / (1.0 + 4.0 * lobe);
        unmapped(sharpened, scale).extend(1.0).to_array()
    })
}
