//! A scene that is opaque and diffuse pays for no more, and its image is the one that all words of a record give.

use super::super::{VoxelTracer, structure};
use crate::path::PathSettings;
use crate::{Gather, LightList, Tracer, World};
use frame::scene_gpu::{GpuScene, SceneOptions};
use frame::{FrameInfo, GBuffer, Gpu, Recorder};
use glam::{Quat, Vec3};
use scene::built_in::sealed::sealed_boxes;
use scene::{Camera, Scene};
use voxel::{RecordLayout, Voxelizer};

const SIZE: [u32; 2] = [64, 48];

/// Bytes of the records, and the diffuse lobe in half floats.
fn render(gpu: &Gpu, source: &Scene, scene: &GpuScene) -> (u64, Vec<[u16; 4]>) {
    let mut voxelizer = Voxelizer::new(gpu, scene).unwrap();
    let (grid, _) = voxelizer.voxelize(gpu, scene, &scene.mesh, source.bounds(), 100).unwrap();
    let lights = LightList::of_voxels(gpu, scene, &grid).unwrap();
    let mut gather = Gather::new(gpu, scene).unwrap();
    gather.resize(gpu, &[SIZE]).unwrap();
    let gbuffer = GBuffer::new(gpu, SIZE).unwrap();
    let settings = PathSettings { spp: 4, bounces: Some(3), ..PathSettings::default() };
    let mut tracer = VoxelTracer::default();
    tracer.resize(gpu, scene, SIZE, &settings).unwrap();
    let camera = Camera {
        name: String::new(),
        eye: Vec3::new(1.5, 3.0, 1.3),
        target: Vec3::new(1.5, 0.0, 1.1),
        up: Vec3::Y,
        vfov: 0.9,
    };
    let frame = FrameInfo {
        previous_camera: camera.clone(),
        camera,
        trace_size: SIZE,
        display_size: SIZE,
        jitter: [0.0; 2],
        previous_jitter: [0.0; 2],
        frame_index: 0,
        seed: 1,
        time: 0.0,
        dt: 0.0,
        radiance_scale: scene.radiance_scale,
        diagonal: source.bounds().diagonal(),
        restart: true,
        sun_elsewhere: false,
    };
    let world = World {
        scene,
        mesh: &scene.mesh,
        grid: Some(&grid),
        lbvh: None,
        cwbvh: None,
        grid_lights: Some(&lights),
        triangle_lights: None,
        cache: None,
    };
    let mut recorder = Recorder::new(gpu);
    let uniform = recorder.uniform(&frame.uniform());
    gather.gather(&mut recorder, "gather", &uniform, scene, &scene.mesh, &gbuffer);
    let light = tracer.trace(&mut recorder, &frame, &uniform, world, &gbuffer, &settings);
    recorder.finish().unwrap();
    (grid.records.bytes() / u64::from(grid.voxel_count), gpu.read_texture(&light.diffuse).unwrap())
}

#[test]
fn an_opaque_diffuse_scene_pays_for_no_more_and_looks_the_same() {
    let gpu = Gpu::new(None).expect("this test needs an adapter");
    let source = sealed_boxes(&[Quat::from_rotation_y(0.7), Quat::from_rotation_x(0.4)]);
    let (mut scene, _) = GpuScene::new(&gpu, &source, source.rest(), &SceneOptions::default()).unwrap();
    let layout = RecordLayout::of(&scene.needs);
    // What reads the rest is not among the kernel's sources.
    let (lean_sources, full_sources) =
        (structure(layout, false).sources, structure(RecordLayout::FULL, false).sources);
    let is_read = |sources: &[&str], what: &str| sources.iter().any(|s| s.contains(what));
    assert!(is_read(&full_sources, "array<vec4u>") && !is_read(&lean_sources, "array<vec4u>"));
    assert!(!is_read(&lean_sources, "index + RECORD_LIGHT_AT"));
    assert!(!is_read(&lean_sources, "index + RECORD_LOBE_AT"));
    let (lean_bytes, lean) = render(&gpu, &source, &scene);
    (scene.needs.emission, scene.needs.specular) = (true, true);
    let (full_bytes, full) = render(&gpu, &source, &scene);
    assert_eq!((lean_bytes, full_bytes), (8, 16));
    let differ = lean.iter().zip(&full).filter(|(a, b)| a != b).count();
    println!("{differ} of {} pixels differ", lean.len());
    assert!(lean.iter().filter(|texel| texel[1] > 0).count() > lean.len() / 2, "there is light");
    // The specular lobe's code is there in one of the kernels: a compiler may round a sum in another order.
    assert!(differ * 100 <= lean.len(), "{differ}");
}
