//! The rays that structures are asked about: those of a view, and those that its light would go on along.
//!
//! Primary: one per trace pixel through its centre. Secondary: one per primary ray that met a triangle, from one voxel
//! elevation `h(n)` above it on the side that was seen (the voxels' own start, [`tracer`]'s `hit_start`), directions
//! cosine-distributed about the triangle's normal (Malley's method). World space, m, unit directions.

use frame::scene_gpu::GpuMesh;
use frame::surface::hash;
use frame::{FrameInfo, Gpu, GpuError};
use glam::{Vec2, Vec3};
use std::f32::consts::TAU;
use tracer::rays::{Met, Ray};

/// One ray per trace pixel, row by row from the top, through `offset` pixels from its centre, x right and y down.
pub fn primary(frame: &FrameInfo, offset: Vec2) -> Vec<Ray> {
    let of_view = frame.uniform();
    let [right, up, forward] = [of_view.right, of_view.up, of_view.forward].map(Vec3::from);
    let [width, height] = frame.trace_size;
    let size = Vec2::new(width as f32, height as f32);
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| Vec2::new(x as f32, y as f32)));
    pixels
        .map(|pixel| {
            let ndc = Vec2::new(2.0, -2.0) * ((pixel + 0.5 + offset) / size) + Vec2::new(-1.0, 1.0);
            let direction = (forward + ndc.x * right + ndc.y * up).normalize();
            Ray::new(frame.camera.eye, direction, farthest(frame))
        })
        .collect()
}

/// No ray of a view ends before it has left the scene, m.
fn farthest(frame: &FrameInfo) -> f32 {
    4.0 * frame.diagonal + frame.camera.eye.length()
}

/// Unit normals of triangles, by number; a triangle without area has none.
pub struct Normals(Vec<Option<Vec3>>);

impl Normals {
    /// Reads a mesh back.
    ///
    /// # Errors
    /// The device was lost.
    pub fn read(gpu: &Gpu, mesh: &GpuMesh) -> Result<Self, GpuError> {
        let words: Vec<u32> = gpu.read_buffer(&mesh.vertices)?;
        let triangles: Vec<[u32; 4]> = gpu.read_buffer(&mesh.triangles)?;
        let position = |vertex: u32| {
            let at = vertex as usize * mesh.layout.stride as usize;
            let [x, y, z] = words.get(at..)?.first_chunk()?.map(f32::from_bits);
            Some(Vec3::new(x, y, z))
        };
        let normal = |[a, b, c, _]: [u32; 4]| {
            let (a, b, c) = (position(a)?, position(b)?, position(c)?);
            (b - a).cross(c - a).try_normalize()
        };
        Ok(Self(triangles.into_iter().map(normal).collect()))
    }

    /// Of what a ray met, towards the ray.
    pub fn towards(&self, ray: &Ray, met: &Met) -> Option<Vec3> {
        let normal = (*self.0.get(met.primitive as usize)?)?;
        Some(if normal.dot(ray.direction.into()) > 0.0 { -normal } else { normal })
    }
}

/// How far above a surface paths through voxels of this side start, m: `(|n|_1 + |n|_inf) / 2` voxels.
fn elevation(normal: Vec3, voxel_size: f32) -> f32 {
    let a = normal.abs();
    0.5 * voxel_size * (a.element_sum() + a.max_element())
}

/// Where light comes from that primary rays see; `met` are triangles.
pub fn secondary(
    frame: &FrameInfo,
    rays: &[Ray],
    met: &[Met],
    normals: &Normals,
    voxel_size: f32,
) -> Vec<Ray> {
    let hits = rays.iter().zip(met).enumerate().filter(|(_, (_, met))| met.is_hit());
    hits.filter_map(|(i, (ray, met))| {
        let normal = normals.towards(ray, met)?;
        let point = Vec3::from(ray.origin) + met.distance * Vec3::from(ray.direction);
        let direction = about(normal, random(frame.seed, i as u32));
        Some(Ray::new(point + elevation(normal, voxel_size) * normal, direction, farthest(frame)))
    })
    .collect()
}

/// Two numbers in 0..1.
pub fn random(seed: u32, index: u32) -> Vec2 {
    let first = hash(index ^ hash(seed));
    let unit = |bits: u32| (bits >> 8) as f32 * (1.0 / 16_777_216.0);
    Vec2::new(unit(first), unit(hash(first)))
}

/// A direction about a unit normal, its density the cosine over pi.
pub fn about(normal: Vec3, u: Vec2) -> Vec3 {
    let (x, y) = normal.any_orthonormal_pair();
    let (sin, cos) = (TAU * u.y).sin_cos();
    let radius = u.x.sqrt();
    (radius * (cos * x + sin * y) + (1.0 - u.x).max(0.0).sqrt() * normal).normalize()
}
