//! What does it take to build what rays search: the grid, or a triangle BVH on the same cores? Prints, asserts nothing:
//! times are only good as ratios, and those differ by machine. `cargo test --test main build_time -- --ignored --nocapture`

use crate::support::{gpu, shared};
use frame::scene_gpu::{GpuScene, SceneOptions};
use scene::Scene;
use std::time::Instant;
use tracer::bvh::cwbvh::{self, Quality};
use voxel::Voxelizer;

/// Seconds of all cores that this process took, where the system says so.
fn cpu_seconds() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // The name before may hold spaces; utime and stime are the 12th and 13th word behind it, in 1/100 s.
    let words: Vec<f64> =
        stat.rsplit(')').next().unwrap_or("").split_whitespace().map(|w| w.parse().unwrap_or(0.0)).collect();
    words.get(11..13).map_or(0.0, |times| times.iter().sum::<f64>() / 100.0)
}

/// Wall and core seconds of something.
fn timed(run: impl FnOnce()) -> [f64; 2] {
    let (start, cpu) = (Instant::now(), cpu_seconds());
    run();
    [start.elapsed().as_secs_f64(), cpu_seconds() - cpu]
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

#[test]
#[ignore = "minutes, and nothing to assert"]
fn of_the_grid_against_a_bvh() {
    let Some(scenes) = shared("scenes") else { return };
    let gpu = gpu();
    for (file, cells) in [("sponza/sponza.gltf", 256), ("wooden_staircase/wooden_staircase.gltf", 512)] {
        let path = scenes.join(file);
        let scene = Scene::load(&path.to_string_lossy()).unwrap();
        let (uploaded, _) = GpuScene::new(&gpu, &scene, scene.rest(), &SceneOptions::default()).unwrap();
        let mut ways: Vec<(&str, Voxelizer)> = ["raster", "compute"]
            .into_iter()
            .map(|way| {
                let mut voxelizer = Voxelizer::new(&gpu, &uploaded).unwrap();
                frame::set_knob(&mut voxelizer.knobs(), "voxelizer", way).unwrap();
                (way, voxelizer)
            })
            .collect();
        let build = |voxelizer: &mut Voxelizer, cells| {
            voxelizer.voxelize(&gpu, &uploaded, &uploaded.mesh, scene.bounds(), cells).unwrap();
        };
        for (_, voxelizer) in &mut ways {
            // Kernels are compiled when they first run.
            build(voxelizer, 32);
        }
        let mut times: Vec<Vec<[f64; 2]>> = vec![Vec::new(); ways.len() + 1];
        for _ in 0..3 {
            for ((_, voxelizer), times) in ways.iter_mut().zip(&mut times) {
                times.push(timed(|| build(voxelizer, cells)));
            }
            let mut wall = 0.0;
            let [_, cpu] = timed(|| {
                let built = cwbvh::build(&gpu, &uploaded, &uploaded.mesh, Quality::Medium).unwrap();
                wall = built.build_ms / 1e3;
            });
            if let Some(times) = times.last_mut() {
                times.push([wall, cpu]);
            }
        }
        let of = |times: &[[f64; 2]]| [0, 1].map(|k| median(times.iter().map(|t| t[k]).collect()));
        let bvh = of(&times[ways.len()]);
        println!("{file}, {} triangles: CWBVH {:.2} s", uploaded.mesh.triangle_count, bvh[0]);
        for ((way, _), times) in ways.iter().zip(&times) {
            let [wall, cpu] = of(times);
            let (by_wall, by_cpu) = (wall / bvh[0], cpu / bvh[1]);
            println!(
                "  {cells} cells, {way}: {wall:.2} s, {by_wall:.2} times; of all cores' seconds {by_cpu:.2}"
            );
        }
    }
}
