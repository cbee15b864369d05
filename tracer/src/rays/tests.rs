//! Rays through the grid: on the device against the CPU's walk, and against what a plane says.
#![allow(clippy::unwrap_used)]

use super::{Ray, RayBatch};
use frame::surface::CREASE_CODE;
use frame::{Gpu, Room};
use glam::{IVec3, Vec3};
use scene::Aabb;
use voxel::grid::reference::{BEHIND, CpuGrid};
use voxel::grid::{Grid, Layout};
use wgpu::BufferUsages;

/// Grid of 64 cells of 1/60 m around the unit cube.
fn layout() -> Layout {
    Layout::fit(Aabb { min: Vec3::ZERO, max: Vec3::ONE }, 64, 8192).unwrap()
}

/// What the device meets in a grid made on the CPU, and what the CPU meets: record, distance (m) and steps.
fn both(grid: &CpuGrid, rays: &[Ray]) -> Vec<[(u32, f32, u32); 2]> {
    let gpu = Gpu::new(None).expect("these tests need an adapter; a software one will do");
    let structure = gpu.storage(Room::Voxels, "structure", &grid.structure).unwrap();
    let usage = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
    let uniform = gpu.buffer(Room::Voxels, "grid", size_of::<Grid>() as u64, usage).unwrap();
    gpu.queue.write_buffer(&uniform, 0, bytemuck::bytes_of(&grid.grid));
    // Cells without planes: their cubes are met.
    let records = vec![[0, (CREASE_CODE as u32) << 24, 0, 0]; grid.voxel_count as usize];
    let stored = gpu.storage(Room::Voxels, "records", &records).unwrap();
    let resources = [&structure, &stored, &uniform].map(|buffer| buffer.as_entire_binding());
    let traced = RayBatch::of_grid(&gpu).unwrap().closest(&gpu, &resources, rays).unwrap();
    assert_eq!(traced.answers.len(), rays.len());
    let on_cpu = rays.iter().map(|ray| {
        let [origin, direction] = [ray.origin, ray.direction].map(Vec3::from);
        let (met, walk) = grid.trace_surfaces(&records, origin, direction, ray.t_max, (origin, BEHIND));
        let (record, distance) =
            met.map_or((Ray::NOTHING, ray.t_max), |met| (met.hit.record, met.hit.distance));
        (record, distance, walk.iterations)
    });
    traced
        .answers
        .iter()
        .map(|met| (met.primitive, met.distance, met.visits))
        .zip(on_cpu)
        .map(|(a, b)| [a, b])
        .collect()
}

/// A number in 0..1 for each index.
fn random(index: u32) -> f32 {
    frame::surface::hash(index) as f32 * (1.0 / 4_294_967_296.0)
}

#[test]
fn the_device_meets_what_the_cpu_meets() {
    let layout = layout();
    // A cell in eleven, so that most rays meet something after some steps.
    let cells = (0..64 * 64 * 64).map(|i: i32| IVec3::new(i % 64, i / 64 % 64, i / 4096));
    let occupied = cells.filter(|c| random((c.x + 64 * (c.y + 64 * c.z)) as u32) < 1.0 / 11.0 && c.x > 20);
    let grid = CpuGrid::new(&layout, occupied);
    let rays: Vec<Ray> = (0..5000)
        .map(|i| {
            let at = |k: u32| random(6 * i + k + 1_000_000);
            let direction = Vec3::new(at(0), at(1), at(2)) - 0.5;
            Ray::new(Vec3::new(at(3), at(4), at(5)), direction.normalize(), 0.8)
        })
        .collect();
    let met = both(&grid, &rays);
    // A device may fuse o + t d into one rounding: a ray that passes an edge within 2^-17 voxel may take either side.
    let differ = met.iter().filter(|[a, b]| a.0 != b.0 || (a.1 - b.1).abs() > 1e-5).count();
    assert!(differ <= 5, "{differ} of {}", met.len());
    let hits = met.iter().filter(|[a, _]| a.0 != Ray::NOTHING).count();
    assert!(hits > 2500 && hits < 5000, "{hits}");
}

#[test]
fn a_plane_is_met_at_its_distance_in_its_cell() {
    let layout = layout();
    let grid = CpuGrid::new(&layout, (0..64 * 64).map(|i| IVec3::new(i % 64, i / 64, 40)));
    let face = layout.origin.z + 40.0 * layout.voxel_size;
    let rays: Vec<Ray> = (0..1000)
        .map(|i| {
            let origin = Vec3::new(0.5, 0.5, 0.1);
            let to = Vec3::new(random(2 * i), random(2 * i + 1), face);
            Ray::new(origin, (to - origin).normalize(), 10.0)
        })
        .collect();
    for (ray, [(record, distance, _), _]) in rays.iter().zip(both(&grid, &rays)) {
        assert_ne!(record, Ray::NOTHING);
        let expected = (face - 0.1) / ray.direction[2];
        // Positions of 64 cells have a grain of 2^-18 cell, distances a few of them.
        assert!((distance - expected).abs() < 1e-6 * expected + 1e-6, "{distance} {expected}");
    }
    let away = Ray::new(Vec3::new(0.5, 0.5, 0.1), Vec3::NEG_Z, 10.0);
    assert_eq!(both(&grid, &[away])[0][0].0, Ray::NOTHING);
}
