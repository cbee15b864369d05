//! Triangles from code or from a scene, on the device, with the tree over them.

use super::super::{Lbvh, LbvhBuilder, WGSL};
use crate::bvh::{FREE, margin};
use crate::rays::{Met, Ray, RayBatch};
use frame::scene_gpu::{GpuScene, SceneOptions};
use frame::{FrameLog, Gpu, Recorder};
use glam::{DVec3, Vec2, Vec3};
use scene::{Aabb, Alpha, Geometry, Material, Object, Scene, Triangle};

/// A search without boxes: whatever it meets, a structure must meet, to the bit.
const ALL_TRIANGLES_WGSL: &str = "
fn bvh_closest(origin: vec3f, direction: vec3f, t_max: f32, skip: u32) -> BvhHit {
    let ray = bvh_ray(origin, direction, skip);
    var hit = BvhHit(BVH_NONE, t_max, vec2f(0.0), 0u, false);
    for (var place = 0u; place < bvh_params.triangle_count; place += 1u) {
        bvh_triangle(ray, place, &hit);
    }
    return hit;
}

fn bvh_blocked(origin: vec3f, direction: vec3f, t_max: f32, skip: u32) -> u32 {
    let ray = bvh_ray(origin, direction, skip);
    var found = BVH_FREE;
    for (var place = 0u; place < bvh_params.triangle_count; place += 1u) {
        var hit = BvhHit(BVH_NONE, t_max, vec2f(0.0), 0u, false);
        bvh_triangle(ray, place, &hit);
        if (hit.triangle != BVH_NONE && found != BVH_BLOCKED) {
            found = select(BVH_BLOCKED, BVH_SHEETS, bvh_is_sheet(place));
        }
    }
    return found;
}";

/// Uniform numbers in 0..1 from a counter.
pub(super) struct Random(pub u32);

impl Random {
    pub(super) fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(1);
        (frame::surface::hash(self.0) >> 8) as f32 / 16_777_216.0
    }

    pub(super) fn index(&mut self, count: usize) -> usize {
        (self.next() * count as f32) as usize % count
    }

    pub(super) fn point(&mut self) -> Vec3 {
        Vec3::new(self.next(), self.next(), self.next())
    }

    pub(super) fn direction(&mut self) -> Vec3 {
        let z = 1.0 - 2.0 * self.next();
        let (sin, cos) = (std::f32::consts::TAU * self.next()).sin_cos();
        let r = (1.0 - z * z).max(0.0).sqrt();
        Vec3::new(r * cos, r * sin, z).normalize()
    }
}

pub(super) fn ray(origin: Vec3, direction: Vec3) -> Ray {
    Ray { origin: origin.into(), t_max: 1e18, direction: direction.normalize().into(), skip: Ray::NOTHING }
}

/// A ray that begins at one point and passes another, rounded as seldom as can be.
pub(super) fn ray_through(origin: Vec3, point: Vec3) -> Ray {
    ray(origin, (point.as_dvec3() - origin.as_dvec3()).normalize_or(DVec3::X).as_vec3())
}

/// Triangles of no scene: one object, every `sheet_every`-th triangle of a blended material (0: none).
pub(super) fn soup(triangles: &[[Vec3; 3]], sheet_every: usize) -> Geometry {
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

/// Random triangles in the unit cube, up to `size` m long.
pub(super) fn random_triangles(count: u32, size: f32) -> Vec<[Vec3; 3]> {
    let mut random = Random(3);
    (0..count)
        .map(|_| {
            let a = random.point();
            let reach = size * random.next();
            [a, a + reach * random.direction(), a + reach * random.direction()]
        })
        .collect()
}

/// A closed sphere of latitude and longitude.
pub(super) fn sphere(center: Vec3, radius: f32, rows: u32) -> Vec<[Vec3; 3]> {
    let point = |row: u32, column: u32| {
        let (theta, phi) = (
            std::f32::consts::PI * row as f32 / rows as f32,
            std::f32::consts::TAU * (column % (2 * rows)) as f32 / (2 * rows) as f32,
        );
        let sin = if row == 0 || row == rows { 0.0 } else { theta.sin() };
        center + radius * Vec3::new(sin * phi.cos(), sin * phi.sin(), theta.cos())
    };
    let mut triangles = Vec::new();
    for (row, column) in (0..rows).flat_map(|row| (0..2 * rows).map(move |column| (row, column))) {
        let [a, b] = [point(row, column), point(row, column + 1)];
        let [c, d] = [point(row + 1, column), point(row + 1, column + 1)];
        triangles.extend([[a, c, d], [a, d, b]]);
    }
    triangles
}

/// A tree on the device, and a search without one.
pub(super) struct Stage {
    pub(super) gpu: Gpu,
    pub(super) geometry: Geometry,
    pub(super) uploaded: GpuScene,
    pub(super) builder: LbvhBuilder,
    pub(super) lbvh: Lbvh,
    pub(super) log: FrameLog,
    pub(super) tree: RayBatch,
    pub(super) all: RayBatch,
}

impl Stage {
    pub(super) fn scene(name: &str) -> Self {
        let scene = Scene::load(name).unwrap();
        let geometry = scene.rest().clone();
        Self::new(&scene, geometry)
    }

    pub(super) fn soup(triangles: &[[Vec3; 3]]) -> Self {
        Self::of(soup(triangles, 0))
    }

    pub(super) fn of(geometry: Geometry) -> Self {
        let mut scene = Scene::load("furnace").unwrap();
        let solid = Material::default();
        scene.materials = vec![solid.clone(), Material { alpha: Alpha::Blend, ..solid }];
        Self::new(&scene, geometry)
    }

    fn new(scene: &Scene, geometry: Geometry) -> Self {
        let gpu = Gpu::new(None).expect("these tests need an adapter; a software one will do");
        let (mut uploaded, _) = GpuScene::new(&gpu, scene, &geometry, &SceneOptions::default()).unwrap();
        uploaded.bounds = geometry.bounds();
        let builder = LbvhBuilder::new(&gpu, &uploaded).unwrap();
        let mut recorder = Recorder::new(&gpu);
        let lbvh = builder.build(&mut recorder, &uploaded.mesh).unwrap();
        let log = recorder.finish().unwrap();
        let [tree, all] =
            [WGSL, ALL_TRIANGLES_WGSL].map(|structure| RayBatch::of_bvh(&gpu, structure).unwrap());
        Self { gpu, geometry, uploaded, builder, lbvh, log, tree, all }
    }

    pub(super) fn corners(&self, triangle: u32) -> [Vec3; 3] {
        self.geometry.corners(&self.geometry.triangles[triangle as usize])
    }

    pub(super) fn met(&self, rays: &[Ray]) -> Vec<Met> {
        let met = self.tree.closest(&self.gpu, &self.lbvh.resources(), rays).unwrap().answers;
        assert!(met.iter().all(|met| met.cut == 0), "a ray was cut off");
        met
    }

    pub(super) fn blocked(&self, rays: &[Ray]) -> Vec<u32> {
        self.tree.blocked(&self.gpu, &self.lbvh.resources(), rays).unwrap().answers
    }

    /// Asserts that rays meet through the tree what they meet without it, to the bit; returns how many met something.
    ///
    /// But for this: a triangle that a ray sees exactly from its edge has no area but that of roundings, and the test
    /// may take it for one that is met, metres beside the ray. A box hides that.
    pub(super) fn compare(&self, rays: &[Ray]) -> usize {
        let met = self.met(rays);
        let expected = self.all.closest(&self.gpu, &self.lbvh.resources(), rays).unwrap().answers;
        let is_blocked = self.blocked(rays);
        let expected_blocked = self.all.blocked(&self.gpu, &self.lbvh.resources(), rays).unwrap().answers;
        let mut beside = 0;
        for (i, ray) in rays.iter().enumerate() {
            if expected[i].primitive != met[i].primitive && self.is_beside(ray, expected[i].primitive) {
                beside += 1;
                continue;
            }
            assert_eq!(Met { visits: 0, ..met[i] }, expected[i], "{ray:?}");
            // What lies behind the nearest triangle may be beside the ray, too.
            if is_blocked[i] != expected_blocked[i] {
                assert_eq!(is_blocked[i] == FREE, met[i].primitive == Ray::NOTHING, "{ray:?}");
                beside += 1;
            }
        }
        // Only rays aimed along triangles do that.
        assert!(beside <= rays.len() / 500, "{beside} of {} rays differ", rays.len());
        met.iter().filter(|met| met.primitive != Ray::NOTHING).count()
    }

    /// Whether a ray misses a triangle's box, in double precision, and by more than boxes are grown.
    fn is_beside(&self, ray: &Ray, triangle: u32) -> bool {
        if triangle == Ray::NOTHING {
            return false;
        }
        let bounds = self.geometry.bounds();
        let grown = 2.0 * margin(bounds.min.abs().max(bounds.max.abs()).max_element());
        let own = Aabb::of(self.corners(triangle));
        let [origin, direction] = [ray.origin, ray.direction].map(|v| DVec3::from(v.map(f64::from)));
        let inverse = direction.map(|d| if d == 0.0 { 1e30 } else { 1.0 / d });
        let [a, b] = [own.min - grown, own.max + grown].map(|p| (p.as_dvec3() - origin) * inverse);
        a.min(b).max_element() > a.max(b).min_element()
    }
}
