//! The shader against its twin, on the adapter there is.

use super::*;
use crate::{Bind, Gpu, Kernel, KernelDesc, Recorder, Room};

const COUNT: usize = 1 << 15;
const FLOATS: usize = 28;

const SHADER: &str = "
@group(2) @binding(0) var<storage, read> in_values: array<f32>;
@group(3) @binding(0) var<storage, read_write> out_words: array<vec4u>;
@group(3) @binding(1) var<storage, read_write> out_values: array<f32>;

fn three(i: u32) -> vec3f { return vec3f(in_values[i], in_values[i + 1u], in_values[i + 2u]); }

fn put(i: u32, v: vec3f) {
  out_values[i] = v.x;
  out_values[i + 1u] = v.y;
  out_values[i + 2u] = v.z;
}

@compute @workgroup_size(64)
fn pack_and_unpack(@builtin(global_invocation_id) id: vec3u) {
  let i = id.x * 28u;
  var s: Surface;
  s.normal = three(i);
  s.tangent = three(i + 3u);
  s.base = three(i + 6u);
  s.emission = three(i + 9u);
  s.absorption = three(i + 12u);
  s.roughness = three(i + 15u).xy;
  s.handedness = in_values[i + 17u];
  s.metalness = in_values[i + 18u];
  s.f0 = in_values[i + 19u];
  s.transmission = in_values[i + 20u];
  s.coverage = in_values[i + 21u];
  s.contour = in_values[i + 22u];
  s.two_sided = in_values[i + 23u] > 0.0;
  s.thin = in_values[i + 24u] > 0.0;

  let voxel = surface_pack_voxel(s, surface_hash(id.x));
  let texel = surface_pack_gbuffer(s, surface_hash(id.x));
  let face = surface_face_normal_pack(s.normal);
  out_words[id.x * 3u] = voxel;
  out_words[id.x * 3u + 1u] = texel;
  out_words[id.x * 3u + 2u] = vec4u(face, surface_hash(id.x), 0u, 0u);

  let back = surface_unpack_voxel(voxel);
  put(i, back.normal);
  put(i + 3u, back.tangent);
  put(i + 6u, back.base);
  put(i + 9u, back.emission);
  put(i + 12u, back.absorption);
  put(i + 15u, vec3f(back.roughness, back.handedness));
  put(i + 18u, vec3f(back.metalness, back.f0, back.transmission));
  put(i + 21u, vec3f(back.coverage, back.contour, select(0.0, 1.0, back.two_sided)));
  put(i + 24u, vec3f(select(0.0, 1.0, back.thin), surface_unpack_gbuffer(texel).metalness, surface_face_normal_unpack(face).x));
}";

fn values(s: &Surface) -> [f32; FLOATS] {
    let mut values = [0.0; FLOATS];
    for (slot, v) in [s.normal, s.tangent, s.base, s.emission, s.absorption].into_iter().enumerate() {
        values[slot * 3..slot * 3 + 3].copy_from_slice(&v.to_array());
    }
    let bit = |b: bool| f32::from(u8::from(b));
    values[15..25].copy_from_slice(&[
        s.roughness.x,
        s.roughness.y,
        s.handedness,
        s.metalness,
        s.f0,
        s.transmission,
        s.coverage,
        s.contour,
        bit(s.two_sided),
        bit(s.thin),
    ]);
    values
}

/// Angle between the directions of two normal codes.
fn apart(a: u32, b: u32) -> f64 {
    degrees(normal_unpack(a).as_dvec3(), normal_unpack(b).as_dvec3())
}

#[test]
fn the_shader_agrees_with_its_twin() {
    let gpu = Gpu::new(None).expect("this test needs an adapter");
    let kernel = Kernel::new(
        &gpu,
        &KernelDesc {
            name: "surface/tests",
            sources: &[WGSL, SHADER],
            entry: "pack_and_unpack",
            workgroup: [64, 1, 1],
            bindings: &[
                Bind::storage_read(2, 0, "in_values"),
                Bind::storage(3, 0, "out_words"),
                Bind::storage(3, 1, "out_values"),
            ],
            constants: &[],
        },
    )
    .unwrap();
    let mut random = Random(20);
    let surfaces: Vec<Surface> = (1..COUNT).map(|_| random.surface()).chain([undefined()]).collect();
    let given: Vec<[f32; FLOATS]> = surfaces.iter().map(values).collect();
    let in_values = gpu.storage(Room::Frame, "in_values", &given).unwrap();
    let out_words = gpu.storage(Room::Frame, "out_words", &vec![[0u32; 12]; COUNT]).unwrap();
    let out_values = gpu.storage(Room::Frame, "out_values", &vec![[0f32; FLOATS]; COUNT]).unwrap();
    let mut recorder = Recorder::new(&gpu);
    let resources = [&in_values, &out_words, &out_values].map(|b| b.as_entire_binding());
    recorder.compute("surface/tests", &kernel, &resources, [COUNT as u32 / 64, 1, 1]);
    recorder.finish().unwrap();
    let words: Vec<[[u32; 4]; 3]> = gpu.read_buffer(&out_words).unwrap();
    let back: Vec<[f32; FLOATS]> = gpu.read_buffer(&out_values).unwrap();

    // Codes that the last bit of a division, a power or an arc tangent moved to their neighbour.
    let mut moved = [0; 4];
    let mut worst: f32 = 0.0;
    for (index, s) in surfaces.iter().enumerate() {
        let hash = hash(index as u32);
        let [voxel, texel, [face, gpu_hash, ..]] = words[index];
        assert_eq!(gpu_hash, hash);
        if s.normal.is_nan() {
            assert_eq!((voxel, texel, face), ([0; 4], [0; 4], 0), "nothing undefined is stored");
            continue;
        }
        for (found, wanted) in [(voxel, s.pack_voxel(hash)), (texel, s.pack_gbuffer(hash))] {
            if (found[0] ^ wanted[0]) & 0xff_ffff != 0 {
                moved[0] += 1;
                // One step of the octahedral grid, at its widest.
                assert!(apart(found[0], wanted[0]) < 0.12, "{s:?}");
            } else if found[0] != wanted[0] {
                moved[1] += 1;
                assert_eq!(found[0] >> 31, wanted[0] >> 31, "handedness");
                let steps = ((found[0] >> 24).wrapping_sub(wanted[0] >> 24)) & 127;
                assert!(steps == 1 || steps == 127, "{s:?}");
            }
            for shift in [0, 8, 16, 24] {
                let (found, wanted) = ((found[1] >> shift) & 0xff, (wanted[1] >> shift) & 0xff);
                moved[2] += u32::from(found != wanted);
                assert!(found.abs_diff(wanted) <= 1, "{s:?}");
            }
            assert_eq!(found[2], wanted[2], "light is exact: {s:?}");
            moved[3] += u32::from(found[3] != wanted[3]);
        }
        assert!(degrees(face_normal_unpack(face).as_dvec3(), s.normal.as_dvec3()) < 0.004);

        let mut wanted = values(&Surface::unpack_voxel(voxel));
        wanted[25] = Surface::unpack_gbuffer(texel).metalness;
        wanted[26] = face_normal_unpack(face).x;
        for (slot, (found, wanted)) in back[index].iter().zip(wanted).enumerate() {
            if (9..15).contains(&slot) {
                assert_eq!(*found, wanted, "light is exact");
            }
            worst = worst.max((found - wanted).abs());
        }
    }
    println!(
        "{}: normals, tangents, bytes, lobes moved: {moved:?}; floats differ by {worst:.1e}",
        gpu.info.name
    );
    // Vulkan allows 2.5 ulp to a division and 2^-11 to a sine; the software adapter stays below 3e-7.
    assert!(worst < 5e-4, "{worst}");
    assert!(moved.iter().all(|&m| m < COUNT as u32 / 100), "{moved:?}");
}
