//! What joins triangles, found once per mesh: corners that lie at one place, edges and their sides.
//!
//! In: a mesh as a GPU holds it, read back, and which of its triangles a tessellator shapes. Out: [`Topology`], words for
//! shaders:
//!
//! | words | content |
//! | --- | --- |
//! | 8 per triangle | edges of its three sides, classes of its three corners, kind 3 and "keeps its frame" 1, 0 |
//! | 4 per edge | two sides (triangle * 4 + the corner it starts at), factor, 1 if a side is shaped |
//! | 2 per class | first word of its list of corners, how many |
//! | 1 per corner | triangle * 4 + corner |
//!
//! Two corners are of one class where their positions have equal bits and neither moves, or both belong to the same moving
//! object: vertices that were split for texture coordinates or hard edges meet again, and what merely touches while moving
//! does not. Classes and edges are numbered in the order of triangles, so that those of static ones come first.
//!
//! A triangle of which two corners fall together is dropped if any of its neighbours is shaped; those are neighbours then.

use frame::scene_gpu::VertexLayout;
use glam::{Vec2, Vec3};
use std::collections::HashMap;
use std::collections::hash_map::Entry;

/// None.
const NONE: u32 = u32::MAX;

/// What a tessellator does with a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Nothing; it may have to follow the edges of others.
    Flat = 1,
    /// It follows its corners, having nothing to say about them.
    Neutral = 2,
    /// It is cut and shaped.
    Shaped = 3,
}

/// A mesh, read back.
pub(crate) struct Source<'a> {
    pub(crate) vertices: &'a [u32],
    pub(crate) triangles: &'a [[u32; 4]],
    pub(crate) layout: VertexLayout,
    /// Leading triangles that never move.
    pub(crate) static_triangle_count: usize,
}

impl Source<'_> {
    fn words<const N: usize>(&self, vertex: u32, offset: u32) -> [u32; N] {
        let at = vertex as usize * self.layout.stride as usize + offset as usize;
        std::array::from_fn(|i| self.vertices.get(at + i).copied().unwrap_or(0))
    }

    /// Metres.
    pub(crate) fn position(&self, vertex: u32) -> Vec3 {
        Vec3::from(self.words::<3>(vertex, 0).map(f32::from_bits))
    }

    /// Unit length.
    pub(crate) fn normal(&self, vertex: u32) -> Vec3 {
        let [code] = self.words::<1>(vertex, 3);
        frame::surface::face_normal_unpack(code)
    }

    /// Both sets of texture coordinates.
    pub(crate) fn uv(&self, vertex: u32) -> [Vec2; 2] {
        let uv = |offset| Vec2::from(self.words::<2>(vertex, offset).map(f32::from_bits));
        [uv(5), if self.layout.uv1_offset == 0 { Vec2::ZERO } else { uv(self.layout.uv1_offset) }]
    }
}

/// The words, and how many of what they are about.
pub(crate) struct Topology {
    pub(crate) words: Vec<u32>,
    pub(crate) edge_count: u32,
    pub(crate) class_count: u32,
    /// Leading ones of static triangles.
    pub(crate) static_class_count: u32,
    /// Triangles that are cut or follow others.
    pub(crate) touched: bool,
}

struct Edge {
    sides: [u32; 2],
    shaped: bool,
}

impl Topology {
    /// `kind` and "keeps its frame" by triangle.
    pub(crate) fn new(source: &Source<'_>, kind: impl Fn(usize) -> (Kind, bool)) -> Self {
        let count = source.triangles.len();
        let mut records = vec![[NONE, NONE, NONE, NONE, NONE, NONE, 0, 0]; count];
        let mut welded = Welded::default();
        let mut edges = Edges::default();
        let mut static_class_count = 0;
        let kinds: Vec<_> = (0..count).map(kind).collect();
        // Those that shape come first: others only follow what these make.
        for t in 0..count {
            if t == source.static_triangle_count {
                static_class_count = welded.corners.len();
            }
            let (kind, keeps_frame) = kinds[t];
            if kind == Kind::Flat {
                continue;
            }
            let classes = corners(source, t).map(|corner| welded.class(source, t, corner));
            let [a, b, c] = classes;
            if a == b || b == c || c == a {
                records[t][6] = DROPPED;
                continue;
            }
            for k in 0..3 {
                records[t][k] = edges.add(t, k, [classes[k], classes[(k + 1) % 3]], kind == Kind::Shaped);
                records[t][3 + k] = classes[k];
                welded.corners[classes[k] as usize].push(side(t, k));
            }
            records[t][6] = kind as u32 | (u32::from(keeps_frame) << 3);
        }
        if count == source.static_triangle_count {
            static_class_count = welded.corners.len();
        }
        for t in (0..count).filter(|&t| kinds[t].0 == Kind::Flat) {
            let classes = corners(source, t).map(|corner| welded.find(source, t, corner));
            if (0..3).any(|k| classes[k].is_some() && classes[k] == classes[(k + 1) % 3]) {
                records[t][6] = DROPPED;
                continue;
            }
            for k in 0..3 {
                if let Some(class) = classes[k] {
                    records[t][3 + k] = class;
                    welded.corners[class as usize].push(side(t, k));
                }
                if let (Some(a), Some(b)) = (classes[k], classes[(k + 1) % 3])
                    && let Some(edge) = edges.join(t, k, [a, b])
                {
                    records[t][k] = edge;
                    records[t][6] = Kind::Flat as u32;
                }
            }
        }
        let touched = !welded.corners.is_empty();
        let mut words = records.into_flattened();
        for edge in &edges.list {
            words.extend([edge.sides[0], edge.sides[1], 1, u32::from(edge.shaped)]);
        }
        let mut first = (words.len() + 2 * welded.corners.len()) as u32;
        for list in &welded.corners {
            words.extend([first, list.len() as u32]);
            first += list.len() as u32;
        }
        words.extend(welded.corners.iter().flatten());
        Self {
            words,
            edge_count: edges.list.len() as u32,
            class_count: welded.corners.len() as u32,
            static_class_count: static_class_count as u32,
            touched,
        }
    }
}

/// Kind of a triangle that is left out.
const DROPPED: u32 = 4;

fn side(triangle: usize, corner: usize) -> u32 {
    (triangle << 2 | corner) as u32
}

fn corners(source: &Source<'_>, triangle: usize) -> [u32; 3] {
    let [a, b, c, _] = source.triangles[triangle];
    [a, b, c]
}

/// Classes by place.
#[derive(Default)]
struct Welded {
    places: HashMap<([u32; 3], u32), u32>,
    corners: Vec<Vec<u32>>,
}

impl Welded {
    /// Bits of the position, 0 and -0 alike, and who may be joined: 0 what stands still, else one moving object.
    fn key(source: &Source<'_>, triangle: usize, vertex: u32) -> ([u32; 3], u32) {
        let place = (source.position(vertex) + 0.0).to_array().map(f32::to_bits);
        let group = match triangle < source.static_triangle_count {
            true => 0,
            false => 1 + (source.triangles[triangle][3] >> 16),
        };
        (place, group)
    }

    fn class(&mut self, source: &Source<'_>, triangle: usize, vertex: u32) -> u32 {
        match self.places.entry(Self::key(source, triangle, vertex)) {
            Entry::Occupied(known) => *known.get(),
            Entry::Vacant(new) => {
                self.corners.push(Vec::new());
                *new.insert(self.corners.len() as u32 - 1)
            }
        }
    }

    fn find(&self, source: &Source<'_>, triangle: usize, vertex: u32) -> Option<u32> {
        self.places.get(&Self::key(source, triangle, vertex)).copied()
    }
}

/// Edges by their two classes.
#[derive(Default)]
struct Edges {
    ends: HashMap<[u32; 2], u32>,
    list: Vec<Edge>,
}

impl Edges {
    fn add(&mut self, triangle: usize, corner: usize, [a, b]: [u32; 2], shaped: bool) -> u32 {
        let index = *self.ends.entry([a.min(b), a.max(b)]).or_insert_with(|| {
            self.list.push(Edge { sides: [NONE; 2], shaped: false });
            self.list.len() as u32 - 1
        });
        let edge = &mut self.list[index as usize];
        edge.shaped |= shaped;
        // Of more than two sides the first two speak for all.
        if let Some(free) = edge.sides.iter_mut().find(|side| **side == NONE) {
            *free = side(triangle, corner);
        }
        index
    }

    /// The same for an edge that must be there already.
    fn join(&mut self, triangle: usize, corner: usize, [a, b]: [u32; 2]) -> Option<u32> {
        let known = self.ends.contains_key(&[a.min(b), a.max(b)]);
        (a != b && known).then(|| self.add(triangle, corner, [a, b], false))
    }
}

#[cfg(test)]
mod tests;
