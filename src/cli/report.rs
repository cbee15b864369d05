//! `gridlight report merge`: the shards of a comparison, joined.

use super::args::ReportCommand;
use super::print;
use crate::{Error, report};

/// Does what the arguments say.
pub fn run(command: &ReportCommand) -> Result<(), Error> {
    let ReportCommand::Merge { out, shards } = command;
    let report = report::merge(out, shards)?;
    print(&format!("{} rows: {}\n", report.rows.len(), out.join("report.html").display()))
}
