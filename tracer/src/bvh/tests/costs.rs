//! What rays of a picture cost in each structure: printed, not judged.

use super::fixture::{Random, Stage, ray};
use crate::bvh::{cwbvh, lbvh};
use crate::rays::{Met, Ray, RayBatch};
use glam::Vec3;

/// Pixels on a side of the picture.
const SIDE: usize = 512;

/// Through the middles of pixels, 60 degrees high and wide, along the nave.
fn primary_rays() -> Vec<Ray> {
    let (eye, target) = (Vec3::new(8.0, 1.6, -0.3), Vec3::new(-8.0, 3.2, -0.3));
    let forward = (target - eye).normalize();
    let right = forward.cross(Vec3::Y).normalize();
    let up = right.cross(forward);
    let half_size = 30f32.to_radians().tan();
    let offset = |i: usize| half_size * (2.0 * (i as f32 + 0.5) / SIDE as f32 - 1.0);
    let through = |i: usize| ray(eye, forward + offset(i % SIDE) * right - offset(i / SIDE) * up);
    (0..SIDE * SIDE).map(through).collect()
}

/// What a matte surface sends on from where rays met it.
fn scattered_rays(stage: &Stage, rays: &[Ray], met: &[Met]) -> Vec<Ray> {
    let mut random = Random::new(61);
    let scattered = |(from, met): (&Ray, &Met)| {
        let direction = Vec3::from(from.direction);
        let [a, b, c] = stage.corners(met.primitive as usize);
        let normal = (b - a).cross(c - a).normalize();
        let normal = if normal.dot(direction) > 0.0 { -normal } else { normal };
        let origin = Vec3::from(from.origin) + met.distance * direction;
        Ray { skip: met.primitive, ..ray(origin, normal + random.direction()) }
    };
    rays.iter().zip(met).filter(|(_, met)| met.primitive != Ray::NOTHING).map(scattered).collect()
}

#[test]
fn rays_of_a_picture_of_sponza() {
    let Some(stage) = Stage::sponza() else { return };
    let (lbvh, cwbvh) = (stage.lbvh(), stage.cwbvh());
    let structures = [("lbvh", lbvh::WGSL, &*lbvh), ("cwbvh", cwbvh::WGSL, &cwbvh.bvh)];
    let structures =
        structures.map(|(name, walk, bvh)| (name, RayBatch::of_bvh(&stage.gpu, walk).unwrap(), bvh));
    let primary = primary_rays();
    let [(_, batch, bvh), _] = &structures;
    let scattered = scattered_rays(&stage, &primary, &stage.met(batch, bvh, &primary));
    for (kind, rays) in [("primary", &primary), ("scattered", &scattered)] {
        for (name, batch, bvh) in &structures {
            let runs = [(); 3].map(|()| batch.closest(&stage.gpu, &bvh.resources(), rays).unwrap());
            let ms = runs.iter().filter_map(|run| run.gpu_ms).fold(f64::INFINITY, f64::min);
            let shadow = batch.blocked(&stage.gpu, &bvh.resources(), rays).unwrap().gpu_ms;
            let met = &runs[0].answers;
            assert!(met.iter().all(|met| met.cut == 0));
            let visits = met.iter().map(|met| f64::from(met.visits)).sum::<f64>() / met.len() as f64;
            println!(
                "{kind} rays, {name}: {} rays, {visits:.1} visits each, {ms:.0} ms; as shadows {shadow:.0?} ms",
                met.len()
            );
        }
    }
}
