//! Animation channels as tracks of the rig.
//!
//! All animations play together. Where several drive the same property of a node, the first in the file counts and
//! the others are left out with a warning.

use super::accessors::Accessors;
use super::nodes::Tree;
use super::{Document, Fault, item, valid};
use crate::motion::{Interpolation, Property, Track};
use gltf::json::accessor::Type;
use gltf::json::animation;
use std::collections::HashSet;

/// All tracks that can be seen: at most one per node and property.
pub(super) fn read(document: &mut Document, tree: &Tree) -> Result<Vec<Track>, Fault> {
    let root = &document.root;
    let accessors = document.accessors();
    let (mut tracks, mut warnings) = (Vec::new(), Vec::new());
    let mut taken = HashSet::new();
    for (a, animation) in root.animations.iter().enumerate() {
        let mut doubled = 0;
        for (c, channel) in animation.channels.iter().enumerate() {
            let place = format!("animations[{a}].channels[{c}]");
            let sampler = item(&animation.samplers, channel.sampler, "samplers", &place)?;
            item(&root.nodes, channel.target.node, "nodes", &place)?;
            let property = match valid(&channel.target.path, &format!("{place}.target.path"))? {
                animation::Property::Translation => Property::Translation,
                animation::Property::Rotation => Property::Rotation,
                animation::Property::Scale => Property::Scale,
                animation::Property::MorphTargetWeights => Property::Weights,
            };
            // A node in a loop is in no tree and cannot be seen.
            let Some(slot) = tree.slot[channel.target.node.value()] else { continue };
            if !taken.insert((slot, property)) {
                doubled += 1;
                continue;
            }
            tracks.push(track(accessors, sampler, slot, property, &place)?);
        }
        if doubled > 0 {
            let name = animation.name.as_deref().unwrap_or("");
            warnings.push(format!(
                "animations[{a}] \"{name}\": {doubled} channels left out, an earlier one drives the same"
            ));
        }
    }
    document.warnings.extend(warnings);
    Ok(tracks)
}

fn track(
    accessors: Accessors,
    sampler: &animation::Sampler,
    slot: usize,
    property: Property,
    place: &str,
) -> Result<Track, Fault> {
    let interpolation = match valid(&sampler.interpolation, &format!("{place}: its sampler's interpolation"))?
    {
        animation::Interpolation::Step => Interpolation::Step,
        animation::Interpolation::Linear => Interpolation::Linear,
        animation::Interpolation::CubicSpline => Interpolation::CubicSpline,
    };
    let times = accessors.floats::<1>(sampler.input, Type::Scalar, place)?.into_flattened();
    let kind = match property {
        Property::Translation | Property::Scale => Type::Vec3,
        Property::Rotation => Type::Vec4,
        Property::Weights => Type::Scalar,
    };
    let values = accessors.flat_floats(sampler.output, kind, place)?;
    let width = match property {
        Property::Weights => {
            let per_key = if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
            (values.len() / (times.len() * per_key).max(1)).max(1)
        }
        _ => kind.multiplicity(),
    };
    Track::new(slot, property, interpolation, times, width, values)
        .map_err(|fault| format!("{place}: {fault}"))
}
