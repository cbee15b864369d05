//! The CPU half: one ray through a pixel against the triangles, in f64 up to the hit, mip 0, nothing packed.

use frame::surface::Surface;
use frame::{FrameInfo, scene_gpu::reference as material, surface};
use glam::{DVec3, Vec2, Vec3};
use scene::{Aabb, Geometry, Object, Scene};

/// What a pixel sees.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    /// Index into [`Geometry::triangles`].
    pub triangle: usize,
    /// m along the ray.
    pub distance: f64,
    /// Unit, turned to the viewer.
    pub face_normal: Vec3,
    /// Whether the viewer sees the back.
    pub is_back: bool,
    /// As the G-buffer would pack it.
    pub surface: Surface,
}

/// The ray through a point of an image (pixel centres lie at +0.5): origin and unit direction.
pub fn camera_ray(frame: &FrameInfo, size: [u32; 2], point: [f64; 2]) -> (DVec3, DVec3) {
    let uniform = frame.uniform();
    let vector = |v: [f32; 3]| Vec3::from(v).as_dvec3();
    let jitter = [0, 1].map(|axis| {
        f64::from(frame.jitter[axis]) * f64::from(size[axis]) / f64::from(frame.trace_size[axis])
    });
    let x = 2.0 * (point[0] + jitter[0]) / f64::from(size[0]) - 1.0;
    let y = 1.0 - 2.0 * (point[1] + jitter[1]) / f64::from(size[1]);
    let direction = vector(uniform.forward) + x * vector(uniform.right) + y * vector(uniform.up);
    (vector(uniform.eye), direction.normalize())
}

/// Distance and the weights of the second and third corner, if the ray meets the triangle in front of its origin.
pub fn intersect(origin: DVec3, direction: DVec3, corners: [Vec3; 3]) -> Option<(f64, [f64; 2])> {
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    let (ab, ac) = (b - a, c - a);
    let p = direction.cross(ac);
    let det = ab.dot(p);
    if det.abs() < 1e-30 {
        return None;
    }
    let to_origin = (origin - a) / det;
    let u = to_origin.dot(p);
    let q = to_origin.cross(ab);
    let v = direction.dot(q);
    let distance = ac.dot(q);
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && distance > 0.0).then_some((distance, [u, v]))
}

/// A scene at one moment, and a box around each object, so that most triangles need no look.
pub struct Caster<'a> {
    scene: &'a Scene,
    geometry: &'a Geometry,
    boxes: Vec<[DVec3; 2]>,
}

impl<'a> Caster<'a> {
    /// Boxes are around the positions as they are now.
    pub fn new(scene: &'a Scene, geometry: &'a Geometry) -> Self {
        let vertices = |object: &Object| object.vertices.start as usize..object.vertices.end as usize;
        let positions = |object: &Object| geometry.positions[vertices(object)].iter().copied();
        let boxes = geometry.objects.iter().map(|object| Aabb::of(positions(object))).map(|b| {
            // A flat box still has to be hit.
            let margin = DVec3::splat(1e-6 + 1e-6 * f64::from(b.diagonal()));
            [b.min.as_dvec3() - margin, b.max.as_dvec3() + margin]
        });
        Self { scene, geometry, boxes: boxes.collect() }
    }

    /// Distance, triangle and weights of everything the ray meets, nearest first. Of two at the same depth the earlier
    /// triangle comes first, as under a strict depth test.
    pub fn hits(&self, origin: DVec3, direction: DVec3) -> Vec<(f64, usize, [f64; 2])> {
        let met = self.boxes.iter().zip(&self.geometry.objects).filter(|([low, high], _)| {
            let (a, b) = ((*low - origin) / direction, (*high - origin) / direction);
            a.min(b).max_element() <= a.max(b).min_element()
        });
        let mut hits: Vec<_> = met
            .flat_map(|(_, object)| object.triangles.start as usize..object.triangles.end as usize)
            .filter_map(|triangle| {
                let corners = self.geometry.corners(&self.geometry.triangles[triangle]);
                intersect(origin, direction, corners).map(|(distance, weights)| (distance, triangle, weights))
            })
            .collect();
        hits.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        hits
    }

    /// What a pixel sees at `point` of an image of this size; the pixel decides which share of a blend it takes.
    pub fn gather_at(
        &self,
        frame: &FrameInfo,
        size: [u32; 2],
        pixel: [u32; 2],
        point: [f64; 2],
    ) -> Option<Hit> {
        let (origin, direction) = camera_ray(frame, size, point);
        let hash = surface::hash(pixel[1].wrapping_add(surface::hash(frame.seed)));
        let hash = surface::hash(pixel[0].wrapping_add(hash));
        let wo = -direction.as_vec3();
        self.hits(origin, direction).into_iter().find_map(|(distance, triangle, weights)| {
            let index = self.geometry.triangles[triangle].material as usize;
            let weights = Vec2::new(weights[0] as f32, weights[1] as f32);
            let point = material::mesh_point(self.geometry, triangle, weights);
            let random = surface::hash(hash ^ surface::hash(triangle as u32));
            if material::opacity(self.scene, index, &point) <= (random >> 8) as f32 / 16_777_216.0 {
                return None;
            }
            let is_back = point.face_normal.dot(wo) < 0.0;
            let mut s = material::surface(self.scene, index, &point, frame.radiance_scale);
            s.coverage = 1.0;
            if is_back {
                s = material::turn(&s);
            }
            s.normal = material::bend(s.normal, wo);
            let face_normal = if is_back { -point.face_normal } else { point.face_normal };
            Some(Hit { triangle, distance, face_normal, is_back, surface: s })
        })
    }
}
