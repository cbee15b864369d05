#![allow(missing_docs, clippy::unwrap_used)]
use frame::scene_gpu::*;
use frame::surface::{self, Surface};
use frame::*;
use glam::Vec3;
use std::time::Instant;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let t = Instant::now();
    let scene = scene::Scene::load(&a[1]).unwrap();
    println!("load {:?} tris {} objects {}", t.elapsed(), scene.rest().triangles.len(), scene.rest().objects.len());
    for w in &scene.warnings { println!("warn {w}"); }
    let gpu = Gpu::new(None).unwrap();
    let t = Instant::now();
    let budget = a.get(9).and_then(|s| s.parse().ok());
    let (up, warn) = GpuScene::new(&gpu, &scene, scene.rest(), &SceneOptions { texture_budget_bytes: budget, ..Default::default() }).unwrap();
    println!("upload {:?} textures {} MB scale {} {:?}", t.elapsed(), up.textures.bytes() as f64 / 1e6, up.radiance_scale, warn);
    println!("needs {}", up.needs);
    let v = |s: &str| { let f: Vec<f32> = s.split(',').map(|x| x.parse().unwrap()).collect(); Vec3::new(f[0], f[1], f[2]) };
    let mut camera = scene.cameras.first().cloned().unwrap_or(scene::Camera::framing(scene.bounds()));
    if a.len() > 4 && a[3] != "-" { camera.eye = v(&a[3]); camera.target = v(&a[4]); camera.vfov = a[5].parse::<f32>().unwrap().to_radians(); }
    let w: u32 = a.get(6).map_or(640, |s| s.parse().unwrap());
    let h: u32 = a.get(7).map_or(480, |s| s.parse().unwrap());
    let mips = a.get(8).is_none_or(|s| s == "1");
    let size = [w, h];
    let frame = FrameInfo { previous_camera: camera.clone(), camera, trace_size: size, display_size: size, jitter: [0.0; 2], previous_jitter: [0.0; 2], frame_index: 0, seed: 1, time: 0.0, dt: 0.0, radiance_scale: up.radiance_scale, diagonal: scene.bounds().diagonal(), restart: true, sun_elsewhere: false };
    let mut g = tracer::Gather::new(&gpu, &up).unwrap();
    set_knob(&mut g.knobs(), "mips", if mips { "on" } else { "off" }).unwrap();
    g.resize(&gpu, &[size]).unwrap();
    let out = GBuffer::new(&gpu, size).unwrap();
    for _ in 0..4 {
        let t = Instant::now();
        let mut r = Recorder::new(&gpu);
        let u = r.uniform(&frame.uniform());
        g.gather(&mut r, "gather/trace", &u, &up, &up.mesh, &out);
        let log = r.finish().unwrap();
        println!("gather {:?} {:?}", t.elapsed(), log.passes.iter().map(|p| p.gpu_ms).collect::<Vec<_>>());
    }
    let s: Vec<[u32; 4]> = gpu.read_texture(&out.surface).unwrap();
    let d: Vec<f32> = gpu.read_texture(&out.distance).unwrap();
    let n: Vec<u32> = gpu.read_texture(&out.face_normal).unwrap();
    let m: Vec<[u32; 2]> = gpu.read_texture(&out.motion_id).unwrap();
    let px = |f: &dyn Fn(usize) -> Vec3, name: &str| {
        let mut b = format!("P6\n{w} {h}\n255\n").into_bytes();
        for i in 0..d.len() { let c = f(i); b.extend(c.to_array().map(|x| (255.0 * surface::srgb_from_linear(x.clamp(0.0, 1.0))) as u8)); }
        std::fs::write(format!("{}/{name}.ppm", a[2]), b).unwrap();
    };
    let sf = |i: usize| Surface::unpack_gbuffer(s[i]);
    px(&|i| if d[i] > 0.0 { sf(i).base } else { Vec3::ZERO }, "base");
    px(&|i| if d[i] > 0.0 { let v = 0.5 * sf(i).normal + 0.5; v * v } else { Vec3::ZERO }, "normal");
    px(&|i| if d[i] > 0.0 { let v = 0.5 * surface::face_normal_unpack(n[i]) + 0.5; v * v } else { Vec3::ZERO }, "face");
    px(&|i| Vec3::splat(2.0 * d[i] / frame.diagonal), "distance");
    px(&|i| Vec3::new(sf(i).roughness.x, sf(i).roughness.y, sf(i).metalness), "lobe");
    px(&|i| sf(i).emission / up.radiance_scale + Vec3::X * if m[i][1] >> 31 == 1 { 0.3 } else { 0.0 } + Vec3::Z * sf(i).transmission, "light");
}
