//! What a depth layer says about space: distances along rays, and the planes of what was hit.
//!
//! In: depth per pixel (m, along the ray or along the view direction) and the vertical field of view (radians). Out, in the
//! space of a camera at the origin that looks along -Z: distances along rays (m, 0 = nothing hit), and unit normals turned to
//! the viewer, from the nearer of the two neighbours on each axis, so that a silhouette does not bend them.

use frame::FrameInfo;
use frame::cpu::Image;
use glam::{IVec2, Vec2, Vec3};
use scene::Camera;

/// What is beyond is sky.
const FARTHEST: f32 = 1e9;

/// How depth is measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum DepthKind {
    /// Along the ray through the pixel.
    Ray,
    /// Along the view direction.
    #[default]
    Z,
}

/// What is seen.
pub struct View {
    /// Along rays, metres; 0 where nothing was hit.
    pub distance: Image<f32>,
    /// Of the surface, unit, towards the viewer.
    pub normals: Image<[f32; 3]>,
}

/// The camera that all of this is seen by.
pub fn camera(vfov: f32) -> Camera {
    Camera { name: String::new(), eye: Vec3::ZERO, target: Vec3::NEG_Z, up: Vec3::Y, vfov }
}

impl View {
    /// From depth; without it everything lies at 1 m, for denoisers that do not ask.
    pub fn of(depth: Option<&Image<f32>>, kind: DepthKind, frame: &FrameInfo) -> Self {
        let size = frame.trace_size;
        let tan = (0.5 * frame.camera.vfov).tan();
        let extent = Vec2::new(size[0] as f32, size[1] as f32);
        let ray = |p: IVec2| {
            let ndc = (p.as_vec2() + 0.5) / extent * Vec2::new(2.0, -2.0) + Vec2::new(-1.0, 1.0);
            Vec3::new(ndc.x * tan * extent.x / extent.y, ndc.y * tan, -1.0)
        };
        let distance = Image::from_fn(size, |x, y| {
            let p = IVec2::new(x as i32, y as i32);
            let depth = depth.map_or(Some(1.0), |depth| depth.get(p.x, p.y)).unwrap_or(0.0);
            if !(depth > 0.0 && depth < FARTHEST) {
                return 0.0;
            }
            if kind == DepthKind::Z { depth * ray(p).length() } else { depth }
        });
        let position = |p: IVec2| {
            let distance = distance.get(p.x, p.y).filter(|d| *d > 0.0)?;
            Some(distance * ray(p).normalize())
        };
        let normals = Image::from_fn(size, |x, y| {
            let p = IVec2::new(x as i32, y as i32);
            let Some(here) = position(p) else { return [0.0, 0.0, 1.0] };
            let along = |step: IVec2| {
                let sides = [position(p + step).map(|q| q - here), position(p - step).map(|q| here - q)];
                sides.into_iter().flatten().min_by(|a, b| a.z.abs().total_cmp(&b.z.abs()))
            };
            let normal =
                along(IVec2::X).zip(along(IVec2::NEG_Y)).and_then(|(x, y)| x.cross(y).try_normalize());
            let normal = normal.unwrap_or_else(|| -here.normalize_or(Vec3::NEG_Z));
            (if normal.dot(here) > 0.0 { -normal } else { normal }).into()
        });
        Self { distance, normals }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn a_plane_has_one_normal_and_both_kinds_of_depth_agree() {
        let size = [20, 15];
        let frame = FrameInfo::still(camera(1.0), size);
        // Through (0, 0, -3), with this normal.
        let normal = Vec3::new(0.3, 0.5, 1.0).normalize();
        let tan = 0.5f32.tan();
        let ray = |x: u32, y: u32| {
            let [u, v] = [(x as f32 + 0.5) / 10.0 - 1.0, 1.0 - (y as f32 + 0.5) / 7.5];
            Vec3::new(u * tan * 20.0 / 15.0, v * tan, -1.0)
        };
        let z = Image::from_fn(size, |x, y| -3.0 * normal.z / normal.dot(ray(x, y)));
        let along = Image::from_fn(size, |x, y| z.get(x as i32, y as i32).unwrap() * ray(x, y).length());
        let views =
            [View::of(Some(&z), DepthKind::Z, &frame), View::of(Some(&along), DepthKind::Ray, &frame)];
        for view in &views {
            for (found, wanted) in view.distance.texels().iter().zip(along.texels()) {
                assert!((found - wanted).abs() < 1e-5 * wanted);
            }
            // Differences of positions a hundred times their size: 1e-4 of f32's 6e-8 is lost.
            assert!(view.normals.texels().iter().all(|n| Vec3::from(*n).dot(normal) > 0.9999));
        }
    }

    #[test]
    fn what_is_no_depth_is_sky() {
        let frame = FrameInfo::still(camera(1.0), [5, 1]);
        let depth = Image::from_texels([5, 1], vec![0.0, -1.0, f32::NAN, f32::INFINITY, 1e10]).unwrap();
        assert!(View::of(Some(&depth), DepthKind::Ray, &frame).distance.texels().iter().all(|d| *d == 0.0));
    }
}
