//! What the system must have: a graphics adapter for everything, an X server for the window's test where all checks
//! run. A browser for the report's test is wanted there, and done without where none can be had.

use crate::run::{Failure, cargo, run, say};
use std::path::Path;
use std::process::{Command, Stdio};

/// Mesa's software Vulkan driver and the loader that finds it.
const DRIVER: &[&str] = &["mesa-vulkan-drivers", "libvulkan1"];

/// A virtual X server, and the libraries that a window opens at run time.
const WINDOW: &[&str] = &[
    "xvfb",
    "xauth",
    "libx11-6",
    "libx11-xcb1",
    "libxcb1",
    "libxcursor1",
    "libxi6",
    "libxkbcommon0",
    "libxkbcommon-x11-0",
];

/// A browser without a screen: opens the report as its reader does.
const BROWSER: &[&str] = &["chromium"];

/// The names under which the report's test looks for one.
const BROWSERS: &[&str] = &["chromium", "chromium-browser", "google-chrome", "headless_shell"];

const ELSEWHERE: &str = "no graphics adapter, and no apt-get to install Mesa's software Vulkan driver with; install \
it or a driver for your GPU (Fedora: mesa-vulkan-drivers, Arch: vulkan-swrast, Alpine: mesa-vulkan-swrast, openSUSE: \
libvulkan_lvp) and try again";

/// What asking for an adapter gave.
enum Probe {
    Found,
    None,
    Refused(String),
}

/// Makes sure there is an adapter: installs the software driver where there is none. `gridlight` must be built already,
/// in release if `release`; it is the one to ask, because a driver's files may be there and still find no device.
pub fn adapter(release: bool) -> Result<(), Failure> {
    match probe(release)? {
        Probe::Found => return Ok(()),
        Probe::Refused(message) => return Err(Failure::new(message)),
        Probe::None if !has("apt-get") => return Err(Failure::new(ELSEWHERE)),
        Probe::None => {}
    }
    say(&format!("no graphics adapter found; installing the software driver: {}", DRIVER.join(" ")));
    install(DRIVER)?;
    match probe(release)? {
        Probe::Found => Ok(()),
        Probe::None => Err(Failure::new("still no graphics adapter after installing the software driver")),
        Probe::Refused(message) => Err(Failure::new(message)),
    }
}

fn probe(release: bool) -> Result<Probe, Failure> {
    let mut command = cargo(["run", "--quiet", "--package", "gridlight"]);
    if release {
        command.arg("--release");
    }
    let asked = command
        .args(["--", "info"])
        .stdin(Stdio::null())
        .output()
        .map_err(|e| Failure::new(format!("gridlight info: {e}")))?;
    let words = String::from_utf8_lossy(&asked.stderr).trim().to_owned();
    Ok(match asked.status.success() {
        true => Probe::Found,
        false if words.contains("no graphics adapter") => Probe::None,
        false => Probe::Refused(words),
    })
}

/// Makes sure a window can be opened without a screen.
pub fn window() -> Result<(), Failure> {
    if has("xvfb-run") {
        return Ok(());
    }
    if !has("apt-get") {
        return Err(Failure::new(
            "the window's test needs xvfb-run (a virtual X server); install it and try again",
        ));
    }
    say(&format!("installing what the window's test needs: {}", WINDOW.join(" ")));
    install(WINDOW)
}

/// Looks for a browser, by the variable or one of the names by which the report's test finds it, and tries to install
/// one where there is none.
pub fn browser() -> Result<(), Failure> {
    let is_there =
        || std::env::var_os("GRIDLIGHT_BROWSER").is_some() || BROWSERS.iter().any(|name| has(name));
    if is_there() {
        return Ok(());
    }
    if !has("apt-get") {
        return Err(Failure::new(
            "no browser: the report's test needs Chromium or Chrome, or one named in GRIDLIGHT_BROWSER",
        ));
    }
    say(&format!("installing what the report's test needs: {}", BROWSER.join(" ")));
    install(BROWSER)
        .map_err(|failure| Failure::new(format!("no browser, and none can be installed ({failure})")))?;
    match is_there() {
        true => Ok(()),
        false => Err(Failure::new(format!("no browser, even after installing {}", BROWSER.join(" ")))),
    }
}

/// Whether a program is on the path.
fn has(program: &str) -> bool {
    let path = std::env::var_os("PATH").unwrap_or_default();
    std::env::split_paths(&path).any(|folder| Path::new(&folder).join(program).is_file())
}

fn install(packages: &[&str]) -> Result<(), Failure> {
    // A stale package list is worth a warning only: what it names may still be there.
    if let Err(failure) = run(apt().args(["update", "-qq"])) {
        say(&failure.to_string());
    }
    run(apt().args(["install", "--yes", "--no-install-recommends"]).args(packages))
}

/// `apt-get` that asks nothing, as root or through sudo.
fn apt() -> Command {
    let id = Command::new("id").arg("-u").output();
    let is_root = id.is_ok_and(|out| out.stdout.trim_ascii() == b"0");
    let mut command = match !is_root && has("sudo") {
        true => {
            let mut sudo = Command::new("sudo");
            sudo.args(["DEBIAN_FRONTEND=noninteractive", "apt-get"]);
            sudo
        }
        false => Command::new("apt-get"),
    };
    command.env("DEBIAN_FRONTEND", "noninteractive");
    command
}
