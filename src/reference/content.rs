//! A name for what a scene holds: equal content, equal name, wherever the file lies.

use scene::Scene;
use xxhash_rust::xxh3::Xxh3;

/// 32 hexadecimal digits over triangles at a moment (s), materials, pictures, sky, sun and lights.
pub fn content_hash(scene: &Scene, time: f32) -> String {
    let mut hash = Xxh3::new();
    let mut geometry = scene.rest().clone();
    scene.pose(time, &mut geometry);
    hash.update(bytemuck::cast_slice(&geometry.positions));
    hash.update(bytemuck::cast_slice(&geometry.normals));
    hash.update(bytemuck::cast_slice(&geometry.tangents));
    hash.update(bytemuck::cast_slice(&geometry.uv0));
    hash.update(bytemuck::cast_slice(&geometry.uv1));
    hash.update(bytemuck::cast_slice(&geometry.colors));
    for triangle in &geometry.triangles {
        hash.update(bytemuck::bytes_of(&triangle.vertices));
        hash.update(&triangle.material.to_le_bytes());
    }
    for image in &scene.images {
        hash.update(bytemuck::cast_slice(&[image.width, image.height]));
        hash.update(bytemuck::cast_slice(&image.rgba));
    }
    // Small, and every field counts: their printed form names them all.
    hash.update(format!("{:?} {:?} {:?}", scene.materials, scene.sun, geometry.lights).as_bytes());
    hash.update(format!("{:?}", scene.sky).as_bytes());
    format!("{:032x}", hash.digest128())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn the_same_content_has_the_same_name_and_any_change_another() {
        let scene = Scene::load("cornell").unwrap();
        let name = content_hash(&scene, 0.0);
        assert_eq!(name, content_hash(&Scene::load("cornell").unwrap(), 0.0));
        let mut other = scene.clone();
        other.materials[0].roughness *= 0.5;
        assert_ne!(name, content_hash(&other, 0.0));
        let mut other = scene;
        other.sky = scene::Sky::Constant(glam::Vec3::ONE);
        assert_ne!(name, content_hash(&other, 0.0));
        assert_ne!(name, content_hash(&Scene::load("furnace").unwrap(), 0.0));
    }
}
