//! What each pass takes, and what it wrote: hovering a row shows that in place of the picture, a click holds it.

use super::Desk;
use crate::session::Side;
use crate::shown::median_and_worst;
use crate::worker::Part;
use egui::{Color32, Sense, Ui};
use egui_plot::{Line, Plot, PlotPoints};

/// Points of a history's small plot.
const PLOT_HEIGHT: f32 = 60.0;

/// The right panel's part about passes, of the edited side.
pub fn show(ui: &mut Ui, desk: &mut Desk<'_>) {
    let side = desk.session.edited;
    let Some(frame) = &desk.shown.frames[side.index()] else { return };
    let title =
        if desk.session.asked.b.is_some() { format!("passes of {}", side.name()) } else { "passes".into() };
    let (mut hovered, mut held) = (None, desk.session.held_pass.clone());
    egui::CollapsingHeader::new(title).id_salt("passes").default_open(true).show(ui, |ui| {
        let largest = frame.passes.iter().filter_map(|p| p.gpu_ms).fold(1e-6, f64::max);
        egui::Grid::new("passes").num_columns(4).striped(true).show(ui, |ui| {
            for heading in ["pass", "ms", "median", "worst"] {
                ui.weak(heading);
            }
            ui.end_row();
            for pass in &frame.passes {
                let is_held = held.as_deref() == Some(pass.name.as_str());
                let response = ui.selectable_label(is_held, short(&pass.name)).on_hover_text(format!(
                    "{}, {} in this frame",
                    pass.name,
                    runs(pass.runs)
                ));
                if response.hovered() {
                    hovered = Some(pass.name.clone());
                }
                if response.clicked() {
                    held = (!is_held).then(|| pass.name.clone());
                }
                bar(ui, pass.gpu_ms, largest);
                let past = desk.shown.times[side.index()].get(&pass.name).and_then(median_and_worst);
                let [median, worst] =
                    past.map_or([None, None], |(median, worst)| [Some(median), Some(worst)]);
                ui.label(milliseconds(median));
                ui.label(milliseconds(worst));
                ui.end_row();
            }
        });
        ui.horizontal_wrapped(|ui| {
            ui.weak("G-buffer:");
            for part in Part::ALL {
                let is_held = held.as_deref() == Some(part.name());
                let response = ui.selectable_label(is_held, part.name());
                if response.hovered() {
                    hovered = Some(part.name().into());
                }
                if response.clicked() {
                    held = (!is_held).then(|| part.name().into());
                }
            }
        });
        let total: Option<f64> = frame.passes.iter().map(|p| p.gpu_ms).sum();
        ui.label(format!("together {} ms", milliseconds(total)));
        history(ui, desk, hovered.as_deref().or(held.as_deref()), side);
        if held.is_some() && ui.button("back to the picture").clicked() {
            held = None;
        }
    });
    egui::CollapsingHeader::new("counts and memory").show(ui, |ui| {
        egui::Grid::new("counts").num_columns(2).striped(true).show(ui, |ui| {
            for (name, count) in &frame.counts {
                ui.label(name);
                ui.label(format!("{count}"));
                ui.end_row();
            }
            for (room, bytes) in &frame.memory {
                ui.label(*room);
                ui.label(format!("{:.1} MB", *bytes as f64 * 1e-6));
                ui.end_row();
            }
        });
    });
    desk.session.hovered_pass = hovered;
    desk.session.held_pass = held;
}

/// Without the first part of its path, which the order says.
fn short(name: &str) -> &str {
    match name.char_indices().rev().nth(26) {
        Some((at, _)) => &name[at..],
        None => name,
    }
}

fn runs(runs: u32) -> String {
    if runs == 1 { "one run".into() } else { format!("{runs} runs") }
}

fn milliseconds(ms: Option<f64>) -> String {
    ms.map_or("-".into(), |ms| format!("{ms:.2}"))
}

/// A number with a bar behind it.
fn bar(ui: &mut Ui, ms: Option<f64>, largest: f64) {
    let (rect, _) = ui.allocate_exact_size(egui::vec2(58.0, 14.0), Sense::hover());
    let share = (ms.unwrap_or(0.0) / largest).clamp(0.0, 1.0) as f32;
    let filled = egui::Rect::from_min_size(rect.min, egui::vec2(rect.width() * share, rect.height()));
    ui.painter().rect_filled(filled, 1.0, Color32::from_rgb(60, 90, 140));
    let font = egui::TextStyle::Body.resolve(ui.style());
    let color = ui.visuals().text_color();
    ui.painter().text(rect.left_center(), egui::Align2::LEFT_CENTER, milliseconds(ms), font, color);
}

fn history(ui: &mut Ui, desk: &Desk<'_>, pass: Option<&str>, side: Side) {
    let times = &desk.shown.times[side.index()];
    let points: PlotPoints = match pass {
        Some(pass) => {
            times.get(pass).into_iter().flatten().enumerate().map(|(frame, ms)| [frame as f64, *ms]).collect()
        }
        None => {
            let frames = times.values().map(std::collections::VecDeque::len).max().unwrap_or(0);
            // Passes that ran in some frames only count where they end: the newest frames.
            let total = |back: usize| -> f64 {
                times.values().filter_map(|t| t.len().checked_sub(back + 1).and_then(|at| t.get(at))).sum()
            };
            (0..frames).map(|frame| [frame as f64, total(frames - 1 - frame)]).collect()
        }
    };
    ui.weak(format!("milliseconds of {} over the last frames", pass.unwrap_or("all passes")));
    Plot::new("milliseconds")
        .height(PLOT_HEIGHT)
        .include_y(0.0)
        .allow_scroll(false)
        .allow_drag(false)
        .allow_zoom(false)
        .show_x(false)
        .show(ui, |plot| plot.line(Line::new("ms", points)));
}
