//! FLIP: the difference that a viewer sees who flips between reference and test in place.
//!
//! In: linear Rec. 709 radiance. Out: a map of 0 (alike) to 1, or its mean. For a display of p pixels per degree of
//! visual angle, both pictures are first seen (`appearance.rs`): filtered by what the eye resolves, in a space where
//! distances are visible differences, with edges and points picked out. Then per pixel
//!
//! ```text
//! dE_c = redistribute(HyAB(hunt(r), hunt(t))^0.7)                       colour, 0..1
//! dE_f = (max(|edge_r - edge_t|, |point_r - point_t|) / sqrt(2))^0.5    features, 0..1
//! FLIP = dE_c ^ (1 - dE_f)
//! ```
//!
//! **LDR-FLIP** ([`flip`], [`flip_map`]) takes the display picture: exposed, clamped to 0..1. (Its authors read files
//! through the sRGB curve and undo it first.) **HDR-FLIP** ([`hdr_flip`], [`hdr_flip_map`]) is the largest LDR-FLIP of
//! each pixel over a sweep of exposures that the *reference* decides ([`Exposures`]), tone-mapped by ACES.
//!
//! Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström, Fairchild, "FLIP: A Difference Evaluator for Alternating
//! Images", HPG 2020; Andersson, Nilsson, Shirley, Akenine-Möller, "Visualizing Errors in Rendered High Dynamic Range
//! Images", Eurographics 2021 (short). Written from the papers: the crate `nv-flip` builds C++ for over a minute and has
//! no HDR. Agrees with the authors' `flip-evaluator` 1.7 within 8e-6 in the mean on the eight pairs of the tests.
//!
//! Departs from it where it gives up: a reference whose median is black takes the median of what is lit, one that is
//! all black is looked at as it is; and where values overflow (radiance beyond 10^6 after exposure is white).

mod appearance;
mod color;
mod exposure;

pub use exposure::Exposures;

use super::display::emitted;
use super::{MetricError, comparable};
use appearance::{Appearance, Eye};
use frame::cpu::Image;
use std::num::NonZero;

/// Of the authors' viewer: 0.7 m from a display 0.7 m and 3840 pixels wide.
pub const PIXELS_PER_DEGREE: f32 = 3840.0 * std::f32::consts::PI / 180.0;

/// Mean LDR-FLIP of the display picture at an exposure in stops, at [`PIXELS_PER_DEGREE`].
///
/// # Errors
/// Sizes differ, or there are no pixels.
pub fn flip(
    reference: &Image<[f32; 3]>,
    test: &Image<[f32; 3]>,
    exposure_stops: f32,
) -> Result<f64, MetricError> {
    flip_map(reference, test, exposure_stops, PIXELS_PER_DEGREE).map(|map| mean(&map))
}

/// LDR-FLIP per pixel of the display picture at an exposure in stops, for a display of so many pixels per degree, more than 0.
///
/// # Errors
/// Sizes differ, or there are no pixels.
pub fn flip_map(
    reference: &Image<[f32; 3]>,
    test: &Image<[f32; 3]>,
    exposure_stops: f32,
    pixels_per_degree: f32,
) -> Result<Image<f32>, MetricError> {
    comparable(reference, test)?;
    let eye = Eye::new(pixels_per_degree);
    let [reference, test] = [reference, test].map(|p| Appearance::of(&emitted(p, exposure_stops), &eye));
    Ok(difference(&reference, &test, &eye))
}

/// Mean HDR-FLIP at [`PIXELS_PER_DEGREE`].
///
/// # Errors
/// Sizes differ, or there are no pixels.
pub fn hdr_flip(reference: &Image<[f32; 3]>, test: &Image<[f32; 3]>) -> Result<f64, MetricError> {
    hdr_flip_map(reference, test, PIXELS_PER_DEGREE).map(|map| mean(&map))
}

/// HDR-FLIP per pixel, for a display of so many pixels per degree, more than 0. Negative radiance is black.
///
/// # Errors
/// Sizes differ, or there are no pixels.
pub fn hdr_flip_map(
    reference: &Image<[f32; 3]>,
    test: &Image<[f32; 3]>,
    pixels_per_degree: f32,
) -> Result<Image<f32>, MetricError> {
    comparable(reference, test)?;
    let eye = Eye::new(pixels_per_degree);
    let stops: Vec<f32> = Exposures::of(reference).stops().collect();
    let workers = std::thread::available_parallelism().map_or(1, NonZero::get);
    // The largest over some of the exposures, on each core. The order does not matter to a maximum.
    let largest = |stops: &[f32]| {
        let maps = stops.iter().map(|stops| {
            let [r, t] = [reference, test].map(|p| Appearance::of(&exposure::tone_mapped(p, *stops), &eye));
            difference(&r, &t, &eye)
        });
        maps.fold(Image::filled(reference.size(), 0.0), |a, b| larger(&a, &b))
    };
    let per_worker = stops.len().div_ceil(workers).max(1);
    let maps = std::thread::scope(|scope| {
        let running: Vec<_> = stops.chunks(per_worker).map(|chunk| scope.spawn(|| largest(chunk))).collect();
        running.into_iter().map(|worker| worker.join()).collect::<Result<Vec<_>, _>>()
    });
    // A worker only computes; should it panic nonetheless, so does its caller.
    let maps = maps.unwrap_or_else(|panic| std::panic::resume_unwind(panic));
    Ok(maps.into_iter().fold(Image::filled(reference.size(), 0.0), |a, b| larger(&a, &b)))
}

fn larger(a: &Image<f32>, b: &Image<f32>) -> Image<f32> {
    let mut b = b.texels().iter();
    a.map(|a| b.next().map_or(a, |b| a.max(*b)))
}

fn mean(map: &Image<f32>) -> f64 {
    map.texels().iter().map(|v| f64::from(*v)).sum::<f64>() / map.texels().len() as f64
}

/// FLIP of each pixel of two pictures as they are seen.
fn difference(reference: &Appearance, test: &Appearance, eye: &Eye) -> Image<f32> {
    let mut pixels = reference.pixels().zip(test.pixels());
    // One pixel of each for every pixel, by construction of both.
    Image::from_fn(reference.size(), |_, _| {
        let Some((r, t)) = pixels.next() else { return 0.0 };
        let color = eye.color_difference(r.lab, t.lab);
        let feature = (r.edge - t.edge).abs().max((r.point - t.point).abs());
        let feature = (feature * std::f32::consts::FRAC_1_SQRT_2).sqrt();
        color.powf(1.0 - feature)
    })
}
