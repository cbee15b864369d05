//! Both structures alike: with each other to the bit, and nothing lost between two triangles.
#![allow(clippy::unwrap_used, clippy::panic)]

mod agreement;
mod closed;
mod costs;
pub mod fixture;
