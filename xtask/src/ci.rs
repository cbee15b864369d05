//! All that must pass: formatting, lints, docs, tests, the window.

use crate::run::{self, Failure, TestCount, cargo, say};
use crate::system;

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
    system::window()?;
    // It is there now: the test that plays a user has no reason to skip.
    let mut command = cargo(["test", "--no-fail-fast", "--package", "gridlight-viewer"]);
    count.add(&run::tests(command.env("GRIDLIGHT_REQUIRE_WINDOW", "1"))?);
    let skipped = if browser.is_ok() { "" } else { " (no browser opened the report)" };
    say(&format!("all passed; tests: {count}{skipped}"));
    Ok(())
}
