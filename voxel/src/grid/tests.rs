//! The walk against a plain one that knows no blocks, the device against the CPU, and what a walk promises.
#![allow(clippy::unwrap_used)]

use super::reference::{BEHIND, CpuGrid, Hit};
use super::{GRID_WGSL, Grid, Layout, STEPS_PER_CELL, TRACE_WGSL};
use crate::VoxelError;
use crate::record::RecordLayout;
use crate::test_scenes::{Random, gpu};
use frame::surface::{self, CREASE, CREASE_CODE, Surface};
use frame::{Bind, Gpu, Kernel, KernelDesc, Recorder, Room};
use glam::{DVec3, IVec3, Vec3};
use scene::Aabb;
use std::collections::HashSet;

fn layout(grid: u32) -> Layout {
    Layout::fit(Aabb { min: Vec3::new(-3.0, 1.0, 2.0), max: Vec3::new(5.0, 4.0, 8.0) }, grid, 8192).unwrap()
}

/// A sphere's shell, a tilted plane and dust: curved, flat and scattered cells.
fn cells(layout: &Layout) -> HashSet<IVec3> {
    let size = IVec3::from(layout.cells.map(|n| n as i32));
    let middle = 0.5 * size.as_vec3();
    let radius = 0.35 * size.min_element() as f32;
    let mut random = Random(7);
    let mut cells = HashSet::new();
    for z in 0..size.z {
        for y in 0..size.y {
            for x in 0..size.x {
                let p = IVec3::new(x, y, z).as_vec3() + 0.5;
                let shell = (p.distance(middle) - radius).abs() < 0.9;
                let plane = (p.x * 0.6 + p.z * 0.8 - 0.25 * size.x as f32).abs() < 0.5;
                if shell || plane || random.next() < 0.001 {
                    cells.insert(IVec3::new(x, y, z));
                }
            }
        }
    }
    cells
}

#[derive(Clone, Copy)]
struct Ray {
    origin: Vec3,
    direction: Vec3,
    t_max: f32,
    /// Of the point beside the ray, from its origin.
    beside: Vec3,
}

/// Every kind of ray that has broken a walk: general, along axes and planes, from corners and faces, from outside.
fn rays(layout: &Layout, count: usize) -> Vec<Ray> {
    let mut random = Random(99);
    let size = Vec3::from(layout.cells.map(|n| n as f32));
    let diagonal = layout.voxel_size * size.length();
    (0..count)
        .map(|i| {
            let mut o = random.point() * size;
            let mut d = random.direction();
            match i % 8 {
                1 => d = [Vec3::X, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_X][i / 8 % 4],
                2 => d = Vec3::new(d.x, 0.0, d.z).normalize(),
                3 => o = o.floor(),
                4 => (o, d) = (o.floor(), d.signum().normalize()),
                5 => o.x = o.x.floor(),
                6 => {
                    (o, d) =
                        (0.5 * size - 1.2 * d * size.length(), (d + 0.3 * (random.point() - 0.5)).normalize())
                }
                7 => (o, d) = (o.floor() + 0.5, Vec3::new(1.0, d.y.signum(), 1e-14).normalize()),
                _ => {}
            }
            let t_max = if i % 5 == 0 { 0.2 * diagonal } else { 10.0 * diagonal };
            Ray {
                origin: layout.origin + layout.voxel_size * o,
                direction: d,
                t_max,
                beside: if i % 3 == 0 { Vec3::ZERO } else { layout.voxel_size * random.direction() },
            }
        })
        .collect()
}

/// Cell by cell in f64 with the same tie order; also says whether some choice was too close to call in f32.
fn plain(layout: &Layout, cells: &HashSet<IVec3>, ray: &Ray) -> (Option<IVec3>, bool) {
    let origin = (ray.origin - layout.origin) / layout.voxel_size;
    let (o, d) = (origin.as_dvec3(), ray.direction.as_dvec3());
    let size = IVec3::from(layout.cells.map(|n| n as i32));
    let limit = f64::from(ray.t_max) / f64::from(layout.voxel_size);
    // f32 positions up to 256 cells have a grain of 2^-16 cell; a few of them per plane.
    let close = |a: f64, b: f64| (a - b).abs() < 1e-4 * (1.0 + a.abs());
    let far = [0, 1, 2].map(|k| d[k].abs() < 9.1e-13);
    let face = |k: usize, low: bool| if low { 0.0 } else { f64::from(size[k]) } - o[k];
    let (mut t, mut axis, mut out, mut tie) = (0.0f64, 3, f64::MAX, false);
    for k in 0..3 {
        if far[k] {
            if o[k] < 0.0 || o[k] >= f64::from(size[k]) {
                return (None, false);
            }
            continue;
        }
        let enter = face(k, d[k] > 0.0) / d[k];
        tie |= close(enter, t) && t > 0.0;
        if enter > t {
            (t, axis) = (enter, k);
        }
        out = out.min(face(k, d[k] < 0.0) / d[k]);
    }
    tie |= close(t, out) || close(t, limit);
    if t >= out || t > limit {
        return (None, tie);
    }
    let p = o + t * d;
    let mut cell = p.floor().as_ivec3().clamp(IVec3::ZERO, size - 1);
    if axis < 3 {
        cell[axis] = if d[axis] > 0.0 { 0 } else { size[axis] - 1 };
        tie |= (0..3).any(|k| k != axis && close(p[k], p[k].round()));
    }
    loop {
        if cells.contains(&cell) {
            return (Some(cell), tie);
        }
        let exits = DVec3::from([0, 1, 2].map(|k| {
            let plane = f64::from(cell[k]) + if d[k] > 0.0 { 1.0 } else { 0.0 };
            if far[k] { 1e30 } else { (plane - o[k]) / d[k] }
        }));
        let k =
            if exits.x <= exits.y && exits.x <= exits.z { 0 } else { 2 - usize::from(exits.y <= exits.z) };
        tie |= (0..3).any(|j| j != k && close(exits[j], exits[k])) || close(exits[k], limit);
        if exits[k] > limit {
            return (None, tie);
        }
        cell[k] += if d[k] > 0.0 { 1 } else { -1 };
        if cell[k] < 0 || cell[k] >= size[k] {
            return (None, tie);
        }
    }
}

#[test]
fn bounds_become_cells() {
    let cube = Aabb { min: Vec3::splat(-0.5), max: Vec3::splat(0.5) };
    // Three quarters of these sides are no binary fractions: rounding must not add a layer.
    for grid in 5..300 {
        assert_eq!(Layout::fit(cube, grid, 8192).unwrap().cells, [grid; 3], "grid {grid}");
    }
    let flat = Layout::fit(Aabb { min: Vec3::ZERO, max: Vec3::new(1.0, 0.0, 0.3) }, 68, 8192).unwrap();
    assert_eq!(flat.cells, [68, 4, 24]);
    assert_eq!(Layout::fit(Aabb::EMPTY, 64, 8192).unwrap().cells, [4; 3]);
    for (bounds, grid) in [
        (cube, 4),
        (cube, 9000),
        (Aabb { min: Vec3::MIN, max: Vec3::MAX }, 64),
        (Aabb { min: Vec3::ZERO, max: Vec3::new(1e-44, 0.0, 0.0) }, 64),
    ] {
        let refused = Layout::fit(bounds, grid, 8192);
        assert!(matches!(refused, Err(VoxelError::Grid { .. } | VoxelError::Bounds { .. })), "{refused:?}");
    }
}

#[test]
fn every_record_is_numbered_once() {
    let layout = layout(150);
    let cells = cells(&layout);
    let grid = CpuGrid::new(&layout, cells.iter().copied());
    assert_eq!(grid.voxel_count as usize, cells.len());
    let numbers: HashSet<u32> = cells.iter().map(|c| grid.record(*c).unwrap()).collect();
    assert_eq!(numbers.len(), cells.len());
    assert!(numbers.iter().all(|n| *n < grid.voxel_count));
    assert_eq!(
        layout.structure_words(
            grid.structure[grid.grid.table_at as usize..grid.grid.bricks_at as usize]
                .iter()
                .filter(|s| **s < super::EMPTY)
                .count() as u32
        ),
        grid.structure.len() as u64
    );
}

#[test]
fn skipping_blocks_finds_what_plain_steps_find() {
    let layout = layout(150);
    let cells = cells(&layout);
    let grid = CpuGrid::new(&layout, cells.iter().copied());
    let rays = rays(&layout, 100_000);
    let (mut ties, mut differ, mut iterations, mut hits, mut most) = (0, 0, 0u64, 0, 0);
    for ray in &rays {
        let (hit, walk) = grid.trace(ray.origin, ray.direction, ray.t_max);
        assert!(!walk.cut);
        iterations += u64::from(walk.iterations);
        most = most.max(walk.iterations);
        let (there, tie) = plain(&layout, &cells, ray);
        hits += u32::from(hit.is_some());
        match (hit.map(|h| h.cell) == there, tie) {
            (true, _) => {}
            (false, true) => ties += 1,
            (false, false) => {
                differ += 1;
                println!("{:?} {:?}: {hit:?} {there:?}", ray.origin, ray.direction);
            }
        }
    }
    let mean = iterations as f64 / rays.len() as f64;
    println!(
        "{} rays, {hits} hits, {mean:.1} iterations, at most {most}, {ties} ties fell otherwise",
        rays.len()
    );
    assert_eq!(differ, 0);
    assert!(hits > rays.len() as u32 / 5, "enough rays must hit something");
    // A quarter of the rays start on lattice corners or run along lattice planes, where f32 and f64 break ties apart.
    assert!(ties < rays.len() / 25, "{ties}");
}

#[test]
fn the_step_limit_is_never_reached() {
    // The longest walk there is: cell by cell along the diagonal of a grid whose blocks all have one dust grain.
    let layout = Layout::fit(Aabb { min: Vec3::ZERO, max: Vec3::ONE }, 132, 8192).unwrap();
    let size = layout.cells[0] as i32;
    let dust = (0..size).flat_map(|x| (0..size).map(move |y| (x, y)));
    let dust = dust.flat_map(|(x, y)| (0..size).map(move |z| IVec3::new(x, y, z)));
    let grid = CpuGrid::new(&layout, dust.filter(|c| (c.x - c.y).abs() > 2 || (c.x - c.z).abs() > 2));
    let d = Vec3::new(1.0, 0.999, 0.998).normalize();
    let (hit, walk) = grid.trace(layout.origin, d, 100.0);
    println!("{} iterations, hit {hit:?}", walk.iterations);
    assert!(!walk.cut && walk.iterations > size as u32 && walk.iterations <= STEPS_PER_CELL * size as u32);
}

const TRACE: &str = "
struct TestRay { origin: vec3f, t_max: f32, direction: vec3f, pad: u32, beside: vec3f }
@group(2) @binding(0) var<storage, read> in_rays: array<TestRay>;
@group(3) @binding(0) var<storage, read_write> out_hits: array<array<u32, 8>>;
@group(3) @binding(1) var<storage, read_write> out_records: array<u32>;
@compute @workgroup_size(64)
fn trace(@builtin(global_invocation_id) id: vec3u) {
    if (id.x >= arrayLength(&in_rays)) { return; }
    let ray = in_rays[id.x];
    let hit = grid_trace(ray.origin, ray.direction, ray.t_max, ray.beside, GRID_BEHIND);
    out_hits[id.x] = array<u32, 8>(u32(hit.hit), bitcast<u32>(hit.distance), u32(hit.cell.x), u32(hit.cell.y),
        u32(hit.cell.z), hit.axis, hit.iterations, u32(hit.cut) + 2u * u32(grid_occupied(hit.cell)));
    out_records[id.x] = select(0u, hit.record, hit.hit);
}";

/// What the device meets of these rays: the shader's words, and the record.
fn traced(gpu: &Gpu, grid: &CpuGrid, records: &[[u32; 4]], rays: &[Ray]) -> Vec<([u32; 8], u32)> {
    let words: Vec<[u32; 12]> = rays
        .iter()
        .map(|r| {
            let [o, d, b] =
                [r.origin, r.direction, r.origin + r.beside].map(|v| v.to_array().map(f32::to_bits));
            [o[0], o[1], o[2], r.t_max.to_bits(), d[0], d[1], d[2], 0, b[0], b[1], b[2], 0]
        })
        .collect();
    let kernel = Kernel::new(
        gpu,
        &KernelDesc {
            name: "test/trace",
            sources: &[surface::WGSL, GRID_WGSL, RecordLayout::FULL.sources()[0], TRACE_WGSL, TRACE],
            entry: "trace",
            workgroup: [64, 1, 1],
            bindings: &[
                Bind::storage_read(1, 16, "grid_structure"),
                Bind::storage_read(1, 17, "grid_records"),
                Bind::uniform::<Grid>(1, 18, "grid"),
                Bind::storage_read(2, 0, "in_rays"),
                Bind::storage(3, 0, "out_hits"),
                Bind::storage(3, 1, "out_records"),
            ],
            constants: &[],
        },
    )
    .unwrap();
    let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
    let uniform = gpu.buffer(Room::Voxels, "grid", size_of::<Grid>() as u64, usage).unwrap();
    gpu.queue.write_buffer(&uniform, 0, bytemuck::bytes_of(&grid.grid));
    let structure = gpu.storage(Room::Voxels, "structure", &grid.structure).unwrap();
    let records = gpu.storage(Room::Voxels, "records", records).unwrap();
    let input = gpu.storage(Room::Frame, "rays", &words).unwrap();
    let hits = gpu.storage(Room::Frame, "hits", &vec![[0u32; 8]; rays.len()]).unwrap();
    let numbers = gpu.storage(Room::Frame, "numbers", &vec![0u32; rays.len()]).unwrap();
    let mut recorder = Recorder::new(gpu);
    let resources = [&structure, &records, &uniform, &input, &hits, &numbers].map(|b| b.as_entire_binding());
    recorder.compute("test/trace", &kernel, &resources, [rays.len().div_ceil(64) as u32, 1, 1]);
    recorder.finish().unwrap();
    let hits: Vec<[u32; 8]> = gpu.read_buffer(&hits).unwrap();
    let numbers: Vec<u32> = gpu.read_buffer(&numbers).unwrap();
    hits.into_iter().zip(numbers).collect()
}

#[test]
fn the_device_meets_what_the_cpu_meets() {
    let Some(gpu) = gpu() else { return };
    let layout = layout(150);
    let cells = cells(&layout);
    let mut grid = CpuGrid::new(&layout, cells.iter().copied());
    let rays = rays(&layout, 100_000);
    let mut random = Random(5);
    let planes: Vec<[u32; 4]> = (0..grid.voxel_count)
        .map(|i| {
            let surface = Surface {
                normal: random.direction(),
                contour: if i % 4 == 0 { CREASE } else { random.next() - 0.5 },
                ..Surface::default()
            };
            surface.pack_voxel(i)
        })
        .collect();
    let cubes = vec![[0, (CREASE_CODE as u32) << 24, 0, 0]; planes.len()];
    for (name, records, contours) in [("cubes", &cubes, 0), ("sides", &planes, 0), ("planes", &planes, 1)] {
        grid.grid.contours = contours;
        let (mut ties, mut differ) = (0, 0);
        for (ray, (out, record)) in rays.iter().zip(traced(&gpu, &grid, records, &rays)) {
            let beside = ray.origin + ray.beside;
            let (hit, walk) =
                grid.trace_surfaces(records, ray.origin, ray.direction, ray.t_max, (beside, BEHIND));
            assert_eq!(out[7] & 1, 0, "a cut ray");
            let there = (out[0] == 1).then(|| Hit {
                distance: f32::from_bits(out[1]),
                cell: IVec3::new(out[2] as i32, out[3] as i32, out[4] as i32),
                record,
                axis: out[5],
            });
            if let Some(there) = there {
                assert!(out[7] == 2 && cells.contains(&there.cell), "{there:?} is not occupied");
                assert_eq!(grid.record(there.cell), Some(there.record));
            }
            // A device may fuse o + t d into one rounding: distances then differ in the last bits, paths only where two
            // exits, or the two sides of a plane, are that close.
            let same = match (hit.map(|met| met.hit), there) {
                (Some(a), Some(b)) => {
                    (a.cell, a.axis) == (b.cell, b.axis)
                        && (a.distance - b.distance).abs() <= 1e-4 * (1.0 + a.distance)
                }
                (None, None) => walk.iterations.abs_diff(out[6]) <= 2,
                _ => false,
            };
            if !same {
                if contours == 1 || plain(&layout, &cells, ray).1 {
                    ties += 1;
                } else {
                    differ += 1;
                    println!("{:?} {:?}: {hit:?} {there:?}", ray.origin, ray.direction);
                }
            }
        }
        println!("{name}: {} rays, {ties} ties fell otherwise, {differ} differ", rays.len());
        // A point on a plane to the last bit has no side: some rays in a hundred thousand.
        assert!(differ <= rays.len() / 10_000, "{name}: {differ}");
        assert!(ties < rays.len() / 50, "{name}: {ties}");
    }
}
