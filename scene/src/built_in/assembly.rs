//! Collects the parts of a built-in scene into one.

use super::part::Part;
use crate::{Camera, Geometry, Image, Material, Object, Scene, Sky, TextureSlot, Triangle, Wrap};
use glam::Mat3;

/// A scene in the making. Materials and images come before the parts that name them.
#[derive(Default)]
pub(super) struct Assembly {
    materials: Vec<Material>,
    images: Vec<Image>,
    geometry: Geometry,
}

impl Assembly {
    /// Adds a material; the number is what a [`Part`] names it by.
    pub fn material(&mut self, material: Material) -> u32 {
        self.materials.push(material);
        self.materials.len() as u32 - 1
    }

    /// Adds a picture; the slot repeats it over the first texture coordinates.
    pub fn texture(&mut self, image: Image) -> TextureSlot {
        self.images.push(image);
        TextureSlot {
            image: self.images.len() as u32 - 1,
            uv_set: 0,
            uv_transform: Mat3::IDENTITY,
            wrap: [Wrap::Repeat; 2],
            linear: true,
        }
    }

    /// Adds a part as an object that never moves.
    pub fn add(&mut self, part: Part) {
        let geometry = &mut self.geometry;
        let object = geometry.objects.len() as u32;
        let (first_vertex, first_triangle) =
            (geometry.positions.len() as u32, geometry.triangles.len() as u32);
        geometry.triangles.extend(part.triangles.iter().map(|corners| Triangle {
            vertices: corners.map(|corner| first_vertex + corner),
            material: part.material,
            object,
        }));
        geometry.positions.extend(part.positions);
        geometry.normals.extend(part.normals);
        geometry.tangents.extend(part.tangents);
        geometry.uv0.extend(part.uv0);
        geometry.objects.push(Object {
            name: part.name,
            vertices: first_vertex..geometry.positions.len() as u32,
            triangles: first_triangle..geometry.triangles.len() as u32,
            moving: false,
        });
    }

    /// The finished scene.
    pub fn finish(self, name: &str, cameras: Vec<Camera>, sky: Sky) -> Scene {
        Scene::assemble(name, self.materials, self.images, self.geometry, cameras, sky)
    }
}
