//! The tree against all triangles, and what a tree must be.
#![allow(clippy::unwrap_used, clippy::panic)]

mod fixture;
mod rays;
mod tree;
