//! `gridlight compare`: every combination of stages, timed, measured and reported.

use super::args::{CompareArgs, Suite};
use super::bar::Bar;
use super::{json, print};
use crate::Error;
use crate::compare::{self, Comparison, Lists};
use crate::reference::Goal;
use crate::settings::View;
use crate::suite;
use frame::Gpu;
use std::time::Duration;

/// Most seconds for one reference on a software adapter where nobody says.
const SOFTWARE_SECONDS: f32 = 600.0;

/// Timed frames where nobody says and no path does.
const USUAL_FRAMES: u32 = 5;

/// Compares what the arguments say.
pub fn run(args: &CompareArgs) -> Result<(), Error> {
    match args.suite {
        Some(Suite::Hard) => hard_suite(args),
        None => one_scene(args),
    }
}

fn one_scene(args: &CompareArgs) -> Result<(), Error> {
    let base = args.view.settings()?.ok_or(Error::NoScene)?;
    let gpu = Gpu::new(args.view.adapter.as_deref())?;
    let frames = args.frames.unwrap_or(match &base.view {
        View::Path(_) => base.frames_of_path(),
        _ => USUAL_FRAMES,
    });
    let comparison = Comparison {
        base,
        lists: lists(args),
        shard: args.shard,
        frames,
        temporal_spp: args.temporal_spp,
        goal: goal(args, &gpu),
        cache: args.cache.clone().unwrap_or_else(compare::default_cache),
        out: args.out.clone(),
        command: command(),
        exposure: args.exposure,
    };
    let (bar, progress) = Bar::new(args.quiet);
    let report = compare::run(&comparison, gpu, &progress)?;
    drop(bar);
    match (args.json, args.quiet) {
        (true, _) => print(&json(&report.rows)?),
        (false, true) => Ok(()),
        (false, false) => print(&format!("{}wrote {}\n", report.markdown(), args.out.display())),
    }
}

fn hard_suite(args: &CompareArgs) -> Result<(), Error> {
    let gpu = Gpu::new(args.view.adapter.as_deref())?;
    let mut base = suite::base();
    args.view.apply(&mut base);
    let hard = suite::Suite {
        base,
        lists: lists(args),
        frames: args.frames.unwrap_or(USUAL_FRAMES),
        goal: goal(args, &gpu),
        cache: args.cache.clone().unwrap_or_else(compare::default_cache),
        out: args.out.clone(),
        command: command(),
    };
    let (bar, progress) = Bar::new(args.quiet);
    let report = suite::run(&hard, &gpu, &progress)?;
    drop(bar);
    match (args.json, args.quiet) {
        (true, _) => print(&json(&report.rows)?),
        (false, true) => Ok(()),
        (false, false) => print(&format!("{}wrote {}\n", report.markdown(), args.out.display())),
    }
}

fn lists(args: &CompareArgs) -> Lists {
    Lists {
        tracers: args.tracers.clone(),
        denoisers: args.denoisers.clone(),
        upsamplers: args.upsamplers.clone(),
        spp: args.spp.clone(),
        grids: args.grids.clone(),
    }
}

fn goal(args: &CompareArgs, gpu: &Gpu) -> Goal {
    let seconds = args.reference_seconds.or(gpu.is_software().then_some(SOFTWARE_SECONDS));
    Goal { spp: args.reference_spp, until: None, within: seconds.map(Duration::from_secs_f32) }
}

/// The command line as it was typed, without what says where and which share: those do not decide the rows.
fn command() -> String {
    let mut words = vec!["gridlight".to_owned()];
    let mut given = std::env::args().skip(1);
    while let Some(word) = given.next() {
        match word.as_str() {
            "--out" | "--shard" => {
                given.next();
            }
            _ if word.starts_with("--out=") || word.starts_with("--shard=") => {}
            _ => words.push(word),
        }
    }
    words.join(" ")
}
