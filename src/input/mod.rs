//! Reads linear pictures from files: OpenEXR, ours or another renderer's.
//!
//! PNG is for looking at (clamped, 8 bits, a display's curve) and is not read: nothing can be measured on it.

mod exr;

pub use exr::{Layers, read_exr, read_exr_layers, read_exr_layers_within, read_exr_within};
