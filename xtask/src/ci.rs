//! All that must pass: formatting, lints, docs, tests, the window.

use crate::run::{self, Failure, TestCount, cargo, say};
use crate::system;
use std::process::Command;

/// Frames that the window's smoke test shows.
const FRAMES: &str = "3";

/// Runs every check in the order in which they fail fastest.
pub fn run() -> Result<(), Failure> {
    say("formatting");
    run::run(&mut cargo(["fmt", "--all", "--check"]))?;
    say("lints");
    run::run(&mut cargo(["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"]))?;
    say("docs");
    run::run(cargo(["doc", "--workspace", "--no-deps"]).env("RUSTDOCFLAGS", "-D warnings"))?;
    say("tests");
    run::run(&mut cargo(["build"]))?;
    system::adapter(false)?;
    let mut command = cargo(["test", "--no-fail-fast"]);
    // With CI set, a test that needs a browser fails without one instead of skipping.
    let browser = system::browser();
    match &browser {
        Ok(()) => command.env("CI", "1"),
        Err(failure) => {
            say(&format!("{failure}; the test that opens the report in a browser will skip"));
            command.env_remove("CI")
        }
    };
    let mut count = TestCount::default();
    count.add(&run::tests(&mut command)?);
    say("the window");
    count.add(&run::tests(&mut cargo(["test", "--no-fail-fast", "--package", "gridlight-viewer"]))?);
    run::run(&mut cargo(["build", "--package", "gridlight-viewer"]))?;
    window()?;
    let skipped = if browser.is_ok() { "" } else { " (no browser opened the report)" };
    say(&format!("all passed; tests: {count}{skipped}"));
    Ok(())
}

/// Opens the window on a virtual screen for a few frames.
fn window() -> Result<(), Failure> {
    system::window()?;
    let small = ["cornell", "--camera", "0", "--trace-size", "80x60", "--grid", "64", "--spp", "1"];
    let mut viewer = cargo(["run", "--quiet", "--package", "gridlight-viewer", "--"]);
    viewer.args(small).args(["--after-frames", FRAMES]);
    let mut command = Command::new("xvfb-run");
    command.args(["--auto-servernum", "--server-args", "-screen 0 1024x768x24"]);
    command.arg(viewer.get_program()).args(viewer.get_args()).current_dir(crate::root());
    for (name, value) in viewer.get_envs() {
        if let Some(value) = value {
            command.env(name, value);
        }
    }
    run::run(&mut command)
}
