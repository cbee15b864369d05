//! What the window does with files and the clipboard, for its panels and for scripts.

use super::Open;
use crate::panels::Action;
use crate::script::Request;
use crate::session::Recording;
use gridlight::output;
use std::path::{Path, PathBuf};
use winit::dpi::PhysicalSize;

/// Where a recorded path is kept.
const PATH_FILE: &str = "path.json";

impl Open {
    /// Shows a scene or a sky.
    pub(super) fn open_file(&mut self, path: &Path) {
        if let Err(why) = self.session.open_file(path) {
            self.shown.say(why);
        }
    }

    /// Does what a panel asked for; screenshots are for the painter.
    pub(super) fn act(&mut self, action: Action, screenshots: &mut Vec<PathBuf>) {
        match action {
            Action::Copy(text) => self.input.set_clipboard_text(text),
            Action::Paste => match self.input.clipboard_text() {
                Some(line) => self.apply_line(&line),
                None => self.shown.say("the clipboard holds no text".into()),
            },
            Action::SaveScreenshot(path) => screenshots.push(path),
            Action::SavePicture(path) => self.save_picture(&path),
            Action::KeepPath(recording) => self.keep_path(recording),
        }
    }

    /// Does what a script asked for.
    pub(super) fn obey(&mut self, request: Request, screenshots: &mut Vec<PathBuf>) {
        match request {
            Request::Resize([width, height]) => {
                // Where the size is granted at once no event says so.
                if let Some(size) = self.window.request_inner_size(PhysicalSize::new(width, height)) {
                    self.painter.resize(size);
                }
            }
            Request::Drop(path) => self.open_file(&path),
            Request::Line(line) => self.apply_line(&line),
            Request::Screenshot(path) => screenshots.push(path),
            Request::Picture(path) => self.save_picture(&path),
            Request::SaveLine(path) => self.save_line(&path),
            Request::Quit => {}
        }
    }

    fn apply_line(&mut self, line: &str) {
        if let Err(why) = self.session.apply_line(line) {
            self.shown.say(why);
        }
    }

    fn keep_path(&mut self, recording: Recording) {
        let file = PathBuf::from(PATH_FILE);
        let kept = recording.path().and_then(|path| {
            let text = serde_json::to_string_pretty(&path).map_err(|e| e.to_string())?;
            output::write(&file, text.as_bytes()).map_err(|e| e.to_string())?;
            Ok(path)
        });
        match kept {
            Ok(path) => self.session.walk(path, file),
            Err(why) => self.shown.say(why),
        }
    }

    fn save_line(&mut self, path: &Path) {
        let frame = self.shown.frames[self.session.edited.index()].as_ref().map(|frame| frame.number);
        if let Err(e) = output::write(path, self.session.line(frame).as_bytes()) {
            self.shown.say(e.to_string());
        }
    }

    fn save_picture(&mut self, path: &Path) {
        let Some(frame) = &self.shown.frames[self.session.edited.index()] else {
            return self.shown.say("there is no picture yet".into());
        };
        if let Err(e) = output::color_exr(path, &frame.radiance) {
            self.shown.say(e.to_string());
        }
    }
}
