//! Objects that glow, with how much: what the voxelizer scales each emitter's flux to.
//!
//! In: world-space triangles (m) and materials. Out: per object `power = sum(area * mean emission luminance * pi)`, W in
//! Rec. 709 luminance, of the front faces, not times `radiance_scale`. The mean of an emission texture is taken over the
//! whole picture.

use super::texels::{Encoding, Plane};
use crate::cpu;
use glam::{Vec3, Vec4Swizzles};
use scene::{Geometry, Image};
use std::f32::consts::PI;
use std::ops::Range;

/// One object that glows.
#[derive(Clone, Debug, PartialEq)]
pub struct Emitter {
    /// Index into [`Geometry::objects`].
    pub object: u32,
    /// Its triangles.
    pub triangles: Range<u32>,
    /// W, luminance.
    pub power: f32,
}

/// All objects with an emitting material.
pub(super) fn emitters(geometry: &Geometry, materials: &[scene::Material], images: &[Image]) -> Vec<Emitter> {
    let luminances: Vec<_> = materials.iter().map(|m| mean_luminance(m, images)).collect();
    let power_of = |triangles: &Range<u32>| -> f64 {
        let triangles = &geometry.triangles[triangles.start as usize..triangles.end as usize];
        let power = |triangle: &scene::Triangle| {
            let [a, b, c] = geometry.corners(triangle);
            let luminance = luminances.get(triangle.material as usize).copied().unwrap_or(0.0);
            f64::from(0.5 * (b - a).cross(c - a).length() * luminance * PI)
        };
        triangles.iter().map(power).sum()
    };
    (0u32..)
        .zip(&geometry.objects)
        .map(|(object, o)| Emitter {
            object,
            triangles: o.triangles.clone(),
            power: power_of(&o.triangles) as f32,
        })
        .filter(|emitter| emitter.power > 0.0)
        .collect()
}

pub(super) fn mean_luminance(material: &scene::Material, images: &[Image]) -> f32 {
    if !material.emits() {
        return 0.0;
    }
    let (factor, texture) = match material.unlit {
        true => (material.base_color.xyz(), material.base_color_texture),
        false => (material.emission, material.emission_texture),
    };
    let image = texture.and_then(|slot| images.get(slot.image as usize));
    cpu::luminance((factor * image.map_or(Vec3::ONE, mean)).to_array())
}

fn mean(image: &Image) -> Vec3 {
    let size = [image.width as usize, image.height as usize];
    Plane::decode(size, &image.rgba, Encoding::Srgb, None).averaged([1, 1]).texels[0].xyz()
}
