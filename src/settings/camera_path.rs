//! `--path FILE`: a camera that moves, as keys over animation time.
//!
//! The file is JSON, written by hand or by the viewer:
//!
//! ```json
//! { "keys": [ { "time": 0.0, "eye": [8, 1.6, 0], "target": [0, 2, 0], "up": [0, 1, 0], "vfov": 60 } ] }
//! ```
//!
//! Times in seconds, rising; positions in metres; `vfov` is the vertical field of view in degrees; `up` may be left out
//! (+Y) and so may `vfov` (45). At a key the camera is that key to the bit, so that a recorded path plays back as it was
//! seen; between keys every number follows a cubic Hermite curve whose slopes are the central differences of the keys
//! (Catmull and Rom 1974, with uneven times); before the first key and after the last it stands still.

use super::LookAt;
use crate::Error;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// A moving camera.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraPath {
    /// At least one; times rise.
    keys: Vec<CameraKey>,
}

/// Where the camera is at one moment.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraKey {
    /// Animation time, s.
    pub time: f32,
    /// Metres.
    pub eye: [f32; 3],
    /// A point looked at, metres.
    pub target: [f32; 3],
    /// Roughly up.
    #[serde(default = "plus_y")]
    pub up: [f32; 3],
    /// Vertical field of view, degrees.
    #[serde(default = "usual_vfov")]
    pub vfov: f32,
}

fn plus_y() -> [f32; 3] {
    [0.0, 1.0, 0.0]
}

fn usual_vfov() -> f32 {
    45.0
}

impl CameraPath {
    /// Of these keys.
    ///
    /// # Errors
    /// No key, times that do not rise, a number that is none, a view of nothing, or a field of view outside (0, 180).
    pub fn new(keys: Vec<CameraKey>) -> Result<Self, String> {
        if keys.is_empty() {
            return Err("it has no keys".into());
        }
        for (index, key) in keys.iter().enumerate() {
            if !numbers(key).iter().all(|x| x.is_finite()) || !key.time.is_finite() {
                return Err(format!("key {index}: a number is not finite"));
            }
            if key.eye == key.target {
                return Err(format!("key {index} looks nowhere: eye and target are both {:?}", key.eye));
            }
            if !(key.vfov > 0.0 && key.vfov < 180.0) {
                return Err(format!("key {index}: vfov {} is not between 0 and 180 degrees", key.vfov));
            }
        }
        for (index, pair) in keys.windows(2).enumerate() {
            if let [a, b] = pair
                && a.time >= b.time
            {
                return Err(format!("key {}: time {} does not follow {}", index + 1, b.time, a.time));
            }
        }
        Ok(Self { keys })
    }

    /// Reads a file.
    ///
    /// # Errors
    /// It is not there, is no JSON, or as [`CameraPath::new`].
    pub fn load(path: &Path) -> Result<Self, Error> {
        let fail = |message: String| Error::Read { path: path.into(), message };
        // A device or a pipe may never end.
        if !std::fs::metadata(path).map_err(|e| fail(e.to_string()))?.is_file() {
            return Err(fail("not a file".into()));
        }
        let text = std::fs::read_to_string(path).map_err(|e| fail(e.to_string()))?;
        Self::parse(&text).map_err(fail)
    }

    /// The content of a file.
    ///
    /// # Errors
    /// It is no JSON, or as [`CameraPath::new`].
    pub fn parse(text: &str) -> Result<Self, String> {
        let read: Self = serde_json::from_str(text).map_err(|e| format!("no camera path: {e}"))?;
        Self::new(read.keys).map_err(|e| format!("no camera path: {e}"))
    }

    /// The keys, in order.
    pub fn keys(&self) -> &[CameraKey] {
        &self.keys
    }

    /// Animation time of the last key, s.
    pub fn end(&self) -> f32 {
        self.keys.last().map_or(0.0, |key| key.time)
    }

    /// The view at an animation time, s.
    pub fn at(&self, time: f32) -> LookAt {
        let after = self.keys.partition_point(|key| key.time <= time);
        let before = after.saturating_sub(1);
        let key = |index: usize| self.keys.get(index.min(self.keys.len() - 1));
        let (Some(a), Some(b)) = (key(before), key(after)) else {
            unreachable!("a path has keys");
        };
        let (from, to) = (numbers(a), numbers(b));
        let span = b.time - a.time;
        let s = if span > 0.0 { ((time - a.time) / span).clamp(0.0, 1.0) } else { 0.0 };
        let (slope_a, slope_b) = (self.slope(before), self.slope(after.min(self.keys.len() - 1)));
        let mut now = from;
        if s > 0.0 {
            let (s2, s3) = (s * s, s * s * s);
            let weights = [2.0 * s3 - 3.0 * s2 + 1.0, s3 - 2.0 * s2 + s, 3.0 * s2 - 2.0 * s3, s3 - s2];
            for (i, value) in now.iter_mut().enumerate() {
                *value = weights[0] * from[i]
                    + weights[1] * span * slope_a[i]
                    + weights[2] * to[i]
                    + weights[3] * span * slope_b[i];
            }
        }
        let [ex, ey, ez, tx, ty, tz, ux, uy, uz, vfov] = now;
        LookAt { eye: [ex, ey, ez], target: [tx, ty, tz], up: [ux, uy, uz], vfov: vfov.to_radians() }
    }

    /// Change per second of every number at a key: over both neighbours, or over the one there is.
    fn slope(&self, index: usize) -> [f32; 10] {
        let last = self.keys.len() - 1;
        let (a, b) = (&self.keys[index.saturating_sub(1)], &self.keys[(index + 1).min(last)]);
        let span = b.time - a.time;
        let (from, to) = (numbers(a), numbers(b));
        std::array::from_fn(|i| if span > 0.0 { (to[i] - from[i]) / span } else { 0.0 })
    }
}

/// Eye, target, up and field of view.
fn numbers(key: &CameraKey) -> [f32; 10] {
    let ([ex, ey, ez], [tx, ty, tz], [ux, uy, uz]) = (key.eye, key.target, key.up);
    [ex, ey, ez, tx, ty, tz, ux, uy, uz, key.vfov]
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn key(time: f32, x: f32) -> CameraKey {
        CameraKey { time, eye: [x, 0.1, 0.7], target: [x, 0.3, -1.0], up: plus_y(), vfov: 50.0 + x }
    }

    #[test]
    fn keys_are_met_to_the_bit_and_the_ends_hold() {
        let keys = vec![key(0.1, 0.3), key(0.4, 1.7), key(1.3, -0.9)];
        let path = CameraPath::new(keys.clone()).unwrap();
        for key in &keys {
            let view = path.at(key.time);
            assert_eq!((view.eye, view.target, view.vfov), (key.eye, key.target, key.vfov.to_radians()));
        }
        assert_eq!(path.at(-5.0), path.at(0.1));
        assert_eq!(path.at(9.0), path.at(1.3));
        assert_eq!(path.end(), 1.3);
    }

    #[test]
    fn even_motion_stays_even_between_uneven_keys() {
        // The slopes are exact for a straight line, and a Hermite cubic keeps it; f32 rounding of a few terms is left.
        let path = CameraPath::new([0.0, 0.5, 2.0, 2.25].map(|t| key(t, 3.0 * t)).to_vec()).unwrap();
        for step in 0..=45 {
            let time = 0.05 * step as f32;
            assert!((path.at(time).eye[0] - 3.0 * time).abs() < 1e-5, "{time}");
        }
    }

    #[test]
    fn one_key_stands_still() {
        let path = CameraPath::new(vec![key(1.0, 2.0)]).unwrap();
        assert_eq!(path.at(0.0), path.at(3.0));
    }

    #[test]
    fn paths_that_mean_nothing_say_which_key() {
        let nowhere = CameraKey { target: [0.0, 0.1, 0.7], ..key(1.0, 0.0) };
        for (keys, part) in [
            (vec![], "no keys"),
            (vec![key(1.0, 0.0), key(1.0, 1.0)], "key 1: time 1 does not follow 1"),
            (vec![key(0.0, 0.0), nowhere], "key 1 looks nowhere"),
            (vec![CameraKey { vfov: 180.0, ..key(0.0, 0.0) }], "key 0: vfov 180"),
            (vec![CameraKey { up: [f32::NAN; 3], ..key(0.0, 0.0) }], "key 0: a number"),
        ] {
            let message = CameraPath::new(keys).unwrap_err();
            assert!(message.contains(part), "{message}");
        }
    }

    #[test]
    fn a_file_is_read_and_a_broken_one_named() {
        let folder = std::env::temp_dir().join(format!("gridlight-path-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let file = folder.join("walk.json");
        std::fs::write(&file, r#"{"keys":[{"time":0,"eye":[0,0,0],"target":[0,0,-1]}]}"#).unwrap();
        let path = CameraPath::load(&file).unwrap();
        assert_eq!(path.at(0.0).up, [0.0, 1.0, 0.0]);
        std::fs::write(&file, r#"{"keys":[{"time":0,"eye":[0,0,0]}]}"#).unwrap();
        let message = CameraPath::load(&file).unwrap_err().to_string();
        assert!(message.contains("walk.json") && message.contains("target"), "{message}");
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
