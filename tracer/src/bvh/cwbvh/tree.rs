//! The tree on the CPU: corners in, nodes and an order of the triangles out.
//!
//! The crate `obvhs` builds it from boxes. They are grown by [`margin`] on every side, m = 2^-20 of the largest coordinate L,
//! of which is used up (in units of 2^-23 L, so that m is 8 of them): 1/2 by the sum of a corner and m, 1 by the difference
//! of two box ends before they are counted in steps, 1/2 by the sum that a shader decodes an end with. The 6 that are left
//! are a hit's own: its distance is rounded otherwise than where its box is entered.

use super::{CwbvhError, Quality, STACK};
use crate::bvh::margin;
use frame::surface;
use glam::{IVec3, Vec3};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::bvh2_to_cwbvh::bvh2_to_cwbvh;
use obvhs::cwbvh::node::CwBvhNode;
use obvhs::ploc::PlocBuilder;
use std::collections::HashMap;

/// Elements of 16 bytes per node.
pub(super) const NODE_ELEMENTS: u32 = (size_of::<CwBvhNode>() / 16) as u32;

/// Steps between the ends of a node's box.
const STEPS: f64 = 255.0;

/// Triangles in a leaf: as many as a node has bits for.
const LEAF_TRIANGLES: u32 = 3;

/// A scene is taken for at least so large, m, so that there is a margin even where all corners are at the origin.
const LEAST_M: f32 = 1e-6;

/// So many boxes may be the same: chains of them add few levels, and the two triangles of a rectangle are left as they are.
const COPIES: u32 = 8;

/// Nodes, the root first, children after their parents.
pub(super) struct Tree {
    pub(super) nodes: Vec<CwBvhNode>,
    /// Which triangle is where, each once.
    pub(super) order: Vec<u32>,
    /// Levels below the root.
    pub(super) depth: u32,
}

impl Tree {
    /// Builds from the corners of triangles, m.
    pub(super) fn new(corners: &[[Vec3; 3]], quality: Quality) -> Result<Self, CwbvhError> {
        Self::of(cwbvh(&boxes(corners), quality))
    }

    /// Refuses what is too deep.
    pub(super) fn of(CwBvh { nodes, primitive_indices: order, .. }: CwBvh) -> Result<Self, CwbvhError> {
        let depth = depth(&nodes);
        if depth > STACK {
            return Err(CwbvhError::TooDeep { triangles: order.len(), depth, allowed: STACK });
        }
        Ok(Self { nodes, order, depth })
    }
}

/// Around each triangle, grown by the margin. Where many are the same, the builder would pair them one by one into a chain;
/// so from [`COPIES`] on each is grown on one side or the other by up to as much again, at random, and there is a nearest
/// to each.
pub(super) fn boxes(corners: &[[Vec3; 3]]) -> Vec<Aabb> {
    let largest = corners.as_flattened().iter().map(|c| c.abs().max_element()).fold(LEAST_M, f32::max);
    let margin = margin(largest);
    let mut seen: HashMap<[IVec3; 2], u32> = HashMap::new();
    let grown = corners.iter().map(|[a, b, c]| {
        let ends = [a.min(*b).min(*c), a.max(*b).max(*c)];
        // The same to within the margin, which is 2^-20 of the largest.
        let copy = seen.entry(ends.map(|end| (end / margin).as_ivec3())).or_default();
        *copy += 1;
        let [low, high] = ends;
        if *copy <= COPIES {
            return [low - margin, high + margin];
        }
        let random = |axis| (surface::hash(3 * *copy + axis) >> 8) as f32 / 16_777_216.0;
        let shift = margin * Vec3::new(random(0), random(1), random(2));
        [low - (margin + shift), high + (2.0 * margin - shift)]
    });
    grown.map(|[low, high]| Aabb::new(low.to_array().into(), high.to_array().into())).collect()
}

/// The steps of `obvhs::cwbvh::builder::build_cwbvh`, but for its checks in debug builds, which allow 10^-5 m at any size
/// of a scene.
pub(super) fn cwbvh(boxes: &[Aabb], quality: Quality) -> CwBvh {
    let params = match quality {
        Quality::Fast => BvhBuildParams::fast_build(),
        Quality::Medium => BvhBuildParams::medium_build(),
        Quality::Slow => BvhBuildParams::slow_build(),
    };
    let mut binary = PlocBuilder::with_capacity(boxes.len()).build(
        params.ploc_search_distance,
        boxes,
        (0..boxes.len() as u32).collect(),
        params.sort_precision,
        params.search_depth_threshold,
    );
    ReinsertionOptimizer::default().run(&mut binary, params.reinsertion_batch_ratio, None);
    let mut cwbvh = bvh2_to_cwbvh(&binary, LEAF_TRIANGLES, true, true);
    let exact = cwbvh.exact_node_aabbs.take().unwrap_or_default();
    for (node, bounds) in cwbvh.nodes.iter_mut().zip(&exact) {
        lengthen_steps(node, bounds);
    }
    cwbvh
}

/// `obvhs` finds the length of a step, a power of two, from a rounded logarithm: where a box is a hair longer than 255
/// steps, it may lose up to 2^-21 of its length at the end. Such steps are doubled.
fn lengthen_steps(node: &mut CwBvhNode, bounds: &Aabb) {
    let steps: [f32; 3] = node.compute_extent().into();
    let (low, high): ([f32; 3], [f32; 3]) = (bounds.min.into(), bounds.max.into());
    let ends = [
        (&mut node.child_min_x, &mut node.child_max_x),
        (&mut node.child_min_y, &mut node.child_max_y),
        (&mut node.child_min_z, &mut node.child_max_z),
    ];
    for (axis, (lows, highs)) in ends.into_iter().enumerate() {
        if f64::from(high[axis]) - f64::from(low[axis]) > STEPS * f64::from(steps[axis]) {
            node.e[axis] += 1;
            *lows = lows.map(|q| q / 2);
            *highs = highs.map(|q| q.div_ceil(2));
        }
    }
}

/// Levels below the root.
fn depth(nodes: &[CwBvhNode]) -> u32 {
    let mut depths = vec![0; nodes.len()];
    for (i, node) in nodes.iter().enumerate() {
        let first = node.child_base_idx as usize;
        let below = depths[i] + 1;
        depths[first..first + node.imask.count_ones() as usize].fill(below);
    }
    depths.into_iter().max().unwrap_or(0)
}
