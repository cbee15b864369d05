//! The node tree of the drawn scene: transforms, instances, skins, cameras, lights.

use super::{Document, Fault, item, valid};
use crate::motion::{Local, Node, PlacedLight, Rig, Skin, unit};
use crate::{PunctualKind, PunctualLight};
use glam::{Affine3A, Mat4, Quat, Vec3};
use gltf::json::accessor::{Accessor, Type};
use gltf::json::extensions::scene::khr_lights_punctual::Type as LightType;
use gltf::json::{Index, Root, Scene, camera, scene};
use serde_json::Value;
use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// The nodes in the order of [`Rig::nodes`].
pub(super) struct Tree {
    pub rig: Rig,
    /// Node of the file for each node of the rig.
    pub file_index: Vec<usize>,
    /// Node of the rig for each node of the file, where it has one.
    pub slot: Vec<Option<usize>>,
    /// So many leading nodes belong to the drawn scene; the others only carry joints.
    pub drawn: usize,
}

/// Walks the default scene, or the first, or all root nodes, then whatever other trees there are.
pub(super) fn tree(root: &Root) -> Result<Tree, Fault> {
    let count = root.nodes.len();
    let mut tree = Tree { rig: Rig::default(), file_index: Vec::new(), slot: vec![None; count], drawn: 0 };
    let mut is_child = vec![false; count];
    for child in root.nodes.iter().flat_map(|n| n.children.iter().flatten()) {
        if let Some(flag) = is_child.get_mut(child.value()) {
            *flag = true;
        }
    }
    let tops = || (0..count).filter(|&n| !is_child[n]);
    let scene = match root.scene {
        Some(index) => Some(item(&root.scenes, index, "scenes", "scene")?),
        None => root.scenes.first(),
    };
    match scene {
        Some(scene) => tree.add(root, &scene_tops(root, scene)?, true)?,
        None => tree.add(root, &tops().collect::<Vec<_>>(), true)?,
    }
    tree.drawn = tree.file_index.len();
    tree.add(root, &tops().collect::<Vec<_>>(), false)?;
    Ok(tree)
}

fn scene_tops(root: &Root, scene: &Scene) -> Result<Vec<usize>, Fault> {
    scene.nodes.iter().map(|&n| item(&root.nodes, n, "nodes", "the scene").map(|_| n.value())).collect()
}

impl Tree {
    /// Appends the trees under `tops`, parents first, in file order. A node met again is an error in the drawn scene.
    fn add(&mut self, root: &Root, tops: &[usize], drawn: bool) -> Result<(), Fault> {
        let mut stack: Vec<(usize, Option<usize>)> = tops.iter().rev().map(|&n| (n, None)).collect();
        while let Some((n, parent)) = stack.pop() {
            if self.slot[n].is_some() {
                if drawn {
                    return Err(format!("nodes[{n}] hangs in the scene twice: nodes must be a tree"));
                }
                continue;
            }
            let (node, place) = (&root.nodes[n], format!("nodes[{n}]"));
            let slot = self.file_index.len();
            self.slot[n] = Some(slot);
            self.file_index.push(n);
            let weights = weights(root, node);
            self.rig.nodes.push(Node { parent, local: local(node, &place)?, weights });
            for &child in node.children.iter().flatten().rev() {
                item(&root.nodes, child, "nodes", &place)?;
                stack.push((child.value(), Some(slot)));
            }
        }
        Ok(())
    }

    /// Slot and node of the drawn scene, in order.
    pub(super) fn drawn<'a>(&'a self, root: &'a Root) -> impl Iterator<Item = (usize, &'a scene::Node)> {
        self.file_index[..self.drawn].iter().enumerate().map(|(slot, &n)| (slot, &root.nodes[n]))
    }
}

/// Finite weights, no more than the mesh has targets.
fn weights(root: &Root, node: &scene::Node) -> Vec<f32> {
    let Some(mesh) = node.mesh.and_then(|m| root.meshes.get(m.value())) else { return Vec::new() };
    let targets = mesh.primitives.iter().map(|p| p.targets.as_ref().map_or(0, Vec::len)).max().unwrap_or(0);
    let weights = node.weights.as_ref().or(mesh.weights.as_ref()).into_iter().flatten().take(targets);
    weights.map(|&w| if w.is_finite() { w } else { 0.0 }).collect()
}

fn local(node: &scene::Node, place: &str) -> Result<Local, Fault> {
    let finite = |values: &[f32], name: &str| match values.iter().find(|x| !x.is_finite()) {
        Some(x) => Err(format!("{place}.{name} holds {x}")),
        None => Ok(()),
    };
    if let Some(matrix) = &node.matrix {
        finite(matrix, "matrix")?;
        return Ok(Local::Matrix(Affine3A::from_mat4(Mat4::from_cols_array(matrix))));
    }
    let translation = node.translation.unwrap_or_default();
    let rotation = node.rotation.unwrap_or_default().0;
    let scale = node.scale.unwrap_or([1.0; 3]);
    finite(&translation, "translation")?;
    finite(&rotation, "rotation")?;
    finite(&scale, "scale")?;
    Ok(Local::Parts { translation: translation.into(), rotation: unit(&rotation), scale: scale.into() })
}

/// Node from mesh for each instance; one identity where the node has no instances.
pub(super) fn instances(
    document: &Document,
    node: &scene::Node,
    place: &str,
) -> Result<Vec<Affine3A>, Fault> {
    let extension = node.extensions.as_ref().and_then(|e| e.others.get("EXT_mesh_gpu_instancing"));
    let Some(attributes) = extension.map(|e| e.get("attributes").unwrap_or(&Value::Null)) else {
        return Ok(vec![Affine3A::IDENTITY]);
    };
    let accessors = document.accessors();
    let index = |name: &str| -> Result<Option<Index<Accessor>>, Fault> {
        let Some(value) = attributes.get(name) else { return Ok(None) };
        let number = value.as_u64().and_then(|n| u32::try_from(n).ok());
        number
            .map(|n| Some(Index::new(n)))
            .ok_or_else(|| format!("{place}: instance attribute {name} is {value}"))
    };
    let read3 = |name: &str| {
        index(name)?.map(|i| accessors.floats::<3>(i, Type::Vec3, &format!("{place} {name}"))).transpose()
    };
    let (translations, scales) = (read3("TRANSLATION")?, read3("SCALE")?);
    let rotations = index("ROTATION")?
        .map(|i| accessors.floats::<4>(i, Type::Vec4, &format!("{place} ROTATION")))
        .transpose()?;
    let counts = [
        translations.as_ref().map(Vec::len),
        scales.as_ref().map(Vec::len),
        rotations.as_ref().map(Vec::len),
    ];
    let count = counts.iter().flatten().copied().max().unwrap_or(0);
    if counts.iter().flatten().any(|&c| c != count) {
        return Err(format!("{place}: instance attributes have {counts:?} elements"));
    }
    let pick = |list: &Option<Vec<[f32; 3]>>, i: usize, default: Vec3| {
        list.as_ref().and_then(|l| l.get(i)).map_or(default, |v| Vec3::from(*v))
    };
    let matrix = |i: usize| {
        let rotation = rotations.as_ref().and_then(|r| r.get(i)).map_or(Quat::IDENTITY, |r| unit(r));
        let translation = pick(&translations, i, Vec3::ZERO);
        Affine3A::from_scale_rotation_translation(pick(&scales, i, Vec3::ONE), rotation, translation)
    };
    Ok((0..count).map(matrix).collect())
}

/// All skins that drawn nodes use, by number in the file; the others stay empty.
pub(super) fn skins(document: &Document, tree: &Tree) -> Result<Vec<Skin>, Fault> {
    let root = &document.root;
    let mut used = vec![false; root.skins.len()];
    for (slot, node) in tree.drawn(root) {
        if let Some(skin) = node.skin {
            item(&root.skins, skin, "skins", &format!("nodes[{}]", tree.file_index[slot]))?;
            used[skin.value()] = true;
        }
    }
    let read = |(s, skin): (usize, &gltf::json::Skin)| {
        if !used[s] {
            return Ok(Skin { joints: Vec::new(), inverse_bind: Vec::new() });
        }
        let place = format!("skins[{s}]");
        let joint = |&joint: &Index<scene::Node>| {
            item(&root.nodes, joint, "nodes", &place)?;
            tree.slot[joint.value()]
                .ok_or_else(|| format!("{place}: nodes[{}] hangs in a loop", joint.value()))
        };
        let joints = skin.joints.iter().map(joint).collect::<Result<Vec<_>, Fault>>()?;
        let inverse_bind = match skin.inverse_bind_matrices {
            Some(index) => inverse_bind(document, index, &place)?,
            None => vec![Affine3A::IDENTITY; joints.len()],
        };
        if inverse_bind.len() < joints.len() {
            return Err(format!(
                "{place}: {} joints, {} inverse bind matrices",
                joints.len(),
                inverse_bind.len()
            ));
        }
        Ok(Skin { joints, inverse_bind })
    };
    root.skins.iter().enumerate().map(read).collect()
}

fn inverse_bind(document: &Document, index: Index<Accessor>, place: &str) -> Result<Vec<Affine3A>, Fault> {
    let accessors = document.accessors();
    let place = format!("{place}.inverseBindMatrices");
    let matrices = accessors.floats::<16>(index, Type::Mat4, &place)?;
    if matrices.as_flattened().iter().any(|x| !x.is_finite()) {
        return Err(format!("{place}: a number is not finite"));
    }
    Ok(matrices.iter().map(|m| Affine3A::from_mat4(Mat4::from_cols_array(m))).collect())
}

/// Node, name and vertical field of view of every perspective camera, by number of the camera in the file.
pub(super) fn cameras(document: &mut Document, tree: &Tree) -> Result<Vec<(usize, String, f32)>, Fault> {
    let root = &document.root;
    let (mut found, mut warnings) = (Vec::new(), Vec::new());
    for (slot, node) in tree.drawn(root) {
        let Some(index) = node.camera else { continue };
        let camera = item(&root.cameras, index, "cameras", &format!("nodes[{}]", tree.file_index[slot]))?;
        let place = format!("cameras[{}]", index.value());
        let kind = valid(&camera.type_, &format!("{place}.type"))?;
        match (&camera.perspective, kind) {
            (Some(perspective), camera::Type::Perspective) => {
                if !(perspective.yfov > 0.0 && perspective.yfov < PI) {
                    return Err(format!(
                        "{place}: yfov is {} radians, needed between 0 and pi",
                        perspective.yfov
                    ));
                }
                let name = camera.name.clone().or_else(|| node.name.clone()).unwrap_or_default();
                found.push((index.value(), (slot, name, perspective.yfov)));
            }
            _ => warnings.push(format!("{place} is left out: only perspective cameras are read")),
        }
    }
    document.warnings.extend(warnings);
    found.sort_by_key(|(index, _)| *index);
    Ok(found.into_iter().map(|(_, camera)| camera).collect())
}

/// The punctual lights of the drawn scene.
pub(super) fn lights(document: &Document, tree: &Tree) -> Result<Vec<PlacedLight>, Fault> {
    let root = &document.root;
    let all =
        root.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref()).map_or(&[][..], |e| &e.lights);
    let mut lights = Vec::new();
    for (slot, node) in tree.drawn(root) {
        let Some(link) = node.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref()) else {
            continue;
        };
        let light = item(all, link.light, "lights", &format!("nodes[{}]", tree.file_index[slot]))?;
        let place = format!("KHR_lights_punctual.lights[{}]", link.light.value());
        let kind = match valid(&light.type_, &format!("{place}.type"))? {
            LightType::Directional => PunctualKind::Directional,
            LightType::Point => PunctualKind::Point,
            LightType::Spot => {
                let (inner, outer) = light
                    .spot
                    .as_ref()
                    .map_or((0.0, FRAC_PI_4), |s| (s.inner_cone_angle, s.outer_cone_angle));
                if !(inner >= 0.0 && inner <= outer && outer > 0.0 && outer <= FRAC_PI_2) {
                    return Err(format!(
                        "{place}: cone angles {inner} and {outer}, needed 0 <= inner <= outer <= pi/2"
                    ));
                }
                PunctualKind::Spot { inner, outer }
            }
        };
        let intensity = Vec3::from(light.color) * light.intensity;
        if !intensity.is_finite() {
            return Err(format!("{place}: colour {:?} times intensity {}", light.color, light.intensity));
        }
        let range = light.range.filter(|&r| r > 0.0).unwrap_or(f32::INFINITY);
        let light = PunctualLight {
            kind,
            position: Vec3::ZERO,
            direction: Vec3::NEG_Z,
            intensity: intensity.max(Vec3::ZERO),
            range,
        };
        lights.push(PlacedLight { node: slot, light });
    }
    Ok(lights)
}
