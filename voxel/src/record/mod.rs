//! What a voxel's record holds, and how shaders read it.

/// Functions `record_*` and binding 17 of group 1, with all words.
pub const FULL_WGSL: &str = include_str!("full.inc.wgsl");
