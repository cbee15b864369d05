//! A real scene: how much there is of it, and that it is closed where its triangles are.
#![allow(clippy::unwrap_used)]

use crate::Voxelizer;
use crate::test_scenes::{Random, build, gpu};
use frame::scene_gpu::{GpuScene, SceneOptions};
use scene::Scene;
use std::path::Path;
use std::time::Instant;

#[test]
fn sponza_takes_the_memory_it_was_designed_to() {
    let file = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/scenes/sponza/sponza.gltf"));
    if !file.exists() {
        println!("skipped: no scene at {}", file.display());
        return;
    }
    let Some(gpu) = gpu() else { return };
    let scene = Scene::load(&file.to_string_lossy()).unwrap();
    // Small textures: this test is about cells.
    let options = SceneOptions { texture_budget_bytes: Some(20_000_000), ..Default::default() };
    let (scene, _) = GpuScene::new(&gpu, &scene, scene.rest(), &options).unwrap();
    let mut voxelizer = Voxelizer::new(&gpu, &scene).unwrap();
    let begin = Instant::now();
    let built = build(&gpu, &mut voxelizer, &scene, scene.bounds, 256);
    let seconds = begin.elapsed().as_secs_f32();
    let (voxels, bricks) = (built.voxels.voxel_count, built.voxels.brick_count);
    let bytes = built.voxels.bytes();
    println!("{:?} cells: {voxels} voxels in {bricks} bricks, {seconds:.2} s", built.voxels.cells);
    println!(
        "{} bytes, structure {}, peak {:?}",
        bytes,
        built.voxels.structure.bytes(),
        gpu.memory(frame::Room::Voxels)
    );
    for pass in &built.log.passes {
        println!("  {} x {}: {:?} ms", pass.name, pass.runs, pass.gpu_ms);
    }
    println!("  {:?}", built.log.counts);
    // The design's figures are 466 k conservative voxels in 5,465 bricks and 8.0 MB; thin voxels are fewer.
    assert!((200_000..466_000).contains(&voxels) && (3_000..6_000).contains(&bricks));
    assert!(bytes < 8_000_000, "{bytes}");

    let (mut random, mut iterations, mut hits) = (Random(1), 0u64, 0);
    let cells = built.cells();
    let rays = 20_000;
    for _ in 0..rays {
        // From free cells next to surfaces.
        let at =
            cells[(random.next() * cells.len() as f32) as usize].as_vec3() + 0.5 + 1.5 * random.direction();
        let origin = built.layout.origin + built.layout.voxel_size * at;
        let (hit, walk) = built.grid.trace(origin, random.direction(), 1e4);
        assert!(!walk.cut);
        iterations += u64::from(walk.iterations);
        hits += u32::from(hit.is_some());
    }
    println!("  {:.1} iterations per ray, {hits} of {rays} hit", iterations as f64 / f64::from(rays));
}
