//! A camera path from walking around: one key per frame of animation, so that it plays back through the same views.

use gridlight::RenderSettings;
use gridlight::settings::{CameraKey, CameraPath, LookAt};

/// What was walked so far.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// Seconds on the window's clock.
    begun: f64,
    keys: Vec<CameraKey>,
}

impl Recording {
    /// Begins at this moment of the window's clock.
    pub fn new(now: f64) -> Self {
        Self { begun: now, keys: Vec::new() }
    }

    /// Frames so far.
    pub fn frame_count(&self) -> u32 {
        self.keys.len() as u32
    }

    /// Notes where the camera is now, for every frame that has begun since the last call.
    pub fn note(&mut self, now: f64, settings: &RenderSettings, look: &LookAt) {
        let frames = ((now - self.begun).max(0.0) * f64::from(settings.fps)) as u32 + 1;
        for index in self.frame_count()..frames {
            self.keys.push(CameraKey {
                time: settings.frame_time(index),
                eye: look.eye,
                target: look.target,
                up: look.up,
                vfov: look.vfov_degrees(),
            });
        }
    }

    /// The path.
    ///
    /// # Errors
    /// Nothing was recorded.
    pub fn path(self) -> Result<CameraPath, String> {
        CameraPath::new(self.keys)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn frames_of_a_recording_look_through_what_was_seen() {
        let settings = RenderSettings { fps: 10.0, time: 1.5, ..Default::default() };
        let look = |x: f32| LookAt {
            eye: [x, 0.1, 7.3],
            target: [0.0; 3],
            up: [0.0, 1.0, 0.0],
            vfov: 41f32.to_radians(),
        };
        let mut recording = Recording::new(100.0);
        for (now, x) in [(100.0, 0.0), (100.05, 0.5), (100.11, 1.0), (100.32, 2.0)] {
            recording.note(now, &settings, &look(x));
        }
        let path = recording.path().unwrap();
        let seen = [0.0, 1.0, 2.0, 2.0].map(look);
        assert_eq!(path.keys().len(), 4);
        for (index, seen) in (0u32..).zip(seen) {
            assert_eq!(path.at(settings.frame_time(index)), seen, "frame {index}, to the bit");
        }
    }
}
