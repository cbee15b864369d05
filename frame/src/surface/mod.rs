//! The surface a ray meets, in 16 bytes: what a voxel stores and what a G-buffer texel stores.
//!
//! Paper: the gather pass renders "the same information" that the voxels hold, "tangent and bi-tangent into only
//! eight bits".
//!
//! In and out: [`Surface`], directions in world space, colours linear Rec. 709, and four words:
//!
//! | word | bits, lowest first |
//! | --- | --- |
//! | 0 | normal 12 + 12 (octahedral, two's complement), tangent angle 7, handedness 1 |
//! | 1 | base colour sRGB 8 x 3; voxel: contour 8 (two's complement, -128 = crease); G-buffer: metalness 8 |
//! | 2 | RGB9E5: absorption of a transmissive solid, emission otherwise |
//! | 3 | roughness 8 + 8, `round(255 sqrt(F0))` 8, select 2, amount 4, two-sided 1, thin 1 |
//!
//! - **Normal**: `p = n.xy / |n|_1`, folded outwards where `n.z < 0`, times 2047. Decoding stays in integers up to the
//!   final normalisation. Worst error 0.059 degrees.
//! - **Tangent**: the angle in 128 steps about the *decoded* normal, from the basis of Duff et al. 2017 whose
//!   hemisphere sign is the decoded integer's. Worst error 1.41 degrees.
//! - **Base colour and amount** round up with a probability linear in the decoded value, by a hash the caller passes
//!   (of the cell or the pixel): the mean over hashes is exact, a colour that a code hits exactly does not change, and
//!   grey stays grey because the channels share one random number.
//! - **Select** names what the 4-bit amount (n/15) is the share of: nothing, metal, transmission, or holes. Where
//!   several are wanted the largest share stays. A G-buffer texel has its metalness in word 1.
//! - **Light** saturates at 65,408; negative and NaN become 0. Emission comes multiplied by the scene's
//!   `radiance_scale`. A transmissive solid that also emits keeps its emission and becomes a thin sheet, because a
//!   thin sheet has no absorption to store.
//!
//! Departs from the paper: nothing that it states; it gives no layout beyond the eight bits.

mod reference;
#[cfg(test)]
mod tests;

pub use reference::{
    CONTOUR_STEP, CREASE, CREASE_CODE, Surface, basis as surface_basis, face_normal_pack, face_normal_unpack,
    hash, linear_from_srgb, normal_pack, normal_unpack, rgb9e5_pack, rgb9e5_unpack, srgb_from_linear,
    tangent_pack, tangent_unpack,
};

/// The shader's half: `struct Surface` and every function named `surface_*`.
pub const WGSL: &str = include_str!("surface.inc.wgsl");
