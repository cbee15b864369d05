//! The pixel inspector: every value the passes saw at the place that was clicked.

use super::Desk;
use egui::Ui;

/// The right panel's lowest part.
pub fn show(ui: &mut Ui, desk: &mut Desk<'_>) {
    egui::CollapsingHeader::new("pixel").default_open(true).show(ui, |ui| {
        if desk.session.inspected.is_none() {
            ui.weak("click into the picture");
            return;
        }
        if ui.button("stop inspecting").clicked() {
            desk.session.inspected = None;
            desk.shown.values.clear();
        }
        egui::Grid::new("values").num_columns(2).striped(true).show(ui, |ui| {
            for (name, value) in &desk.shown.values {
                ui.weak(name);
                ui.monospace(value);
                ui.end_row();
            }
        });
    });
}
