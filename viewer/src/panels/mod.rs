//! The panels: functions over a [`Session`] that they edit and what was [`Shown`]; no window, no device.
//!
//! Every control has a name of its own for readers of the screen, and thereby for tests and scripts ([`crate::widgets`]).

mod bar;
mod error;
mod inspect;
mod knobs;
mod light;
mod passes;
mod setup;
mod view;

pub use view::Screen;

use crate::session::{Recording, Session};
use crate::shown::Shown;
use crate::store::Store;
use egui::Ui;
use std::path::PathBuf;

/// What the panels ask of the window, which has the clipboard and the files.
#[derive(Clone, Debug, PartialEq)]
pub enum Action {
    /// Text for the clipboard.
    Copy(String),
    /// The clipboard's text is a line.
    Paste,
    /// The window as it is, as PNG.
    SaveScreenshot(PathBuf),
    /// The picture of the edited side, as EXR.
    SavePicture(PathBuf),
    /// What was walked, as a file; then along it.
    KeepPath(Recording),
}

/// Everything the panels see.
pub struct Desk<'a> {
    /// What the user asked for.
    pub session: &'a mut Session,
    /// What came back.
    pub shown: &'a mut Shown,
    /// Pictures as the graphics card has them.
    pub screen: &'a mut Screen,
    /// Recent files, presets and bookmarks.
    pub store: &'a mut Store,
    /// For the window.
    pub actions: &'a mut Vec<Action>,
}

/// All panels; what is left in the middle is the picture.
pub fn show(ui: &mut Ui, desk: &mut Desk<'_>) {
    desk.session.hovered_pass = None;
    egui::Panel::top("bar").show(ui, |ui| bar::show(ui, desk));
    egui::Panel::bottom("status").show(ui, |ui| bar::status(ui, desk));
    egui::Panel::left("setup").default_size(290.0).show(ui, |ui| {
        egui::ScrollArea::vertical().show(ui, |ui| {
            setup::show(ui, desk);
            light::show(ui, desk);
            knobs::show(ui, desk);
        });
    });
    egui::Panel::right("look inside").default_size(300.0).show(ui, |ui| {
        egui::ScrollArea::vertical().show(ui, |ui| {
            error::show(ui, desk);
            passes::show(ui, desk);
            inspect::show(ui, desk);
        });
    });
    egui::CentralPanel::default_margins().show(ui, |ui| view::show(ui, desk));
    // A control that is still held is no edit yet.
    if !ui.input(|i| i.pointer.any_down()) && !desk.session.flight.is_moving {
        desk.session.history.note(&desk.session.asked);
    }
}

/// A list to choose from, with a name.
fn choice<T: PartialEq + Clone>(
    ui: &mut Ui,
    name: &str,
    chosen: &mut T,
    all: &[T],
    word: impl Fn(&T) -> String,
) -> bool {
    let before = chosen.clone();
    ui.horizontal(|ui| {
        let label = ui.label(name);
        let list = egui::ComboBox::from_id_salt(name).selected_text(word(chosen)).show_ui(ui, |ui| {
            for value in all {
                ui.selectable_value(chosen, value.clone(), word(value));
            }
        });
        list.response.labelled_by(label.id);
    });
    *chosen != before
}

#[cfg(test)]
mod tests;
