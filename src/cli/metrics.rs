//! `gridlight metrics`: every error metric between two pictures, as JSON.

use super::args::MetricsArgs;
use super::{json, print, values};
use crate::Error;
use crate::input::read_exr_within;
use crate::metrics::Errors;
use scene::LoadBudget;
use serde::Serialize;
use std::path::Path;

#[derive(Serialize)]
struct Comparison<'a> {
    reference: &'a Path,
    test: &'a Path,
    size: [u32; 2],
    exposure: f32,
    #[serde(flatten)]
    errors: Errors,
}

/// Compares what the arguments say.
pub fn run(args: &MetricsArgs) -> Result<(), Error> {
    let MetricsArgs { reference, test, exposure, load_mb } = args;
    let budget = LoadBudget { bytes: values::bytes(*load_mb) };
    let (r, t) = (read_exr_within(reference, budget)?, read_exr_within(test, budget)?);
    let errors = Errors::between_exposed(&r, &t, *exposure).map_err(|source| Error::Metrics {
        reference: reference.clone(),
        test: test.clone(),
        source,
    })?;
    print(&json(&Comparison { reference, test, size: r.size(), exposure: *exposure, errors })?)
}
