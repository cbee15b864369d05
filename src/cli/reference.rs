//! `gridlight reference`: converges an image, going on from where an earlier run stopped.

use super::args::ReferenceArgs;
use super::bar::Bar;
use super::{json, print};
use crate::Error;
use crate::pipeline::Pipeline;
use crate::reference::{self, Goal};
use frame::Gpu;
use tracer::Search;

/// Samples per pixel where neither --spp nor --until says anything: what the references of reports have.
const SPP: u32 = 1024;
/// The most where only --until says when to stop.
const MOST_SPP: u32 = 1 << 20;

/// Converges what the arguments say.
pub fn run(args: &ReferenceArgs) -> Result<(), Error> {
    let settings = args.settings()?;
    let search = match settings.tracer.as_str() {
        "voxel" => Search::Grid,
        "bvh_lbvh" => Search::Lbvh,
        _ => Search::Cwbvh,
    };
    let spp = args.street.spp.unwrap_or(if args.until.is_some() { MOST_SPP } else { SPP });
    let goal = Goal { spp, until: args.until.map(f64::from), within: None };
    let gpu = Gpu::new(args.street.view.adapter.as_deref())?;
    let (bar, progress) = Bar::new(args.quiet);
    let mut pipeline = Pipeline::new(gpu, &settings, progress)?;
    pipeline.warnings().iter().for_each(|warning| bar.note(&format!("warning: {warning}")));
    let reference = reference::run(&mut pipeline, search, goal, &args.out)?;
    drop(bar);
    let summary = &reference.summary;
    match (args.json, args.quiet) {
        (true, _) => print(&json(summary)?),
        (false, true) => Ok(()),
        (false, false) => print(&format!(
            "{} samples ({} of them from an earlier run) in {:.1} s, relative error {:.3} %\nwrote {}\n",
            summary.spp,
            summary.resumed_spp,
            summary.seconds,
            100.0 * summary.rel_error,
            args.out.display()
        )),
    }
}
