//! GPU against CPU, and closed forms.
#![allow(clippy::unwrap_used, clippy::panic)]

mod gpu_matches_cpu;
mod pictures;
mod upload;

use super::*;
use crate::surface;
use glam::{Mat3, Vec2};
use scene::{Image, TextureSlot, Wrap};

/// Numbers in 0..1 that depend on nothing but the seed.
struct Random(u32);

impl Random {
    fn next(&mut self) -> f32 {
        self.0 = surface::hash(self.0);
        (self.0 >> 8) as f32 / 16_777_216.0
    }

    fn below(&mut self, n: u32) -> u32 {
        ((self.next() * n as f32) as u32).min(n - 1)
    }
}

fn random_image(name: &str, width: u32, height: u32) -> Image {
    let mut random = Random(width * 4099 + height);
    let mut texel = || [0; 4].map(|_: u8| random.below(256) as u8);
    Image { name: name.into(), width, height, rgba: (0..width * height).map(|_| texel()).collect() }
}

fn slot(image: u32, wrap: [Wrap; 2], linear: bool) -> TextureSlot {
    let uv_transform = Mat3::from_translation(Vec2::new(0.3, -0.7))
        * Mat3::from_angle(0.4)
        * Mat3::from_scale(Vec2::new(1.7, 0.6));
    TextureSlot { image, uv_set: image % 2, uv_transform, wrap, linear }
}

fn scene(name: &str) -> Scene {
    Scene::load(name).unwrap()
}

fn gpu() -> Gpu {
    Gpu::new(None).expect("these tests need an adapter; a software one will do")
}

fn uploaded(gpu: &Gpu, scene: &Scene) -> GpuScene {
    GpuScene::new(gpu, scene, scene.rest(), &SceneOptions::default()).unwrap().0
}
