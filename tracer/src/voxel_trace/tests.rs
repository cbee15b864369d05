//! The device against its twin, and both against what is known in closed form.
#![allow(clippy::unwrap_used, clippy::panic)]

mod cache;
mod closed_forms;
mod fixture;
mod glow;
mod leaks;
mod lean;
mod sheets;
mod twin;
mod variance;
