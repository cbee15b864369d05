//! What a fresh machine needs to see gridlight run: `cargo xtask demo`, `test`, `fuzz`, `ci`.
//!
//! Only the standard library, so that the first command anyone types is built in seconds. What the machine lacks is
//! installed here, by name and aloud; nothing else is.

mod ci;
mod fuzz;
mod run;
mod system;

use run::{Failure, cargo, say};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

const USAGE: &str = "usage: cargo xtask COMMAND

  demo             render the courtyard, 640x480 lifted to 1920x1080, into out/demo
  test [--shared]  run the tests; --shared adds the long ones that read ../shared
  fuzz [TARGET] [--seconds N]
                   the fuzz targets, or one of them, a minute each or N seconds
  ci               formatting, lints, docs, tests, the window: all that must pass";

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let done = match words.as_slice() {
        ["demo"] => demo(),
        ["test"] => test(false),
        ["test", "--shared"] => test(true),
        ["fuzz", rest @ ..] => match fuzzing(rest) {
            Some((target, seconds)) => fuzz::run(target, seconds),
            None => {
                eprintln!("{USAGE}");
                return ExitCode::from(2);
            }
        },
        ["ci"] => ci::run(),
        _ => {
            eprintln!("{USAGE}");
            return ExitCode::from(2);
        }
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("xtask: {failure}");
            ExitCode::FAILURE
        }
    }
}

/// Target and seconds of `fuzz`, in any order.
fn fuzzing<'a>(mut words: &[&'a str]) -> Option<(Option<&'a str>, u32)> {
    let (mut target, mut seconds) = (None, 60);
    while let Some((first, rest)) = words.split_first() {
        words = rest;
        match *first {
            "--seconds" => {
                let (value, rest) = words.split_first()?;
                (seconds, words) = (value.parse().ok().filter(|s| *s > 0)?, rest);
            }
            name if target.is_none() && !name.starts_with('-') => target = Some(name),
            _ => return None,
        }
    }
    Some((target, seconds))
}

/// The repository's root.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().map(Path::to_path_buf).unwrap_or_default()
}

/// Renders the courtyard and says where the pictures are.
fn demo() -> Result<(), Failure> {
    say("building (the first time takes minutes)");
    run::run(&mut cargo(["build", "--release", "--package", "gridlight"]))?;
    system::adapter(true)?;
    let out = root().join("out/demo");
    say("rendering the courtyard");
    run::run(
        cargo(["run", "--release", "--quiet", "--package", "gridlight", "--", "render", "courtyard"])
            .args(["--camera", "0", "--trace-size", "640x480", "--display-size", "1920x1080", "--out"])
            .arg(&out),
    )?;
    say(&format!("the picture is {}", out.join("display.png").display()));
    say(&format!(
        "beside it: display.exr (linear), light.exr (before and after the filter), log.json in {}",
        out.display()
    ));
    Ok(())
}

/// Runs the tests of everything but the window.
fn test(shared: bool) -> Result<(), Failure> {
    say("building");
    run::run(&mut cargo(["build"]))?;
    system::adapter(false)?;
    let mut command = cargo(["test", "--no-fail-fast"]);
    if shared {
        command.env("GRIDLIGHT_SHARED", "1");
    }
    let count = run::tests(&mut command)?;
    say(&format!("tests: {count}"));
    Ok(())
}
