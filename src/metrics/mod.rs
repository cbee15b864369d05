//! How far a picture is from a reference: every error metric, on linear Rec. 709 radiance.
//!
//! In: the reference first, then the test, of one size and finite. With r, t a pixel-channel of reference and test, the
//! mean over all of them:
//!
//! | id | what | where |
//! | --- | --- | --- |
//! | `rmse` | `sqrt(mean((t - r)^2))` | [`rmse`] |
//! | `rel_mse` | `mean((t - r)^2 / (r^2 + 0.01))`, no exposure | [`rel_mse`] |
//! | `smape` | `mean(2 abs(t - r) / (abs(t) + abs(r) + 0.01))` | [`smape`] |
//! | `psnr` | decibels on the display picture; none for equal pictures | [`psnr`] |
//! | `ssim` | Wang et al. 2004 on the display picture, as scikit-image has it | [`ssim`] |
//! | `flip` | mean LDR-FLIP of the display picture | [`flip`] |
//! | `hdr_flip` | mean HDR-FLIP; "FLIP" without more words is this one | [`flip`] |
//! | `bias` | mean of the test over mean of the reference, per channel | [`bias`] |
//! | `worst_tile` | 99th percentile of `rel_mse` over tiles of 16x16 pixels | [`worst_tile`] |
//! | `nan_count`, `inf_count`, `negative_count` | pixel-channels of the test | [`Counts`] |
//!
//! Apart from these: [`excess_rel_mse`] where standard errors are known, [`Temporal`] and [`Recovery`] over sequences. The *display
//! picture* is radiance times 2^exposure, clamped to 0..1; PSNR and SSIM look at it through the sRGB curve. Sums are
//! f64, so figures do not depend on the size.
//!
//! **NaN and infinity** make every figure but the counts meaningless. [`Errors::between`] refuses such a picture with an
//! error that holds the counts, instead of leaving the worst pixels out.

mod display;
pub mod flip;
mod heat;
mod radiance;
mod recovery;
mod separable;
mod ssim;
mod temporal;

pub use display::psnr;
pub use heat::{magma, magma_color};
pub use radiance::{bias, excess_rel_mse, rel_mse, rmse, smape, worst_tile};
pub use recovery::Recovery;
pub use ssim::ssim;
pub use temporal::{Consecutive, Temporal, origin};

use frame::cpu::Image;
use serde::Serialize;
use std::fmt;

/// All figures about one picture, named as logs print them.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Errors {
    /// Root of the mean squared difference, W / (sr m^2).
    pub rmse: f64,
    /// Mean squared relative difference.
    pub rel_mse: f64,
    /// Symmetric mean absolute relative difference, 0..2.
    pub smape: f64,
    /// Peak signal to noise, decibels; none (`null`) where the display pictures are equal.
    pub psnr: Option<f64>,
    /// Structural similarity, at most 1; none (`null`) below 11 pixels a side.
    pub ssim: Option<f64>,
    /// LDR-FLIP, 0..1.
    pub flip: f64,
    /// HDR-FLIP, 0..1.
    pub hdr_flip: f64,
    /// Mean of test over mean of reference; none (`null`) for a channel that the reference has at 0.
    pub bias: [Option<f64>; 3],
    /// What only one tile of 16x16 pixels in a hundred exceeds, as `rel_mse`.
    pub worst_tile: f64,
    /// What of the test is no radiance; the first two are 0 here, for else there would be no figures.
    #[serde(flatten)]
    pub counts: Counts,
}

impl Errors {
    /// Every figure, at exposure 0.
    ///
    /// # Errors
    /// Sizes differ, a picture has no pixels, or one holds NaN or infinity.
    pub fn between(reference: &Image<[f32; 3]>, test: &Image<[f32; 3]>) -> Result<Self, MetricError> {
        Self::between_exposed(reference, test, 0.0)
    }

    /// Every figure, those of the display picture (`psnr`, `ssim`, `flip`) at an exposure in stops.
    ///
    /// # Errors
    /// As [`Self::between`].
    pub fn between_exposed(
        reference: &Image<[f32; 3]>,
        test: &Image<[f32; 3]>,
        exposure_stops: f32,
    ) -> Result<Self, MetricError> {
        comparable(reference, test)?;
        Counts::finite(Side::Reference, reference)?;
        let counts = Counts::finite(Side::Test, test)?;
        Ok(Self {
            rmse: rmse(reference, test)?,
            rel_mse: rel_mse(reference, test)?,
            smape: smape(reference, test)?,
            psnr: psnr(reference, test, exposure_stops)?,
            ssim: ssim(reference, test, exposure_stops)?,
            flip: flip::flip(reference, test, exposure_stops)?,
            hdr_flip: flip::hdr_flip(reference, test)?,
            bias: bias(reference, test)?,
            worst_tile: worst_tile(reference, test)?,
            counts,
        })
    }
}

/// Pixel-channels that hold no radiance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// Not a number.
    pub nan_count: u64,
    /// Infinite, of either sign.
    pub inf_count: u64,
    /// Below 0, minus infinity among them.
    pub negative_count: u64,
}

impl Counts {
    /// Counts them.
    pub fn of(picture: &Image<[f32; 3]>) -> Self {
        let count =
            |is: fn(f32) -> bool| picture.texels().iter().flatten().filter(|v| is(**v)).count() as u64;
        Self {
            nan_count: count(f32::is_nan),
            inf_count: count(f32::is_infinite),
            negative_count: count(|v| v < 0.0),
        }
    }

    /// Counts, and refuses what is not finite.
    fn finite(side: Side, picture: &Image<[f32; 3]>) -> Result<Self, MetricError> {
        let counts = Self::of(picture);
        let first = picture.texels().iter().position(|texel| texel.iter().any(|v| !v.is_finite()));
        match first.map(|index| index as u32) {
            None => Ok(counts),
            Some(index) => {
                let width = picture.size()[0].max(1);
                Err(MetricError::NotFinite { side, counts, first: [index % width, index / width] })
            }
        }
    }
}

/// Which of two pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Taken for the truth.
    Reference,
    /// The one that is judged.
    Test,
}

impl fmt::Display for Side {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Self::Reference => "reference",
            Self::Test => "test",
        })
    }
}

/// Why two pictures cannot be compared.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum MetricError {
    /// There is no pixel for every pixel.
    #[error(
        "sizes differ: the reference has {}x{} pixels, the test {}x{}",
        .reference[0], .reference[1], .test[0], .test[1]
    )]
    SizesDiffer {
        /// Pixels.
        reference: [u32; 2],
        /// Pixels.
        test: [u32; 2],
    },
    /// A mean over nothing.
    #[error("the pictures have no pixels: {}x{}", .size[0], .size[1])]
    Empty {
        /// Pixels.
        size: [u32; 2],
    },
    /// NaN or infinity.
    #[error(
        "the {side} holds {} NaN and {} infinite values, the first in column {}, row {}",
        .counts.nan_count, .counts.inf_count, .first[0], .first[1]
    )]
    NotFinite {
        /// Where.
        side: Side,
        /// How many.
        counts: Counts,
        /// Column and row of the first, from 0 at the top left.
        first: [u32; 2],
    },
}

/// Two pictures, or a picture and a map of something, have a pixel for every pixel.
fn comparable<T: Copy, U: Copy>(reference: &Image<T>, test: &Image<U>) -> Result<(), MetricError> {
    let size = reference.size();
    match size == test.size() {
        false => Err(MetricError::SizesDiffer { reference: size, test: test.size() }),
        true if size.contains(&0) => Err(MetricError::Empty { size }),
        true => Ok(()),
    }
}

#[cfg(test)]
mod tests;
