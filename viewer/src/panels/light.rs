//! Sun and sky: the scene's own, or others in their place.

use super::Desk;
use egui::{DragValue, Slider, Ui};
use glam::Vec3;
use gridlight::settings::{SkySetting, SunSetting};

/// A sun where the scene has none: a clear afternoon's.
const SUN: SunSetting = SunSetting { direction: [-0.4, -0.8, -0.3], irradiance: [3.0, 2.8, 2.5] };

/// The left panel's part about light.
pub fn show(ui: &mut Ui, desk: &mut Desk<'_>) {
    egui::CollapsingHeader::new("sun and sky").show(ui, |ui| {
        sun(ui, desk);
        sky(ui, desk);
    });
}

/// Azimuth around +Y from -Z towards +X, elevation of the sun above the horizon, degrees; and back.
fn angles(direction: [f32; 3]) -> [f32; 2] {
    let towards = -Vec3::from(direction).normalize_or(Vec3::NEG_Y);
    [towards.x.atan2(-towards.z).to_degrees(), towards.y.clamp(-1.0, 1.0).asin().to_degrees()]
}

fn direction([azimuth, elevation]: [f32; 2]) -> [f32; 3] {
    let [azimuth, elevation] = [azimuth, elevation].map(f32::to_radians);
    let towards =
        Vec3::new(elevation.cos() * azimuth.sin(), elevation.sin(), -elevation.cos() * azimuth.cos());
    (-towards).into()
}

fn sun(ui: &mut Ui, desk: &mut Desk<'_>) {
    let given = desk.session.settings().sun;
    let own = desk.shown.scene.as_ref().and_then(|facts| facts.sun);
    let own = own
        .map_or(SUN, |sun| SunSetting { direction: sun.direction.into(), irradiance: sun.irradiance.into() });
    let mut replaced = given.is_some();
    if ui.checkbox(&mut replaced, "another sun").changed() {
        desk.session.edit(|s| s.sun = replaced.then_some(own));
        return;
    }
    let Some(given) = given else { return };
    let draft = egui::Id::unique("sun being turned");
    let mut sun = ui.data(|d| d.get_temp(draft)).unwrap_or(given);
    let [mut azimuth, mut elevation] = angles(sun.direction);
    let mut done = false;
    for (name, value, range) in
        [("azimuth", &mut azimuth, -180.0..=180.0), ("elevation", &mut elevation, -89.0..=89.0)]
    {
        ui.horizontal(|ui| {
            let label = ui.label(name);
            done |= settled(&ui.add(Slider::new(value, range).suffix("°")).labelled_by(label.id));
        });
    }
    sun.direction = direction([azimuth, elevation]);
    ui.horizontal(|ui| {
        ui.label("irradiance");
        for value in &mut sun.irradiance {
            done |= settled(&ui.add(DragValue::new(value).range(0.0..=1e4).speed(0.05)));
        }
    });
    ui.data_mut(|d| d.insert_temp(draft, sun));
    if done {
        desk.session.edit(|s| s.sun = Some(sun));
    }
    if !ui.input(|i| i.pointer.any_down()) {
        ui.data_mut(|d| d.remove::<SunSetting>(draft));
    }
}

fn sky(ui: &mut Ui, desk: &mut Desk<'_>) {
    let given = desk.session.settings().sky.clone();
    let mut replaced = given.is_some();
    if ui.checkbox(&mut replaced, "another sky").changed() {
        desk.session.edit(|s| s.sky = replaced.then_some(SkySetting::Constant([1.0; 3])));
        return;
    }
    match given {
        Some(SkySetting::Constant(radiance)) => {
            let draft = egui::Id::unique("sky being turned");
            let mut radiance = ui.data(|d| d.get_temp(draft)).unwrap_or(radiance);
            let mut done = false;
            ui.horizontal(|ui| {
                ui.label("radiance");
                for value in &mut radiance {
                    done |= settled(&ui.add(DragValue::new(value).range(0.0..=1e4).speed(0.02)));
                }
            });
            ui.data_mut(|d| d.insert_temp(draft, radiance));
            if done {
                desk.session.edit(|s| s.sky = Some(SkySetting::Constant(radiance)));
            }
            if !ui.input(|i| i.pointer.any_down()) {
                ui.data_mut(|d| d.remove::<[f32; 3]>(draft));
            }
        }
        Some(SkySetting::File(path)) => {
            ui.label(path.display().to_string());
        }
        None => {}
    }
}

/// A value that was let go of: another light makes another scene, too much for every step of a drag.
fn settled(response: &egui::Response) -> bool {
    response.drag_stopped() || (response.changed() && !response.dragged())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_and_directions_are_the_same_thing() {
        for pair in [[0.0f32, 30.0f32], [90.0, 10.0], [-135.0, 80.0], [179.0, -20.0]] {
            let back = angles(direction(pair));
            // Degrees from sines of f32: 1e-3 of a degree.
            assert!(
                (back[0] - pair[0]).abs() < 1e-3 && (back[1] - pair[1]).abs() < 1e-3,
                "{pair:?} {back:?}"
            );
        }
        assert_eq!(direction([0.0, 0.0])[2], 1.0, "from -Z the light travels along +Z");
    }
}
