//! Walking around: each motion takes a camera and gives another. Metres, radians; the picture's x grows to the right.

use crate::worker::SceneFacts;
use glam::{Quat, Vec3};
use gridlight::settings::{LookAt, View};
use scene::{Aabb, Camera};

/// Nearer to straight up or down than this the view would tip over, radians.
const CLOSEST_TO_POLE: f32 = 0.02;

/// What one notch of the wheel does to the speed, or to the distance.
const PER_NOTCH: f32 = 1.2;

/// How the camera is moved.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Flight {
    /// Metres a second; none until a scene's size is known.
    pub speed: Option<f32>,
    /// Around the target instead of on the spot.
    pub orbits: bool,
    /// Somebody is moving it right now.
    pub is_moving: bool,
}

impl Flight {
    /// Metres a second; crossing the scene takes five seconds until somebody says otherwise.
    pub fn speed(&self, bounds: Aabb) -> f32 {
        self.speed.unwrap_or(0.2 * bounds.diagonal().max(1e-3))
    }

    /// Faster by so many notches of the wheel.
    pub fn faster(&mut self, bounds: Aabb, notches: f32) {
        self.speed = Some((self.speed(bounds) * PER_NOTCH.powf(notches)).clamp(1e-4, 1e6));
    }
}

/// What a view looks through, in numbers; none for a camera that the scene does not have.
pub fn look(view: &View, facts: &SceneFacts) -> Option<LookAt> {
    match view {
        View::Framing => Some(of_camera(&Camera::framing(facts.bounds))),
        View::Camera(index) => facts.cameras.get(*index).map(of_camera),
        View::LookAt(look) => Some(*look),
        View::Path(path) => Some(path.at(0.0)),
    }
}

/// A camera of a scene as numbers of its own.
fn of_camera(camera: &Camera) -> LookAt {
    LookAt {
        eye: camera.eye.into(),
        target: camera.target.into(),
        up: camera.up.into(),
        // Only angles that come from degrees can be said on the command line to the bit.
        vfov: camera.vfov.to_degrees().to_radians(),
    }
}

fn axes(look: &LookAt) -> (Vec3, Vec3, Vec3) {
    let up = Vec3::from(look.up).normalize_or(Vec3::Y);
    let forward = (Vec3::from(look.target) - Vec3::from(look.eye)).normalize_or(Vec3::NEG_Z);
    let right = forward.cross(up).normalize_or(up.any_orthonormal_vector());
    (right, up, forward)
}

/// Turns a direction by angles to the right and up, not over the poles.
fn turned(direction: Vec3, up: Vec3, right: Vec3, yaw: f32, pitch: f32) -> Vec3 {
    let elevation = direction.normalize_or(Vec3::NEG_Z).dot(up).clamp(-1.0, 1.0).asin();
    let highest = std::f32::consts::FRAC_PI_2 - CLOSEST_TO_POLE;
    let pitch = (elevation + pitch).clamp(-highest, highest) - elevation;
    Quat::from_axis_angle(up, -yaw) * Quat::from_axis_angle(right, pitch) * direction
}

/// Turns the head: `yaw` to the right, `pitch` up.
pub fn look_around(look: &LookAt, yaw: f32, pitch: f32) -> LookAt {
    let (right, up, _) = axes(look);
    let eye = Vec3::from(look.eye);
    let to_target = turned(Vec3::from(look.target) - eye, up, right, yaw, pitch);
    LookAt { target: (eye + to_target).into(), ..*look }
}

/// Circles around the target: the scene turns with the pointer.
pub fn orbit(look: &LookAt, yaw: f32, pitch: f32) -> LookAt {
    let (right, up, _) = axes(look);
    let target = Vec3::from(look.target);
    let from_target = turned(Vec3::from(look.eye) - target, up, right, yaw, pitch);
    LookAt { eye: (target + from_target).into(), ..*look }
}

/// Moves by metres to the right, up and forward.
pub fn walk(look: &LookAt, step: Vec3) -> LookAt {
    let (right, up, forward) = axes(look);
    let by = step.x * right + step.y * up + step.z * forward;
    let moved = |point: [f32; 3]| (Vec3::from(point) + by).into();
    LookAt { eye: moved(look.eye), target: moved(look.target), ..*look }
}

/// Nearer to the target by so many notches, never through it.
pub fn approach(look: &LookAt, notches: f32) -> LookAt {
    let target = Vec3::from(look.target);
    let from_target = (Vec3::from(look.eye) - target) * PER_NOTCH.powf(-notches);
    LookAt { eye: (target + from_target).into(), ..*look }
}

/// Backs off, without turning, until a box fits the view.
pub fn frame(look: &LookAt, bounds: Aabb) -> LookAt {
    let (_, _, forward) = axes(look);
    let radius = 0.5 * bounds.diagonal().max(1e-3);
    let distance = radius / (0.5 * look.vfov).sin().max(1e-3);
    let target = bounds.center();
    LookAt { eye: (target - distance * forward).into(), target: target.into(), ..*look }
}
