//! Rays and matrices say the same.

use super::*;
use glam::Vec2;

fn info(jitter: [f32; 2]) -> FrameInfo {
    let camera = Camera {
        name: String::new(),
        eye: Vec3::new(1.0, 2.0, 3.0),
        target: Vec3::new(-2.0, 1.0, -4.0),
        up: Vec3::Y,
        vfov: 0.9,
    };
    FrameInfo {
        previous_camera: camera.clone(),
        camera,
        trace_size: [640, 480],
        display_size: [1920, 1080],
        jitter,
        previous_jitter: jitter,
        frame_index: 0,
        seed: 1,
        time: 0.0,
        dt: 0.0,
        radiance_scale: 1.0,
        diagonal: 10.0,
        restart: true,
        sun_elsewhere: false,
    }
}

#[test]
fn a_point_seen_through_a_pixel_projects_to_it() {
    for jitter in [[0.0, 0.0], [0.25, -0.4]] {
        let info = info(jitter);
        let frame = info.uniform();
        let size = Vec2::new(640.0, 480.0);
        for pixel in [Vec2::new(0.5, 0.5), Vec2::new(320.0, 240.0), Vec2::new(611.5, 33.5)] {
            // The sample point of a jittered pixel is its centre plus the jitter.
            let ndc = Vec2::new(2.0, -2.0) * ((pixel + Vec2::from(jitter)) / size) + Vec2::new(-1.0, 1.0);
            let direction =
                Vec3::from(frame.forward) + ndc.x * Vec3::from(frame.right) + ndc.y * Vec3::from(frame.up);
            let world = Vec3::from(frame.eye) + 7.0 * direction;
            let clip = Mat4::from_cols_array_2d(&frame.clip_from_world) * world.extend(1.0);
            let seen = Vec2::new(0.5 + 0.5 * clip.x / clip.w, 0.5 - 0.5 * clip.y / clip.w) * size;
            // 1e-3 pixel: f32 rounding of a 4x4 product at 640 pixels.
            assert!((seen - pixel).length() < 1e-3, "{pixel} seen at {seen} with jitter {jitter:?}");
            assert!(clip.z > 0.0 && clip.z < clip.w, "depth {} of {}", clip.z, clip.w);
        }
    }
}

#[test]
fn the_papers_sizes_make_radii_three_quarters_along_a_row() {
    assert!((info([0.0; 2]).columns_per_row() - 0.75).abs() < 1e-6);
}
