//! How a picture is seen: contrast sensitivity, uniform colour, edges and points.
//!
//! In: linear colour of 0..1. The opponent channels Y, Cx, Cz are filtered by sums of Gaussians
//! `a sqrt(pi / b) exp(-pi^2 x^2 / b)`, x in degrees, whose widths are the eye's; the result goes to CIELAB with the Hunt
//! effect. Edges and points are the lengths of the gradient and of the second derivatives along x and y of luminance
//! under a Gaussian of 0.082 degrees (six standard deviations, HPG 2020, section 3.2).
//!
//! All filters are a row times a column (Cz is a sum of two such), as the authors' own implementation has it.

use super::super::separable::{both, columns, rows};
use super::color::{Spaces, hyab, relative_luminance};
use frame::cpu::Image;
use glam::Vec3;
use std::f32::consts::PI;

/// (a, b) of each channel's Gaussians: HPG 2020, table 1.
const Y: (f32, f32) = (1.0, 0.0047);
const CX: (f32, f32) = (1.0, 0.0053);
const CZ: [(f32, f32); 2] = [(34.1, 0.04), (13.5, 0.025)];
/// Width in degrees of what counts as an edge.
const FEATURE_WIDTH: f32 = 0.082;
/// Exponent that makes large colour differences count less.
const COLOR_EXPONENT: f32 = 0.7;
/// The share of the largest colour difference that [`REDISTRIBUTED`] of the scale is given to.
const SMALL_DIFFERENCES: f32 = 0.4;
const REDISTRIBUTED: f32 = 0.95;

/// An eye in front of a display: filters and scales.
pub(super) struct Eye {
    spaces: Spaces,
    y: Vec<f32>,
    cx: Vec<f32>,
    cz: [Vec<f32>; 2],
    /// A Gaussian and its first and second derivative.
    feature: [Vec<f32>; 3],
    /// Between the two colours of the display that are furthest apart.
    largest_difference: f32,
}

impl Eye {
    pub(super) fn new(pixels_per_degree: f32) -> Self {
        let spaces = Spaces::new();
        let [green, blue] = [Vec3::Y, Vec3::Z].map(|c| spaces.hunt_lab_from_linear(c));
        let [y, cx] = [Y, CX].map(|(_, b)| {
            let taps = gaussian(1.0, b, pixels_per_degree);
            let sum: f32 = taps.iter().sum();
            taps.into_iter().map(|weight| weight / sum).collect()
        });
        // As a filter of both axes each is weighed by a; along one by its root.
        let cz = CZ.map(|(a, b)| gaussian((a * (PI / b).sqrt()).sqrt(), b, pixels_per_degree));
        let sum = cz.iter().map(|taps| taps.iter().sum::<f32>().powi(2)).sum::<f32>().sqrt();
        Self {
            y,
            cx,
            cz: cz.map(|taps| taps.into_iter().map(|weight| weight / sum).collect()),
            feature: feature(0.5 * FEATURE_WIDTH * pixels_per_degree),
            largest_difference: hyab(green, blue).powf(COLOR_EXPONENT),
            spaces,
        }
    }

    /// Of two colours as seen, 0..1.
    pub(super) fn color_difference(&self, a: Vec3, b: Vec3) -> f32 {
        let difference = hyab(a, b).powf(COLOR_EXPONENT);
        let small = SMALL_DIFFERENCES * self.largest_difference;
        match difference < small {
            true => difference * REDISTRIBUTED / small,
            false => {
                let rest = (difference - small) / (self.largest_difference - small);
                REDISTRIBUTED + rest * (1.0 - REDISTRIBUTED)
            }
        }
    }
}

/// `scale exp(-pi^2 x^2 / b)`, three standard deviations of the widest to each side, less where it is 0 to f32.
fn gaussian(scale: f32, b: f32, pixels_per_degree: f32) -> Vec<f32> {
    let deviation = |b: f32| (b / 2.0).sqrt() / PI * pixels_per_degree;
    let (widest, own) = (3.0 * deviation(CZ[0].1), 6.5 * deviation(b));
    let radius = widest.ceil().min(own.ceil()) as i32;
    let weight = |x: i32| scale * (-(PI * x as f32 / pixels_per_degree).powi(2) / b).exp();
    (-radius..=radius).map(weight).collect()
}

/// A Gaussian of this many pixels that sums to 1, and its derivatives, whose negative and positive weights sum to -1, 1.
fn feature(deviation: f32) -> [Vec<f32>; 3] {
    let radius = (3.0 * deviation).ceil() as i32;
    let taps = |of: fn(f32) -> f32| -> Vec<f32> {
        let weight = |x: f32| of(x) * (-0.5 * x * x).exp();
        let raw: Vec<f32> = (-radius..=radius).map(|x| weight(x as f32 / deviation)).collect();
        let sum_of = |sign: f32| raw.iter().map(|w| (w * sign).max(0.0)).sum::<f32>();
        let [positive, negative] = [1.0, -1.0].map(sum_of);
        raw.iter()
            .map(|w| if *w > 0.0 { w / positive } else { w / negative.max(f32::MIN_POSITIVE) })
            .collect()
    };
    [taps(|_| 1.0), taps(|x| -x), taps(|x| x * x - 1.0)]
}

/// A picture as it is seen.
pub(super) struct Appearance {
    size: [u32; 2],
    lab: Vec<Vec3>,
    edges: Vec<f32>,
    points: Vec<f32>,
}

/// One pixel of it.
pub(super) struct Seen {
    /// CIELAB with the Hunt effect.
    pub lab: Vec3,
    pub edge: f32,
    pub point: f32,
}

impl Appearance {
    /// Of linear colour in 0..1.
    pub(super) fn of(picture: &Image<[f32; 3]>, eye: &Eye) -> Self {
        let width = picture.size()[0] as usize;
        let opponent = picture.map(|texel| eye.spaces.opponent_from_linear(texel.into()));
        let [y, cx, cz] =
            [0, 1, 2].map(|c: usize| opponent.texels().iter().map(|v| v[c]).collect::<Vec<f32>>());
        let luminance: Vec<f32> = y.iter().map(|y| relative_luminance(*y)).collect();
        let [edges, points] = features(&luminance, width, eye);

        let (y, cx) = (both(&y, width, &eye.y), both(&cx, width, &eye.cx));
        let [wide, narrow] = [0, 1].map(|i: usize| both(&cz, width, &eye.cz[i]));
        let filtered = y.into_iter().zip(cx).zip(wide.into_iter().zip(narrow));
        let lab = filtered.map(|((y, cx), (wide, narrow))| {
            let linear = eye.spaces.linear_from_opponent(Vec3::new(y, cx, wide + narrow));
            eye.spaces.hunt_lab_from_linear(linear.clamp(Vec3::ZERO, Vec3::ONE))
        });
        Self { size: picture.size(), lab: lab.collect(), edges, points }
    }

    pub(super) fn size(&self) -> [u32; 2] {
        self.size
    }

    pub(super) fn pixels(&self) -> impl Iterator<Item = Seen> {
        let features = self.edges.iter().zip(&self.points);
        self.lab.iter().zip(features).map(|(lab, (edge, point))| Seen {
            lab: *lab,
            edge: *edge,
            point: *point,
        })
    }
}

/// Lengths of the first and the second derivatives.
fn features(luminance: &[f32], width: usize, eye: &Eye) -> [Vec<f32>; 2] {
    let [smooth, first, second] = &eye.feature;
    let smooth_along_x = rows(luminance, width, smooth);
    [first, second].map(|derivative| {
        let along_x = columns(&rows(luminance, width, derivative), width, smooth);
        let along_y = columns(&smooth_along_x, width, derivative);
        along_x.into_iter().zip(along_y).map(|(x, y)| (x * x + y * y).sqrt()).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::super::PIXELS_PER_DEGREE;
    use super::*;

    #[test]
    fn filters_keep_constants_and_derivatives_ignore_them() {
        let eye = Eye::new(PIXELS_PER_DEGREE);
        let sum = |taps: &[f32]| taps.iter().sum::<f32>();
        // Two dozen roundings of f32.
        for one in
            [sum(&eye.y), sum(&eye.cx), sum(&eye.feature[0]), eye.cz.iter().map(|t| sum(t).powi(2)).sum()]
        {
            assert!((one - 1.0).abs() < 1e-6, "{one}");
        }
        assert!(sum(&eye.feature[1]).abs() < 1e-6 && sum(&eye.feature[2]).abs() < 1e-6);
        // Radii at 67 pixels per degree: 10 for the widest colour filter, 9 for features.
        assert_eq!([eye.cz[0].len(), eye.feature[0].len()], [21, 19]);
    }

    #[test]
    fn a_step_has_an_edge_of_its_height() {
        let eye = Eye::new(PIXELS_PER_DEGREE);
        let width = 40;
        let luminance: Vec<f32> =
            (0..width * width).map(|i| if i % width < 20 { 0.25 } else { 0.75 }).collect();
        let [edges, points] = features(&luminance, width, &eye);
        let row = 20 * width;
        // All positive weights, which sum to 1, lie on one side, all negative ones on the other; the middle one is 0.
        for edge in [edges[row + 19], edges[row + 20]] {
            assert!((edge - 0.5).abs() < 1e-6, "{edge}");
        }
        assert!(edges[row] < 1e-6 && points[row] < 1e-6, "{} {}", edges[row], points[row]);
        assert!(edges.iter().all(|e| *e <= 0.5 + 1e-6));
    }
}
