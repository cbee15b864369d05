//! The raster pass against one ray per pixel.
#![allow(clippy::unwrap_used, clippy::panic)]

use super::*;
use frame::scene_gpu::SceneOptions;
use frame::surface::{self, Surface};
use frame::{FrameInfo, Texture};
use glam::{Vec2, Vec3};
use reference::{Caster, Hit, camera_ray};
use scene::{Alpha, Geometry, Scene};

const SIZE: [u32; 2] = [64, 48];

fn frame_info(scene: &Scene, uploaded: &GpuScene) -> FrameInfo {
    let camera = scene.cameras.first().cloned().unwrap_or_else(|| scene::Camera::framing(scene.bounds()));
    FrameInfo {
        previous_camera: camera.clone(),
        camera,
        trace_size: SIZE,
        display_size: SIZE,
        jitter: [0.0; 2],
        previous_jitter: [0.0; 2],
        frame_index: 0,
        seed: 7,
        time: 0.0,
        dt: 0.0,
        radiance_scale: uploaded.radiance_scale,
        diagonal: scene.bounds().diagonal(),
        restart: true,
        sun_elsewhere: false,
    }
}

/// One pixel as the G-buffer has it, unpacked.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Pixel {
    surface: Surface,
    distance: f32,
    face_normal: Vec3,
    motion: Vec2,
    object: u32,
}

struct Stage {
    gpu: Gpu,
    scene: Scene,
    geometry: Geometry,
    uploaded: GpuScene,
    frame: FrameInfo,
}

impl Stage {
    fn new(scene: Scene) -> Self {
        let gpu = Gpu::new(None).expect("these tests need an adapter; a software one will do");
        let geometry = scene.rest().clone();
        let (uploaded, _) = GpuScene::new(&gpu, &scene, &geometry, &SceneOptions::default()).unwrap();
        let frame = frame_info(&scene, &uploaded);
        Self { gpu, scene, geometry, uploaded, frame }
    }

    fn gather(&self, size: [u32; 2]) -> Vec<Pixel> {
        let mut gather = Gather::new(&self.gpu, &self.uploaded).unwrap();
        gather.mips = false;
        gather.resize(&self.gpu, &[size]).unwrap();
        let out = GBuffer::new(&self.gpu, size).unwrap();
        let mut recorder = Recorder::new(&self.gpu);
        let uniform = recorder.uniform(&self.frame.uniform());
        gather.gather(&mut recorder, "gather/trace", &uniform, &self.uploaded, &self.uploaded.mesh, &out);
        recorder.finish().unwrap();
        let surfaces = self.read::<[u32; 4]>(&out.surface);
        let distances = self.read::<f32>(&out.distance);
        let normals = self.read::<u32>(&out.face_normal);
        let ids = self.read::<[u32; 2]>(&out.motion_id);
        let pixel = |i: usize| Pixel {
            surface: Surface::unpack_gbuffer(surfaces[i]),
            distance: distances[i],
            face_normal: surface::face_normal_unpack(normals[i]),
            motion: Vec2::new(half(ids[i][0]), half(ids[i][0] >> 16)),
            object: ids[i][1],
        };
        (0..distances.len()).map(pixel).collect()
    }

    fn read<T: bytemuck::Pod>(&self, texture: &Texture) -> Vec<T> {
        self.gpu.read_texture(texture).unwrap()
    }
}

/// A half float in the low 16 bits.
fn half(bits: u32) -> f32 {
    let (exponent, mantissa) = ((bits >> 10) & 31, (bits & 1023) as f32);
    let size = match exponent {
        0 => mantissa * 2f32.powi(-24),
        _ => (1024.0 + mantissa) * 2f32.powi(exponent as i32 - 25),
    };
    if bits & 0x8000 == 0 { size } else { -size }
}

/// Compares every pixel whose centre is farther than 2^-8 pixel from all edges: rasterisers snap corners to such a
/// grid, which shifts what a pixel sees by as much. The four points at that distance bound the shift's effect.
fn compare(stage: &Stage) {
    let pixels = stage.gather(SIZE);
    let caster = Caster::new(&stage.scene, &stage.geometry);
    let (mut compared, mut near_an_edge, mut misses) = (0, 0, 0);
    for (i, pixel) in pixels.iter().enumerate() {
        let (x, y) = (i as u32 % SIZE[0], i as u32 / SIZE[0]);
        let cast = |offset: [f64; 2]| {
            let point = [f64::from(x) + 0.5 + offset[0], f64::from(y) + 0.5 + offset[1]];
            caster.gather_at(&stage.frame, SIZE, [x, y], point)
        };
        let here = cast([0.0; 2]);
        let step = 1.0 / 256.0;
        let around = [[step, step], [step, -step], [-step, step], [-step, -step]].map(cast);
        let triangle = |hit: &Option<Hit>| hit.map(|hit| hit.triangle);
        if around.iter().any(|hit| triangle(hit) != triangle(&here)) {
            near_an_edge += 1;
            continue;
        }
        let Some(hit_here) = here else {
            assert_eq!((pixel.distance, pixel.object), (0.0, 0), "a hit at {x}, {y} where there is nothing");
            misses += 1;
            continue;
        };
        let around = around.map(|hit| hit.unwrap_or(hit_here));
        check(stage, pixel, &hit_here, &around, [x, y]);
        compared += 1;
    }
    let count = pixels.len();
    println!("{}: {compared} compared, {misses} misses, {near_an_edge} near an edge", stage.scene.name);
    assert!(2 * (compared + misses) > count && compared > count / 10, "too few: {compared} of {count}");
}

fn check(stage: &Stage, pixel: &Pixel, hit: &Hit, around: &[Hit; 4], at: [u32; 2]) {
    let s = &hit.surface;
    let spread = |f: &dyn Fn(&Hit) -> f32| around.iter().map(f).fold(0.0_f32, f32::max);
    // f32 positions: 2^-23 of the distance from the origin, a few roundings.
    let distance_error = (f64::from(pixel.distance) - hit.distance).abs();
    let scale = f64::from(stage.frame.diagonal) + hit.distance;
    let allowed = f64::from(spread(&|h| (h.distance - hit.distance).abs() as f32)) + 2e-6 * scale;
    assert!(distance_error <= allowed, "{at:?}: distance {} against {}", pixel.distance, hit.distance);
    // 16 + 16 bits.
    let face_error = pixel.face_normal.distance(hit.face_normal);
    assert!(face_error < 2e-4, "{at:?}: face normal {} against {}", pixel.face_normal, hit.face_normal);
    let object = stage.geometry.triangles[hit.triangle].object + 1;
    assert_eq!(pixel.object, object | if hit.is_back { 0x8000_0000 } else { 0 }, "{at:?}: object");
    // 12 + 12 bits: 0.059 degrees.
    let allowed = 1.5e-3 + spread(&|h| h.surface.normal.distance(s.normal));
    let error = pixel.surface.normal.distance(s.normal);
    assert!(error <= allowed, "{at:?}: normal {} against {}", pixel.surface.normal, s.normal);
    // One sRGB code, which is at most 0.009 of linear light, plus the driver's decoding.
    let allowed = 0.0105 + spread(&|h| (h.surface.base - s.base).abs().max_element());
    let error = (pixel.surface.base - s.base).abs().max_element();
    assert!(error <= allowed, "{at:?}: base {} against {}", pixel.surface.base, s.base);
    // RGB9E5: 2^-9 of the largest channel.
    let allowed =
        s.emission.max_element() / 256.0 + spread(&|h| (h.surface.emission - s.emission).abs().max_element());
    let error = (pixel.surface.emission - s.emission).abs().max_element();
    assert!(error <= allowed, "{at:?}: emission {} against {}", pixel.surface.emission, s.emission);
    // Half a code of 255.
    let lobe = |s: &Surface| Vec3::new(s.roughness.x, s.roughness.y, s.metalness);
    let allowed = 0.0025 + spread(&|h| (lobe(&h.surface) - lobe(s)).abs().max_element());
    assert!(
        (lobe(&pixel.surface) - lobe(s)).abs().max_element() <= allowed,
        "{at:?}: roughness or metalness"
    );
    let same = |s: &Surface| (s.two_sided, s.handedness);
    assert_eq!(same(&pixel.surface), same(s), "{at:?}: two-sided, handedness");
    assert_eq!(pixel.motion, Vec2::ZERO, "{at:?}: what stands still moves");
}

#[test]
fn the_cornell_box_is_seen_alike() {
    compare(&Stage::new(Scene::load("cornell").unwrap()));
}

#[test]
fn spheres_are_seen_alike() {
    compare(&Stage::new(Scene::load("spheres").unwrap()));
}

#[test]
fn textures_backs_and_blends_are_seen_alike() {
    // The back of the relief's wall through its own texture, and a room some of whose walls are veils.
    let mut stage = Stage::new(Scene::load("relief").unwrap());
    let camera = &mut stage.frame.camera;
    camera.eye = stage.scene.bounds().center() - 1.2 * (camera.eye - stage.scene.bounds().center());
    camera.target = stage.scene.bounds().center();
    stage.frame.previous_camera = camera.clone();
    compare(&stage);

    let mut scene = Scene::load("cornell").unwrap();
    for m in scene.materials.iter_mut().step_by(2) {
        m.alpha = Alpha::Blend;
        m.base_color.w = 0.6;
    }
    compare(&Stage::new(scene));
}

#[test]
fn jitter_moves_the_picture_and_not_the_motion() {
    let mut stage = Stage::new(Scene::load("cornell").unwrap());
    stage.frame.jitter = [0.31, -0.42];
    stage.frame.previous_jitter = [0.31, -0.42];
    compare(&stage);
    stage.frame.previous_jitter = [-0.2, 0.1];
    for pixel in stage.gather(SIZE) {
        // Projected through two matrices: 64 pixels in f32, a few roundings.
        assert!(pixel.motion.abs().max_element() < 1e-4, "{:?}", pixel.motion);
    }
}

#[test]
fn motion_is_where_the_point_was() {
    // A camera that slides by a known way in front of a wall, and an image that is not the trace image.
    let mut stage = Stage::new(Scene::load("cornell").unwrap());
    let size = [96, 72];
    let slide = Vec3::new(0.1, -0.05, 0.0);
    stage.frame.previous_camera.eye -= slide;
    stage.frame.previous_camera.target -= slide;
    let uniform = stage.frame.uniform();
    let mut compared = 0;
    for (i, pixel) in stage.gather(size).iter().enumerate().filter(|(_, p)| p.distance > 0.0) {
        let point = Vec2::new((i % 96) as f32 + 0.5, (i / 96) as f32 + 0.5);
        let ndc = Vec2::new(2.0, -2.0) * (point / Vec2::new(96.0, 72.0)) + Vec2::new(-1.0, 1.0);
        let forward = Vec3::from(uniform.forward);
        let ray = forward + ndc.x * Vec3::from(uniform.right) + ndc.y * Vec3::from(uniform.up);
        let depth = pixel.distance / ray.length();
        // Half the picture's height spans tan(vfov / 2) * depth metres; the camera looks along -z here.
        let px_per_m = 36.0 / (0.5 * stage.frame.camera.vfov).tan() / depth;
        let expected = -px_per_m * Vec2::new(slide.x, -slide.y);
        // Half floats: 2^-11 of a few pixels.
        assert!(pixel.motion.abs_diff_eq(expected, 5e-3), "{i}: {} against {expected}", pixel.motion);
        compared += 1;
    }
    assert!(compared > 3000, "{compared}");
}

#[test]
fn a_moving_part_moves_and_the_rest_does_not() {
    let mut scene = Scene::load("spheres").unwrap();
    scene.set_moving(0.5);
    let mut stage = Stage::new(scene);
    stage.scene.pose(0.1, &mut stage.geometry);
    stage.uploaded.update(&stage.gpu, &stage.geometry);
    let (mut moving, mut still) = (0, 0);
    for pixel in stage.gather(SIZE).iter().filter(|p| p.distance > 0.0) {
        let object = &stage.geometry.objects[((pixel.object & 0x7fff_ffff) - 1) as usize];
        if object.moving {
            assert!(pixel.motion.length() > 0.01, "{:?} of {}", pixel.motion, object.name);
            moving += 1;
        } else {
            assert_eq!(pixel.motion, Vec2::ZERO, "{}", object.name);
            still += 1;
        }
    }
    assert!(moving > 50 && still > 50, "{moving} moving, {still} still");
}

#[test]
fn a_blend_keeps_its_share_of_pixels() {
    let mut scene = Scene::load("cornell").unwrap();
    let opacity = 0.3;
    for m in &mut scene.materials {
        m.alpha = Alpha::Blend;
        m.base_color.w = opacity;
    }
    let stage = Stage::new(scene);
    let size = [256, 192];
    let pixels = stage.gather(size);
    let caster = Caster::new(&stage.scene, &stage.geometry);
    let layers = |x: u32, y: u32| {
        let (origin, direction) = camera_ray(&stage.frame, size, [f64::from(x) + 0.5, f64::from(y) + 0.5]);
        caster.hits(origin, direction).len() as i32
    };
    let (mut expected, mut variance, mut seen) = (0.0, 0.0, 0.0);
    for (i, pixel) in pixels.iter().enumerate() {
        let p = 1.0 - (1.0 - f64::from(opacity)).powi(layers(i as u32 % size[0], i as u32 / size[0]));
        expected += p;
        variance += p * (1.0 - p);
        seen += f64::from(u8::from(pixel.distance > 0.0));
    }
    // Five standard deviations of independent pixels: the hash would have to be unlucky once in two million.
    assert!((seen - expected).abs() < 5.0 * variance.sqrt(), "{seen} pixels kept, {expected} expected");
}
