//! Keyframes of one property of one node: glTF's step, linear and cubic-spline interpolation.
//!
//! Before its first key a track holds the first value, after its last key the last one; it does not loop.
//! Rotations go along the shorter great circle (`LINEAR`) and are made unit again (`CUBICSPLINE`).

use glam::{Quat, Vec4};

/// What a track drives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Property {
    /// Three numbers, metres.
    Translation,
    /// A quaternion, x y z w.
    Rotation,
    /// Three factors.
    Scale,
    /// One number per morph target.
    Weights,
}

/// How values between keys come about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Interpolation {
    /// The value of the key before.
    Step,
    /// A straight line, or a great circle for rotations.
    Linear,
    /// Hermite splines; each key holds in-tangent, value, out-tangent.
    CubicSpline,
}

/// One animation channel with its sampler.
#[derive(Clone, Debug)]
pub(crate) struct Track {
    /// Index into [`super::Rig::nodes`].
    pub node: usize,
    /// What is driven.
    pub property: Property,
    interpolation: Interpolation,
    /// Seconds, not decreasing, at least one.
    times: Vec<f32>,
    /// Numbers per value.
    width: usize,
    values: Vec<f32>,
}

impl Track {
    /// A track whose lists fit each other; otherwise what does not fit.
    pub(crate) fn new(
        node: usize,
        property: Property,
        interpolation: Interpolation,
        times: Vec<f32>,
        width: usize,
        values: Vec<f32>,
    ) -> Result<Self, String> {
        let per_key = width * if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
        if times.is_empty() {
            return Err("no keys".into());
        }
        if values.len() != times.len() * per_key {
            let (found, keys) = (values.len(), times.len());
            return Err(format!("{found} output numbers, {keys} keys of {per_key} need {}", keys * per_key));
        }
        if !times.iter().all(|t| t.is_finite()) || times.windows(2).any(|pair| pair[1] < pair[0]) {
            return Err("key times are not finite and ascending".into());
        }
        if !values.iter().all(|v| v.is_finite()) {
            return Err("an output number is not finite".into());
        }
        Ok(Self { node, property, interpolation, times, width, values })
    }

    /// Seconds at which keys lie.
    pub(crate) fn times(&self) -> &[f32] {
        &self.times
    }

    /// Whether any two moments differ.
    pub(crate) fn varies(&self) -> bool {
        let first = self.value(0);
        let differs = (1..self.times.len()).any(|key| self.value(key) != first);
        let bends = self.interpolation == Interpolation::CubicSpline
            && (0..self.times.len())
                .any(|key| [0, 2].iter().any(|&part| self.key(key, part).iter().any(|&x| x != 0.0)));
        self.times.len() > 1 && (differs || bends)
    }

    /// The value at `time` seconds, as many numbers as the property has.
    pub(crate) fn sample(&self, time: f32) -> Vec<f32> {
        let next = self.times.partition_point(|&t| t <= time);
        if next == 0 || next == self.times.len() {
            return self.value(next.saturating_sub(1)).to_vec();
        }
        let last = next - 1;
        let span = self.times[next] - self.times[last];
        let s = (time - self.times[last]) / span;
        match self.interpolation {
            Interpolation::Step => self.value(last).to_vec(),
            Interpolation::Linear if self.property == Property::Rotation => {
                unit(self.value(last)).slerp(unit(self.value(next)), s).to_array().to_vec()
            }
            Interpolation::Linear => {
                self.value(last).iter().zip(self.value(next)).map(|(a, b)| a + s * (b - a)).collect()
            }
            Interpolation::CubicSpline => self.hermite(last, s, span),
        }
    }

    /// `(2s^3 - 3s^2 + 1) v0 + d (s^3 - 2s^2 + s) b0 + (3s^2 - 2s^3) v1 + d (s^3 - s^2) a1`, d the span in seconds.
    fn hermite(&self, last: usize, s: f32, span: f32) -> Vec<f32> {
        let (s2, s3) = (s * s, s * s * s);
        let (v0, b0) = (self.value(last), self.key(last, 2));
        let (a1, v1) = (self.key(last + 1, 0), self.value(last + 1));
        let value: Vec<f32> = (0..self.width)
            .map(|i| {
                (2.0 * s3 - 3.0 * s2 + 1.0) * v0[i]
                    + span * (s3 - 2.0 * s2 + s) * b0[i]
                    + (3.0 * s2 - 2.0 * s3) * v1[i]
                    + span * (s3 - s2) * a1[i]
            })
            .collect();
        if self.property == Property::Rotation { unit(&value).to_array().to_vec() } else { value }
    }

    fn value(&self, key: usize) -> &[f32] {
        self.key(key, if self.interpolation == Interpolation::CubicSpline { 1 } else { 0 })
    }

    /// Part 0, 1, 2 of a spline key (in-tangent, value, out-tangent); part 0 of any other.
    fn key(&self, key: usize, part: usize) -> &[f32] {
        let parts = if self.interpolation == Interpolation::CubicSpline { 3 } else { 1 };
        let start = (key * parts + part) * self.width;
        &self.values[start..start + self.width]
    }
}

/// The rotation that four numbers mean; none where they are all but 0.
pub(crate) fn unit(xyzw: &[f32]) -> Quat {
    let v = Vec4::from_slice(xyzw);
    Quat::from_vec4(v.normalize_or(Vec4::W))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use std::f32::consts::FRAC_PI_2;

    fn track(property: Property, how: Interpolation, width: usize, values: &[f32]) -> Track {
        Track::new(0, property, how, vec![1.0, 3.0], width, values.to_vec()).unwrap()
    }

    #[test]
    fn step_holds_and_ends_hold() {
        let t = track(Property::Weights, Interpolation::Step, 1, &[5.0, 7.0]);
        for (time, value) in [(0.0, 5.0), (1.0, 5.0), (2.999, 5.0), (3.0, 7.0), (99.0, 7.0), (f32::NAN, 5.0)]
        {
            assert_eq!(t.sample(time), [value], "at {time} s");
        }
    }

    #[test]
    fn linear_is_a_line() {
        let t = track(Property::Translation, Interpolation::Linear, 3, &[0.0, 1.0, 2.0, 4.0, 1.0, -2.0]);
        assert_eq!(t.sample(1.5), [1.0, 1.0, 1.0]);
    }

    #[test]
    fn rotations_take_the_shorter_way_at_even_speed() {
        let quarter = Quat::from_rotation_y(FRAC_PI_2);
        // The far key is stored with the other sign: the same rotation, the long way round for a plain slerp.
        let values = [Quat::IDENTITY.to_array(), (-quarter).to_array()].concat();
        let t = track(Property::Rotation, Interpolation::Linear, 4, &values);
        let third = Quat::from_slice(&t.sample(1.0 + 2.0 / 3.0));
        // 1e-5: a few roundings of sin and acos in f32.
        assert!(third.angle_between(Quat::from_rotation_y(FRAC_PI_2 / 3.0)) < 1e-3, "{third}");
        assert!((third.length() - 1.0).abs() < 1e-5);
    }

    #[test]
    fn a_spline_through_a_cubic_is_that_cubic() {
        // x(t) = t^3 over 1..3 s, with its own derivatives as tangents: Hermite interpolation is exact.
        let (x, dx) = (|t: f32| t * t * t, |t: f32| 3.0 * t * t);
        let t = track(
            Property::Weights,
            Interpolation::CubicSpline,
            1,
            &[0.0, x(1.0), dx(1.0), dx(3.0), x(3.0), 0.0],
        );
        for time in [1.0, 1.25, 2.0, 2.9, 3.0] {
            // 1e-5 of the largest value: f32 rounding of four terms.
            assert!((t.sample(time)[0] - x(time)).abs() < 27.0 * 1e-5, "at {time} s: {}", t.sample(time)[0]);
        }
    }

    #[test]
    fn lists_that_do_not_fit_are_refused() {
        let new = |times: &[f32], values: &[f32]| {
            Track::new(0, Property::Scale, Interpolation::Linear, times.to_vec(), 3, values.to_vec())
        };
        assert!(new(&[], &[]).is_err());
        assert!(new(&[0.0], &[1.0, 1.0]).is_err());
        assert!(new(&[1.0, 0.0], &[1.0; 6]).is_err());
        assert!(new(&[f32::NAN], &[1.0; 3]).is_err());
        assert!(new(&[0.0], &[1.0, f32::INFINITY, 1.0]).is_err());
        assert!(!new(&[0.0, 1.0], &[1.0; 6]).unwrap().varies());
    }
}
