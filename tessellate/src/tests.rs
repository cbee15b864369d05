//! Promises of every tessellator.
#![allow(clippy::unwrap_used, clippy::panic)]

use crate::all;
use frame::info::FrameInfo;
use frame::scene_gpu::{GpuScene, SceneOptions};
use frame::{Gpu, Recorder};
use scene::{Camera, Scene};

#[test]
fn identity_returns_the_same_buffers_and_runs_nothing() {
    let gpu = Gpu::new(None).expect("tests need an adapter, a software one will do");
    let world = Scene::load("cornell").unwrap();
    let (uploaded, _) = GpuScene::new(&gpu, &world, world.rest(), &SceneOptions::default()).unwrap();
    let camera = Camera::framing(world.bounds());
    let frame = FrameInfo {
        previous_camera: camera.clone(),
        camera,
        trace_size: [4, 3],
        display_size: [4, 3],
        jitter: [0.0; 2],
        previous_jitter: [0.0; 2],
        frame_index: 0,
        seed: 1,
        time: 0.0,
        dt: 0.0,
        radiance_scale: uploaded.radiance_scale,
        diagonal: world.bounds().diagonal(),
        restart: true,
        sun_elsewhere: false,
    };
    for (name, make) in all().iter().filter(|(name, _)| *name == "identity") {
        let mut recorder = Recorder::new(&gpu);
        let mesh = make(&gpu).unwrap().tessellate(&mut recorder, &frame, 0.01, &uploaded.mesh);
        assert!(recorder.finish().unwrap().passes.is_empty(), "{name}");
        let before = &uploaded.mesh;
        for (after, before) in [
            (&mesh.vertices, &before.vertices),
            (&mesh.previous, &before.previous),
            (&mesh.triangles, &before.triangles),
        ] {
            assert!(**after == **before, "{name}: another {}", before.label());
        }
        assert_eq!(
            (mesh.vertex_count, mesh.triangle_count),
            (before.vertex_count, before.triangle_count),
            "{name}"
        );
    }
}

#[test]
fn names_are_those_of_the_list() {
    let gpu = Gpu::new(None).expect("tests need an adapter, a software one will do");
    for (name, make) in all() {
        assert_eq!(make(&gpu).unwrap().name(), *name);
    }
}
