//! What the recorder promises, on the adapter there is.
#![allow(clippy::unwrap_used)]

use crate::{Bind, Gpu, Kernel, KernelDesc, Recorder, Room};

const ADD: &str = "
@group(0) @binding(0) var<uniform> step_of: Step;
struct Step { amount: u32, _a: u32, _b: u32, _c: u32 }
@group(3) @binding(0) var<storage, read_write> totals: array<u32>;
@compute @workgroup_size(64)
fn add(@builtin(global_invocation_id) id: vec3u) { totals[id.x] += step_of.amount; }";

crate::gpu_struct! {
    /// One addition.
    pub struct Step {
        /// Added to each.
        pub amount: u32,
        /// Padding.
        pub _pad: [u32; 3],
    }
}

fn gpu() -> Gpu {
    Gpu::new(None).expect("this test needs an adapter")
}

fn kernel(gpu: &Gpu) -> Kernel {
    Kernel::new(
        gpu,
        &KernelDesc {
            name: "add",
            sources: &[ADD],
            entry: "add",
            workgroup: [64, 1, 1],
            bindings: &[Bind::uniform::<Step>(0, 0, "step_of"), Bind::storage(3, 0, "totals")],
            constants: &[],
        },
    )
    .unwrap()
}

#[test]
fn every_pass_runs_in_order_across_slices_and_is_counted() {
    let gpu = gpu();
    let kernel = kernel(&gpu);
    let totals = gpu.storage(Room::Frame, "totals", &[0u32; 128]).unwrap();
    let mut recorder = Recorder::new(&gpu);
    // 300 passes: several slices, several query sets, several uniform chunks.
    for amount in 1..=300 {
        let step = recorder.uniform(&Step { amount, ..Default::default() });
        let name = if amount % 2 == 0 { "sum/even" } else { "sum/odd" };
        recorder.compute(name, &kernel, &[step.binding(), totals.as_entire_binding()], [2, 1, 1]);
    }
    recorder.counter("total", &totals, 0);
    let log = recorder.finish().unwrap();
    assert_eq!(gpu.read_buffer::<u32>(&totals).unwrap(), vec![300 * 301 / 2; 128]);
    let runs: Vec<_> = log.passes.iter().map(|p| (p.name.as_str(), p.runs)).collect();
    assert_eq!(runs, [("sum/odd", 150), ("sum/even", 150)]);
    assert_eq!(log.stage_ms("sum").is_some(), gpu.timestamp_period.is_some());
    // A counter is a pair of words, low first: here two equal ones.
    assert_eq!(log.counts["total"], 45_150.0 * (1.0 + 4_294_967_296.0));
}

#[test]
fn a_frame_that_comes_again_allocates_nothing() {
    let gpu = gpu();
    let kernel = kernel(&gpu);
    let totals = [(); 2].map(|()| gpu.storage(Room::Frame, "totals", &[0u32; 128]).unwrap());
    let frame = |index: usize| {
        let mut recorder = Recorder::of_frame(&gpu);
        // More than a slice, a query set and a chunk of uniforms hold; what is bound takes turns, as a history does.
        for amount in 1..=150 {
            let step = recorder.uniform(&Step { amount, ..Default::default() });
            let resources = [step.binding(), totals[index % 2].as_entire_binding()];
            recorder.compute("sum", &kernel, &resources, [2, 1, 1]);
        }
        recorder.counter("total", &totals[0], 0);
        recorder.finish().unwrap();
        (gpu.allocations(), gpu.memory(Room::Frame).live)
    };
    let begun: Vec<_> = (0..2).map(frame).collect();
    let steady: Vec<_> = (2..8).map(frame).collect();
    assert!(steady.iter().all(|s| *s == begun[1]), "{begun:?} {steady:?}");
    assert_eq!(gpu.read_buffer::<u32>(&totals[1]).unwrap()[0], 4 * 150 * 151 / 2);
    // Other recorders keep no groups, and do not make those of frames old.
    for _ in 0..8 {
        Recorder::new(&gpu).finish().unwrap();
    }
    let before = gpu.allocations();
    frame(8);
    assert_eq!(gpu.allocations(), before);
}

#[test]
fn memory_is_what_lives() {
    let gpu = gpu();
    let before = gpu.memory(Room::History);
    let buffer = gpu.buffer(Room::History, "history", 1000, wgpu::BufferUsages::STORAGE).unwrap();
    let texture = gpu
        .texture(
            Room::History,
            "texture",
            [16, 8, 1],
            2,
            wgpu::TextureFormat::Rgba16Float,
            wgpu::TextureUsages::TEXTURE_BINDING,
        )
        .unwrap();
    // 1000 bytes, and 8 bytes for each of 16x8 and 8x4 texels.
    assert_eq!(gpu.memory(Room::History).live - before.live, 1000 + 8 * (128 + 32));
    drop((buffer, texture));
    let after = gpu.memory(Room::History);
    assert_eq!((after.live, after.peak), (before.live, before.peak + 1000 + 8 * 160));
}

#[test]
fn too_large_says_both_values() {
    let gpu = gpu();
    let bytes = (128 << 20) + 4;
    let message =
        gpu.buffer(Room::Voxels, "grid", bytes, wgpu::BufferUsages::STORAGE).err().unwrap().to_string();
    assert!(message.contains("grid needs 134217732 bytes, the adapter allows 134217728"), "{message}");
}

#[test]
fn an_unknown_adapter_is_refused_with_those_there_are() {
    let message = Gpu::new(Some("no such adapter")).err().unwrap().to_string();
    assert!(message.contains("named \"no such adapter\"") && message.contains("found: "), "{message}");
}

#[test]
fn the_canary_knows_mesas_cap() {
    let gpu = gpu();
    let cap = gpu.loop_cap();
    println!("{}: loop cap {cap:?}", gpu.info.name);
    // Mesa 22.3's software driver ends loops after 65,535 iterations per group of 8; other drivers have no cap. A cap
    // elsewhere, or a lower one, would break kernels that state a worst case below 65,535.
    assert!(cap.is_none_or(|c| c >= 65_535), "loops end after {cap:?} iterations");
}

#[test]
fn the_time_of_a_pass_is_that_of_its_work() {
    let gpu = gpu();
    if gpu.timestamp_period.is_none() {
        println!("left out: {} has no timestamps", gpu.info.name);
        return;
    }
    let kernel = Kernel::new(
        &gpu,
        &KernelDesc {
            name: "spin",
            sources: &[SPIN],
            entry: "spin",
            workgroup: [64, 1, 1],
            bindings: &[Bind::uniform::<Step>(0, 0, "step_of"), Bind::storage(3, 0, "totals")],
            constants: &[],
        },
    )
    .unwrap();
    let totals = gpu.storage(Room::Frame, "totals", &[1u32; 1 << 16]).unwrap();
    // A pass with 50 times the work of its neighbours. The first run compiles, and on a busy machine any pass can be
    // held up; work that is booked to the wrong pass is booked wrongly every time, so one clear run in ten is proof.
    let mut seen = Vec::new();
    for _ in 0..10 {
        let mut recorder = Recorder::new(&gpu);
        for (name, amount) in [("short/before", 200), ("long/work", 10_000), ("short/after", 200)] {
            let step = recorder.uniform(&Step { amount, ..Default::default() });
            recorder.compute(name, &kernel, &[step.binding(), totals.as_entire_binding()], [1 << 10, 1, 1]);
        }
        let log = recorder.finish().unwrap();
        let (long, short) = (log.stage_ms("long").unwrap(), log.stage_ms("short").unwrap());
        // 25 by the work.
        if long > 5.0 * short {
            return;
        }
        seen.push((long, short));
    }
    assert!(seen.is_empty(), "(long pass, both short ones) in ms: {seen:?}");
}

const SPIN: &str = "
@group(0) @binding(0) var<uniform> step_of: Step;
struct Step { amount: u32, _a: u32, _b: u32, _c: u32 }
@group(3) @binding(0) var<storage, read_write> totals: array<u32>;
@compute @workgroup_size(64)
fn spin(@builtin(global_invocation_id) id: vec3u) {
    var x = totals[id.x];
    for (var i = 0u; i < step_of.amount; i += 1u) { x = x * 747796405u + 1u; }
    totals[id.x] = x;
}";
