//! Rays with a known answer.
#![allow(clippy::unwrap_used)]

use super::*;
