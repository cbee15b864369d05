//! The tree of nodes and where each is at a moment.

use super::track::{Property, Track, unit};
use glam::{Affine3A, Mat4, Quat, Vec3};

/// A node's own transform, parent from node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Local {
    /// As the file's `matrix`.
    Matrix(Affine3A),
    /// Scale first, then rotation, then translation.
    Parts {
        /// Metres.
        translation: Vec3,
        /// Unit.
        rotation: Quat,
        /// Factors; negative ones mirror.
        scale: Vec3,
    },
}

impl Local {
    /// Parent from node.
    pub(crate) fn matrix(&self) -> Affine3A {
        match *self {
            Self::Matrix(m) => m,
            Self::Parts { translation, rotation, scale } => {
                Affine3A::from_scale_rotation_translation(scale, rotation, translation)
            }
        }
    }

    /// Sets one property; a matrix is taken apart first.
    fn drive(&mut self, property: Property, value: &[f32]) {
        if let Self::Matrix(m) = *self {
            let (scale, rotation, translation) = Mat4::from(m).to_scale_rotation_translation();
            *self = Self::Parts { translation, rotation, scale };
        }
        if let Self::Parts { translation, rotation, scale } = self {
            match property {
                Property::Translation => *translation = Vec3::from_slice(value),
                Property::Rotation => *rotation = unit(value),
                Property::Scale => *scale = Vec3::from_slice(value),
                Property::Weights => {}
            }
        }
    }
}

/// One node.
#[derive(Clone, Debug)]
pub(crate) struct Node {
    /// Index of the parent, lower than this node's own.
    pub parent: Option<usize>,
    /// Where the file puts it.
    pub local: Local,
    /// Weights of the morph targets of its mesh.
    pub weights: Vec<f32>,
}

/// All nodes, parents first, and what drives them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Rig {
    /// Parents before children.
    pub nodes: Vec<Node>,
    /// At most one per node and property.
    pub tracks: Vec<Track>,
    /// The point of the file's world that is the origin here, m.
    pub origin: Vec3,
}

/// Where everything is at one moment.
pub(crate) struct Moment {
    /// World from node.
    pub world: Vec<Affine3A>,
    /// Morph weights per node.
    pub weights: Vec<Vec<f32>>,
}

impl Rig {
    /// Evaluates all tracks and walks the tree once.
    pub(crate) fn moment(&self, time: f32) -> Moment {
        let mut locals: Vec<Local> = self.nodes.iter().map(|n| n.local).collect();
        let mut weights: Vec<Vec<f32>> = self.nodes.iter().map(|n| n.weights.clone()).collect();
        for track in &self.tracks {
            let value = track.sample(time);
            match track.property {
                Property::Weights => weights[track.node] = value,
                property => locals[track.node].drive(property, &value),
            }
        }
        let mut world: Vec<Affine3A> = Vec::with_capacity(self.nodes.len());
        for (node, local) in self.nodes.iter().zip(&locals) {
            let local = local.matrix();
            world.push(match node.parent {
                Some(parent) => world[parent] * local,
                None => Affine3A::from_translation(-self.origin) * local,
            });
        }
        Moment { world, weights }
    }

    /// Per node: whether its place in the world changes.
    pub(crate) fn moving_nodes(&self) -> Vec<bool> {
        let mut moving = vec![false; self.nodes.len()];
        for track in self.tracks.iter().filter(|t| t.property != Property::Weights && t.varies()) {
            moving[track.node] = true;
        }
        for (i, node) in self.nodes.iter().enumerate() {
            moving[i] |= node.parent.is_some_and(|parent| moving[parent]);
        }
        moving
    }

    /// Per node: whether its morph weights change.
    pub(crate) fn morphing_nodes(&self) -> Vec<bool> {
        let mut morphing = vec![false; self.nodes.len()];
        for track in self.tracks.iter().filter(|t| t.property == Property::Weights && t.varies()) {
            morphing[track.node] = true;
        }
        morphing
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::super::track::Interpolation;
    use super::*;

    #[test]
    fn a_child_follows_its_parent_and_only_it_counts_as_moving() {
        let at = |parent, x| Node {
            parent,
            local: Local::Matrix(Affine3A::from_translation(Vec3::new(x, 0.0, 0.0))),
            weights: Vec::new(),
        };
        let lift = Track::new(
            0,
            Property::Translation,
            Interpolation::Linear,
            vec![0.0, 2.0],
            3,
            vec![1.0, 0.0, 0.0, 1.0, 4.0, 0.0],
        )
        .unwrap();
        let rig = Rig {
            nodes: vec![at(None, 1.0), at(Some(0), 2.0), at(None, 7.0)],
            tracks: vec![lift],
            ..Rig::default()
        };
        assert_eq!(rig.moving_nodes(), [true, true, false]);
        let moment = rig.moment(1.0);
        assert_eq!(moment.world[1].transform_point3(Vec3::ZERO), Vec3::new(3.0, 2.0, 0.0));
        assert_eq!(moment.world[2].transform_point3(Vec3::ZERO), Vec3::new(7.0, 0.0, 0.0));
    }
}
