//! Finds controls by the names that readers of the screen say: how scripts and tests know where to click.

use egui::accesskit::{Node, TreeUpdate};
use egui::{Event, Modifiers, PointerButton, Pos2, Rect};

/// Controls of one frame of panels.
#[derive(Default)]
pub struct Widgets(Vec<Widget>);

/// A control.
#[derive(Clone, Debug)]
pub struct Widget {
    /// As it is read out.
    pub name: String,
    /// Points.
    pub rect: Rect,
}

impl Widgets {
    /// All controls with a name. [`egui::Context::enable_accesskit`] has to be called before the frame.
    pub fn of(update: Option<&TreeUpdate>) -> Self {
        let nodes = update.map(|update| update.nodes.as_slice()).unwrap_or_default();
        let name = |node: &Node| {
            let label = node.label().map(str::to_owned);
            label.or_else(|| {
                let labels = node.labelled_by();
                let (_, by) = nodes.iter().find(|(id, _)| labels.contains(id))?;
                by.value().or(by.label()).map(str::to_owned)
            })
        };
        let widget = |node: &Node| {
            let bounds = node.bounds()?;
            let [x0, y0, x1, y1] = [bounds.x0, bounds.y0, bounds.x1, bounds.y1].map(|v| v as f32);
            let rect = Rect { min: Pos2::new(x0, y0), max: Pos2::new(x1, y1) };
            Some(Widget { name: name(node)?, rect })
        };
        Self(nodes.iter().filter_map(|(_, node)| widget(node)).collect())
    }

    /// The control of this name; else the first whose name begins so.
    pub fn find(&self, name: &str) -> Option<&Widget> {
        let exact = self.0.iter().find(|widget| widget.name == name);
        exact.or_else(|| self.0.iter().find(|widget| widget.name.starts_with(name)))
    }

    /// All names, for messages.
    pub fn names(&self) -> Vec<&str> {
        let mut names: Vec<&str> = self.0.iter().map(|widget| widget.name.as_str()).collect();
        names.sort_unstable();
        names
    }
}

/// The pointer comes to a place.
pub fn moved(to: Pos2) -> Vec<Event> {
    vec![Event::PointerMoved(to)]
}

/// A button goes down or up there.
pub fn pressed(at: Pos2, button: PointerButton, pressed: bool) -> Event {
    Event::PointerButton { pos: at, button, pressed, modifiers: Modifiers::NONE }
}
