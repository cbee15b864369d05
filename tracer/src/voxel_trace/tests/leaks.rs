//! Closed boxes in bright sun: light inside has leaked.

use super::super::VoxelTracer;
use crate::path::PathSettings;
use crate::{Gather, LightList, Tracer, World};
use frame::scene_gpu::{GpuScene, SceneOptions};
use frame::surface::hash;
use frame::{FrameInfo, GBuffer, Gpu, Recorder};
use glam::{Quat, Vec3};
use half::f16;
use scene::Camera;
use scene::built_in::sealed::{GRID, MOST_TURNS, WALLS, sealed_boxes};
use voxel::Voxelizer;

const SIZE: [u32; 2] = [24; 2];

fn random(index: u32) -> f32 {
    hash(index) as f32 * (1.0 / 4_294_967_296.0)
}

/// Uniform over all rotations (Shoemake 1992).
fn turn(index: u32) -> Quat {
    let [u, a, b] = [0, 1, 2].map(|k| random(3 * index + k));
    let (a, b) = (std::f32::consts::TAU * a, std::f32::consts::TAU * b);
    let (inner, outer) = ((1.0 - u).max(0.0).sqrt(), u.sqrt());
    Quat::from_xyzw(inner * a.sin(), inner * a.cos(), outer * b.sin(), outer * b.cos()).normalize()
}

/// Mean diffuse radiance inside and outside by thickness of the walls, summed over so many turns and shifts.
fn radiance(knobs: &[(&str, &str)], turns: u32) -> [[f64; 2]; WALLS.len()] {
    let gpu = Gpu::new(None).expect("this test needs an adapter");
    let mut sums = [[0.0; 2]; WALLS.len()];
    for first in (0..turns).step_by(MOST_TURNS) {
        let turned: Vec<Quat> = (first..turns.min(first + MOST_TURNS as u32)).map(turn).collect();
        let source = sealed_boxes(&turned);
        let (scene, _) = GpuScene::new(&gpu, &source, source.rest(), &SceneOptions::default()).unwrap();
        let mut voxelizer = Voxelizer::new(&gpu, &scene).unwrap();
        for (name, value) in knobs {
            frame::set_knob(&mut voxelizer.knobs(), name, value).unwrap();
        }
        // Other bounds of the same size shift the cells against the boxes.
        let mut bounds = source.bounds();
        let voxel_size = bounds.size().max_element() / (GRID - 4) as f32;
        let shift = voxel_size * Vec3::from([0, 1, 2].map(|k| random(7000 + 3 * first + k) - 0.5));
        (bounds.min, bounds.max) = (bounds.min + shift, bounds.max + shift);
        let (grid, _) = voxelizer.voxelize(&gpu, &scene, &scene.mesh, bounds, GRID).unwrap();
        let lights = LightList::of_voxels(&gpu, &scene, &grid).unwrap();
        let mut gather = Gather::new(&gpu, &scene).unwrap();
        gather.resize(&gpu, &[SIZE]).unwrap();
        let gbuffer = GBuffer::new(&gpu, SIZE).unwrap();
        let settings = PathSettings { spp: 2, bounces: Some(3), ..PathSettings::default() };
        let mut tracer = VoxelTracer::default();
        tracer.resize(&gpu, &scene, SIZE, &settings).unwrap();
        let world = World {
            scene: &scene,
            mesh: &scene.mesh,
            grid: Some(&grid),
            lbvh: None,
            cwbvh: None,
            grid_lights: Some(&lights),
            triangle_lights: None,
            cache: None,
        };
        for (place, camera) in source.cameras.iter().enumerate() {
            // Walls, edges and the corner; then the corner alone.
            let views: &[f32] = if place % 2 == 0 { &[camera.vfov, 0.1] } else { &[camera.vfov] };
            for vfov in views {
                let camera = Camera { vfov: *vfov, ..camera.clone() };
                let frame = FrameInfo {
                    previous_camera: camera.clone(),
                    camera,
                    trace_size: SIZE,
                    display_size: SIZE,
                    jitter: [0.0; 2],
                    previous_jitter: [0.0; 2],
                    frame_index: 0,
                    seed: first,
                    time: 0.0,
                    dt: 0.0,
                    radiance_scale: scene.radiance_scale,
                    diagonal: source.bounds().diagonal(),
                    restart: true,
                    sun_elsewhere: false,
                };
                let mut recorder = Recorder::new(&gpu);
                let uniform = recorder.uniform(&frame.uniform());
                gather.gather(&mut recorder, "gather", &uniform, &scene, &scene.mesh, &gbuffer);
                let light = tracer.trace(&mut recorder, &frame, &uniform, world, &gbuffer, &settings);
                recorder.finish().unwrap();
                let texels: Vec<[u16; 4]> = gpu.read_texture(&light.diffuse).unwrap();
                let sum: f64 = texels.iter().map(|t| f64::from(f16::from_bits(t[1]).to_f32())).sum();
                let row = place / 2 / turned.len();
                sums[row][place % 2] += sum / texels.len() as f64 / views.len() as f64;
                if place % 2 == 0 && sum > 0.0 {
                    println!(
                        "turn {}, walls {}, vfov {vfov}: {:.2e}",
                        first as usize + place / 2 % turned.len(),
                        WALLS[row],
                        sum / texels.len() as f64
                    );
                }
            }
        }
    }
    sums
}

fn check(knobs: &[(&str, &str)], turns: u32) {
    // Half of the pixels look at nothing but 1.7 voxels around a corner. One path in 10^4 that finds the sun there is
    // 10^-4 of the light outside: few turns say nothing finer.
    let bound = if turns < 64 { 2e-4 } else { 1e-4 };
    for (walls, [inside, outside]) in WALLS.iter().zip(radiance(knobs, turns)) {
        println!("{knobs:?}, walls of {walls}: {:.2e}", inside / outside);
        assert!(outside > 0.0 && inside < bound * outside, "walls of {walls}: {inside} {outside}");
    }
}

#[test]
fn a_sealed_box_is_dark_inside() {
    check(&[], 4);
}

#[test]
fn a_sealed_box_of_planes_is_dark_inside() {
    check(&[("contours", "on")], 4);
}

#[test]
#[ignore = "takes minutes: 64 turns and shifts"]
fn a_sealed_box_is_dark_inside_however_it_is_turned() {
    check(&[], 64);
    check(&[("contours", "on")], 64);
}
