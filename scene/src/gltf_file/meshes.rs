//! Primitives: attributes, indices, and what the file leaves out (normals, tangents).
//!
//! Points and lines are left out. Missing normals mean flat shading: vertices are no longer shared. Triangles with a
//! corner that is not finite are left out and counted.

use super::accessors::Accessors;
use super::{Document, Fault, item, tangents, valid};
use crate::Material;
use crate::motion::{Influences, Shape, Target, face_normal, perpendicular};
use glam::{Vec2, Vec3, Vec4};
use gltf::json::accessor::{Accessor, Type};
use gltf::json::mesh::{Mode, Primitive as FilePrimitive, Semantic};
use gltf::json::validation::Checked;
use gltf::json::{Index, mesh};
use std::sync::Arc;

/// A primitive ready to be placed.
pub(super) struct Primitive {
    /// What motion needs of it.
    pub shape: Arc<Shape>,
    /// Empty where the file has none; the same for the other two.
    pub uv0: Vec<Vec2>,
    pub uv1: Vec<Vec2>,
    /// Linear RGBA.
    pub colors: Vec<Vec4>,
    /// Indices into the lists above.
    pub triangles: Vec<[u32; 3]>,
    /// Index into the file's materials, or one past the last for the default one.
    pub material: usize,
    /// Joints that its vertices name, one more than the highest.
    pub joint_count: usize,
}

/// What reading meshes found out beside the meshes.
#[derive(Default)]
pub(super) struct Skipped {
    /// Triangles with a corner that is not finite.
    pub not_finite: usize,
    /// Primitives of points or lines.
    pub no_triangles: usize,
    /// Primitives without positions.
    pub no_positions: usize,
}

/// All drawable primitives of a mesh, each with its number in the file.
pub(super) fn read(
    document: &Document,
    index: Index<mesh::Mesh>,
    materials: &[Material],
    skipped: &mut Skipped,
    asker: &str,
) -> Result<Vec<(usize, Primitive)>, Fault> {
    let mesh = item(&document.root.meshes, index, "meshes", asker)?;
    let accessors = document.accessors();
    let mut primitives = Vec::with_capacity(mesh.primitives.len());
    for (p, primitive) in mesh.primitives.iter().enumerate() {
        let place = format!("meshes[{}].primitives[{p}]", index.value());
        let reader = Reader { accessors, file: primitive, place };
        if let Some(primitive) = reader.read(materials, skipped)? {
            primitives.push((p, primitive));
        }
    }
    Ok(primitives)
}

/// Vertices while they are still being completed; every list has one element per vertex or none.
#[derive(Default)]
struct Vertices {
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    tangents: Vec<Vec4>,
    uv0: Vec<Vec2>,
    uv1: Vec<Vec2>,
    colors: Vec<Vec4>,
    targets: Vec<Target>,
    influences: Option<Influences>,
}

impl Vertices {
    /// The vertices named by `order`, which may name some twice.
    fn gather(&self, order: &[u32]) -> Self {
        fn pick<T: Copy>(from: &[T], order: &[u32]) -> Vec<T> {
            if from.is_empty() { Vec::new() } else { order.iter().map(|&v| from[v as usize]).collect() }
        }
        let targets = self.targets.iter().map(|t| Target {
            positions: pick(&t.positions, order),
            normals: pick(&t.normals, order),
            tangents: pick(&t.tangents, order),
        });
        let influences = self.influences.as_ref().map(|i| Influences {
            per_vertex: i.per_vertex,
            pairs: order
                .iter()
                .flat_map(|&v| i.pairs.iter().skip(v as usize * i.per_vertex).take(i.per_vertex))
                .copied()
                .collect(),
        });
        Self {
            positions: pick(&self.positions, order),
            normals: pick(&self.normals, order),
            tangents: pick(&self.tangents, order),
            uv0: pick(&self.uv0, order),
            uv1: pick(&self.uv1, order),
            colors: pick(&self.colors, order),
            targets: targets.collect(),
            influences,
        }
    }
}

struct Reader<'a> {
    accessors: Accessors<'a>,
    file: &'a FilePrimitive,
    place: String,
}

impl Reader<'_> {
    fn read(&self, materials: &[Material], skipped: &mut Skipped) -> Result<Option<Primitive>, Fault> {
        let mode = valid(&self.file.mode, &format!("{}.mode", self.place))?;
        if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
            skipped.no_triangles += 1;
            return Ok(None);
        }
        let Some(positions) = self.attribute(Semantic::Positions) else {
            skipped.no_positions += 1;
            return Ok(None);
        };
        let material = match self.file.material {
            Some(index) => {
                item(&self.accessors.root.materials, index, "materials", &self.place)?;
                index.value()
            }
            None => materials.len(),
        };
        let mut vertices = self.vertices(positions)?;
        let mut triangles = self.triangles(mode, vertices.positions.len())?;
        let all = triangles.len();
        triangles.retain(|t| t.iter().all(|&v| vertices.positions[v as usize].is_finite()));
        skipped.not_finite += all - triangles.len();
        for position in vertices.positions.iter_mut().filter(|p| !p.is_finite()) {
            *position = Vec3::ZERO;
        }

        let flat = vertices.normals.is_empty();
        if flat {
            vertices = vertices.gather(triangles.as_flattened());
            for (v, triangle) in triangles.iter_mut().enumerate() {
                *triangle = [0, 1, 2].map(|corner| 3 * v as u32 + corner);
            }
            let faces = vertices.positions.chunks_exact(3);
            vertices.normals = faces.flat_map(|p| [face_normal(p[0], p[1], p[2]); 3]).collect();
            vertices.tangents.clear();
        } else {
            repair_normals(&mut vertices.normals, &vertices.positions, &triangles);
        }
        let uv_set = materials.get(material).and_then(tangents::uv_set);
        if vertices.tangents.is_empty()
            && let Some(set) = uv_set
        {
            let uvs = if set == 0 { &vertices.uv0 } else { &vertices.uv1 };
            let split = tangents::generate(&vertices.positions, &vertices.normals, uvs, &triangles);
            vertices = vertices.gather(&split.order);
            vertices.tangents = split.tangents;
            triangles = split.triangles;
        } else if vertices.tangents.is_empty() {
            vertices.tangents = vec![Vec4::W; vertices.positions.len()];
        }
        for (tangent, normal) in vertices.tangents.iter_mut().zip(&vertices.normals) {
            *tangent = perpendicular(tangent.truncate(), tangent.w, *normal);
        }
        let Vertices { positions, normals, tangents, uv0, uv1, colors, targets, influences } = vertices;
        let joints = influences.iter().flat_map(|i| &i.pairs).map(|&(joint, _)| joint as usize + 1);
        let joint_count = joints.max().unwrap_or(0);
        let shape = Arc::new(Shape { positions, normals, tangents, flat, targets, influences });
        Ok(Some(Primitive { shape, uv0, uv1, colors, triangles, material, joint_count }))
    }

    fn attribute(&self, semantic: Semantic) -> Option<Index<Accessor>> {
        self.file.attributes.get(&Checked::Valid(semantic)).copied()
    }

    fn vertices(&self, positions: Index<Accessor>) -> Result<Vertices, Fault> {
        let at = |name: &str| format!("{}.{name}", self.place);
        let positions: Vec<Vec3> = self.vec3(positions, &at("POSITION"))?;
        let count = positions.len();
        let mut v = Vertices { positions, ..Vertices::default() };
        if let Some(index) = self.attribute(Semantic::Normals) {
            v.normals = self.counted(count, &at("NORMAL"), self.vec3(index, &at("NORMAL"))?)?;
        }
        if let Some(index) = self.attribute(Semantic::Tangents) {
            let tangents = self.accessors.floats::<4>(index, Type::Vec4, &at("TANGENT"))?;
            v.tangents =
                self.counted(count, &at("TANGENT"), tangents.into_iter().map(Vec4::from).collect())?;
        }
        for (set, uvs) in [(0, &mut v.uv0), (1, &mut v.uv1)] {
            if let Some(index) = self.attribute(Semantic::TexCoords(set)) {
                let place = at(&format!("TEXCOORD_{set}"));
                let found = self.accessors.floats::<2>(index, Type::Vec2, &place)?;
                let finite = |uv| Some(Vec2::from(uv)).filter(|uv| uv.is_finite()).unwrap_or(Vec2::ZERO);
                *uvs = self.counted(count, &place, found.into_iter().map(finite).collect())?;
            }
        }
        if let Some(index) = self.attribute(Semantic::Colors(0)) {
            v.colors = self.counted(count, &at("COLOR_0"), self.colors(index, &at("COLOR_0"))?)?;
        }
        for (t, target) in self.file.targets.iter().flatten().enumerate() {
            let read = |index: Option<Index<Accessor>>, name: &str| {
                let place = at(&format!("targets[{t}].{name}"));
                let Some(index) = index else { return Ok(Vec::new()) };
                let mut deltas = self.counted(count, &place, self.vec3(index, &place)?)?;
                deltas.iter_mut().filter(|d| !d.is_finite()).for_each(|d| *d = Vec3::ZERO);
                Ok::<_, Fault>(deltas)
            };
            v.targets.push(Target {
                positions: read(target.positions, "POSITION")?,
                normals: read(target.normals, "NORMAL")?,
                tangents: read(target.tangents, "TANGENT")?,
            });
        }
        v.influences = self.influences(count)?;
        Ok(v)
    }

    fn vec3(&self, index: Index<Accessor>, place: &str) -> Result<Vec<Vec3>, Fault> {
        Ok(self.accessors.floats::<3>(index, Type::Vec3, place)?.into_iter().map(Vec3::from).collect())
    }

    fn colors(&self, index: Index<Accessor>, place: &str) -> Result<Vec<Vec4>, Fault> {
        let rgba: Vec<Vec4> = match self.accessors.kind(index, place)? {
            Type::Vec3 => self.vec3(index, place)?.into_iter().map(|rgb| rgb.extend(1.0)).collect(),
            kind => self.accessors.floats::<4>(index, kind, place)?.into_iter().map(Vec4::from).collect(),
        };
        Ok(rgba
            .into_iter()
            .map(|c| if c.is_finite() { c.clamp(Vec4::ZERO, Vec4::ONE) } else { Vec4::ONE })
            .collect())
    }

    /// Joints and weights of all sets, four pairs a set, weights made to sum to 1.
    fn influences(&self, count: usize) -> Result<Option<Influences>, Fault> {
        let mut sets = Vec::new();
        while let Some(joints) = self.attribute(Semantic::Joints(sets.len() as u32)) {
            let set = sets.len() as u32;
            let (joints_at, weights_at) =
                (format!("{}.JOINTS_{set}", self.place), format!("{}.WEIGHTS_{set}", self.place));
            let weights =
                self.attribute(Semantic::Weights(set)).ok_or_else(|| format!("{weights_at} is missing"))?;
            let joints = self.accessors.integers::<4>(joints, Type::Vec4, &joints_at)?;
            let weights = self.accessors.floats::<4>(weights, Type::Vec4, &weights_at)?;
            sets.push((self.counted(count, &joints_at, joints)?, self.counted(count, &weights_at, weights)?));
        }
        if sets.is_empty() {
            return Ok(None);
        }
        let per_vertex = 4 * sets.len();
        let mut pairs = Vec::with_capacity(count * per_vertex);
        for v in 0..count {
            let first = pairs.len();
            for (joints, weights) in &sets {
                for (&joint, &weight) in joints[v].iter().zip(&weights[v]) {
                    let weight = if weight.is_finite() { weight.max(0.0) } else { 0.0 };
                    let joint = u16::try_from(joint)
                        .map_err(|_| format!("{}: joint {joint} of vertex {v}", self.place))?;
                    // Padding may name any joint.
                    pairs.push(if weight > 0.0 { (joint, weight) } else { (0, 0.0) });
                }
            }
            let sum: f32 = pairs[first..].iter().map(|&(_, weight)| weight).sum();
            if sum > 0.0 && sum.is_finite() {
                pairs[first..].iter_mut().for_each(|(_, weight)| *weight /= sum);
            } else {
                pairs[first].1 = 1.0;
            }
        }
        Ok(Some(Influences { per_vertex, pairs }))
    }

    fn counted<T>(&self, count: usize, place: &str, list: Vec<T>) -> Result<Vec<T>, Fault> {
        if list.len() == count {
            Ok(list)
        } else {
            Err(format!("{place} has {} elements, POSITION {count}", list.len()))
        }
    }

    /// Corners of all triangles, counter-clockwise as the file winds them.
    fn triangles(&self, mode: Mode, vertex_count: usize) -> Result<Vec<[u32; 3]>, Fault> {
        let corners: Vec<u32> = match self.file.indices {
            Some(index) => {
                let place = format!("{}.indices", self.place);
                self.accessors.integers::<1>(index, Type::Scalar, &place)?.into_flattened()
            }
            None => (0..vertex_count as u32).collect(),
        };
        if let Some(wrong) = corners.iter().find(|&&v| v as usize >= vertex_count) {
            return Err(format!("{}: index {wrong} of {vertex_count} vertices", self.place));
        }
        Ok(match mode {
            Mode::TriangleStrip => {
                let turned = |(i, w): (usize, &[u32])| {
                    if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[0], w[2], w[1]] }
                };
                corners.windows(3).enumerate().map(turned).collect()
            }
            Mode::TriangleFan => corners.windows(2).skip(1).map(|w| [w[0], w[1], corners[0]]).collect(),
            _ => corners.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect(),
        })
    }
}

/// Makes all normals unit; where one has no direction, the triangles around the vertex give it.
fn repair_normals(normals: &mut [Vec3], positions: &[Vec3], triangles: &[[u32; 3]]) {
    let unit = |n: Vec3| n.try_normalize().filter(|n| n.is_finite());
    let mut around = Vec::new();
    if normals.iter().any(|n| unit(*n).is_none()) {
        around = vec![Vec3::ZERO; normals.len()];
        for triangle in triangles {
            let [a, b, c] = triangle.map(|v| positions[v as usize]);
            triangle.iter().for_each(|&v| around[v as usize] += (b - a).cross(c - a));
        }
    }
    for (v, normal) in normals.iter_mut().enumerate() {
        *normal = unit(*normal).or_else(|| unit(*around.get(v)?)).unwrap_or(Vec3::Y);
    }
}
