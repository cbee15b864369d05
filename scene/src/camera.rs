//! A pinhole camera in world space.

use crate::geometry::Aabb;
use glam::{Mat4, Vec3};

/// Right-handed, looking along `target - eye`; aspect comes from the picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// From the file; may be empty.
    pub name: String,
    /// Metres.
    pub eye: Vec3,
    /// A point looked at, metres.
    pub target: Vec3,
    /// Roughly up; not parallel to the view.
    pub up: Vec3,
    /// Vertical field of view, radians.
    pub vfov: f32,
}

impl Camera {
    /// The view used where nobody says otherwise: the centre of the bounds seen from (0.4, 0.3, 1) times the
    /// diagonal, at 45 degrees.
    pub fn framing(bounds: Aabb) -> Self {
        let diagonal = if bounds.diagonal() > 0.0 { bounds.diagonal() } else { 1.0 };
        Self {
            name: "framing".into(),
            eye: bounds.center() + diagonal * Vec3::new(0.4, 0.3, 1.0),
            target: bounds.center(),
            up: Vec3::Y,
            vfov: std::f32::consts::FRAC_PI_4,
        }
    }

    /// Unit view direction.
    pub fn forward(&self) -> Vec3 {
        (self.target - self.eye).normalize_or(Vec3::NEG_Z)
    }

    /// View space (x right, y up, looking along -z) from world space.
    pub fn view_from_world(&self) -> Mat4 {
        let forward = self.forward();
        let up = if forward.cross(self.up).length_squared() > 1e-12 {
            self.up
        } else {
            forward.any_orthogonal_vector()
        };
        glam::camera::rh::view::look_to_mat4(self.eye, forward, up)
    }
}
