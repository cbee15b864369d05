//! The command line: `gridlight SUBCOMMAND`.
//!
//! Exit codes are a contract: 0 done, 1 failed with one message on stderr, 2 wrong usage.

mod args;
mod bar;
mod compare;
mod denoise;
mod info;
mod line;
mod list;
mod metrics;
mod reference;
mod render;
mod report;
mod table;
mod values;
mod view;

pub use args::Cli;
pub use line::RenderLine;
pub use view::StreetArgs;

use crate::Error;
use args::Command;
use clap::Parser;
use std::io::Write;
use std::process::ExitCode;

/// Parses the command line, does what it says, and tells how that went.
pub fn run() -> ExitCode {
    // Wrong usage ends here with code 2, --help and --version with 0.
    let done = match Cli::parse().command {
        Command::Render(args) => render::run(&args),
        Command::Reference(args) => reference::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::Denoise(args) => denoise::run(&args),
        Command::Metrics(args) => metrics::run(&args),
        Command::List(args) => list::run(&args),
        Command::Info(args) => info::run(&args),
        Command::Report(command) => report::run(&command),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => {
            eprintln!("error: {e}");
            ExitCode::from(if e.is_usage() { 2 } else { 1 })
        }
    }
}

/// Writes to stdout. A reader that has seen enough (`gridlight list | head`) is no failure.
fn print(text: &str) -> Result<(), Error> {
    match std::io::stdout().lock().write_all(text.as_bytes()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Error::Write { path: "stdout".into(), message: e.to_string() })
        }
        _ => Ok(()),
    }
}

/// Any of our reports as indented JSON with a newline at its end.
fn json(value: &impl serde::Serialize) -> Result<String, Error> {
    serde_json::to_string_pretty(value)
        .map(|text| text + "\n")
        .map_err(|e| Error::Write { path: "JSON".into(), message: e.to_string() })
}
