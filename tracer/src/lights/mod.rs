//! Picks one light that is no surface (sun, point, spot, directional) for a vertex's one shadow ray.
//!
//! Paper: none; section 3 says that sun rays "can be implemented using shadow maps", which comes with its own issue.
//!
//! In: number of lights, the vertex (world, m), two random numbers. Out: a unit direction, a distance in metres, and the
//! irradiance on a plane facing the light over the probability of the choice, so that one ray per vertex is unbiased for
//! any number of lights. All lights are equally likely.
//!
//! Formula: a punctual light gives `intensity / d^2 * (1 - min(d / range, 1)^4)`, a spot times the squared linear ramp
//! between its two cosines (`KHR_lights_punctual`); the sun's direction is uniform over its disc.
//!
//! Beside it stands one more: a point of an emitter, or a direction of a sky that is a map, drawn in proportion to its
//! light and weighted against the paths that find it by chance (multiple importance sampling, power heuristic, Veach 1997).

mod list;
#[cfg(test)]
pub(crate) mod reference;

pub use list::LightList;

/// Struct `LightSample` and function `light_sample`; needs the frame uniform and `frame::scene_gpu::LIGHT_WGSL`.
pub const WGSL: &str = include_str!("lights.inc.wgsl");
