//! Puts everything together: parts in the world at time 0, static ones first, and the motion of the others.

use super::meshes::{Primitive, Skipped};
use super::{Document, Fault, animations, meshes, nodes};
use crate::budget::Meter;
use crate::motion::{Motion, Part, PlacedLight, Rig, Skin, Vertices, camera_at, flipped, unwritten};
use crate::{Geometry, Image, Material, Object, Scene, Sky, Triangle};
use glam::{Affine3A, Vec2, Vec3, Vec4};
use std::collections::HashMap;
use std::rc::Rc;

/// Most vertices, and most triangles, whatever the budget: indices stay far inside 32 bits.
const MOST: u64 = 1 << 28;

/// Bytes of a vertex in the scene: position, normal, tangent, two sets of texture coordinates, colour.
const VERTEX_BYTES: u64 = (3 + 3 + 4 + 2 + 2 + 4) * 4;
/// Bytes of an object with its name, and of the part that it is placed by.
const OBJECT_BYTES: u64 = 512;
/// Characters of a name that objects repeat.
const NAME_LENGTH: usize = 80;

/// One primitive at one place.
struct Drawn {
    name: String,
    primitive: Rc<Vec<(usize, Primitive)>>,
    /// Index into `primitive`.
    which: usize,
    part: Part,
    moving: bool,
}

impl Drawn {
    fn primitive(&self) -> &Primitive {
        &self.primitive[self.which].1
    }
}

/// How much is drawn so far: nodes, primitives and instances multiply.
struct Counts<'a> {
    vertices: u64,
    triangles: u64,
    meter: &'a Meter,
}

impl Counts<'_> {
    /// Takes a primitive's places before they take any memory.
    fn add(&mut self, primitive: &Primitive, instances: usize) -> Result<(), Fault> {
        let instances = instances as u64;
        let vertices = instances.saturating_mul(primitive.shape.positions.len() as u64);
        let triangles = instances.saturating_mul(primitive.triangles.len() as u64);
        let taken = self
            .meter
            .take(vertices, VERTEX_BYTES)
            .and_then(|()| self.meter.take(triangles, size_of::<Triangle>() as u64))
            .and_then(|()| self.meter.take(instances, OBJECT_BYTES));
        taken.map_err(|over| {
            format!("{instances} instances with {vertices} vertices and {triangles} triangles: {over}")
        })?;
        self.vertices = self.vertices.saturating_add(vertices);
        self.triangles = self.triangles.saturating_add(triangles);
        match [("vertices", self.vertices), ("triangles", self.triangles)]
            .into_iter()
            .find(|(_, n)| *n > MOST)
        {
            Some((what, count)) => Err(format!("{count} {what} so far, at most {MOST}")),
            None => Ok(()),
        }
    }
}

/// The scene of a document whose materials and pictures are read.
pub(super) fn scene(
    name: String,
    mut document: Document,
    mut materials: Vec<Material>,
    images: Vec<Image>,
) -> Result<Scene, Fault> {
    let mut tree = nodes::tree(&document.root)?;
    tree.rig.tracks = animations::read(&mut document, &tree)?;
    let skins = nodes::skins(&document, &tree)?;
    let cameras = nodes::cameras(&mut document, &tree)?;
    let lights = nodes::lights(&document, &tree)?;
    let mut drawn = parts(&mut document, &tree, &skins, &materials)?;
    drawn.sort_by_key(|d| d.moving);
    if materials.is_empty() || drawn.iter().any(|d| d.primitive().material >= materials.len()) {
        materials.push(Material { name: "default".into(), ..Material::default() });
    }
    if document
        .root
        .scenes
        .iter()
        .any(|s| s.extras.as_ref().is_some_and(|e| e.get().contains("\"emitters\"")))
    {
        document
            .warnings
            .push("extras.emitters is left out: give light from far away with --sky or --sun".into());
    }

    let (mut rest, mut movers, mut dropped) = geometry(&drawn, &tree.rig, &skins, &lights);
    let origin = rest.bounds().better_origin();
    if origin != Vec3::ZERO {
        tree.rig.origin = origin;
        (rest, movers, dropped) = geometry(&drawn, &tree.rig, &skins, &lights);
    }
    let second_uv = |m: &Material| {
        let slots = m.textures().map(|(slot, _)| slot);
        slots.into_iter().chain([m.height.map(|h| h.texture)]).flatten().any(|slot| slot.uv_set == 1)
    };
    if !drawn.iter().any(|d| materials.get(d.primitive().material).is_some_and(second_uv)) {
        rest.uv1 = Vec::new();
    }
    if dropped > 0 {
        document.warnings.push(format!("{dropped} triangles are left out: a corner is not finite"));
    }
    let start = tree.rig.moment(0.0);
    let places = cameras.iter().map(|(node, ..)| *node).collect();
    let cameras =
        cameras.into_iter().map(|(node, name, vfov)| camera_at(&start.world[node], name, vfov)).collect();
    let motion = Motion::new(tree.rig, skins, movers, lights, places);
    let bounds = motion.bounds(&rest);
    Ok(Scene {
        name,
        materials,
        images,
        cameras,
        sky: Sky::Constant(Vec3::ZERO),
        sun: None,
        warnings: document.warnings,
        rest,
        bounds,
        origin,
        motion,
    })
}

/// Every primitive of every drawn node and instance, in file order.
fn parts(
    document: &mut Document,
    tree: &nodes::Tree,
    skins: &[Skin],
    materials: &[Material],
) -> Result<Vec<Drawn>, Fault> {
    let (moving_nodes, morphing_nodes) = (tree.rig.moving_nodes(), tree.rig.morphing_nodes());
    let mut read: HashMap<usize, Rc<Vec<(usize, Primitive)>>> = HashMap::new();
    let (mut skipped, mut drawn) = (Skipped::default(), Vec::new());
    let mut counts = Counts { vertices: 0, triangles: 0, meter: &document.meter };
    for (slot, node) in tree.drawn(&document.root) {
        let Some(mesh) = node.mesh else { continue };
        let n = tree.file_index[slot];
        let place = format!("nodes[{n}]");
        let primitives = match read.get(&mesh.value()) {
            Some(primitives) => primitives.clone(),
            None => {
                let primitives = Rc::new(meshes::read(document, mesh, materials, &mut skipped, &place)?);
                read.insert(mesh.value(), primitives.clone());
                primitives
            }
        };
        let mesh_name = document.root.meshes.get(mesh.value()).and_then(|m| m.name.as_deref());
        let name: String =
            node.name.as_deref().or(mesh_name).unwrap_or(&place).chars().take(NAME_LENGTH).collect();
        let instances = nodes::instances(document, node, &place)?;
        for (which, (p, primitive)) in primitives.iter().enumerate() {
            let skin = node.skin.map(|s| s.value()).filter(|_| primitive.shape.influences.is_some());
            if let Some(s) = skin
                && primitive.joint_count > skins[s].joints.len()
            {
                let (highest, count) = (primitive.joint_count - 1, skins[s].joints.len());
                return Err(format!("{place}, primitive {p}: joint {highest} named, skins[{s}] has {count}"));
            }
            let moved = match skin {
                Some(s) => skins[s].joints.iter().any(|&joint| moving_nodes[joint]),
                None => moving_nodes[slot],
            };
            let moving = moved || (morphing_nodes[slot] && !primitive.shape.targets.is_empty());
            // A skinned mesh is where its joints are, so its instances would coincide.
            let instances = if skin.is_some() { &[Affine3A::IDENTITY][..] } else { &instances };
            counts.add(primitive, instances.len()).map_err(|fault| format!("{place}: {fault}"))?;
            for (i, &instance) in instances.iter().enumerate() {
                let copy = if instances.len() > 1 { format!(", instance {i}") } else { String::new() };
                drawn.push(Drawn {
                    name: format!("{name}, primitive {p}{copy}"),
                    primitive: primitives.clone(),
                    which,
                    part: Part { shape: primitive.shape.clone(), node: slot, instance, skin },
                    moving,
                });
            }
        }
    }
    for (count, what) in [
        (skipped.not_finite, "triangles are left out: a corner is not finite"),
        (skipped.no_triangles, "primitives of points or lines are left out"),
        (skipped.no_positions, "primitives without positions are left out"),
    ] {
        if count > 0 {
            document.warnings.push(format!("{count} {what}"));
        }
    }
    Ok(drawn)
}

/// The world at time 0; the moving parts, each with whether it is mirrored; how many triangles left the range of
/// floats on their way into the world.
fn geometry(
    drawn: &[Drawn],
    rig: &Rig,
    skins: &[Skin],
    lights: &[PlacedLight],
) -> (Geometry, Vec<(Part, bool)>, usize) {
    let moment = rig.moment(0.0);
    let joints: Vec<_> = skins.iter().map(|s| s.matrices(&moment)).collect();
    let has_uv1 = drawn.iter().any(|d| !d.primitive().uv1.is_empty());
    let has_colors = drawn.iter().any(|d| !d.primitive().colors.is_empty());
    let (mut g, mut movers, mut dropped) = (Geometry::default(), Vec::new(), 0);
    for d in drawn {
        let (primitive, first) = (d.primitive(), g.positions.len());
        unwritten(&mut g, primitive.shape.positions.len());
        let end = g.positions.len();
        let out = Vertices {
            positions: &mut g.positions[first..],
            normals: &mut g.normals[first..],
            tangents: &mut g.tangents[first..],
        };
        let mirrored = d.part.place(&moment, &joints, out);
        fill(&mut g.uv0, &primitive.uv0, end, Vec2::ZERO);
        if has_uv1 {
            fill(&mut g.uv1, &primitive.uv1, end, Vec2::ZERO);
        }
        if has_colors {
            fill(&mut g.colors, &primitive.colors, end, Vec4::ONE);
        }
        let (first_triangle, object) = (g.triangles.len(), g.objects.len() as u32);
        for corners in &primitive.triangles {
            let vertices = corners.map(|v| first as u32 + v);
            let triangle = Triangle { vertices, material: primitive.material as u32, object };
            if g.corners(&triangle).iter().all(|p| p.is_finite()) {
                g.triangles.push(if mirrored { flipped(triangle) } else { triangle });
            } else {
                dropped += 1;
            }
        }
        g.positions[first..].iter_mut().filter(|p| !p.is_finite()).for_each(|p| *p = Vec3::ZERO);
        g.objects.push(Object {
            name: d.name.clone(),
            vertices: first as u32..end as u32,
            triangles: first_triangle as u32..g.triangles.len() as u32,
            moving: d.moving,
        });
        if d.moving {
            movers.push((d.part.clone(), mirrored));
        }
    }
    g.lights = lights.iter().map(|l| l.at(&moment)).collect();
    (g, movers, dropped)
}

/// Appends a primitive's list, then `default` up to `end`.
fn fill<T: Copy>(to: &mut Vec<T>, from: &[T], end: usize, default: T) {
    to.extend_from_slice(from);
    to.resize(end, default);
}
