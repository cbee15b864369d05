//! Every generator as the shader has it: flat, independent, and stratified where it says so.

use super::super::{MASK_BIND, Noise, STRATIFIED_WGSL, WGSL, stratified, upload_mask};
use super::*;
use frame::info::{self, Frame};
use frame::{Bind, Gpu, Kernel, KernelDesc, Recorder, Room};

const SIDE: u32 = 64;
const SAMPLES: u32 = 16;

const SHADER: &str = "
@group(3) @binding(0) var<storage, read_write> out_numbers: array<vec4f>;

@compute @workgroup_size(8, 8)
fn draw(@builtin(global_invocation_id) id: vec3u) {
    let texel = frame.diagonal / 512.0;
    // A wall of one texel of the paper's texture per pixel.
    noise_point = vec3f(texel * (vec2f(id.xy) + 0.5), 0.0);
    let at = (id.z * 64u + id.y) * 64u + id.x;
    out_numbers[2u * at] = vec4f(noise_stratified(id.xy, id.z), 0.0, 0.0);
    out_numbers[2u * at + 1u] = noise_at(id.xy, id.z, 5u);
}";

/// Of every pixel's every sample: the first direction, and four numbers of another block.
fn drawn(gpu: &Gpu, noise: Noise) -> Vec<[f32; 4]> {
    let kernel = Kernel::new(
        gpu,
        &KernelDesc {
            name: "noise/tests",
            sources: &[info::WGSL, WGSL, STRATIFIED_WGSL, SHADER],
            entry: "draw",
            workgroup: [8, 8, 1],
            bindings: &[Bind::uniform::<Frame>(0, 0, "frame"), MASK_BIND, Bind::storage(3, 0, "out_numbers")],
            constants: &[("noise_kind", f64::from(noise as u32))],
        },
    )
    .unwrap();
    let mask = upload_mask(gpu).unwrap();
    let count = (2 * SIDE * SIDE * SAMPLES) as usize;
    let out = gpu.storage(Room::Frame, "out_numbers", &vec![[0f32; 4]; count]).unwrap();
    let mut recorder = Recorder::new(gpu);
    let frame = recorder.uniform(&Frame { diagonal: 10.0, seed: 3, ..Frame::default() });
    let resources = [frame.binding(), mask.as_entire_binding(), out.as_entire_binding()];
    recorder.compute("noise/tests", &kernel, &resources, [SIDE / 8, SIDE / 8, SAMPLES]);
    recorder.finish().unwrap();
    gpu.read_buffer(&out).unwrap()
}

#[test]
fn every_generator_is_flat_and_as_stratified_as_it_says() {
    let gpu = Gpu::new(None).expect("this test needs an adapter");
    for noise in [Noise::Paper, Noise::R2Blue, Noise::Sobol, Noise::Reference] {
        let numbers = drawn(&gpu, noise);
        for (name, odd, [a, b]) in
            [("first", 0, [0, 1]), ("xy", 1, [0, 1]), ("zw", 1, [2, 3]), ("xw", 1, [0, 3])]
        {
            let mut counts = [0u32; 256];
            let mut crowded = 0;
            for pixel in 0..(SIDE * SIDE) as usize {
                let mut cells = [0u32; 16];
                for sample in 0..SAMPLES as usize {
                    let n = numbers[2 * (sample * (SIDE * SIDE) as usize + pixel) + odd];
                    assert!(n.iter().all(|x| (0.0..1.0).contains(x)), "{noise:?}: {n:?}");
                    counts[(n[a] * 16.0) as usize * 16 + (n[b] * 16.0) as usize] += 1;
                    cells[(n[a] * 4.0) as usize * 4 + (n[b] * 4.0) as usize] += 1;
                }
                crowded += u32::from(cells.iter().any(|c| *c != 1));
            }
            let deviation = deviation(&counts);
            println!("{noise:?} {name}: {deviation:.1} deviations, {crowded} pixels with a crowded cell");
            // Stratified numbers are flatter than chance; none may be less flat. The texture holds 2^18 numbers of its own,
            // each read about as often as there are draws over texels.
            assert!(
                deviation < if noise == Noise::Paper { 12.0 } else { LIMIT },
                "{noise:?} {name}: {deviation}"
            );
            // 16 Sobol points have one in each of 4 x 4 cells; by chance that happens once in a million.
            if noise == Noise::Sobol && (a, b) != (0, 3) {
                assert_eq!(crowded, 0, "{name}");
            }
        }
        if noise == Noise::R2Blue {
            for (pixel, sample) in [([0, 0], 0), ([17, 5], 3), ([63, 40], 15)] {
                let at = ((sample * SIDE + pixel[1]) * SIDE + pixel[0]) as usize;
                let [x, y, ..] = numbers[2 * at];
                assert_eq!([x, y], stratified(pixel, sample, 3));
            }
        }
    }
}
