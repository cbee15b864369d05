//! What the tests of every structure use: random numbers, triangles, rays, and what f64 says that they meet.

use crate::bvh::Bvh;
use crate::bvh::cwbvh::{self, Cwbvh, Quality};
use crate::bvh::lbvh::{Lbvh, LbvhBuilder};
use crate::gather::reference::intersect;
use crate::rays::{Met, Ray, RayBatch};
use frame::scene_gpu::{GpuScene, SceneOptions};
use frame::{Gpu, Recorder, surface};
use glam::{DVec3, Vec2, Vec3};
use scene::{Alpha, Geometry, Material, Object, Scene, Triangle};
use std::f32::consts::PI;
use std::path::Path;

/// m, farther than any scene here.
pub const FAR_M: f32 = 1e18;

/// A stream of numbers within 0..1.
pub struct Random(u32);

impl Random {
    pub fn new(seed: u32) -> Self {
        Self(surface::hash(seed))
    }

    pub fn unit(&mut self) -> f32 {
        self.0 = surface::hash(self.0.wrapping_add(0x9e37_79b9));
        (self.0 >> 8) as f32 / 16_777_216.0
    }

    pub fn below(&mut self, count: usize) -> usize {
        (self.unit() * count as f32) as usize % count
    }

    /// In the unit cube.
    pub fn point(&mut self) -> Vec3 {
        Vec3::from_array([(); 3].map(|()| self.unit()))
    }

    /// Evenly over the sphere.
    pub fn direction(&mut self) -> Vec3 {
        loop {
            let v = 2.0 * self.point() - 1.0;
            if (0.01..1.0).contains(&v.length_squared()) {
                return v.normalize();
            }
        }
    }
}

/// Endless; any triangle can be met.
pub fn ray(origin: Vec3, direction: Vec3) -> Ray {
    let direction = direction.normalize().to_array();
    Ray { origin: origin.to_array(), t_max: FAR_M, direction, skip: Ray::NOTHING }
}

/// A ray that begins at one point and passes another, rounded as seldom as can be.
pub fn ray_through(origin: Vec3, point: DVec3) -> Ray {
    let direction = (point - origin.as_dvec3()).normalize_or(DVec3::X).as_vec3().to_array();
    Ray { direction, ..ray(origin, Vec3::X) }
}

/// Triangles of no scene, which share no vertices: one object, every `sheet_every`-th triangle of a blended material
/// (0: none).
pub fn soup(triangles: &[[Vec3; 3]], sheet_every: usize) -> Geometry {
    let mut geometry = Geometry::default();
    for (i, corners) in triangles.iter().enumerate() {
        let v = geometry.positions.len() as u32;
        let n = (corners[1] - corners[0]).cross(corners[2] - corners[0]).try_normalize().unwrap_or(Vec3::Z);
        geometry.positions.extend(corners);
        geometry.normals.extend([n; 3]);
        geometry.tangents.extend([n.any_orthonormal_vector().extend(1.0); 3]);
        geometry.uv0.extend([Vec2::ZERO; 3]);
        let material = u32::from(sheet_every > 0 && i.is_multiple_of(sheet_every));
        geometry.triangles.push(Triangle { vertices: [v, v + 1, v + 2], material, object: 0 });
    }
    let vertices = 0..geometry.positions.len() as u32;
    let count = 0..triangles.len() as u32;
    geometry.objects.push(Object { name: String::new(), vertices, triangles: count, moving: false });
    geometry
}

/// A closed ball of about 1 m, pushed in and out at random; the origin sees all of it.
pub fn bumpy_ball(rings: u32, seed: u32) -> Vec<[Vec3; 3]> {
    let columns = 2 * rings;
    let point = |ring: u32, column: u32| {
        let (column, is_pole) = (column % columns, ring.is_multiple_of(rings));
        let (theta, phi) = (PI * ring as f32 / rings as f32, PI * column as f32 / rings as f32);
        let vertex = if is_pole { ring } else { columns * ring + column };
        let (s, c) = if is_pole { (0.0, theta.cos()) } else { theta.sin_cos() };
        let reach = 0.9 + 0.2 * Random::new(seed.wrapping_add(vertex)).unit();
        reach * Vec3::new(s * phi.cos(), s * phi.sin(), c)
    };
    let mut triangles = Vec::new();
    for (ring, column) in (0..rings).flat_map(|ring| (0..columns).map(move |column| (ring, column))) {
        let [a, b] = [point(ring, column), point(ring, column + 1)];
        let [c, d] = [point(ring + 1, column), point(ring + 1, column + 1)];
        triangles.extend((c != d).then_some([a, c, d]));
        triangles.extend((a != b).then_some([a, d, b]));
    }
    triangles
}

/// Triangles on the device.
pub struct Stage {
    pub gpu: Gpu,
    pub geometry: Geometry,
    pub uploaded: GpuScene,
}

impl Stage {
    pub fn new(scene: &Scene, geometry: Geometry) -> Self {
        let gpu = Gpu::new(None).expect("these tests need an adapter; a software one will do");
        let (mut uploaded, _) = GpuScene::new(&gpu, scene, &geometry, &SceneOptions::default()).unwrap();
        uploaded.bounds = geometry.bounds();
        Self { gpu, geometry, uploaded }
    }

    /// Built in, or a file.
    pub fn scene(name: &str) -> Self {
        let scene = Scene::load(name).unwrap();
        Self::new(&scene, scene.rest().clone())
    }

    /// Of [`soup`]'s two materials.
    pub fn of(geometry: Geometry) -> Self {
        let mut scene = Scene::load("furnace").unwrap();
        let solid = Material::default();
        scene.materials = vec![solid.clone(), Material { alpha: Alpha::Blend, ..solid }];
        Self::new(&scene, geometry)
    }

    /// Sponza, if the long tests were asked for and it is there.
    pub fn sponza() -> Option<Self> {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/scenes/sponza/sponza.gltf");
        if std::env::var_os("GRIDLIGHT_SHARED").is_none() {
            println!("skipped: GRIDLIGHT_SHARED is not set (cargo xtask test --shared)");
            return None;
        }
        if !Path::new(path).is_file() {
            println!("skipped: no file {path}");
            return None;
        }
        Some(Self::scene(path))
    }

    pub fn lbvh(&self) -> Lbvh {
        let builder = LbvhBuilder::new(&self.gpu, &self.uploaded).unwrap();
        let mut recorder = Recorder::new(&self.gpu);
        let lbvh = builder.build(&mut recorder, &self.uploaded.mesh).unwrap();
        recorder.finish().unwrap();
        lbvh
    }

    pub fn cwbvh(&self) -> Cwbvh {
        cwbvh::build(&self.gpu, &self.uploaded, &self.uploaded.mesh, Quality::Medium).unwrap()
    }

    pub fn met(&self, batch: &RayBatch, bvh: &Bvh, rays: &[Ray]) -> Vec<Met> {
        batch.closest(&self.gpu, &bvh.resources(), rays).unwrap().answers
    }

    pub fn blocked(&self, batch: &RayBatch, bvh: &Bvh, rays: &[Ray]) -> Vec<u32> {
        batch.blocked(&self.gpu, &bvh.resources(), rays).unwrap().answers
    }

    pub fn corners(&self, triangle: usize) -> [Vec3; 3] {
        self.geometry.corners(&self.geometry.triangles[triangle])
    }

    /// From random points within the bounds into random directions.
    pub fn random_rays(&self, count: usize, seed: u32) -> Vec<Ray> {
        let bounds = self.geometry.bounds();
        let mut random = Random::new(seed);
        let origin = |random: &mut Random| bounds.min + random.point() * bounds.size();
        (0..count).map(|_| ray(origin(&mut random), random.direction())).collect()
    }

    /// Rays where rounding decides: along axes and coordinate planes, with components that all but vanish, in the planes
    /// of triangles, from their corners and edges, through them from far away, with limits and skipped triangles.
    pub fn awkward_rays(&self, count: usize, seed: u32) -> Vec<Ray> {
        let mut random = Random::new(seed);
        let bounds = self.geometry.bounds();
        let size = bounds.size().max_element();
        let awkward = |i: usize| {
            let triangle = random.below(self.geometry.triangles.len());
            let [a, b, c] = self.corners(triangle);
            let on_it = [a, a.midpoint(b), (a + b + c) / 3.0][random.below(3)];
            let axis = Vec3::AXES[random.below(3)] * [1.0, -1.0][random.below(2)];
            let mut flat = random.direction();
            flat[random.below(3)] = [0.0, -0.0, 1e-30, -1e-12][random.below(4)];
            let along = (b - a).try_normalize().unwrap_or(axis);
            let anywhere = bounds.min + random.point() * bounds.size();
            let begun = match i % 8 {
                0 => ray(anywhere, axis),
                1 => ray(anywhere, flat),
                2 => ray(on_it, axis),
                3 => ray(on_it, flat),
                4 => ray(on_it, along),
                // From beside it, so that it is seen from its edge.
                5 => ray(on_it - random.unit() * size * along, along),
                6 => ray(on_it - 2.0 * size * axis, axis),
                _ => ray_through(on_it + 2.0 * size * random.unit() * random.direction(), on_it.as_dvec3()),
            };
            let t_max = if i.is_multiple_of(3) { size * random.unit() } else { FAR_M };
            let skip = if i.is_multiple_of(5) { triangle as u32 } else { Ray::NOTHING };
            Ray { t_max, skip, ..begun }
        };
        (0..count).map(awkward).collect()
    }

    /// How far f32 may be off along a ray that meets a triangle: a coordinate relative to the origin is rounded to 2^-24
    /// of its size, eight such roundings go into a distance, and a plane met at an angle stretches them.
    pub fn allowed(&self, ray: &Ray, triangle: usize) -> f64 {
        let [a, b, c] = self.corners(triangle).map(Vec3::as_dvec3);
        let direction = Vec3::from(ray.direction).as_dvec3();
        let cosine = (b - a).cross(c - a).normalize_or_zero().dot(direction).abs();
        let bounds = self.geometry.bounds();
        let scale = bounds.min.abs().max(bounds.max.abs()).max_element() + Vec3::from(ray.origin).length();
        8.0 * f64::from(scale) * 2f64.powi(-24) / cosine.max(1e-6)
    }

    /// Compares with all triangles in f64. True if something was met and is what f64 says; rays within rounding of an edge
    /// or of the limit count as neither.
    pub fn check(&self, ray: &Ray, hit: &Met) -> bool {
        let (origin, direction) = (Vec3::from(ray.origin).as_dvec3(), Vec3::from(ray.direction).as_dvec3());
        let meet = |i: usize| intersect(origin, direction, self.corners(i)).map(|(t, w)| (i, t, w));
        let all = (0..self.geometry.triangles.len()).filter(|i| *i as u32 != ray.skip);
        let all: Vec<_> = all.filter_map(meet).collect();
        assert_eq!(hit.cut, 0);
        // Nothing that is surely met may be missed.
        for &(triangle, distance, [v, w]) in &all {
            let allowed = self.allowed(ray, triangle);
            let [a, b, c] = self.corners(triangle).map(Vec3::as_dvec3);
            let area = (b - a).cross(c - a).length();
            let longest = (b - a).length().max((c - a).length()).max((c - b).length());
            let from_edge = (1.0 - v - w).min(v).min(w) * area / longest;
            let sure = from_edge > allowed && distance > allowed;
            let within = distance < f64::from(ray.t_max) - allowed;
            assert!(
                !(sure && within) || f64::from(hit.distance) <= distance + allowed,
                "{ray:?} misses {triangle} at {distance}: {hit:?}"
            );
        }
        if hit.primitive == Ray::NOTHING {
            assert_eq!(hit.distance, ray.t_max, "{ray:?}");
            return false;
        }
        assert!(hit.primitive != ray.skip && hit.distance <= ray.t_max, "{ray:?}: {hit:?}");
        let triangle = hit.primitive as usize;
        let [a, b, c] = self.corners(triangle).map(Vec3::as_dvec3);
        let [v, w] = hit.weights.map(f64::from);
        let (point, met) = (origin + f64::from(hit.distance) * direction, a + v * (b - a) + w * (c - a));
        let allowed = 2.0 * self.allowed(ray, triangle);
        assert!(point.distance(met) <= allowed, "{ray:?}: {point} is not {met}, {allowed} allowed");
        all.iter()
            .any(|&(i, distance, _)| i == triangle && (distance - f64::from(hit.distance)).abs() <= allowed)
    }
}
