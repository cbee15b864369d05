//! Does what a pixel's motion points at in the last frame's G-buffer show the same surface?

use crate::support::pipeline;
use frame::surface::{Surface, face_normal_unpack};
use frame::{FrameInfo, GBuffer, Gpu};
use glam::{Vec2, Vec3};
use gridlight::RenderSettings;
use gridlight::settings::View;
use half::f16;

/// One frame's G-buffer, read back.
struct Seen {
    frame: FrameInfo,
    distance: Vec<f32>,
    normal: Vec<Vec3>,
    face_normal: Vec<Vec3>,
    motion: Vec<Vec2>,
    object: Vec<u32>,
}

impl Seen {
    fn of(gpu: &Gpu, frame: &FrameInfo, guides: &GBuffer) -> Self {
        let motion_id: Vec<[u32; 2]> = gpu.read_texture(&guides.motion_id).unwrap();
        let half = |bits: u32| f16::from_bits(bits as u16).to_f32();
        let surfaces: Vec<[u32; 4]> = gpu.read_texture(&guides.surface).unwrap();
        let face_normals: Vec<u32> = gpu.read_texture(&guides.face_normal).unwrap();
        Self {
            frame: frame.clone(),
            distance: gpu.read_texture(&guides.distance).unwrap(),
            normal: surfaces.into_iter().map(|words| Surface::unpack_gbuffer(words).normal).collect(),
            face_normal: face_normals.into_iter().map(face_normal_unpack).collect(),
            motion: motion_id.iter().map(|[m, _]| Vec2::new(half(*m), half(m >> 16))).collect(),
            object: motion_id.iter().map(|[_, id]| id & 0x7fff_ffff).collect(),
        }
    }

    /// World space, metres.
    fn position(&self, x: i32, y: i32) -> Vec3 {
        let [width, height] = self.frame.trace_size;
        let view = self.frame.uniform();
        let point = Vec2::new(x as f32, y as f32) + 0.5 + Vec2::from(self.frame.jitter);
        let ndc =
            point / Vec2::new(width as f32, height as f32) * Vec2::new(2.0, -2.0) + Vec2::new(-1.0, 1.0);
        let [forward, right, up, eye] = [view.forward, view.right, view.up, view.eye].map(Vec3::from);
        eye + self.distance[(y * width as i32 + x) as usize]
            * (forward + ndc.x * right + ndc.y * up).normalize()
    }
}

/// Shares of hit pixels whose motion points into the picture: at the same object with the same normal, and, where they
/// stand still, at the same plane. Counts those that moved, too.
fn agreement(before: &Seen, now: &Seen, is_moving: impl Fn(u32) -> bool) -> (f64, f64, usize) {
    let [width, height] = now.frame.trace_size.map(|n| n as i32);
    let (mut inside, mut same, mut still, mut in_plane, mut moved) = (0usize, 0usize, 0usize, 0usize, 0usize);
    for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
        let i = (y * width + x) as usize;
        let place = Vec2::new(x as f32, y as f32) - now.motion[i];
        let q = (place + 0.5).floor().as_ivec2();
        if now.distance[i] <= 0.0 || q.x < 0 || q.y < 0 || q.x >= width || q.y >= height {
            continue;
        }
        let j = (q.y * width + q.x) as usize;
        inside += 1;
        moved += usize::from(now.motion[i].length() > 0.1);
        let agrees = before.object[j] == now.object[i] && before.normal[j].dot(now.normal[i]) > 0.9;
        same += usize::from(agrees);
        if agrees && !is_moving(now.object[i]) {
            still += 1;
            let away = now.face_normal[i].dot(before.position(q.x, q.y) - now.position(x, y)).abs();
            // Half a pixel along a plane seen aslant stays in the plane; 1 % is what filters allow.
            in_plane += usize::from(away <= 0.01 * now.distance[i]);
        }
    }
    (same as f64 / inside as f64, in_plane as f64 / still.max(1) as f64, moved)
}

fn two_frames(settings: &RenderSettings) -> (Seen, Seen, usize) {
    let mut pipeline = pipeline(settings);
    let still_count = pipeline.scene().rest().static_object_count();
    let frames = [(), ()].map(|()| {
        let rendered = pipeline.render().unwrap();
        Seen::of(pipeline.gpu(), &rendered.frame, &rendered.trace)
    });
    let [before, now] = frames;
    (before, now, still_count)
}

#[test]
fn moving_objects_are_where_their_motion_says() {
    let settings = RenderSettings {
        scene: "cornell".into(),
        view: View::Framing,
        trace_size: [160, 120],
        display_size: [160, 120],
        grid: 32,
        spp: 1,
        tracer: "bvh_cwbvh".into(),
        denoiser: "identity".into(),
        upsampler: "nearest".into(),
        moving_share: Some(0.5),
        fps: 30.0,
        ..Default::default()
    };
    let (before, now, still_count) = two_frames(&settings);
    let (same, in_plane, moved) = agreement(&before, &now, |object| object as usize > still_count);
    println!("{same:.4} agree, {in_plane:.4} in the plane, {moved} moved");
    assert!(moved > 200, "only {moved} pixels moved at all");
    // What was just uncovered and silhouettes make the rest: a rim a pixel wide around each mover.
    assert!(same > 0.95, "{same} of the pixels find themselves");
    assert!(in_plane > 0.99, "{in_plane} of those that stand still lie in their plane");
}
