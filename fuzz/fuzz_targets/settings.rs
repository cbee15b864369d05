//! What `--set` and `--path` take: knobs of every kind, and camera paths.
//!
//! The first line is a knob's name, `=` and its value; the rest is a camera path's JSON.
#![no_main]

use frame::{Knob, KnobValue, set_knob};
use gridlight::settings::CameraPath;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let (first, rest) = text.split_once('\n').unwrap_or((text, ""));
    if let Some((name, value)) = first.split_once('=') {
        knobs(name, value);
    }
    if let Ok(path) = CameraPath::parse(rest) {
        for time in [0.0, path.end(), 0.5 * path.end(), -1e30, f32::MAX, f32::NAN] {
            let _ = path.at(time);
        }
        // At a key the camera is that key.
        for key in path.keys() {
            assert_eq!(path.at(key.time).eye, key.eye);
        }
    }
});

/// A value that is refused changes nothing; one that is taken is allowed.
fn knobs(name: &str, value: &str) {
    let (mut real, mut whole, mut on, mut choice) = (0.5_f32, 3_u32, false, 1_u32);
    let mut knobs = [
        knob("real", KnobValue::Float { value: &mut real, min: -1.0, max: 2.0 }),
        knob("whole", KnobValue::Int { value: &mut whole, min: 1, max: 9 }),
        knob("on", KnobValue::Bool(&mut on)),
        knob("choice", KnobValue::Choice { value: &mut choice, names: &["a", "b", "c"] }),
    ];
    let taken = set_knob(&mut knobs, name, value).is_ok();
    let [printed_real, printed_whole, ..] = knobs.each_ref().map(ToString::to_string);
    assert!((-1.0..=2.0).contains(&real) && (1..=9).contains(&whole) && choice < 3, "{name}={value}");
    assert!(taken || ((real, whole, on, choice) == (0.5, 3, false, 1)), "{name}={value}");
    assert!(printed_real.parse() == Ok(real) && printed_whole.parse() == Ok(whole), "{name}={value}");
}

fn knob<'a>(name: &'static str, value: KnobValue<'a>) -> Knob<'a> {
    Knob { name, unit: "", doc: "", value }
}
