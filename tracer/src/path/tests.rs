//! The twin alone, in worlds simple enough for closed forms; the device is compared with it in the tracers' tests.
#![allow(clippy::unwrap_used, clippy::panic)]

use super::PathParams;
use super::reference::{Hit, NO_OWN, Ray, Structure, Tally, Texel, World, roughness_samples, view_direction};
use frame::FrameInfo;
use frame::brdf::{self, BrdfTable};
use frame::surface::{Surface, face_normal_pack};
use glam::{DVec3, UVec2, Vec2, Vec3};
use scene::{Camera, Sky};

/// A ball of radius 1 m about the origin.
struct Ball(Surface);

impl Ball {
    /// The first distance along a ray at which it meets the ball's skin, off which it starts.
    fn meets(origin: Vec3, direction: Vec3) -> Option<f32> {
        let (o, d) = (origin.as_dvec3(), direction.as_dvec3());
        let middle = -o.dot(d);
        let half = (middle * middle - o.length_squared() + 1.0).max(0.0).sqrt();
        [middle - half, middle + half].into_iter().find(|t| half > 0.0 && *t > 1e-4).map(|t| t as f32)
    }
}

impl Structure for Ball {
    fn trace(&self, ray: &Ray, _: &mut Tally) -> Option<Hit> {
        let distance = Self::meets(ray.origin, ray.direction)?;
        let normal = (ray.origin + distance * ray.direction).normalize();
        let face = if normal.dot(ray.direction) > 0.0 { -normal } else { normal };
        let surface = Surface { normal, tangent: normal.any_orthonormal_vector(), ..self.0 };
        let front = normal.dot(ray.direction) < 0.0;
        Some(Hit { distance, surface, front, face, entry: face, face_of: None, own: NO_OWN, beyond: NO_OWN })
    }

    fn starts_from(&self, _: Vec3, _: Vec3, _: Vec3) -> [u32; 2] {
        NO_OWN
    }

    fn start(&self, point: Vec3, _: Vec3, _: Vec3, _: Vec3) -> Vec3 {
        point
    }

    fn leave(&self, point: Vec3, _: &Hit, _: Vec3) -> Vec3 {
        point
    }

    fn pass(&self, point: Vec3, _: &Hit) -> Vec3 {
        point
    }
}

/// `M_d diffuse + M_s specular` of the pixels that see the ball in a white sky, each beside the cosine there.
fn seen(ball: &Ball, spp: u32, bounces: u32) -> Vec<(f64, DVec3)> {
    let camera = Camera {
        name: String::new(),
        eye: Vec3::new(0.5, 1.0, 3.0),
        target: Vec3::ZERO,
        up: Vec3::Y,
        vfov: 0.8,
    };
    let info = FrameInfo {
        camera: camera.clone(),
        previous_camera: camera,
        trace_size: [32, 32],
        display_size: [32, 32],
        jitter: [0.0; 2],
        previous_jitter: [0.0; 2],
        frame_index: 0,
        seed: 3,
        time: 0.0,
        dt: 0.0,
        radiance_scale: 1.0,
        diagonal: 4.0,
        restart: true,
        sun_elsewhere: false,
    };
    let (frame, table, sky) = (info.uniform(), BrdfTable::new(), Sky::Constant(Vec3::ONE));
    let world = World { frame: &frame, structure: ball, sky: &sky, lights: &[], table: &table };
    let roulette_from = if bounces > 100 { 8 } else { u32::MAX };
    let params = PathParams { samples: spp, bounces, roulette_from, ..PathParams::default() };
    let mut tally = Tally::default();
    let pixels = (0..32).flat_map(|y| (0..32).map(move |x| UVec2::new(x, y)));
    pixels
        .filter_map(|pixel| {
            let direction = view_direction(&frame, pixel);
            let distance = Ball::meets(info.camera.eye, direction)?;
            let normal = (info.camera.eye + distance * direction).normalize();
            let surface = Surface { normal, ..ball.0 }.pack_gbuffer(0);
            let texel = Texel { surface, distance, face_normal: face_normal_pack(normal), motion_id: [0, 1] };
            let found = world.pixel(&params, pixel, &texel, &mut tally);
            let surface = Surface::unpack_gbuffer(surface);
            let cosine = -f64::from(surface.normal.dot(direction));
            let m = brdf::modulators(&surface, cosine.max(0.0), &table);
            let [diffuse, specular] = found.lobes.map(|lobe| lobe.truncate());
            Some((cosine, m.diffuse * diffuse + m.specular * specular))
        })
        .collect()
}

#[test]
fn a_tinted_ball_that_does_not_bend_light_absorbs_along_the_chord() {
    let absorption = Vec3::new(0.5, 1.0, 2.0);
    let ball = Ball(Surface { transmission: 1.0, f0: 0.0, absorption, ..Surface::default() });
    // Going in and out is straight: no scattering, so that one bounce is enough.
    for (cosine, light) in seen(&ball, 1, 1) {
        let wanted = (-absorption.as_dvec3() * 2.0 * cosine).exp();
        // RGB9E5 holds 9 bits of the absorption, 12 + 12 bits of normal give the cosine to 1e-3.
        assert!((light - wanted).abs().max_element() < 5e-3, "{cosine}: {light}, not {wanted}");
    }
}

#[test]
fn a_clear_ball_neither_adds_light_nor_takes_it() {
    for roughness in [0.0, 0.2, 0.7] {
        let ball =
            Surface { transmission: 1.0, f0: 0.04, roughness: Vec2::splat(roughness), ..Surface::default() };
        let values: Vec<f64> =
            seen(&Ball(ball), 16, 512).iter().map(|(_, light)| light.element_sum() / 3.0).collect();
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        let error = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>()).sqrt() / count;
        println!("roughness {roughness}: {mean} +- {error}");
        assert!((mean - 1.0).abs() <= 3.0 * error + 1e-3, "{mean} +- {error}");
    }
}

#[test]
fn a_white_ball_under_a_white_sky_shows_it_whole() {
    let white = Ball(Surface::default());
    for (cosine, light) in seen(&white, 2, 1) {
        assert!((light - 1.0).abs().max_element() < 1e-6 || cosine < 1e-3, "{cosine}: {light}");
    }
}

#[test]
fn rougher_surfaces_get_more_samples() {
    let of =
        |x: f32, y: f32| roughness_samples(&Surface { roughness: Vec2::new(x, y), ..Surface::default() });
    assert_eq!([0.0, 0.09, 0.11, 0.5, 0.89, 0.91, 1.0].map(|r| of(r, 0.0)), [1, 1, 2, 4, 5, 6, 6]);
    assert_eq!(of(0.0, 1.0), 6, "the larger of the two");
}
