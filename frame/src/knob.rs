//! One list of settings per stage: it serves `--set`, the viewer's sliders, the report and the benches.

use std::fmt;

/// Where a setting's value lives.
pub enum KnobValue<'a> {
    /// A real number within `min..=max`.
    Float {
        /// The setting itself.
        value: &'a mut f32,
        /// Least allowed.
        min: f32,
        /// Most allowed.
        max: f32,
    },
    /// A whole number within `min..=max`.
    Int {
        /// The setting itself.
        value: &'a mut u32,
        /// Least allowed.
        min: u32,
        /// Most allowed.
        max: u32,
    },
    /// On or off.
    Bool(&'a mut bool),
    /// One of a list, by index.
    Choice {
        /// The setting itself.
        value: &'a mut u32,
        /// The names, in order.
        names: &'static [&'static str],
    },
}

/// A named setting of a stage.
pub struct Knob<'a> {
    /// Within its stage: `k0`, `radial_cutoff`.
    pub name: &'static str,
    /// Unit, or empty for a plain number: `px`, `m`, `rad`.
    pub unit: &'static str,
    /// What it does, what higher and lower cost, how the default was chosen.
    pub doc: &'static str,
    /// Lent out for reading or writing.
    pub value: KnobValue<'a>,
}

/// A setting that was refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum KnobError {
    /// The stage has no such knob.
    #[error("no knob \"{name}\"; there are: {known}")]
    Unknown {
        /// As given.
        name: String,
        /// Those there are.
        known: String,
    },
    /// Not a number, not in the list, or outside the range.
    #[error("knob {name} = \"{text}\": allowed is {allowed}")]
    Value {
        /// The knob.
        name: String,
        /// As given.
        text: String,
        /// The range or the list.
        allowed: String,
    },
}

impl<'a> Knob<'a> {
    /// A real number.
    pub fn float(
        name: &'static str,
        value: &'a mut f32,
        range: std::ops::RangeInclusive<f32>,
        unit: &'static str,
        doc: &'static str,
    ) -> Self {
        Self { name, unit, doc, value: KnobValue::Float { value, min: *range.start(), max: *range.end() } }
    }

    /// A whole number.
    pub fn int(
        name: &'static str,
        value: &'a mut u32,
        range: std::ops::RangeInclusive<u32>,
        unit: &'static str,
        doc: &'static str,
    ) -> Self {
        Self { name, unit, doc, value: KnobValue::Int { value, min: *range.start(), max: *range.end() } }
    }

    /// On or off.
    pub fn bool(name: &'static str, value: &'a mut bool, doc: &'static str) -> Self {
        Self { name, unit: "", doc, value: KnobValue::Bool(value) }
    }

    /// One of a list.
    pub fn choice(
        name: &'static str,
        value: &'a mut u32,
        names: &'static [&'static str],
        doc: &'static str,
    ) -> Self {
        Self { name, unit: "", doc, value: KnobValue::Choice { value, names } }
    }

    /// What a value may be: `1..=6`, `on, off`, or the list.
    pub fn allowed(&self) -> String {
        match &self.value {
            KnobValue::Float { min, max, .. } => format!("{min}..={max}"),
            KnobValue::Int { min, max, .. } => format!("{min}..={max}"),
            KnobValue::Bool(_) => "on, off".into(),
            KnobValue::Choice { names, .. } => names.join(", "),
        }
    }

    /// Reads a value from text.
    ///
    /// # Errors
    /// Not one of what [`Knob::allowed`] says.
    pub fn set(&mut self, text: &str) -> Result<(), KnobError> {
        let fits = match &mut self.value {
            KnobValue::Float { value, min, max } => {
                text.parse().ok().filter(|v: &f32| (*min..=*max).contains(v)).map(|v| **value = v)
            }
            KnobValue::Int { value, min, max } => {
                text.parse().ok().filter(|v: &u32| (*min..=*max).contains(v)).map(|v| **value = v)
            }
            KnobValue::Bool(value) => match text {
                "on" | "true" | "1" => Some(true),
                "off" | "false" | "0" => Some(false),
                _ => None,
            }
            .map(|v| **value = v),
            KnobValue::Choice { value, names } => {
                names.iter().position(|n| *n == text).map(|index| **value = index as u32)
            }
        };
        fits.ok_or_else(|| KnobError::Value {
            name: self.name.into(),
            text: text.into(),
            allowed: self.allowed(),
        })
    }
}

impl fmt::Display for Knob<'_> {
    /// The value alone.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.value {
            KnobValue::Float { value, .. } => write!(f, "{value}"),
            KnobValue::Int { value, .. } => write!(f, "{value}"),
            KnobValue::Bool(value) => f.write_str(if **value { "on" } else { "off" }),
            KnobValue::Choice { value, names } => f.write_str(names.get(**value as usize).unwrap_or(&"?")),
        }
    }
}

/// Sets the knob of this name in a stage's list.
///
/// # Errors
/// No such knob, or a value it does not take.
pub fn set_knob(knobs: &mut [Knob<'_>], name: &str, text: &str) -> Result<(), KnobError> {
    match knobs.iter().position(|k| k.name == name) {
        Some(index) => knobs[index].set(text),
        None => {
            let known = knobs.iter().map(|k| k.name).collect::<Vec<_>>().join(", ");
            Err(KnobError::Unknown { name: name.into(), known })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn knobs<'a>(radius: &'a mut u32, order: &'a mut u32) -> Vec<Knob<'a>> {
        vec![
            Knob::int("k0", radius, 0..=32, "px", "half width"),
            Knob::choice("order", order, &["ascending", "descending"], "of the phases"),
        ]
    }

    #[test]
    fn a_value_is_read_or_refused_with_what_is_allowed() {
        let (mut radius, mut order) = (2u32, 0u32);
        assert_eq!(set_knob(&mut knobs(&mut radius, &mut order), "k0", "5"), Ok(()));
        assert_eq!(set_knob(&mut knobs(&mut radius, &mut order), "order", "descending"), Ok(()));
        assert_eq!((radius, order), (5, 1));
        let too_much = set_knob(&mut knobs(&mut radius, &mut order), "k0", "33").map_err(|e| e.to_string());
        assert_eq!(too_much, Err("knob k0 = \"33\": allowed is 0..=32".into()));
        let unknown = set_knob(&mut knobs(&mut radius, &mut order), "k9", "1").map_err(|e| e.to_string());
        assert_eq!(unknown, Err("no knob \"k9\"; there are: k0, order".into()));
        assert_eq!(radius, 5, "a refused value changes nothing");
    }
}
