//! The device against f64, against its twin and against `obvhs`, and the tree against what a tree has to be.
#![allow(clippy::unwrap_used, clippy::panic)]

mod fixture;
mod rays;
mod trees;
