//! Every knob of the chosen stages: unit and range, what it does as a tooltip, back to the preset's value.

use super::Desk;
use crate::session::set_knob;
use egui::{DragValue, Slider, Ui};
use gridlight::RenderSettings;
use gridlight::stages::{KnobInfo, KnobKind};

/// The left panel's lower part.
pub fn show(ui: &mut Ui, desk: &mut Desk<'_>) {
    let settings = desk.session.settings().clone();
    let stages = [
        "voxel",
        "gather",
        "tracer",
        &settings.tessellator,
        &settings.tracer,
        &settings.denoiser,
        &settings.upsampler,
    ];
    let mut seen = Vec::new();
    for id in stages {
        if seen.contains(&id) {
            continue;
        }
        seen.push(id);
        let Some((_, knobs)) = desk.shown.knobs.iter().find(|(known, _)| *known == id) else { continue };
        if knobs.is_empty() {
            continue;
        }
        egui::CollapsingHeader::new(format!("{id} knobs")).show(ui, |ui| {
            for knob in knobs {
                if let Some(turn) = row(ui, &settings, id, knob) {
                    desk.session.edit(|s| set_knob(s, id, knob.name, turn));
                }
            }
        });
    }
}

/// What a knob stands at: as set, else as the preset has it, else as the stage comes.
pub fn value_of(settings: &RenderSettings, id: &str, knob: &KnobInfo) -> String {
    let set = settings.sets_for(id).filter(|(name, _)| *name == knob.name).last();
    let preset = settings.preset.knobs().iter().find(|(stage, name, _)| *stage == id && *name == knob.name);
    match (set, preset) {
        (Some((_, value)), _) => value.into(),
        (None, Some((_, _, value))) => (*value).into(),
        (None, None) => knob.default.clone(),
    }
}

/// A knob's row; the value it was turned to, or none in it for back to the preset's.
fn row(ui: &mut Ui, settings: &RenderSettings, id: &str, knob: &KnobInfo) -> Option<Option<String>> {
    let value = value_of(settings, id, knob);
    let is_set = settings.sets_for(id).any(|(name, _)| name == knob.name);
    let mut turn = None;
    ui.horizontal(|ui| {
        let text = if is_set { egui::RichText::new(knob.name).strong() } else { knob.name.into() };
        let what = format!("{}\n\n{} {}; by default {}", knob.doc, knob.allowed, knob.unit, knob.default);
        let label = ui.label(text).on_hover_text(&what);
        let suffix = if knob.unit.is_empty() { String::new() } else { format!(" {}", knob.unit) };
        match knob.kind {
            KnobKind::Bool => {
                let mut on = value == "on";
                if ui.checkbox(&mut on, "").labelled_by(label.id).changed() {
                    turn = Some(if on { "on" } else { "off" }.into());
                }
            }
            KnobKind::Choice(names) => {
                let mut chosen = value.as_str();
                let list = egui::ComboBox::from_id_salt((id, knob.name)).selected_text(chosen);
                let list = list.show_ui(ui, |ui| {
                    for name in names {
                        ui.selectable_value(&mut chosen, name, *name);
                    }
                });
                list.response.labelled_by(label.id);
                if chosen != value {
                    turn = Some(chosen.into());
                }
            }
            KnobKind::Int(least, most) => {
                let mut number: u32 = value.parse().unwrap_or(least);
                let slider = Slider::new(&mut number, least..=most).suffix(suffix).logarithmic(most > 256);
                if ui.add(slider).labelled_by(label.id).on_hover_text(&what).changed() {
                    turn = Some(number.to_string());
                }
            }
            KnobKind::Float(least, most) => {
                let mut number: f32 = value.parse().unwrap_or(least);
                let response = match most.is_finite() && most <= 1e6 {
                    true => ui.add(Slider::new(&mut number, least..=most).suffix(suffix)),
                    // A slider over more than that cannot be aimed with.
                    false => ui.add(DragValue::new(&mut number).range(least..=most).suffix(suffix)),
                };
                if response.labelled_by(label.id).on_hover_text(&what).changed() {
                    turn = Some(number.to_string());
                }
            }
        }
        if is_set && ui.small_button("reset").on_hover_text("As the preset has it").clicked() {
            turn = Some(String::new());
        }
    });
    turn.map(|value| (!value.is_empty()).then_some(value))
}
