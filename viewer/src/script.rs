//! Plays a user: a list of steps, one a line, done in the real window through the events that a hand would make.
//!
//! | step | does |
//! | --- | --- |
//! | `frames N` | waits for N more frames |
//! | `rest` | waits until nothing is left to do, the reference left aside |
//! | `judged N` | waits until the reference has N samples |
//! | `pause N` | waits N milliseconds |
//! | `message TEXT` | waits for a message with TEXT in it |
//! | `hover NAME`, `click NAME` | a control, by the name that readers of the screen say |
//! | `pass NAME` | waits until what this pass wrote is there |
//! | `drag X,Y X,Y` | left button, from and to as shares of the picture |
//! | `turn X,Y X,Y` | the same with the right button |
//! | `resize WxH` | the window, in pixels |
//! | `drop FILE` | on the window |
//! | `line LINE` | as pasted |
//! | `screenshot FILE`, `picture FILE`, `save-line FILE` | the window as PNG, the picture as EXR, the command line |
//! | `quit` | |

use crate::session::Session;
use crate::shown::Shown;
use crate::widgets::{Widgets, moved, pressed};
use egui::{Event, PointerButton, Pos2};
use std::collections::VecDeque;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// A step has failed when nothing is heard of the worker for so long.
const PATIENCE: Duration = Duration::from_secs(600);

/// One line.
#[derive(Clone, Debug, PartialEq)]
enum Step {
    Frames(u64),
    Rest,
    Judged(u64),
    Pause(Duration),
    Message(String),
    Hover(String),
    Click(String),
    Pass(String),
    Drag([f32; 2], [f32; 2], PointerButton),
    Ask(Request),
}

/// What only the window can do.
#[derive(Clone, Debug, PartialEq)]
pub enum Request {
    /// Pixels.
    Resize([u32; 2]),
    /// A file falls on the window.
    Drop(PathBuf),
    /// A line comes from the clipboard.
    Line(String),
    /// The window as PNG.
    Screenshot(PathBuf),
    /// The picture as EXR.
    Picture(PathBuf),
    /// The line that renders what is shown.
    SaveLine(PathBuf),
    /// The end.
    Quit,
}

/// What happens in the next frame of panels.
pub enum Turn {
    /// The pointer does this.
    Events(Vec<Event>),
    /// The window does this.
    Ask(Request),
    /// Nothing until something else happens.
    Wait,
    /// A step cannot be done.
    Stuck(String),
}

/// The steps that are left.
pub struct Script {
    steps: VecDeque<Step>,
    /// One frame of panels after the other.
    events: VecDeque<Vec<Event>>,
    /// Since when, and from which frame on, the step at the front is waited for.
    waiting: Option<(Instant, u64)>,
    /// What was told so far, and when the last of it was.
    heard: Option<(u64, Instant)>,
}

impl Script {
    /// Reads one.
    ///
    /// # Errors
    /// A line that is no step; the message has its number.
    pub fn parse(text: &str) -> Result<Self, String> {
        let lines = text.lines().map(str::trim).enumerate();
        let steps = lines
            .filter(|(_, line)| !line.is_empty() && !line.starts_with('#'))
            .map(|(number, line)| step(line).ok_or_else(|| format!("line {}: no step: {line}", number + 1)));
        Ok(Self {
            steps: steps.collect::<Result<_, _>>()?,
            events: VecDeque::new(),
            waiting: None,
            heard: None,
        })
    }

    /// The next thing to do, given what the last frame of panels was like.
    pub fn turn(&mut self, session: &Session, shown: &Shown, widgets: &Widgets) -> Turn {
        if let Some(events) = self.events.pop_front() {
            return Turn::Events(events);
        }
        let Some(step) = self.steps.front().cloned() else { return Turn::Wait };
        let (since, from) = *self.waiting.get_or_insert_with(|| (Instant::now(), shown.frame_count));
        let done = match &step {
            Step::Frames(count) => shown.frame_count >= from + count,
            Step::Rest => shown.orders[0] > 0 && shown.orders[0] == shown.orders[1],
            Step::Judged(spp) => shown.judgement.as_ref().is_some_and(|judgement| judgement.spp >= *spp),
            Step::Pause(time) => since.elapsed() >= *time,
            Step::Message(text) => shown.messages.iter().any(|message| message.contains(text)),
            Step::Pass(name) => {
                session.watched() == Some(name)
                    && shown.output.as_ref().is_some_and(|output| output.pass == *name)
            }
            Step::Hover(name) => self.point(widgets, name, false),
            Step::Click(name) => self.point(widgets, name, true),
            Step::Drag(from, to, button) => self.drag(widgets, *from, *to, *button),
            Step::Ask(_) => true,
        };
        if !done {
            if self.heard.is_none_or(|(count, _)| count != shown.event_count) {
                self.heard = Some((shown.event_count, Instant::now()));
            }
            let is_silent = self.heard.is_some_and(|(_, last)| last.elapsed() > PATIENCE);
            let is_late = is_silent && since.elapsed() > PATIENCE;
            return match is_late {
                true => {
                    Turn::Stuck(format!("{step:?}: not after {PATIENCE:?}; there is: {:?}", widgets.names()))
                }
                false => Turn::Wait,
            };
        }
        self.steps.pop_front();
        self.waiting = None;
        match step {
            Step::Ask(request) => Turn::Ask(request),
            _ => Turn::Events(self.events.pop_front().unwrap_or_default()),
        }
    }

    /// Whether there is something left.
    pub fn is_going_on(&self) -> bool {
        !self.steps.is_empty() || !self.events.is_empty()
    }

    fn point(&mut self, widgets: &Widgets, name: &str, clicks: bool) -> bool {
        let Some(at) = widgets.find(name).map(|widget| widget.rect.center()) else { return false };
        self.events.push_back(moved(at));
        if clicks {
            self.events.extend([true, false].map(|down| vec![pressed(at, PointerButton::Primary, down)]));
        }
        // What opens or closes does so over some frames.
        self.events.extend(std::iter::repeat_n(Vec::new(), 3));
        true
    }

    fn drag(&mut self, widgets: &Widgets, from: [f32; 2], to: [f32; 2], button: PointerButton) -> bool {
        let Some(rect) = widgets.find("picture").map(|widget| widget.rect) else { return false };
        let place = |share: [f32; 2]| -> Pos2 { rect.min + rect.size() * egui::vec2(share[0], share[1]) };
        let (from, to) = (place(from), place(to));
        self.events.push_back(moved(from));
        self.events.push_back(vec![pressed(from, button, true)]);
        self.events.push_back(moved(from + 0.5 * (to - from)));
        self.events.push_back(moved(to));
        self.events.push_back(vec![pressed(to, button, false)]);
        self.events.push_back(Vec::new());
        true
    }
}

fn step(line: &str) -> Option<Step> {
    let (word, rest) = line.split_once(' ').unwrap_or((line, ""));
    let rest = rest.trim();
    let text = || (!rest.is_empty()).then(|| rest.to_owned());
    let places = || {
        let (from, to) = rest.split_once(' ')?;
        Some((pair(from, ',')?, pair(to, ',')?))
    };
    Some(match word {
        "frames" => Step::Frames(rest.parse().ok()?),
        "rest" => Step::Rest,
        "judged" => Step::Judged(rest.parse().ok()?),
        "pause" => Step::Pause(Duration::from_millis(rest.parse().ok()?)),
        "message" => Step::Message(text()?),
        "hover" => Step::Hover(text()?),
        "click" => Step::Click(text()?),
        "pass" => Step::Pass(text()?),
        "drag" => places().map(|(from, to)| Step::Drag(from, to, PointerButton::Primary))?,
        "turn" => places().map(|(from, to)| Step::Drag(from, to, PointerButton::Secondary))?,
        "resize" => Step::Ask(Request::Resize(pair(rest, 'x')?)),
        "drop" => Step::Ask(Request::Drop(text()?.into())),
        "line" => Step::Ask(Request::Line(text()?)),
        "screenshot" => Step::Ask(Request::Screenshot(text()?.into())),
        "picture" => Step::Ask(Request::Picture(text()?.into())),
        "save-line" => Step::Ask(Request::SaveLine(text()?.into())),
        "quit" => Step::Ask(Request::Quit),
        _ => return None,
    })
}

fn pair<T: std::str::FromStr>(text: &str, between: char) -> Option<[T; 2]> {
    let (a, b) = text.trim().split_once(between)?;
    Some([a.trim().parse().ok()?, b.trim().parse().ok()?])
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_read_or_refused_with_their_line() {
        let script =
            Script::parse("# a comment\nframes 2\n\nclick bvh_cwbvh\n drag 0.5,0.5 0.25,0.5\nquit").unwrap();
        assert_eq!(script.steps[1], Step::Click("bvh_cwbvh".into()));
        assert_eq!(script.steps[2], Step::Drag([0.5, 0.5], [0.25, 0.5], PointerButton::Primary));
        assert_eq!(Script::parse("quit\njump 3").err().unwrap(), "line 2: no step: jump 3");
        assert!(Script::parse("frames x").is_err() && Script::parse("resize 3").is_err());
    }
}
