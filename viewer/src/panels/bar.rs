//! The bar above: undo, the command line, comparison, exposure, animation. The line below: what goes on.

use super::{Action, Desk, choice};
use crate::session::{Channel, Compare, Side};
use egui::{Button, Ui};

/// Above.
pub fn show(ui: &mut Ui, desk: &mut Desk<'_>) {
    ui.horizontal_wrapped(|ui| {
        edits(ui, desk);
        ui.separator();
        comparison(ui, desk);
        ui.separator();
        development(ui, desk);
        ui.separator();
        animation(ui, desk);
    });
}

fn edits(ui: &mut Ui, desk: &mut Desk<'_>) {
    let has_back = desk.session.history.has_back();
    if ui.add_enabled(has_back, Button::new("undo")).on_hover_text("Ctrl+Z").clicked() {
        desk.session.undo();
    }
    let has_forth = desk.session.history.has_forth();
    if ui.add_enabled(has_forth, Button::new("redo")).on_hover_text("Ctrl+Y").clicked() {
        desk.session.redo();
    }
    let what = "The command line that renders what is shown, to the bit";
    if ui.button("copy line").on_hover_text(what).clicked() {
        desk.actions.push(Action::Copy(line(desk)));
    }
    if ui.button("paste line").on_hover_text("Shows what a `gridlight render` line renders").clicked() {
        desk.actions.push(Action::Paste);
    }
    if ui.button("screenshot").on_hover_text("This window, as screenshot.png in this folder").clicked() {
        desk.actions.push(Action::SaveScreenshot("screenshot.png".into()));
    }
    if ui.button("save EXR").on_hover_text("The picture's radiance, as picture.exr in this folder").clicked()
    {
        desk.actions.push(Action::SavePicture("picture.exr".into()));
    }
}

/// The line of the edited side, up to the frame that is shown.
pub fn line(desk: &Desk<'_>) -> String {
    desk.session.line(desk.shown.frames[desk.session.edited.index()].as_ref().map(|frame| frame.number))
}

fn comparison(ui: &mut Ui, desk: &mut Desk<'_>) {
    let mut compare = desk.session.compare;
    if choice(ui, "compare", &mut compare, &Compare::ALL, |c| c.name().into()) {
        desk.session.compare_as(compare);
    }
    if desk.session.asked.b.is_some() {
        for side in [Side::A, Side::B] {
            ui.selectable_value(&mut desk.session.edited, side, side.name())
                .on_hover_text("The side that the panels edit");
        }
    }
    if let (Compare::Flip, Some((_, mean))) = (desk.session.compare, &desk.shown.flip) {
        ui.label(format!("FLIP {mean:.4}"));
    }
}

fn development(ui: &mut Ui, desk: &mut Desk<'_>) {
    let development = &mut desk.session.development;
    let label = ui.label("exposure");
    ui.add(
        egui::DragValue::new(&mut development.exposure_stops)
            .speed(0.02)
            .range(-16.0..=16.0)
            .suffix(" stops"),
    )
    .labelled_by(label.id);
    choice(ui, "channel", &mut development.channel, &Channel::ALL, |c| c.name().into());
    ui.checkbox(&mut development.false_color, "false colour")
        .on_hover_text("Eight stops of luminance in the colours of magma, 0.18 in the middle");
    ui.checkbox(&mut development.mark_strange, "mark NaN")
        .on_hover_text("NaN magenta, infinity cyan, negative green");
}

fn animation(ui: &mut Ui, desk: &mut Desk<'_>) {
    let word = if desk.session.playing { "pause" } else { "play" };
    if ui.button(word).on_hover_text("Frames go on, and the animation with them").clicked() {
        desk.session.toggle_playing(desk.shown.frames[0].as_ref().map(|frame| frame.time));
    }
    if ui.button("restart").on_hover_text("Forgets all history: the next frame is the first").clicked() {
        desk.session.restarts += 1;
    }
    let duration = desk.shown.scene.as_ref().map_or(0.0, |scene| scene.duration);
    if duration > 0.0 {
        let mut time = desk.shown.frames[0].as_ref().map_or(0.0, |frame| frame.time);
        let label = ui.label("time");
        let slider = egui::Slider::new(&mut time, 0.0..=duration).suffix(" s");
        if ui.add(slider).labelled_by(label.id).changed() {
            desk.session.playing = false;
            desk.session.edit(|s| s.time = time);
        }
    }
}

/// Below.
pub fn status(ui: &mut Ui, desk: &mut Desk<'_>) {
    ui.horizontal(|ui| {
        if let Some((what, done)) = &desk.shown.progress {
            ui.spinner();
            ui.label(what);
            if *done > 0.0 {
                ui.add(egui::ProgressBar::new(*done).desired_width(100.0));
            }
        }
        for side in [Side::A, Side::B] {
            let Some(frame) = &desk.shown.frames[side.index()] else { continue };
            if side == Side::B && desk.session.asked.b.is_none() {
                continue;
            }
            let gpu_ms: Option<f64> = frame.passes.iter().map(|pass| pass.gpu_ms).sum();
            let gpu_ms = gpu_ms.map_or(String::new(), |ms| format!("{ms:.1} ms GPU, "));
            ui.label(format!("{} frame {}: {gpu_ms}{:.0} ms", side.name(), frame.number, frame.wall_ms));
        }
        ui.label(&desk.shown.adapter);
        if let Some(message) = desk.shown.messages.back().cloned() {
            ui.separator();
            let all = desk.shown.messages.iter().cloned().collect::<Vec<_>>().join("\n");
            ui.colored_label(ui.visuals().warn_fg_color, message.lines().next().unwrap_or_default())
                .on_hover_text(all);
            if ui.small_button("dismiss").clicked() {
                desk.shown.messages.clear();
            }
        }
    });
}
