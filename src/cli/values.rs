//! Reads the values of flags: each function takes text and returns a value or one clear sentence.

use crate::settings::{Emit, KnobSetting, SkySetting, SunSetting};
use std::str::FromStr;

/// Pixels per side that every adapter can do: wgpu's default limit.
const LARGEST_SIDE: u32 = 8192;

/// `640x480`.
pub fn size(text: &str) -> Result<[u32; 2], String> {
    let sides = text.split_once(['x', 'X']).and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    let allowed = 1..=LARGEST_SIDE;
    sides
        .filter(|sides: &[u32; 2]| sides.iter().all(|side| allowed.contains(side)))
        .ok_or_else(|| format!("a size is WIDTHxHEIGHT, like 640x480, each 1 to {LARGEST_SIDE}"))
}

/// A finite number within a range given in words.
fn number(text: &str, fits: impl Fn(f32) -> bool, allowed: &str) -> Result<f32, String> {
    text.parse()
        .ok()
        .filter(|v: &f32| v.is_finite() && fits(*v))
        .ok_or_else(|| format!("allowed is {allowed}"))
}

/// Any finite number.
pub fn finite(text: &str) -> Result<f32, String> {
    number(text, |_| true, "any finite number")
}

/// 0 or more.
pub fn not_negative(text: &str) -> Result<f32, String> {
    number(text, |v| v >= 0.0, "a finite number, 0 or more")
}

/// More than 0.
pub fn positive(text: &str) -> Result<f32, String> {
    number(text, |v| v > 0.0, "a finite number above 0")
}

/// Megabytes (10^6 bytes) as bytes.
pub fn bytes(megabytes: f32) -> u64 {
    (f64::from(megabytes) * 1e6) as u64
}

/// A share: above 0, at most 1.
pub fn share(text: &str) -> Result<f32, String> {
    number(text, |v| v > 0.0 && v <= 1.0, "a number above 0, at most 1")
}

/// Degrees strictly between 0 and 180, as radians.
pub fn field_of_view(text: &str) -> Result<f32, String> {
    number(text, |v| v > 0.0 && v < 180.0, "degrees above 0 and below 180").map(f32::to_radians)
}

/// Degrees from 0 to below 180, as radians.
pub fn disc(text: &str) -> Result<f32, String> {
    number(text, |v| (0.0..180.0).contains(&v), "degrees from 0 to below 180").map(f32::to_radians)
}

/// Exactly `N` finite numbers between commas.
fn numbers<const N: usize>(text: &str) -> Option<[f32; N]> {
    let list: Option<Vec<f32>> =
        text.split(',').map(|part| f32::from_str(part.trim()).ok().filter(|v| v.is_finite())).collect();
    list?.try_into().ok()
}

/// `x,y,z`.
pub fn point(text: &str) -> Result<[f32; 3], String> {
    numbers(text).ok_or_else(|| "three finite numbers, like 1,2.5,-3".into())
}

/// `r,g,b`, none negative.
fn radiance(text: &str) -> Option<[f32; 3]> {
    numbers(text).filter(|rgb| rgb.iter().all(|v| *v >= 0.0))
}

/// `r,g,b`, or a map's file name.
pub fn sky(text: &str) -> Result<SkySetting, String> {
    if let Some(rgb) = radiance(text) {
        return Ok(SkySetting::Constant(rgb));
    }
    let lower = text.to_lowercase();
    match lower.ends_with(".hdr") || lower.ends_with(".exr") {
        true => Ok(SkySetting::File(text.into())),
        false => Err("a sky is r,g,b with finite numbers of 0 or more, or a .hdr or .exr file".into()),
    }
}

/// `dx,dy,dz,r,g,b`.
pub fn sun(text: &str) -> Result<SunSetting, String> {
    numbers(text)
        .map(|[dx, dy, dz, r, g, b]| SunSetting { direction: [dx, dy, dz], irradiance: [r, g, b] })
        .filter(|sun| glam::Vec3::from(sun.direction).try_normalize().is_some())
        .filter(|sun| sun.irradiance.iter().all(|v| *v >= 0.0))
        .ok_or_else(|| {
            "a sun is dx,dy,dz,r,g,b: a direction of travel that is not 0, and irradiance of 0 or more".into()
        })
}

/// A count or `inf`; none is `inf`.
pub fn bounces(text: &str) -> Result<Bounces, String> {
    match text {
        "inf" => Ok(Bounces(None)),
        _ => text.parse().map(|n| Bounces(Some(n))).map_err(|_| "a whole number of 0 or more, or inf".into()),
    }
}

/// Most surface scatterings; none = no limit. (A bare `Option` would read as "flag not given".)
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bounces(pub Option<u32>);

/// `ID.knob=value`.
pub fn knob(text: &str) -> Result<KnobSetting, String> {
    let parts = text.split_once('=').and_then(|(path, value)| {
        let (id, knob) = path.split_once('.')?;
        Some((id, knob, value)).filter(|(id, knob, value)| ![id, knob, value].iter().any(|s| s.is_empty()))
    });
    match parts {
        Some((id, knob, value)) => {
            Ok(KnobSetting { id: id_of(id), knob: knob.replace('-', "_"), value: value.into() })
        }
        None => Err("a knob is set as ID.knob=value, like five_phase.k0=2".into()),
    }
}

/// `MATERIAL=r,g,b`; the name may contain `=`.
pub fn emit(text: &str) -> Result<Emit, String> {
    text.rsplit_once('=')
        .and_then(|(name, rgb)| Some(Emit { material: name.into(), radiance: radiance(rgb)? }))
        .ok_or_else(|| "a glow is MATERIAL=r,g,b with finite numbers of 0 or more".into())
}

/// An id as logs print it: `-` is read as `_`, `none` as `identity`.
pub fn id_of(text: &str) -> String {
    let id = text.replace('-', "_");
    if id == "none" { "identity".into() } else { id }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes() {
        assert_eq!(size("640x480"), Ok([640, 480]));
        for bad in
            ["", "640", "640x", "0x480", "640x0", "-1x5", "640x480x3", "8193x1", "1e3x5", "99999999999x1"]
        {
            assert!(size(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn what_is_not_finite_or_out_of_range_is_refused() {
        for bad in ["nan", "NaN", "inf", "-inf", "", "x", "1e999"] {
            assert!(finite(bad).is_err() && positive(bad).is_err() && share(bad).is_err(), "{bad}");
            assert!(point(&format!("0,{bad},0")).is_err(), "{bad}");
        }
        assert!(positive("0").is_err() && not_negative("-1").is_err() && not_negative("0").is_ok());
        assert!(share("0").is_err() && share("1.01").is_err() && share("1").is_ok());
        assert!(field_of_view("0").is_err() && field_of_view("180").is_err());
        assert_eq!(field_of_view("90"), Ok(std::f32::consts::FRAC_PI_2));
        assert!(disc("-0.1").is_err() && disc("0").is_ok());
    }

    #[test]
    fn skies_and_suns() {
        assert_eq!(sky("3,3.6,4.8"), Ok(SkySetting::Constant([3.0, 3.6, 4.8])));
        assert_eq!(sky("a/b.HDR"), Ok(SkySetting::File("a/b.HDR".into())));
        for bad in ["1,1", "1,-1,1", "a.png", "1,nan,1"] {
            assert!(sky(bad).is_err(), "{bad}");
        }
        let day = SunSetting { direction: [-0.15, -1.0, -0.2], irradiance: [20.0, 18.0, 15.0] };
        assert_eq!(sun("-0.15,-1,-0.2,20,18,15"), Ok(day));
        assert!(sun("0,0,0,1,1,1").is_err() && sun("0,-1,0,1,1").is_err() && sun("0,-1,0,-1,1,1").is_err());
    }

    #[test]
    fn bounces_take_a_count_or_inf() {
        assert_eq!(bounces("inf"), Ok(Bounces(None)));
        assert_eq!(bounces("0"), Ok(Bounces(Some(0))));
        assert!(bounces("-1").is_err() && bounces("1.5").is_err());
    }

    #[test]
    fn knobs_and_glows() {
        let setting = |id: &str, knob: &str, value: &str| KnobSetting {
            id: id.into(),
            knob: knob.into(),
            value: value.into(),
        };
        assert_eq!(knob("five-phase.k0=2"), Ok(setting("five_phase", "k0", "2")));
        assert_eq!(knob("tracer.max-length=1.5"), Ok(setting("tracer", "max_length", "1.5")));
        for bad in ["k0=2", "five_phase.k0", "five_phase.=2", ".k0=2", "five_phase.k0="] {
            assert!(knob(bad).is_err(), "{bad}");
        }
        assert_eq!(emit("a=b=1,2,3"), Ok(Emit { material: "a=b".into(), radiance: [1.0, 2.0, 3.0] }));
        assert!(emit("lamp").is_err() && emit("lamp=1,2").is_err() && emit("lamp=-1,0,0").is_err());
    }

    #[test]
    fn ids_have_two_spellings() {
        assert_eq!([id_of("five-phase"), id_of("none")], ["five_phase", "identity"]);
    }
}
