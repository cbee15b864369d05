//! From settings to the scene they mean and the camera they look through.
//!
//! The scene's own sky and sun stand unless the settings replace them; a scene that nothing lights gets a white sky.

use super::{LookAt, RenderSettings, SkySetting, View};
use crate::Error;
use glam::Vec3;
use scene::{Camera, LoadBudget, Scene, Sky, Sun};

/// Loads the scene and applies everything the settings say about it.
///
/// # Errors
/// The scene or the sky cannot be loaded, or `--emit` names a material that is not there.
pub fn scene(settings: &RenderSettings) -> Result<Scene, Error> {
    let budget = LoadBudget { bytes: settings.load_budget_bytes };
    let mut scene = Scene::load_within(&settings.scene, budget)?;
    for emit in &settings.emit {
        scene.emit(&emit.material, emit.radiance.into())?;
    }
    if let Some(share) = settings.moving_share {
        scene.set_moving(share);
    }
    match &settings.sky {
        Some(SkySetting::Constant(radiance)) => scene.sky = Sky::Constant((*radiance).into()),
        Some(SkySetting::File(path)) => scene.sky = Sky::load_within(path, budget)?,
        None => {}
    }
    if let Some(sun) = settings.sun {
        scene.sun = Some(Sun {
            direction: Vec3::from(sun.direction).normalize(),
            irradiance: sun.irradiance.into(),
            angle: 0.0,
        });
    }
    if let (Some(sun), Some(angle)) = (&mut scene.sun, settings.sun_angle) {
        sun.angle = angle;
    }
    if settings.sky.is_none() && is_dark(&scene) {
        scene.sky = Sky::Constant(Vec3::ONE);
    }
    Ok(scene)
}

/// Whether there is no emitter, no light and no sky.
fn is_dark(scene: &Scene) -> bool {
    let needs = scene.needs();
    !needs.emission && !needs.shadow_rays && scene.sky == Sky::Constant(Vec3::ZERO)
}

/// The camera at `time` seconds.
///
/// # Errors
/// `--camera` names one that the file does not have.
pub fn camera(settings: &RenderSettings, scene: &Scene, time: f32) -> Result<Camera, Error> {
    match &settings.view {
        View::Framing => Ok(Camera::framing(scene.bounds())),
        View::Camera(index) => scene.camera(*index, time).ok_or_else(|| Error::NoSuchCamera {
            scene: scene.name.clone(),
            index: *index,
            count: scene.cameras.len(),
        }),
        View::LookAt(view) => Ok(look_at(view, scene.origin())),
        View::Path(path) => Ok(look_at(&path.at(time), scene.origin())),
    }
}

fn look_at(view: &LookAt, origin: Vec3) -> Camera {
    Camera {
        name: String::new(),
        eye: Vec3::from(view.eye) - origin,
        target: Vec3::from(view.target) - origin,
        up: view.up.into(),
        vfov: view.vfov,
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::panic)]
mod tests {
    use super::*;
    use crate::settings::{Emit, SunSetting};

    fn of(name: &str) -> RenderSettings {
        RenderSettings { scene: name.into(), ..Default::default() }
    }

    #[test]
    fn a_given_sky_and_sun_replace_the_scenes() {
        let settings = RenderSettings {
            sky: Some(SkySetting::Constant([1.0, 2.0, 3.0])),
            sun: Some(SunSetting { direction: [0.0, -2.0, 0.0], irradiance: [4.0, 5.0, 6.0] }),
            sun_angle: Some(0.01),
            ..of("spheres")
        };
        let scene = scene(&settings).unwrap();
        assert_eq!(scene.sky, Sky::Constant(Vec3::new(1.0, 2.0, 3.0)));
        let sun = scene.sun.unwrap();
        assert_eq!((sun.direction, sun.angle), (Vec3::NEG_Y, 0.01));
    }

    #[test]
    fn a_given_black_sky_stays_black() {
        let settings = RenderSettings { sky: Some(SkySetting::Constant([0.0; 3])), ..of("relief") };
        assert_eq!(scene(&settings).unwrap().sky, Sky::Constant(Vec3::ZERO));
    }

    #[test]
    fn a_material_that_is_not_there_is_named() {
        let emit = Emit { material: "plasma".into(), radiance: [1.0; 3] };
        let message = scene(&RenderSettings { emit: vec![emit], ..of("cornell") }).unwrap_err().to_string();
        assert!(message.contains("plasma"), "{message}");
    }

    #[test]
    fn a_camera_that_is_not_there_is_refused_with_both_numbers() {
        let settings = RenderSettings { view: View::Camera(7), ..of("cornell") };
        let scene = scene(&settings).unwrap();
        let message = camera(&settings, &scene, 0.0).unwrap_err().to_string();
        assert!(message.contains('7') && message.contains("cornell"), "{message}");
        assert!(camera(&of("cornell"), &scene, 0.0).is_ok());
    }
}
