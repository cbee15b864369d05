//! What the user asked for: plain state that panels edit and the worker is told, no window in it.
//!
//! A and B are two sets of settings over one world. They may differ in tracer, denoiser, upsampler, the knobs of these,
//! samples, bounces and seed; everything else is A's ([`mod@share`]), so that a split screen builds nothing twice.

pub mod camera;
mod history;
mod recording;
mod seen;
mod share;

pub use history::History;
pub use recording::Recording;
pub use seen::{Channel, Compare, Development};
pub use share::{set_knob, share};

use crate::worker::{Order, SceneFacts};
use camera::Flight;
use gridlight::RenderSettings;
use gridlight::cli::RenderLine;
use gridlight::settings::{CameraPath, LookAt, SkySetting, View};
use std::path::{Path, PathBuf};

/// One of the two that are compared.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Side {
    /// The left one; without a comparison the only one.
    #[default]
    A,
    /// The right one.
    B,
}

impl Side {
    /// Its place in lists.
    pub fn index(self) -> usize {
        self as usize
    }

    /// `A` or `B`.
    pub fn name(self) -> &'static str {
        if self == Self::A { "A" } else { "B" }
    }
}

/// Everything that undo brings back.
#[derive(Clone, Debug, PartialEq)]
pub struct Asked {
    /// A's settings.
    pub a: RenderSettings,
    /// B's, where two are compared.
    pub b: Option<RenderSettings>,
}

/// The state of the viewer.
pub struct Session {
    /// What is rendered.
    pub asked: Asked,
    /// Earlier states of it.
    pub history: History,
    /// The one that panels edit.
    pub edited: Side,
    /// How both are shown.
    pub compare: Compare,
    /// Where the split is, 0..1 of the picture's width.
    pub divider: f32,
    /// From radiance to the screen.
    pub development: Development,
    /// After so many frames from restart a resting view stands.
    pub frames_at_rest: u32,
    /// Frames go on, and with them the animation.
    pub playing: bool,
    /// The reference converges while the view rests.
    pub judging: bool,
    /// The error map stands in place of the picture.
    pub error_map: bool,
    /// The pass under the pointer.
    pub hovered_pass: Option<String>,
    /// The pass that was clicked.
    pub held_pass: Option<String>,
    /// The pixel that is inspected, as 0..1 of the picture.
    pub inspected: Option<[f32; 2]>,
    /// How the camera is moved.
    pub flight: Flight,
    /// Views to come back to.
    pub bookmarks: Vec<View>,
    /// A path that is being walked.
    pub recording: Option<Recording>,
    /// The file of the path that is looked along.
    pub path_file: Option<PathBuf>,
    /// Raised to forget all history and begin at the first frame.
    pub restarts: u64,
    /// Something in the scene moves.
    pub has_motion: bool,
}

impl Session {
    /// Begins with these settings.
    pub fn new(settings: RenderSettings) -> Self {
        let asked = Asked { a: settings.clone(), b: None };
        Self {
            history: History::new(asked.clone()),
            asked,
            edited: Side::A,
            compare: Compare::Off,
            divider: 0.5,
            development: Development::default(),
            frames_at_rest: settings.frames.max(1),
            playing: false,
            judging: true,
            error_map: false,
            hovered_pass: None,
            held_pass: None,
            inspected: None,
            flight: Flight::default(),
            bookmarks: Vec::new(),
            recording: None,
            path_file: None,
            restarts: 0,
            has_motion: false,
        }
    }

    /// The settings that panels show.
    pub fn settings(&self) -> &RenderSettings {
        match (self.edited, &self.asked.b) {
            (Side::B, Some(b)) => b,
            _ => &self.asked.a,
        }
    }

    /// Edits them, and keeps to both sides what both share.
    pub fn edit(&mut self, edit: impl FnOnce(&mut RenderSettings)) {
        match (self.edited, &mut self.asked.b) {
            (Side::B, Some(b)) => {
                edit(b);
                share(&b.clone(), &mut self.asked.a);
            }
            (_, b) => {
                edit(&mut self.asked.a);
                if let Some(b) = b {
                    share(&self.asked.a, b);
                }
            }
        }
    }

    /// Chooses how both are shown; the first comparison makes B a copy of A.
    pub fn compare_as(&mut self, compare: Compare) {
        self.compare = compare;
        match compare {
            Compare::Off => {
                self.asked.b = None;
                self.edited = Side::A;
            }
            _ => {
                self.asked.b.get_or_insert_with(|| self.asked.a.clone());
            }
        }
    }

    /// Opens another scene: its own framing, its own light, from time 0.
    pub fn open_scene(&mut self, scene: String) {
        self.flight.speed = None;
        self.edit(|s| {
            *s = RenderSettings {
                scene,
                view: View::Framing,
                sky: None,
                sun: None,
                sun_angle: None,
                emit: Vec::new(),
                time: 0.0,
                ..s.clone()
            };
        });
    }

    /// Opens a file by its ending: a scene, or a sky.
    ///
    /// # Errors
    /// Neither.
    pub fn open_file(&mut self, path: &Path) -> Result<(), String> {
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
        match extension.as_str() {
            "gltf" | "glb" => self.open_scene(path.display().to_string()),
            "hdr" | "exr" => self.edit(|s| s.sky = Some(SkySetting::File(path.into()))),
            _ => {
                return Err(format!(
                    "{}: neither a scene (.gltf, .glb) nor a sky (.hdr, .exr)",
                    path.display()
                ));
            }
        }
        Ok(())
    }

    /// Shows what a line of the command line renders.
    ///
    /// # Errors
    /// What the command line says to it.
    pub fn apply_line(&mut self, line: &str) -> Result<(), String> {
        let RenderLine { settings, path_file } = line.parse()?;
        self.path_file = path_file;
        self.frames_at_rest = settings.frames.max(1);
        self.edit(|s| *s = RenderSettings { frames: s.frames, ..settings });
        Ok(())
    }

    /// Takes over what settings say about stages and their costs, not what is seen.
    pub fn take_stages(&mut self, kept: &RenderSettings) {
        let kept = kept.clone();
        self.edit(|s| {
            *s = RenderSettings {
                trace_size: kept.trace_size,
                display_size: kept.display_size,
                grid: kept.grid,
                tracer: kept.tracer,
                denoiser: kept.denoiser,
                upsampler: kept.upsampler,
                tessellator: kept.tessellator,
                spp: kept.spp,
                bounces: kept.bounces,
                preset: kept.preset,
                sets: kept.sets,
                ..s.clone()
            };
        });
    }

    /// The camera in numbers, wherever it comes from.
    pub fn look(&self, facts: &SceneFacts) -> Option<LookAt> {
        camera::look(&self.settings().view, facts)
    }

    /// Moves the camera.
    pub fn fly(&mut self, facts: &SceneFacts, motion: impl FnOnce(&LookAt) -> LookAt) {
        if let Some(look) = self.look(facts) {
            let view = View::LookAt(motion(&look));
            self.edit(|s| s.view = view);
        }
    }

    /// The whole scene from this side.
    pub fn frame(&mut self, facts: &SceneFacts) {
        self.fly(facts, |look| camera::frame(look, facts.bounds));
    }

    /// Lets frames go on, from the first, or stops at the moment that is shown.
    pub fn toggle_playing(&mut self, shown_time: Option<f32>) {
        self.playing = !self.playing;
        match (self.playing, shown_time) {
            (true, _) => self.restarts += 1,
            // Where nothing moves time stands, and the picture with it.
            (false, Some(time)) if self.has_motion => self.edit(|s| s.time = time),
            (false, _) => {}
        }
    }

    /// The pass whose output stands in place of the picture.
    pub fn watched(&self) -> Option<&str> {
        self.hovered_pass.as_deref().or(self.held_pass.as_deref())
    }

    /// One step back or forth in what was asked for.
    pub fn step_history(&mut self, asked: Option<Asked>) {
        let Some(asked) = asked else { return };
        self.asked = asked;
        if self.asked.b.is_none() {
            self.compare_as(Compare::Off);
        } else if self.compare == Compare::Off {
            self.compare = Compare::Split;
        }
    }

    /// Undoes the last edit.
    pub fn undo(&mut self) {
        let asked = self.history.back();
        self.step_history(asked);
    }

    /// Does it again.
    pub fn redo(&mut self) {
        let asked = self.history.forth();
        self.step_history(asked);
    }

    /// Takes back what could not be had.
    pub fn put_back(&mut self, a: RenderSettings, b: Option<RenderSettings>) {
        self.step_history(Some(Asked { a, b }));
        self.history.note(&self.asked);
    }

    /// The command line that renders what is shown; `frame` is the number of the frame on the screen, if there is one.
    pub fn line(&self, frame: Option<u32>) -> String {
        let frames = frame.unwrap_or(self.frames_at_rest);
        let settings = RenderSettings { frames, ..self.settings().clone() };
        RenderLine { settings, path_file: self.path_file.clone() }.to_string()
    }

    /// Looks along a path that lies in a file: all of its frames, from the first.
    pub fn walk(&mut self, path: CameraPath, file: PathBuf) {
        self.frames_at_rest = path.keys().len() as u32;
        self.path_file = Some(file);
        self.playing = false;
        self.edit(|s| s.view = View::Path(path));
        self.restarts += 1;
    }

    /// What the worker is to do.
    pub fn order(&self) -> Order {
        Order {
            sides: std::iter::once(&self.asked.a).chain(&self.asked.b).cloned().collect(),
            is_moving: self.flight.is_moving,
            is_playing: self.playing,
            frames_at_rest: self.frames_at_rest,
            restarts: self.restarts,
            watched: self.watched().map(str::to_owned),
            watched_side: self.edited.index(),
            inspected: self.inspected,
            is_judging: self.judging,
            wants_flip: self.compare == Compare::Flip,
        }
    }
}

#[cfg(test)]
mod tests;
