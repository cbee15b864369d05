//! What every reader of scenes must hold for any bytes: an end, a budget kept, and a scene that is whole or a refusal
//! that names the file.

use scene::{LoadBudget, Scene};
use std::path::Path;

/// Small, so that asking for more than there is happens often.
pub const BUDGET: LoadBudget = LoadBudget::megabytes(64);

/// Longer inputs find nothing new, only later.
pub const LONGEST: usize = 1 << 16;

/// Reads a scene of these bytes, moves it, and looks at what came out.
pub fn scene(name: &str, bytes: &[u8]) {
    match Scene::of_bytes(Path::new(name), bytes, BUDGET) {
        Ok(mut scene) => {
            let mut geometry = scene.rest().clone();
            for time in [0.0, 0.5, 1e30, f32::NAN] {
                scene.pose(time, &mut geometry);
                assert!(geometry.positions.iter().all(|p| p.is_finite()), "a place that is none at {time} s");
            }
            assert!(geometry.normals.iter().all(|n| n.is_normalized()), "a normal that is not 1 long");
            for triangle in &geometry.triangles {
                assert!(triangle.vertices.iter().all(|&v| (v as usize) < geometry.positions.len()));
                assert!((triangle.material as usize) < scene.materials.len());
            }
            let slots = scene.materials.iter().flat_map(|m| m.textures()).filter_map(|(slot, _)| slot);
            assert!(slots.into_iter().all(|slot| (slot.image as usize) < scene.images.len()));
            let _ = (scene.needs(), scene.bounds(), scene.duration(), scene.camera(0, 0.5));
            scene.set_moving(0.5);
            scene.pose(0.25, &mut geometry);
        }
        Err(fault) => {
            let message = fault.to_string();
            assert!(message.starts_with(name) && message.lines().count() == 1, "{message}");
        }
    }
}
