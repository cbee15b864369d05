//! Runs commands from the repository's root, and counts what cargo tested.

use std::ffi::OsStr;
use std::fmt;
use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};

/// A command that could not be run, or did not succeed.
pub struct Failure(String);

impl Failure {
    pub fn new(message: impl Into<String>) -> Self {
        Self(message.into())
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// One line about what happens next. On stderr, where cargo also talks.
pub fn say(line: &str) {
    eprintln!("xtask: {line}");
}

/// The cargo that runs us, in the repository's root.
pub fn cargo<S: AsRef<OsStr>>(args: impl IntoIterator<Item = S>) -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.args(args).current_dir(crate::root());
    // Tests that need an adapter fail without one instead of skipping.
    command.env("GRIDLIGHT_REQUIRE_ADAPTER", "1");
    // Each device of the software driver starts a worker per core; two tests at a time keep a small machine usable.
    command.env("RUST_TEST_THREADS", "2");
    if std::env::var_os("XDG_RUNTIME_DIR").is_none() {
        // Without one the driver prints a warning each time it opens.
        command.env("XDG_RUNTIME_DIR", std::env::temp_dir());
    }
    command
}

/// Runs to the end.
pub fn run(command: &mut Command) -> Result<(), Failure> {
    let status = command.stdin(Stdio::null()).status().map_err(|e| not_started(command, &e))?;
    match status.success() {
        true => Ok(()),
        false => Err(failed(command, &status.to_string())),
    }
}

/// What `cargo test` reported, over all its binaries.
#[derive(Default)]
pub struct TestCount {
    passed: u64,
    failed: u64,
    ignored: u64,
}

impl TestCount {
    pub fn add(&mut self, other: &Self) {
        self.passed += other.passed;
        self.failed += other.failed;
        self.ignored += other.ignored;
    }

    /// Reads `test result: ok. 3 passed; 0 failed; 1 ignored; …`.
    fn read(&mut self, line: &str) {
        let Some(rest) = line.strip_prefix("test result: ") else { return };
        for part in rest.split(['.', ';']) {
            let mut words = part.split_whitespace();
            if let (Some(Ok(count)), Some(what)) = (words.next().map(str::parse::<u64>), words.next()) {
                match what {
                    "passed" => self.passed += count,
                    "failed" => self.failed += count,
                    "ignored" => self.ignored += count,
                    _ => {}
                }
            }
        }
    }
}

impl fmt::Display for TestCount {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} passed, {} failed, {} ignored", self.passed, self.failed, self.ignored)
    }
}

/// Runs a `cargo test`, passing its words on and adding up its results.
pub fn tests(command: &mut Command) -> Result<TestCount, Failure> {
    let mut child =
        command.stdin(Stdio::null()).stdout(Stdio::piped()).spawn().map_err(|e| not_started(command, &e))?;
    let mut count = TestCount::default();
    for line in child.stdout.take().into_iter().flat_map(|out| BufReader::new(out).lines()) {
        let line = line.map_err(|e| Failure::new(format!("reading cargo's words: {e}")))?;
        println!("{line}");
        count.read(&line);
    }
    let status = child.wait().map_err(|e| Failure::new(format!("waiting for cargo: {e}")))?;
    match status.success() {
        true => Ok(count),
        false => Err(failed(command, &format!("{status}; tests: {count}"))),
    }
}

fn words(command: &Command) -> String {
    let program = command.get_program().to_string_lossy();
    let program = program.rsplit('/').next().unwrap_or_default().to_owned();
    command.get_args().fold(program, |line, arg| line + " " + &arg.to_string_lossy())
}

fn not_started(command: &Command, e: &std::io::Error) -> Failure {
    Failure::new(format!("{}: {e}", words(command)))
}

fn failed(command: &Command, status: &str) -> Failure {
    Failure::new(format!("{}: {status}", words(command)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_add_up_over_binaries() {
        let mut count = TestCount::default();
        count.read(
            "test result: ok. 12 passed; 0 failed; 1 ignored; 0 measured; 0 filtered out; finished in 0.31s",
        );
        count.read("test brdf::furnace ... ok");
        count.read(
            "test result: FAILED. 3 passed; 2 failed; 0 ignored; 0 measured; 0 filtered out; finished in 1s",
        );
        assert_eq!(count.to_string(), "15 passed, 2 failed, 1 ignored");
    }
}
