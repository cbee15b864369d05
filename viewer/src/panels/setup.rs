//! What is rendered: scene, camera, sizes, stages, presets.

use super::{Action, Desk, choice};
use crate::session::{Recording, Session, camera};
use crate::worker::SceneFacts;
use egui::{DragValue, Ui};
use gridlight::RenderSettings;
use gridlight::cli::RenderLine;
use gridlight::settings::{Model, Preset, View};
use gridlight::stages::Kind;

/// The left panel's upper part.
pub fn show(ui: &mut Ui, desk: &mut Desk<'_>) {
    egui::CollapsingHeader::new("scene").default_open(true).show(ui, |ui| {
        scenes(ui, desk);
        cameras(ui, desk);
    });
    egui::CollapsingHeader::new("stages").default_open(true).show(ui, |ui| stages(ui, desk));
    egui::CollapsingHeader::new("sizes and paths").default_open(true).show(ui, |ui| sizes(ui, desk));
    egui::CollapsingHeader::new("presets").show(ui, |ui| presets(ui, desk));
    egui::CollapsingHeader::new("line").show(ui, |ui| line(ui, desk));
}

fn scenes(ui: &mut Ui, desk: &mut Desk<'_>) {
    let mut scene = desk.session.settings().scene.clone();
    let built_in = scene::built_in::all().iter().map(|(name, ..)| (*name).to_owned());
    let mut all: Vec<String> = built_in.chain(desk.store.recent_scenes.iter().cloned()).collect();
    if !all.contains(&scene) {
        all.push(scene.clone());
    }
    if choice(ui, "open", &mut scene, &all, |path| short(path)) {
        desk.session.open_scene(scene);
    }
    ui.weak("or drop a .gltf, .glb, .hdr or .exr on the window");
    if let Some(facts) = &desk.shown.scene {
        ui.weak(format!("{} triangles, {:.1} m across", facts.triangle_count, facts.bounds.diagonal()));
    }
}

/// The end of a path: lists are narrow.
fn short(path: &str) -> String {
    path.rsplit(['/', '\\']).next().unwrap_or(path).into()
}

fn cameras(ui: &mut Ui, desk: &mut Desk<'_>) {
    let Some(facts) = &desk.shown.scene else { return };
    let mut view = desk.session.settings().view.clone();
    let mut all = vec![View::Framing];
    all.extend((0..facts.cameras.len()).map(View::Camera));
    all.extend(desk.session.bookmarks.iter().cloned());
    let names: Vec<String> = facts.cameras.iter().map(|camera| camera.name.clone()).collect();
    let bookmarks = desk.session.bookmarks.clone();
    let word = |view: &View| match view {
        View::Framing => "whole scene".into(),
        View::Camera(index) => match names.get(*index).filter(|name| !name.is_empty()) {
            Some(name) => format!("{index}: {name}"),
            None => format!("camera {index}"),
        },
        View::LookAt(_) => match bookmarks.iter().position(|known| known == view) {
            Some(index) => format!("bookmark {}", index + 1),
            None => "free".into(),
        },
        View::Path(path) => format!("path of {} keys", path.keys().len()),
    };
    if choice(ui, "camera", &mut view, &all, word) {
        desk.session.edit(|s| s.view = view);
    }
    ui.horizontal(|ui| {
        if ui.button("bookmark").on_hover_text("Puts this view in the list of cameras").clicked() {
            let view = desk.session.settings().view.clone();
            desk.session.bookmarks.push(view);
        }
        ui.checkbox(&mut desk.session.flight.orbits, "orbit").on_hover_text(
            "Drag with the right button: turns around the target; without, looks around from where you are",
        );
        if ui.button("frame").on_hover_text("F: the whole scene from this side").clicked() {
            desk.session.frame(facts);
        }
    });
    record(ui, facts, desk.session, desk.actions);
    let speed = desk.session.flight.speed(facts.bounds);
    ui.weak(format!("right mouse and WASD, QE: {speed:.2} m/s; wheel: faster"));
    if let Some(look) = desk.session.look(facts) {
        let place = |p: [f32; 3]| format!("{:.2}, {:.2}, {:.2}", p[0], p[1], p[2]);
        ui.weak(format!("at {}, looking at {}", place(look.eye), place(look.target)));
    }
    if let View::LookAt(mut look) = desk.session.settings().view {
        let mut degrees = look.vfov.to_degrees();
        ui.horizontal(|ui| {
            let label = ui.label("field of view");
            let value = DragValue::new(&mut degrees).range(1.0..=170.0).suffix("°");
            if ui.add(value).labelled_by(label.id).changed() {
                look.vfov = degrees.to_radians();
                desk.session.edit(|s| s.view = View::LookAt(look));
            }
        });
    } else if ui.button("free the camera").clicked()
        && let Some(look) = camera::look(&desk.session.settings().view, facts)
    {
        desk.session.edit(|s| s.view = View::LookAt(look));
    }
}

/// Walking around, kept as a path.
fn record(ui: &mut Ui, facts: &SceneFacts, session: &mut Session, actions: &mut Vec<Action>) {
    let now = ui.input(|i| i.time);
    let settings = session.settings().clone();
    let Some(look) = session.look(facts) else { return };
    match &mut session.recording {
        None => {
            let what = "Keeps where you walk as a camera path, path.json in this folder, and walks it again";
            if ui.button("record path").on_hover_text(what).clicked() {
                session.recording = Some(Recording::new(now));
            }
        }
        Some(recording) => {
            recording.note(now, &settings, &look);
            ui.ctx().request_repaint();
            if ui.button(format!("end path, {} frames", recording.frame_count())).clicked() {
                actions.extend(session.recording.take().map(Action::KeepPath));
            }
        }
    }
}

/// A stage's choice within settings.
fn chosen(settings: &mut RenderSettings, kind: Kind) -> &mut String {
    match kind {
        Kind::Tessellator => &mut settings.tessellator,
        Kind::Tracer => &mut settings.tracer,
        Kind::Denoiser => &mut settings.denoiser,
        Kind::Upsampler => &mut settings.upsampler,
    }
}

fn stages(ui: &mut Ui, desk: &mut Desk<'_>) {
    for kind in Kind::ALL {
        let mut id = chosen(&mut desk.session.settings().clone(), kind).clone();
        let all: Vec<String> = kind.ids().into_iter().map(str::to_owned).collect();
        if choice(ui, kind.name(), &mut id, &all, Clone::clone) {
            desk.session.edit(|s| {
                *chosen(s, kind) = id;
                drop_foreign_knobs(s);
            });
        }
    }
}

/// Knobs of stages that take no part would be refused.
fn drop_foreign_knobs(settings: &mut RenderSettings) {
    let taking_part: Vec<String> =
        Kind::ALL.into_iter().map(|kind| chosen(&mut settings.clone(), kind).clone()).collect();
    let always = ["voxel", "gather", "tracer"];
    settings.sets.retain(|set| always.contains(&set.id.as_str()) || taking_part.contains(&set.id));
}

fn sizes(ui: &mut Ui, desk: &mut Desk<'_>) {
    let mut s = desk.session.settings().clone();
    let number = |ui: &mut Ui, name: &str, value: &mut u32, range: std::ops::RangeInclusive<u32>| {
        let label = ui.label(name);
        let response =
            ui.add(DragValue::new(value).range(range).update_while_editing(false)).labelled_by(label.id);
        // While it is dragged a size would load the scene at every step.
        response.drag_stopped() || (response.changed() && !response.dragged())
    };
    let mut changed = false;
    egui::Grid::new("sizes").num_columns(4).show(ui, |ui| {
        for (name, size) in [("trace", &mut s.trace_size), ("display", &mut s.display_size)] {
            changed |= number(ui, &format!("{name} width"), &mut size[0], 8..=8192);
            changed |= number(ui, &format!("{name} height"), &mut size[1], 8..=8192);
            ui.end_row();
        }
        changed |= number(ui, "grid", &mut s.grid, 8..=1024);
        changed |= number(ui, "samples", &mut s.spp, 1..=64);
        ui.end_row();
        let mut bounces = s.bounces.unwrap_or(0);
        if number(ui, "bounces", &mut bounces, 0..=32) {
            s.bounces = Some(bounces);
            changed = true;
        }
        changed |= number(ui, "seed", &mut s.seed, 0..=u32::MAX);
        ui.end_row();
        number(ui, "frames at rest", &mut desk.session.frames_at_rest, 1..=1024);
        ui.end_row();
    });
    let mut unlimited = s.bounces.is_none();
    if ui.checkbox(&mut unlimited, "no limit of bounces").changed() {
        s.bounces = if unlimited { None } else { RenderSettings::default().bounces };
        changed = true;
    }
    if changed {
        desk.session.edit(|settings| *settings = s);
    }
}

fn presets(ui: &mut Ui, desk: &mut Desk<'_>) {
    let name = |value: String| value.to_lowercase();
    let mut preset = desk.session.settings().preset;
    let all = [Preset::Default, Preset::Paper, Preset::Gltf];
    if choice(ui, "knobs as", &mut preset, &all, |p| name(format!("{p:?}"))) {
        desk.session.edit(|s| s.preset = preset);
    }
    let mut model = desk.session.settings().model;
    if choice(ui, "materials as", &mut model, &[Model::Gltf, Model::Lambert], |m| name(format!("{m:?}"))) {
        desk.session.edit(|s| s.model = model);
    }
    let mut chosen = None;
    for (name, line) in &desk.store.presets {
        if ui.button(name).on_hover_text(line).clicked() {
            chosen = line.parse::<RenderLine>().ok();
        }
    }
    if let Some(kept) = chosen {
        desk.session.take_stages(&kept.settings);
    }
    ui.horizontal(|ui| {
        let label = ui.label("name");
        ui.add(egui::TextEdit::singleline(&mut desk.store.new_preset).desired_width(100.0))
            .labelled_by(label.id);
        let named = !desk.store.new_preset.trim().is_empty();
        let what = "Keeps stages, knobs, sizes and samples under this name";
        if ui.add_enabled(named, egui::Button::new("keep")).on_hover_text(what).clicked() {
            desk.store.keep_preset(desk.session.line(None));
        }
    });
}

fn line(ui: &mut Ui, desk: &mut Desk<'_>) {
    // Until somebody writes into it, it follows.
    let mut text = desk.store.edited_line.clone().unwrap_or_else(|| super::bar::line(desk));
    let label = ui.label("as a command line");
    let edit = egui::TextEdit::multiline(&mut text).desired_rows(6).desired_width(f32::INFINITY);
    if ui.add(edit).labelled_by(label.id).changed() {
        desk.store.edited_line = Some(text.clone());
    }
    ui.horizontal(|ui| {
        if ui.button("apply line").clicked() {
            match desk.session.apply_line(&text) {
                Ok(()) => desk.store.edited_line = None,
                Err(why) => desk.shown.say(why),
            }
        }
        if desk.store.edited_line.is_some() && ui.button("discard").clicked() {
            desk.store.edited_line = None;
        }
    });
}
