//! Which light counts, and sums of it: what every filter here does with the numbers themselves.
//!
//! - **Valid** light is finite and not negative. A half float that overflowed is infinite, so what was above the format's
//!   range is told by the same test. What is not valid is no tap of any filter; it is counted, and filled from its
//!   neighbours.
//! - **Means** are of rgb by weight, and of the length in a over the taps that have one (0 is "no sample").
//! - **Beyond the border** lies the picture's mirror image: a filter whose weights depend on the distance alone then gives
//!   of each pixel exactly as much as it takes.
//!
//! No source; the snippet and the twin are the whole of it.

pub mod reference;

/// Functions `light_…`; after [`frame::HALF_WGSL`].
pub const WGSL: &str = include_str!("light.inc.wgsl");
