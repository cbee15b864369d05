//! Levels that moved against levels built where they are, rays through them against triangles in f64, and what a scene of
//! 100 m takes.
#![allow(clippy::unwrap_used)]

use super::{Cascades, Level};
use crate::grid::{Grid, LEVELS};
use crate::test_scenes::{Part, Random, gpu, quad, soup, sphere, upload};
use crate::{LEVELS_BINDS, LEVELS_WGSL, RecordLayout, TRACE_LEVELS_WGSL, VoxelError, VoxelGrid, Voxelizer};
use frame::scene_gpu::GpuScene;
use frame::{Bind, Gpu, Kernel, KernelDesc, Recorder, Room, surface};
use glam::{DVec3, IVec3, Vec3};
use scene::{Aabb, Material};

const UNIT: Aabb = Aabb { min: Vec3::ZERO, max: Vec3::ONE };

fn voxelizer(gpu: &Gpu, scene: &GpuScene, knobs: &[(&str, &str)]) -> Voxelizer {
    let mut voxelizer = Voxelizer::new(gpu, scene).unwrap();
    for (knob, value) in knobs {
        frame::set_knob(&mut voxelizer.knobs(), knob, value).unwrap();
    }
    voxelizer
}

/// Everything that tracers read.
fn words(gpu: &Gpu, grid: &VoxelGrid, cascades: &Cascades) -> ([Vec<u32>; 2], Vec<Grid>) {
    let uniforms = cascades.levels.iter().enumerate().map(|(number, level)| cascades.uniform(number, level));
    ([&grid.structure, &grid.records].map(|buffer| gpu.read_buffer(buffer).unwrap()), uniforms.collect())
}

#[test]
fn levels_that_moved_are_those_that_a_build_there_gives() {
    let Some(gpu) = gpu() else { return };
    let lamp = Material::emitter("", Vec3::ZERO, Vec3::new(3.0, 2.0, 1.0));
    let parts: Vec<Part> = vec![
        (Material::lambert("", Vec3::new(0.8, 0.3, 0.1)), soup(200, 0.6)),
        // Larger than any finer level.
        (
            Material::lambert("", Vec3::X),
            vec![[Vec3::ZERO, Vec3::new(1.0, 0.1, 0.0), Vec3::new(0.3, 0.9, 1.0)]],
        ),
        (lamp, quad(Vec3::new(0.2, 0.9, 0.2), 0.3 * Vec3::X, 0.2 * Vec3::Z)),
    ];
    let scene = upload(&gpu, &parts);
    for cover in ["thin", "conservative"] {
        let knobs = [("cascades", "4"), ("cover", cover)];
        let mut moving = voxelizer(&gpu, &scene, &knobs);
        let mut fresh = voxelizer(&gpu, &scene, &knobs);
        let mut eye = Vec3::splat(0.4);
        let (mut grid, mut cascades, _) =
            moving.voxelize_levels(&gpu, &scene, &scene.mesh, UNIT, 48, eye).unwrap();
        let mut random = Random(7);
        let mut moves = 0;
        for step in 0..10 {
            // Less than a brick of the finest level, some, and far away.
            let reach = [0.01, 0.1, 0.1, 1.0][step % 4];
            eye = (eye + reach * (2.0 * random.point() - 1.0)).clamp(Vec3::splat(-0.2), Vec3::splat(1.2));
            let before = cascades.moves(eye);
            let log = moving.follow(&gpu, &scene, &scene.mesh, &mut grid, &mut cascades, eye).unwrap();
            assert_eq!((log.is_some(), cascades.moves(eye)), (before, false));
            moves += usize::from(before);
            let (built, there, all) =
                fresh.voxelize_levels(&gpu, &scene, &scene.mesh, UNIT, 48, eye).unwrap();
            let (is, expected) = (words(&gpu, &grid, &cascades), words(&gpu, &built, &there));
            assert!(is == expected, "{cover}, step {step}");
            assert_eq!(grid.glowing, built.glowing, "{cover}, step {step}");
            assert_eq!((grid.voxel_count, grid.brick_count), (built.voxel_count, built.brick_count));
            if let Some(log) = log.filter(|_| reach == 0.1) {
                // Of four levels the coarsest never moves, and the next hardly.
                assert!(log.counts["new_bricks"] < all.counts["new_bricks"], "{cover}, step {step}");
            }
        }
        assert!(moves > 5, "{moves}");
    }
}

#[test]
fn what_cannot_be_nested_is_an_error_with_the_numbers() {
    let Some(gpu) = gpu() else { return };
    let scene = upload(&gpu, &[(Material::lambert("", Vec3::X), soup(3, 0.5))]);
    let build = |knobs: &[(&str, &str)], grid| {
        let mut voxelizer = voxelizer(&gpu, &scene, knobs);
        voxelizer.voxelize_levels(&gpu, &scene, &scene.mesh, UNIT, grid, Vec3::ZERO).map(|_| ())
    };
    let contours = build(&[("cascades", "2"), ("contours", "on")], 40);
    assert!(matches!(contours, Err(VoxelError::CascadedContours { cascades: 2 })), "{contours:?}");
    let cells = build(&[("cascades", "8")], 1000);
    let expected = VoxelError::Cascades { grid: 1000, cascades: 8, cells: 128_000, most: 65_536 };
    assert_eq!(cells.unwrap_err().to_string(), expected.to_string());
    assert!(build(&[("cascades", "8")], 20).is_ok());
}

const TRACE: &str = "
struct TestRay { origin: vec3f, t_max: f32, direction: vec3f }
@group(2) @binding(0) var<storage, read> in_rays: array<TestRay>;
@group(3) @binding(0) var<storage, read_write> out_hits: array<vec4u>;
@compute @workgroup_size(64)
fn trace(@builtin(global_invocation_id) id: vec3u) {
    if (id.x >= arrayLength(&in_rays)) { return; }
    let ray = in_rays[id.x];
    let hit = grid_first(ray.origin, ray.direction, ray.t_max, ray.origin, GRID_BEHIND);
    out_hits[id.x] = vec4u(u32(hit.hit) + 2u * u32(hit.cut), bitcast<u32>(hit.distance), grid_level(), hit.iterations);
}";

/// Distance, m, and level.
type Met = Option<(f32, u32)>;

/// What rays from points along unit directions meet.
fn traced(gpu: &Gpu, grid: &VoxelGrid, rays: &[(Vec3, Vec3)]) -> Vec<Met> {
    let words: Vec<[u32; 8]> = rays
        .iter()
        .map(|(origin, direction)| {
            let ([a, b, c], [d, e, f]) = (origin.to_array(), direction.to_array());
            [a, b, c, 1e4, d, e, f, 0.0].map(f32::to_bits)
        })
        .collect();
    let records = RecordLayout::sources(grid.record);
    let sources = [&[surface::WGSL, LEVELS_WGSL], &records[..], &[TRACE_LEVELS_WGSL, TRACE]].concat();
    let mut bindings = LEVELS_BINDS.to_vec();
    bindings.extend([Bind::storage_read(2, 0, "in_rays"), Bind::storage(3, 0, "out_hits")]);
    let desc = KernelDesc {
        name: "test/levels",
        sources: &sources,
        entry: "trace",
        workgroup: [64, 1, 1],
        bindings: &bindings,
        constants: &[],
    };
    let kernel = Kernel::new(gpu, &desc).unwrap();
    let input = gpu.storage(Room::Frame, "rays", &words).unwrap();
    let hits = gpu.storage(Room::Frame, "hits", &vec![[0u32; 4]; rays.len()]).unwrap();
    let mut recorder = Recorder::new(gpu);
    let mut resources = grid.resources().to_vec();
    resources.extend([&input, &hits].map(|b| b.as_entire_binding()));
    recorder.compute("test/levels", &kernel, &resources, [rays.len().div_ceil(64) as u32, 1, 1]);
    recorder.finish().unwrap();
    let hits: Vec<[u32; 4]> = gpu.read_buffer(&hits).unwrap();
    hits.into_iter()
        .map(|[hit, distance, level, iterations]| {
            assert!(hit < 2, "cut after {iterations}");
            (hit == 1).then_some((f32::from_bits(distance), level))
        })
        .collect()
}

/// Distance along a ray to a triangle (Möller and Trumbore 1997).
fn meets([a, b, c]: [DVec3; 3], o: DVec3, d: DVec3) -> Option<f64> {
    let (ab, ac) = (b - a, c - a);
    let p = d.cross(ac);
    let det = ab.dot(p);
    let s = o - a;
    let (u, q) = (s.dot(p) / det, s.cross(ab));
    let v = d.dot(q) / det;
    let t = ac.dot(q) / det;
    (det != 0.0 && u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0).then_some(t)
}

/// Distance of a point from a triangle.
fn away([a, b, c]: [DVec3; 3], p: DVec3) -> f64 {
    let n = (b - a).cross(c - a).normalize();
    let inside = [(a, b), (b, c), (c, a)].iter().all(|(a, b)| n.cross(*b - *a).dot(p - *a) >= 0.0);
    if inside {
        return n.dot(p - a).abs();
    }
    let edge = |(a, b): (DVec3, DVec3)| {
        let t = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
        (p - a - t * (b - a)).length()
    };
    [(a, b), (b, c), (c, a)].into_iter().map(edge).fold(f64::MAX, f64::min)
}

fn room() -> Vec<[Vec3; 3]> {
    let mut triangles = sphere(Vec3::new(0.62, 0.35, 0.5), 0.17, 10);
    triangles.extend(sphere(Vec3::new(0.3, 0.7, 0.7), 0.05, 6));
    triangles.extend(sphere(Vec3::splat(0.5), 0.49, 12));
    triangles
}

#[test]
fn rays_through_levels_meet_what_rays_meet_of_triangles() {
    let Some(gpu) = gpu() else { return };
    let triangles = room();
    let scene = upload(&gpu, &[(Material::lambert("", Vec3::splat(0.5)), triangles.clone())]);
    let of_f64: Vec<[DVec3; 3]> = triangles.iter().map(|t| t.map(|p| p.as_dvec3())).collect();
    let mut voxelizer = voxelizer(&gpu, &scene, &[("cascades", "4"), ("cover", "conservative")]);
    // Close to the small ball.
    let eye = Vec3::new(0.36, 0.7, 0.7);
    let (grid, cascades, _) = voxelizer.voxelize_levels(&gpu, &scene, &scene.mesh, UNIT, 48, eye).unwrap();
    let mut random = Random(3);
    // In the free room, three of the coarsest voxels off all walls: what it starts in is not asked here.
    let is_free = |o: Vec3| {
        let free = of_f64.iter().map(|t| away(*t, o.as_dvec3())).fold(f64::MAX, f64::min);
        let within = |center: Vec3, radius: f32| o.distance(center) < radius;
        let is_inside = within(Vec3::splat(0.5), 0.47)
            && !within(Vec3::new(0.62, 0.35, 0.5), 0.17)
            && !within(Vec3::new(0.3, 0.7, 0.7), 0.05);
        is_inside && free > 3.0 * f64::from(grid.voxel_size)
    };
    let mut rays: Vec<(Vec3, Vec3)> = Vec::new();
    while rays.len() < 20_000 {
        let o = random.point();
        if is_free(o) {
            // Anywhere, and to where the fine levels are.
            let near = eye + 0.15 * (random.point() - 0.5);
            rays.extend([(o, random.direction()), (o, (near - o).normalize())]);
        }
    }
    let hits = traced(&gpu, &grid, &rays);
    let mut by_level = [0; LEVELS as usize];
    let (mut late, mut early) = (0, 0);
    for ((o, d), hit) in rays.iter().zip(hits) {
        let (o, d) = (o.as_dvec3(), d.as_dvec3());
        let t = of_f64.iter().filter_map(|t| meets(*t, o, d)).fold(f64::MAX, f64::min);
        let Some((distance, level)) = hit else {
            late += 1;
            continue;
        };
        by_level[level as usize] += 1;
        let voxel_size = f64::from(grid.voxel_size) / 2f64.powi(LEVELS as i32 - 1 - level as i32);
        let distance = f64::from(distance);
        // Rounding of positions: 2^-20 of the room. Where a ray changes levels within a cell, it may be as late as that is
        // long.
        let is_late = distance > t + 1.75 * voxel_size;
        late += usize::from(is_late);
        if is_late {
            println!("{o} {d}: {distance} m in level {level}, {t} m to a triangle");
        }
        // Somewhere in the cube that was met there is a surface.
        let point = o + distance * d;
        let nearest = of_f64.iter().map(|t| away(*t, point)).fold(f64::MAX, f64::min);
        early += usize::from(nearest > 1.75 * voxel_size);
    }
    println!("hits by level {by_level:?}; late {late}, early {early}");
    assert_eq!((late, early), (0, 0));
    assert!(by_level[4..].iter().all(|n| *n > 200), "{by_level:?}");
    assert_eq!(cascades.levels.len(), 4);
}

#[test]
fn what_rays_meet_does_not_depend_on_where_levels_are_placed() {
    let Some(gpu) = gpu() else { return };
    let scene = upload(&gpu, &[(Material::lambert("", Vec3::splat(0.5)), room())]);
    let mut voxelizer = voxelizer(&gpu, &scene, &[("cascades", "4")]);
    let mut at = |eye| voxelizer.voxelize_levels(&gpu, &scene, &scene.mesh, UNIT, 48, eye).unwrap();
    let brick = {
        let (grid, _, _) = at(Vec3::splat(0.4));
        grid.voxel_size
    };
    // On either side of where the finest level, with bricks of a coarsest voxel, goes on by one along every axis.
    let (origin, half_way) = (-2.0 * brick, (0.4 / brick).floor() * brick + 0.5 * brick);
    let eye = Vec3::splat(origin + half_way);
    let [(before, one, _), (after, other, _)] = [-0.1, 0.1].map(|off| at(eye + off * brick));
    assert_ne!(one.levels[3].layout.low, other.levels[3].layout.low);
    // From there both are seen; the boxes are where the viewer is.
    one.look(&gpu, eye);
    other.look(&gpu, eye);
    let mut random = Random(11);
    let rays: Vec<_> =
        (0..20_000).map(|_| (eye + 0.2 * (random.point() - 0.5), random.direction())).collect();
    let (a, b) = (traced(&gpu, &before, &rays), traced(&gpu, &after, &rays));
    let same = |pair: &(&Met, &Met)| match pair {
        // Positions in a level are rounded from its corner: 2^-20 of the scene.
        (Some((a, i)), Some((b, j))) => i == j && (a - b).abs() < 1e-5,
        (a, b) => a.is_none() && b.is_none(),
    };
    let others = a.iter().zip(&b).filter(|pair| !same(pair)).count();
    // One in a thousand passes a corner of a cell so closely that rounding decides.
    assert!(others < 20, "{others} of {} rays meet something else", rays.len());
}

fn cells(gpu: &Gpu, level: &Level) -> Vec<IVec3> {
    let structure: Vec<u32> = gpu.read_buffer(&level.structure).unwrap();
    let mut grid = level.layout.uniform(0);
    (grid.table_at, grid.bricks_at) = (level.table_at, level.bricks_at);
    crate::grid::reference::CpuGrid { grid, structure, voxel_count: level.voxel_count }.cells()
}

#[test]
fn a_detail_of_a_centimetre_is_there_in_a_scene_of_a_hundred_metres() {
    let Some(gpu) = gpu() else { return };
    let bounds = Aabb { min: Vec3::new(-50.0, 0.0, -50.0), max: Vec3::new(50.0, 30.0, 50.0) };
    let mut triangles = quad(bounds.min, 100.0 * Vec3::X, 100.0 * Vec3::Z);
    // Houses of ten metres all over it, and a pearl of a centimetre on the ground.
    for i in 0..49 {
        let at = Vec3::new(14.0 * (i % 7) as f32 - 45.0, 8.0, 14.0 * (i / 7) as f32 - 45.0);
        triangles.extend(sphere(at, 5.0, 16));
    }
    let pearl = Vec3::new(31.234, 0.005, 17.771);
    triangles.extend(sphere(pearl, 0.005, 8));
    let scene = upload(&gpu, &[(Material::lambert("", Vec3::splat(0.5)), triangles)]);
    let mut voxelizer = voxelizer(&gpu, &scene, &[("cascades", "8")]);
    let eye = pearl + Vec3::new(0.1, 0.15, 0.1);
    let (grid, cascades, _) = voxelizer.voxelize_levels(&gpu, &scene, &scene.mesh, bounds, 128, eye).unwrap();
    let finest = cascades.levels.last().unwrap();
    assert!((finest.layout.voxel_size - 100.0 / 124.0 / 128.0).abs() < 1e-6);
    let there = |level: &Level| {
        let size = level.layout.voxel_size;
        let centers =
            cells(&gpu, level).into_iter().map(|c| level.layout.corner() + size * (c.as_vec3() + 0.5));
        // Above the ground by more than its own voxel.
        centers.filter(|c| c.distance(pearl) < 0.005 + size && c.y > size).count()
    };
    assert!(there(finest) > 0);
    assert_eq!(there(&cascades.levels[0]), 0);
    // Memory says what a budget of 64 MB is compared with.
    println!("{} voxels in 8 levels: {:.1} MB", grid.voxel_count, grid.bytes() as f64 / 1e6);
    assert!(grid.bytes() < 64_000_000, "{}", grid.bytes());
    // Rays from above at the middle of the pearl: none of them reaches the ground.
    let rays: Vec<_> = (0..64)
        .map(|i| {
            let from = pearl + Vec3::new(0.01 * (i % 8) as f32 - 0.035, 0.1, 0.01 * (i / 8) as f32 - 0.035);
            (from, (pearl - from).normalize())
        })
        .collect();
    for ((from, _), hit) in rays.iter().zip(traced(&gpu, &grid, &rays)) {
        let (distance, level) = hit.unwrap();
        assert_eq!(level, LEVELS - 1 - 7);
        let miss = (from.distance(pearl) - 0.005 - distance).abs();
        assert!(miss < 1.75 * finest.layout.voxel_size, "{miss} m");
    }
}
