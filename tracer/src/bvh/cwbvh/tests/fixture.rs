//! Meshes with their structure, and rays given to the device, to the twin, and to f64.

use super::super::reference::CpuCwbvh;
use super::super::{Cwbvh, Quality, WGSL, build};
use crate::bvh::{BVH_BINDS, BvhParams, RAY_WGSL};
use crate::gather::reference::intersect;
use frame::scene_gpu::{GpuMesh, GpuScene, SceneOptions};
use frame::{Bind, Gpu, Kernel, KernelDesc, Recorder, Room, surface};
use glam::{DVec3, Vec2, Vec3, Vec4};
use scene::{Geometry, Scene, Triangle};

pub const NONE: u32 = u32::MAX;
/// Farther than any scene here.
pub const FAR_M: f32 = 1e6;

frame::gpu_struct! {
    /// See `rays.wgsl`.
    pub struct TestRay {
        pub origin: [f32; 3],
        pub t_max: f32,
        pub direction: [f32; 3],
        pub skip: u32,
    }
}

frame::gpu_struct! {
    /// See `rays.wgsl`.
    pub struct TestHit {
        pub triangle: u32,
        pub distance: f32,
        pub weights: [f32; 2],
        pub visits: u32,
        pub cut: u32,
        pub blocked: u32,
        pub _pad: u32,
    }
}

impl TestRay {
    pub fn new(origin: Vec3, direction: Vec3) -> Self {
        let direction = direction.normalize().to_array();
        Self { origin: origin.to_array(), t_max: FAR_M, direction, skip: NONE }
    }
}

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
        (self.unit() * count as f32) as usize
    }

    pub fn vector(&mut self) -> Vec3 {
        Vec3::from_array([(); 3].map(|()| self.unit()))
    }

    /// Evenly over the sphere.
    pub fn direction(&mut self) -> Vec3 {
        loop {
            let v = 2.0 * self.vector() - 1.0;
            if (0.01..1.0).contains(&v.length_squared()) {
                return v.normalize();
            }
        }
    }
}

/// Triangles on the device.
pub struct Fixture {
    pub gpu: Gpu,
    pub uploaded: GpuScene,
    pub geometry: Geometry,
    pub cwbvh: Cwbvh,
    kernel: Kernel,
}

impl Fixture {
    pub fn new(scene: &Scene, geometry: Geometry) -> Self {
        let gpu = Gpu::new(None).expect("this test needs an adapter");
        let (uploaded, _) = GpuScene::new(&gpu, scene, &geometry, &SceneOptions::default()).unwrap();
        let cwbvh = build(&gpu, &uploaded, &uploaded.mesh, Quality::Medium).unwrap();
        let own = [Bind::storage_read(2, 0, "in_rays"), Bind::storage(3, 0, "out_hits")];
        let kernel = Kernel::new(
            &gpu,
            &KernelDesc {
                name: "bvh/cwbvh/tests",
                sources: &[RAY_WGSL, WGSL, include_str!("rays.wgsl")],
                entry: "trace_rays",
                workgroup: [64, 1, 1],
                bindings: &[BVH_BINDS.as_slice(), &[own[0].of::<TestRay>(), own[1].of::<TestHit>()]].concat(),
                constants: &[],
            },
        );
        Self { kernel: kernel.unwrap(), gpu, uploaded, geometry, cwbvh }
    }

    pub fn named(name: &str) -> Self {
        let scene = Scene::load(name).unwrap();
        Self::new(&scene, scene.rest().clone())
    }

    /// Triangles of one opaque material.
    pub fn of(triangles: &[[Vec3; 3]]) -> Self {
        Self::new(&Scene::load("cornell").unwrap(), soup(triangles))
    }

    /// The same triangles, built otherwise.
    pub fn rebuild(&mut self, quality: Quality) {
        let mesh = GpuMesh::new(&self.gpu, &self.geometry).unwrap();
        self.cwbvh = build(&self.gpu, &self.uploaded, &mesh, quality).unwrap();
    }

    pub fn trace(&self, rays: &[TestRay]) -> Vec<TestHit> {
        let gpu = &self.gpu;
        let from = gpu.storage(Room::Frame, "rays", rays).unwrap();
        let to = gpu.storage(Room::Frame, "hits", &vec![TestHit::default(); rays.len()]).unwrap();
        let mut recorder = Recorder::new(gpu);
        let [elements, params] = self.cwbvh.bvh.resources();
        let resources = [elements, params, from.as_entire_binding(), to.as_entire_binding()];
        let groups = rays.len().div_ceil(64) as u32;
        recorder.compute("bvh/cwbvh/tests", &self.kernel, &resources, [groups, 1, 1]);
        recorder.finish().unwrap();
        gpu.read_buffer(&to).unwrap()
    }

    /// What the device has, for the twin.
    pub fn twin(&self) -> CpuCwbvh {
        let Cwbvh { bvh, triangle_count, .. } = &self.cwbvh;
        let elements = self.gpu.read_buffer(&bvh.elements).unwrap();
        let (node_count, triangle_count) = (bvh.node_count, *triangle_count);
        let params = BvhParams { triangles_at: 5 * node_count, triangle_count, node_count, _pad: 0 };
        CpuCwbvh { elements, params }
    }

    pub fn corners(&self, triangle: usize) -> [Vec3; 3] {
        self.geometry.corners(&self.geometry.triangles[triangle])
    }

    /// From random points within the bounds into random directions.
    pub fn random_rays(&self, count: usize, seed: u32) -> Vec<TestRay> {
        let bounds = self.geometry.bounds();
        let mut random = Random::new(seed);
        let origin = |random: &mut Random| bounds.min + random.vector() * bounds.size();
        (0..count).map(|_| TestRay::new(origin(&mut random), random.direction())).collect()
    }

    /// How far f32 may be off along a ray that meets a triangle: a coordinate relative to the origin is rounded to 2^-24
    /// of its size, eight such roundings go into a distance, and a plane met at an angle stretches them.
    pub fn allowed(&self, ray: &TestRay, triangle: usize) -> f64 {
        let [a, b, c] = self.corners(triangle).map(Vec3::as_dvec3);
        let direction = Vec3::from(ray.direction).as_dvec3();
        let cosine = (b - a).cross(c - a).normalize_or_zero().dot(direction).abs();
        let bounds = self.geometry.bounds();
        let scale = bounds.min.abs().max(bounds.max.abs()).max_element() + Vec3::from(ray.origin).length();
        8.0 * f64::from(scale) * 2f64.powi(-24) / cosine.max(1e-6)
    }

    /// Compares with all triangles in f64. True if something was met and is what f64 says; rays within rounding of an edge
    /// or of the limit count as neither.
    pub fn check(&self, ray: &TestRay, hit: &TestHit) -> bool {
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
        if hit.triangle == NONE {
            assert_eq!(hit.distance, ray.t_max, "{ray:?}");
            return false;
        }
        assert!(hit.triangle != ray.skip && hit.distance <= ray.t_max, "{ray:?}: {hit:?}");
        let triangle = hit.triangle as usize;
        let [a, b, c] = self.corners(triangle).map(Vec3::as_dvec3);
        let [v, w] = hit.weights.map(f64::from);
        let (point, met) = (origin + f64::from(hit.distance) * direction, a + v * (b - a) + w * (c - a));
        let allowed = 2.0 * self.allowed(ray, triangle);
        assert!(point.distance(met) <= allowed, "{ray:?}: {point} is not {met}, {allowed} allowed");
        all.iter()
            .any(|&(i, distance, _)| i == triangle && (distance - f64::from(hit.distance)).abs() <= allowed)
    }
}

/// Triangles that share no vertices, of material 0.
pub fn soup(triangles: &[[Vec3; 3]]) -> Geometry {
    let positions = triangles.as_flattened().to_vec();
    let count = positions.len();
    let triangle =
        |i: usize| Triangle { vertices: [0, 1, 2].map(|k| (3 * i + k) as u32), material: 0, object: 0 };
    Geometry {
        positions,
        normals: vec![Vec3::Z; count],
        tangents: vec![Vec4::new(1.0, 0.0, 0.0, 1.0); count],
        uv0: vec![Vec2::ZERO; count],
        triangles: (0..triangles.len()).map(triangle).collect(),
        ..Default::default()
    }
}

/// A ball whose triangles share their vertices, pushed in and out at random; the origin sees all of it.
pub fn bumpy_ball(rings: u32, seed: u32) -> Geometry {
    let mut random = Random::new(seed);
    let columns = 2 * rings;
    let mut at = |theta: f32, phi: f32| {
        let (s, c) = theta.sin_cos();
        (0.9 + 0.2 * random.unit()) * Vec3::new(s * phi.cos(), s * phi.sin(), c)
    };
    let pi = std::f32::consts::PI;
    let mut positions = vec![at(0.0, 0.0), at(pi, 0.0)];
    for i in 1..rings {
        for j in 0..columns {
            positions.push(at(pi * i as f32 / rings as f32, pi * j as f32 / rings as f32));
        }
    }
    let index = |i: u32, j: u32| match i {
        0 => 0,
        i if i == rings => 1,
        i => 2 + (i - 1) * columns + j % columns,
    };
    let mut triangles = Vec::new();
    for i in 0..rings {
        for j in 0..columns {
            let [a, b, c, d] = [index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)];
            let mut add = |vertices| triangles.push(Triangle { vertices, material: 0, object: 0 });
            if b != c {
                add([a, b, c]);
            }
            if a != d {
                add([a, c, d]);
            }
        }
    }
    let count = positions.len();
    Geometry { positions, triangles, ..soup(&vec![[Vec3::ZERO; 3]; count.div_ceil(3)]) }
}

/// A direction as f64 meant it.
pub fn towards(from: Vec3, to: DVec3) -> Vec3 {
    (to - from.as_dvec3()).normalize().as_vec3()
}

/// What `bvh_blocked` returns.
pub const FREE: u32 = 0;
pub const BLOCKED: u32 = 1;
pub const SHEETS: u32 = 2;
