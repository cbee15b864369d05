//! The command line `gridlight`.

use std::process::ExitCode;

fn main() -> ExitCode {
    gridlight::cli::run()
}
