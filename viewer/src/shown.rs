//! What came back: the last frames, what passes took, the error so far, messages. Panels read it.

use crate::session::Session;
use crate::worker::{Event, Frame, Judgement, Output, SceneFacts};
use frame::cpu::Image;
use gridlight::stages::KnobInfo;
use std::collections::{BTreeMap, VecDeque};

/// Frames over which a pass's milliseconds are remembered.
const REMEMBERED: usize = 120;

/// Messages that are kept.
const MESSAGES: usize = 20;

/// Everything that was told.
#[derive(Default)]
pub struct Shown {
    /// Of the renderer.
    pub adapter: String,
    /// Every knob there is, by stage.
    pub knobs: Vec<(&'static str, Vec<KnobInfo>)>,
    /// The loaded scene.
    pub scene: Option<SceneFacts>,
    /// The last frame of A and of B.
    pub frames: [Option<Box<Frame>>; 2],
    /// Milliseconds of each pass over the last frames, per side.
    pub times: [BTreeMap<String, VecDeque<f64>>; 2],
    /// What is being done, 0..1.
    pub progress: Option<(String, f32)>,
    /// Newest last.
    pub messages: VecDeque<String>,
    /// What the watched pass wrote.
    pub output: Option<Box<Output>>,
    /// At the inspected place.
    pub values: Vec<(String, String)>,
    /// The newest error against the reference.
    pub judgement: Option<Box<Judgement>>,
    /// Per side: (samples of the reference, relMSE), since the view rests.
    pub curves: [Vec<[f64; 2]>; 2],
    /// FLIP of B against A, and its mean.
    pub flip: Option<(Image<f32>, f64)>,
    /// Orders that were sent, and those whose work is done.
    pub orders: [u64; 2],
    /// What was told so far.
    pub event_count: u64,
    /// Frames of A so far.
    pub frame_count: u64,
    /// Raised with everything that changes a picture.
    pub revision: u64,
}

impl Shown {
    /// Takes an event in. One that says an order was refused puts the session back to what stands.
    pub fn take(&mut self, event: Event, session: &mut Session) {
        self.event_count += 1;
        match event {
            Event::Progress(what, done) => self.progress = (done < 1.0).then_some((what, done)),
            Event::Adapter(name) => self.adapter = name,
            Event::Knobs(knobs) => self.knobs = knobs,
            Event::Scene(facts) => {
                for warning in &facts.warnings {
                    self.say(format!("{}: {warning}", facts.settings.scene));
                }
                session.has_motion = facts.has_motion;
                self.scene = Some(*facts);
                self.output = None;
                self.values.clear();
                self.times = Default::default();
            }
            Event::Frame(frame) => self.take_frame(frame),
            Event::Output(output) => {
                self.output = Some(output);
                self.revision += 1;
            }
            Event::Values(values) => self.values = values,
            Event::Judged(judgement) => {
                self.progress = None;
                for (curve, error) in self.curves.iter_mut().zip(&judgement.rel_mse) {
                    curve.extend(error.map(|error| [judgement.spp as f64, error]));
                }
                self.judgement = Some(judgement);
                self.revision += 1;
            }
            Event::Flip(map, mean) => {
                self.flip = Some((map, mean));
                self.revision += 1;
            }
            Event::Failed(why, standing) => {
                self.progress = None;
                self.say(why);
                if let Some([a, rest @ ..]) = standing.as_deref() {
                    session.put_back(a.clone(), rest.first().cloned());
                }
            }
            Event::Rests(taken) => {
                self.progress = None;
                self.orders[1] = taken;
            }
        }
    }

    fn take_frame(&mut self, frame: Box<Frame>) {
        let side = frame.side.min(1);
        self.progress = None;
        self.revision += 1;
        for pass in &frame.passes {
            let Some(ms) = pass.gpu_ms else { continue };
            let times = self.times[side].entry(pass.name.clone()).or_default();
            times.push_back(ms);
            if times.len() > REMEMBERED {
                times.pop_front();
            }
        }
        if side == 0 {
            self.frame_count += 1;
            self.judgement = None;
            self.curves = Default::default();
        }
        self.frames[side] = Some(frame);
    }

    /// Keeps a message for the user.
    pub fn say(&mut self, message: String) {
        eprintln!("{message}");
        if self.messages.len() == MESSAGES {
            self.messages.pop_front();
        }
        self.messages.push_back(message);
    }
}

/// Median and largest of some milliseconds.
pub fn median_and_worst(times: &VecDeque<f64>) -> Option<(f64, f64)> {
    let mut sorted: Vec<f64> = times.iter().copied().collect();
    sorted.sort_by(f64::total_cmp);
    Some((*sorted.get(sorted.len() / 2)?, *sorted.last()?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use gridlight::RenderSettings;

    #[test]
    fn a_refused_order_is_told_and_taken_back() {
        let mut session = Session::new(RenderSettings::default());
        let (before, mut shown) = (session.asked.a.clone(), Shown::default());
        session.edit(|a| a.scene = "broken.glb".into());
        shown.take(Event::Failed("broken.glb: no".into(), Some(vec![before.clone()])), &mut session);
        assert_eq!(session.asked.a, before);
        assert_eq!(shown.messages.back().map(String::as_str), Some("broken.glb: no"));
    }

    #[test]
    fn median_and_worst_of_few_and_none() {
        assert_eq!(median_and_worst(&[3.0, 1.0, 9.0].into()), Some((3.0, 9.0)));
        assert_eq!(median_and_worst(&VecDeque::new()), None);
    }
}
