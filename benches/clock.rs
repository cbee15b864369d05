//! criterion measures what the adapter's clock says: nanoseconds between a pass's first and last command, host and
//! driver left out. Where the adapter has no clock, wall time of a whole frame, under names of its own.

use criterion::Throughput;
use criterion::measurement::{Measurement, ValueFormatter};

/// Nanoseconds that a bench reads off a frame's log and hands to criterion itself.
pub struct GpuTime;

impl Measurement for GpuTime {
    type Intermediate = ();
    type Value = f64;

    /// Nothing to start: every bench here uses `iter_custom`.
    fn start(&self) {}

    fn end(&self, (): ()) -> f64 {
        0.0
    }

    fn add(&self, a: &f64, b: &f64) -> f64 {
        a + b
    }

    fn zero(&self) -> f64 {
        0.0
    }

    fn to_f64(&self, value: &f64) -> f64 {
        *value
    }

    fn formatter(&self) -> &dyn ValueFormatter {
        &Milliseconds
    }
}

/// One unit everywhere, so that columns can be compared by eye.
struct Milliseconds;

impl ValueFormatter for Milliseconds {
    fn scale_values(&self, _typical: f64, values: &mut [f64]) -> &'static str {
        values.iter_mut().for_each(|ns| *ns *= 1e-6);
        "ms"
    }

    fn scale_throughputs(&self, _typical: f64, throughput: &Throughput, values: &mut [f64]) -> &'static str {
        // Benches here count elements alone: rays, triangles, pixels.
        let Throughput::Elements(count) = throughput else { return self.scale_for_machines(values) };
        values.iter_mut().for_each(|ns| *ns = *count as f64 / *ns * 1e3);
        "M/s"
    }

    fn scale_for_machines(&self, _values: &mut [f64]) -> &'static str {
        "ns"
    }
}
