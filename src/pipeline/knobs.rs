//! Knobs of all stages by the ids that `--set` takes: as they came, then as the preset, then as the settings say.

use super::Pipeline;
use crate::Error;
use crate::settings::KnobSetting;
use frame::Knob;

/// Stage, name, value.
pub(super) type KnobValues = Vec<((&'static str, &'static str), String)>;

impl Pipeline {
    /// Every knob of the chosen stages, by the id that `--set` takes.
    pub fn with_knobs<R>(&mut self, visit: impl FnOnce(Vec<(&'static str, Vec<Knob<'_>>)>) -> R) -> R {
        let mut choices = self.street.paths.choices();
        let of_tracer = self.street.paths.knobs(&mut choices);
        let (tessellator, tracer) = (self.tessellator.name(), self.street.tracer.name());
        let (denoiser, upsampler) = (self.street.denoiser.name(), self.street.upsampler.name());
        let mut all = vec![
            ("voxel", self.searches.knobs()),
            ("gather", self.gather.knobs()),
            ("tracer", of_tracer),
            (tessellator, self.tessellator.knobs()),
            (tracer, self.street.tracer.knobs()),
            (denoiser, self.street.denoiser.knobs()),
            (upsampler, self.street.upsampler.knobs()),
        ];
        // The tracer `voxel` and the stage `voxel` share an id: one list.
        let mut merged: Vec<(&'static str, Vec<Knob<'_>>)> = Vec::new();
        for (id, knobs) in all.drain(..) {
            match merged.iter_mut().find(|(known, _)| *known == id) {
                Some((_, list)) => list.extend(knobs),
                None => merged.push((id, knobs)),
            }
        }
        let result = visit(merged);
        self.street.paths.choose(choices);
        result
    }

    /// Notes the values of stages that were just made.
    pub(super) fn note_defaults(&mut self) {
        for (knob, value) in self.knob_values() {
            self.knob_defaults.entry(knob).or_insert(value);
        }
    }

    pub(super) fn knob_values(&mut self) -> KnobValues {
        let of = |(id, knobs): &(&'static str, Vec<Knob<'_>>)| {
            knobs.iter().map(|knob| ((*id, knob.name), knob.to_string())).collect::<Vec<_>>()
        };
        self.with_knobs(|stages| stages.iter().flat_map(of).collect())
    }

    /// Every knob as it came, then as the preset, then as the settings say.
    pub(super) fn apply_knobs(&mut self) -> Result<(), Error> {
        let settings = self.street.settings.clone();
        let defaults = std::mem::take(&mut self.knob_defaults);
        let reset: Result<(), Error> = self.with_knobs(|mut stages| {
            for (id, knobs) in &mut stages {
                for knob in knobs.iter_mut() {
                    if let Some(value) = defaults.get(&(*id, knob.name)) {
                        knob.set(value).map_err(|source| Error::Knob { id: (*id).into(), source })?;
                    }
                }
            }
            Ok(())
        });
        self.knob_defaults = defaults;
        reset?;
        let preset = settings.preset.knobs();
        self.with_knobs(|stages| {
            let known = stages.iter().map(|(id, _)| *id).collect::<Vec<_>>().join(", ");
            let mut stages: Vec<_> = stages;
            for (id, name, value) in preset {
                // A preset speaks of every stage; those not chosen have nothing to set.
                if let Some((_, knobs)) = stages.iter_mut().find(|(known, _)| known == id) {
                    set(id, knobs, name, value)?;
                }
            }
            for wanted in &settings.sets {
                let Some((_, knobs)) = stages.iter_mut().find(|(id, _)| *id == wanted.id) else {
                    return Err(Error::NoSuchStage {
                        id: wanted.id.clone(),
                        knob: wanted.knob.clone(),
                        known,
                    });
                };
                set(&wanted.id, knobs, &wanted.knob, &wanted.value)?;
            }
            Ok(())
        })?;
        // What paths are traced through is no knob of theirs.
        self.street.paths.build.levels = self.searches.has_levels();
        Ok(())
    }
}

/// Sets knobs of one stage, the only one that `wanted` may name.
///
/// # Errors
/// Another stage is named, or a knob refuses its value.
pub fn set_knobs(id: &str, knobs: &mut [Knob<'_>], wanted: &[KnobSetting]) -> Result<(), Error> {
    wanted.iter().try_for_each(|wanted| match wanted.id == id {
        true => set(id, knobs, &wanted.knob, &wanted.value),
        false => {
            Err(Error::NoSuchStage { id: wanted.id.clone(), knob: wanted.knob.clone(), known: id.into() })
        }
    })
}

fn set(id: &str, knobs: &mut [Knob<'_>], name: &str, value: &str) -> Result<(), Error> {
    frame::set_knob(knobs, name, value).map_err(|source| Error::Knob { id: id.into(), source })
}
