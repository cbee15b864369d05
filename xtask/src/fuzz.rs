//! `cargo xtask fuzz`: the fuzz targets of `fuzz/`, built with instrumentation on the stable toolchain and run two at a
//! time.
//!
//! libFuzzer needs nothing that the stable compiler lacks: the coverage pass is LLVM's own and is asked for by flags. What
//! a run finds lies in `fuzz/artifacts/TARGET`; new inputs that reached new code go to `fuzz/corpus/TARGET/found-*` only if
//! they are put there by hand: a run works on a copy, so that the repository's corpus stays small.

use crate::run::{self, Failure, cargo, say};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

/// Readers of files; built without the rest of gridlight.
const READERS: &[&str] = &["gltf", "glb", "hdr", "exr"];
/// Readers of what people type; wgpu is built with them.
const TYPED: &[&str] = &["settings", "command_line"];

/// LLVM's coverage pass as libFuzzer reads it: a byte per edge, a table of the edges, the operands of comparisons.
const FLAGS: &str = "--cfg fuzzing -Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 \
-Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table \
-Cllvm-args=-sanitizer-coverage-trace-compares";

/// Seconds after which one input counts as a hang.
const HANG_S: u32 = 10;
/// Megabytes a target may grow to.
const MOST_MB: u32 = 1024;

/// Runs one target, or all of them, `seconds` each.
pub fn run(target: Option<&str>, seconds: u32) -> Result<(), Failure> {
    let all = || READERS.iter().chain(TYPED).copied();
    let targets: Vec<&str> = match target {
        None => all().collect(),
        Some(name) => match all().find(|known| *known == name) {
            Some(known) => vec![known],
            None => {
                let known: Vec<&str> = all().collect();
                return Err(Failure::new(format!("no fuzz target {name}; there are: {}", known.join(", "))));
            }
        },
    };
    let folder = crate::root().join("fuzz");
    let host = host()?;
    say("building the fuzz targets");
    build(&folder, &host, &targets)?;
    let programs = folder.join("target").join(&host).join("debug");
    for pair in targets.chunks(2) {
        say(&format!("fuzzing {} for {seconds} s", pair.join(" and ")));
        let mut running = Vec::new();
        for target in pair {
            running.push((*target, start(&programs.join(target), &folder, target, seconds)?));
        }
        // Both are waited for, whatever the first one says.
        let ended: Vec<_> = running.iter_mut().map(|(target, child)| (*target, child.wait())).collect();
        for (target, status) in ended {
            let status = status.map_err(|e| Failure::new(format!("{target}: {e}")))?;
            if !status.success() {
                let found = folder.join("artifacts").join(target);
                return Err(Failure::new(format!(
                    "{target}: {status}; the input lies in {}, its log is {}",
                    found.display(),
                    log(&folder, target).display()
                )));
            }
            say(&format!("{target}: {}", last_line(&log(&folder, target))));
        }
    }
    Ok(())
}

/// What this toolchain builds for: with a target named, flags do not reach build scripts and macros.
fn host() -> Result<String, Failure> {
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let said =
        Command::new(rustc).arg("-vV").output().map_err(|e| Failure::new(format!("rustc -vV: {e}")))?;
    let said = String::from_utf8_lossy(&said.stdout).into_owned();
    let host = said.lines().find_map(|line| line.strip_prefix("host: "));
    host.map(str::to_owned).ok_or_else(|| Failure::new("rustc -vV names no host"))
}

fn build(folder: &Path, host: &str, targets: &[&str]) -> Result<(), Failure> {
    let mut command = cargo(["build", "--locked", "--target", host]);
    command.current_dir(folder).env("RUSTFLAGS", FLAGS).env("CARGO_TARGET_DIR", folder.join("target"));
    if targets.iter().any(|target| TYPED.contains(target)) {
        command.args(["--features", "street"]);
    }
    targets.iter().for_each(|target| {
        command.args(["--bin", target]);
    });
    run::run(&mut command)
}

/// Starts a target on a copy of its corpus.
fn start(program: &Path, folder: &Path, target: &str, seconds: u32) -> Result<Child, Failure> {
    let fail = |what: &Path, e: std::io::Error| Failure::new(format!("{}: {e}", what.display()));
    let work = folder.join("target/corpus").join(target);
    let artifacts = folder.join("artifacts").join(target);
    for made in [&work, &artifacts] {
        std::fs::create_dir_all(made).map_err(|e| fail(made, e))?;
    }
    let said = log(folder, target);
    let to = std::fs::File::create(&said).map_err(|e| fail(&said, e))?;
    let mut command = Command::new(program);
    // New inputs go to the first folder; the kept ones are only read.
    command.arg(&work).arg(folder.join("corpus").join(target));
    let dictionary = folder.join("dictionaries").join(format!("{target}.dict"));
    if dictionary.is_file() {
        command.arg(format!("-dict={}", dictionary.display()));
    }
    command
        .arg(format!("-artifact_prefix={}/", artifacts.display()))
        .arg(format!("-max_total_time={seconds}"))
        .arg(format!("-timeout={HANG_S}"))
        .arg(format!("-rss_limit_mb={MOST_MB}"))
        .arg("-print_final_stats=1")
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(to)
        .spawn()
        .map_err(|e| fail(program, e))
}

fn log(folder: &Path, target: &str) -> PathBuf {
    folder.join("target").join(format!("{target}.log"))
}

/// What the engine counted last: `#12345 DONE cov: ...`.
fn last_line(log: &Path) -> String {
    let text = std::fs::read_to_string(log).unwrap_or_default();
    text.lines().rev().find(|line| line.contains("DONE")).unwrap_or("no summary").to_owned()
}
