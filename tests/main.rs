//! One test binary, one module per question.

#![allow(clippy::unwrap_used, clippy::panic)]

mod arithmetic;
#[path = "report_browser.rs"]
mod browser;
mod build_time;
mod cli;
mod compare;
mod counts;
mod denoise;
mod dependencies;
mod furnace;
mod hard;
mod machine;
mod metrics;
mod motion;
mod radiometry;
mod references;
mod scenes;
mod steady;
mod support;
