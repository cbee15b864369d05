//! Measures after how many loop iterations the driver silently gives up.
//!
//! Mesa's software driver (22.3) ends every loop of an invocation group once it has run 65,535 iterations in total, and
//! carries on with wrong data. Each kernel here states a worst case below that; this canary tells whether the cap is
//! there at all, so that work is cut into small dispatches only where it must be.

use super::{Gpu, Room};
use crate::{Bind, Kernel, KernelDesc};

const TRIED: u32 = 1 << 17;

const SOURCE: &str = "
@group(0) @binding(0) var<storage, read_write> canary_count: array<u32>;
@compute @workgroup_size(8)
fn canary(@builtin(global_invocation_id) id: vec3u) {
    var state = id.x + 1u;
    var count = 0u;
    // The state is part of the condition, so that no compiler folds the loop away; it never is 0 (an odd multiplier
    // permutes the residues, and the increment is even).
    for (var i = 0u; i < canary_tried && state != 0u; i += 1u) {
        state = (state * 747796405u + 2u) | 1u;
        count += 1u;
    }
    canary_count[id.x] = count;
}";

/// None where all iterations ran; else how many did. A driver that cannot even run this counts as capped at 0.
pub(super) fn measure(gpu: &Gpu) -> Option<u32> {
    let count = || -> Result<u32, super::GpuError> {
        let prelude = format!("const canary_tried = {TRIED}u;");
        let kernel = Kernel::new(
            gpu,
            &KernelDesc {
                name: "canary",
                sources: &[&prelude, SOURCE],
                entry: "canary",
                workgroup: [8, 1, 1],
                bindings: &[Bind::storage(0, 0, "canary_count")],
                constants: &[],
            },
        )?;
        let counts = gpu.storage(Room::Frame, "canary::count", &[0u32; 8])?;
        let mut recorder = crate::Recorder::new(gpu);
        recorder.compute("canary", &kernel, &[counts.as_entire_binding()], [1, 1, 1]);
        recorder.finish()?;
        Ok(gpu.read_buffer::<u32>(&counts)?.into_iter().min().unwrap_or(0))
    };
    count().map_or(Some(0), |reached| (reached < TRIED).then_some(reached))
}
