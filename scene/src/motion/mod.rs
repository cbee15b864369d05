//! What moves: animated nodes, skins, morph targets, and the circling parts of `--move`.
//!
//! All animations of a file play together from time 0, once; after its last key a track holds. Out come world-space
//! positions (m), normals, tangents and windings of the moving tail of a [`Geometry`], its lights, and cameras.

mod circle;
mod rig;
mod shape;
mod track;

pub(crate) use circle::circle;
pub(crate) use rig::{Local, Moment, Node, Rig};
pub(crate) use shape::{Influences, Placement, Shape, Target, Vertices, face_normal, perpendicular};
pub(crate) use track::{Interpolation, Property, Track, unit};

use crate::{Aabb, Camera, Geometry, Object, PunctualLight, Triangle};
use glam::{Affine3A, Vec3, Vec4};
use std::ops::Range;
use std::sync::Arc;

/// Most moments that bounds are made of.
const MOST_SAMPLES: usize = 256;
/// Fewest, however large the scene.
const FEWEST_SAMPLES: usize = 16;
/// Vertices placed in all for the bounds: a second or so.
const BOUNDS_WORK: usize = 20_000_000;

/// Joints of a skin.
#[derive(Clone, Debug)]
pub(crate) struct Skin {
    /// Indices into [`Rig::nodes`].
    pub joints: Vec<usize>,
    /// Joint from mesh, one per joint.
    pub inverse_bind: Vec<Affine3A>,
}

impl Skin {
    /// World from mesh, per joint.
    pub(crate) fn matrices(&self, moment: &Moment) -> Vec<Affine3A> {
        self.joints.iter().zip(&self.inverse_bind).map(|(&joint, bind)| moment.world[joint] * *bind).collect()
    }
}

/// A shape at a node.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    /// Its vertices.
    pub shape: Arc<Shape>,
    /// Index into [`Rig::nodes`].
    pub node: usize,
    /// Node from mesh; the identity but for instances.
    pub instance: Affine3A,
    /// Index of the skin; then the node's own place does not count.
    pub skin: Option<usize>,
}

impl Part {
    /// Writes its vertices; returns whether its triangles are mirrored. `skins` are the matrices of all skins.
    pub(crate) fn place(&self, moment: &Moment, skins: &[Vec<Affine3A>], out: Vertices) -> bool {
        let placement = match self.skin.and_then(|skin| skins.get(skin)) {
            Some(matrices) => Placement::Skinned(matrices),
            None => Placement::Rigid(moment.world[self.node] * self.instance),
        };
        self.shape.place(placement, &moment.weights[self.node], out)
    }
}

/// One moving object of the geometry.
#[derive(Clone, Debug)]
struct Mover {
    /// What poses it; none where only `--move` does.
    part: Option<Part>,
    /// Whether its triangles are mirrored at time 0.
    mirrored: bool,
    /// Whether `--move` chose it.
    circles: bool,
}

/// A light at a node, as the file describes it.
#[derive(Clone, Debug)]
pub(crate) struct PlacedLight {
    /// Index into [`Rig::nodes`].
    pub node: usize,
    /// At the origin of the node, shining along -Z.
    pub light: PunctualLight,
}

impl PlacedLight {
    /// In world space.
    pub(crate) fn at(&self, moment: &Moment) -> PunctualLight {
        let world = moment.world[self.node];
        PunctualLight {
            position: world.translation.into(),
            direction: Vec3::from(-world.matrix3.z_axis).normalize_or(Vec3::NEG_Z),
            ..self.light
        }
    }
}

/// Everything needed to pose a scene at another time; empty where nothing moves.
#[derive(Clone, Debug, Default)]
pub(crate) struct Motion {
    rig: Rig,
    skins: Vec<Skin>,
    movers: Vec<Mover>,
    lights: Vec<PlacedLight>,
    /// The node of each camera.
    cameras: Vec<usize>,
}

impl Motion {
    /// `movers` are the moving objects in the order of the geometry, each with whether it is mirrored at time 0.
    pub(crate) fn new(
        rig: Rig,
        skins: Vec<Skin>,
        movers: Vec<(Part, bool)>,
        lights: Vec<PlacedLight>,
        cameras: Vec<usize>,
    ) -> Self {
        if rig.tracks.is_empty() {
            return Self::default();
        }
        let movers = movers
            .into_iter()
            .map(|(part, mirrored)| Mover { part: Some(part), mirrored, circles: false })
            .collect();
        Self { rig, skins, movers, lights, cameras }
    }

    /// Rewrites the moving tail of `geometry`, a copy of `rest`, for `time` seconds.
    pub(crate) fn pose(&self, time: f32, rest: &Geometry, geometry: &mut Geometry) {
        self.animate(time, rest, geometry);
        let offset = circle::offset(time);
        for (mover, object) in self.movers.iter().zip(moving(rest)) {
            if mover.circles {
                geometry.positions[vertices(object)].iter_mut().for_each(|p| *p += offset);
            }
        }
    }

    /// The same without `--move`.
    fn animate(&self, time: f32, rest: &Geometry, geometry: &mut Geometry) {
        if geometry.positions.len() != rest.positions.len()
            || geometry.triangles.len() != rest.triangles.len()
        {
            geometry.clone_from(rest);
        }
        let moment = self.rig.moment(time);
        let skins: Vec<_> = self.skins.iter().map(|s| s.matrices(&moment)).collect();
        for (mover, object) in self.movers.iter().zip(moving(rest)) {
            let vertices = vertices(object);
            let Some(part) = &mover.part else {
                geometry.positions[vertices.clone()].copy_from_slice(&rest.positions[vertices]);
                continue;
            };
            let out = Vertices {
                positions: &mut geometry.positions[vertices.clone()],
                normals: &mut geometry.normals[vertices.clone()],
                tangents: &mut geometry.tangents[vertices],
            };
            let turned = part.place(&moment, &skins, out) != mover.mirrored;
            let triangles = object.triangles.start as usize..object.triangles.end as usize;
            let own = geometry.triangles[triangles.clone()].iter_mut();
            for (triangle, rest) in own.zip(&rest.triangles[triangles]) {
                *triangle = if turned { flipped(*rest) } else { *rest };
            }
        }
        for (light, placed) in geometry.lights.iter_mut().zip(&self.lights) {
            *light = placed.at(&moment);
        }
    }

    /// Camera `index`, whose place at time 0 is `rest`, at `time` seconds.
    pub(crate) fn camera(&self, index: usize, rest: &Camera, time: f32) -> Camera {
        match self.cameras.get(index) {
            Some(&node) => camera_at(&self.rig.moment(time).world[node], rest.name.clone(), rest.vfov),
            None => rest.clone(),
        }
    }

    /// Seconds until the last key, and at least one turn where parts circle.
    pub(crate) fn duration(&self) -> f32 {
        let keys = self.rig.tracks.iter().filter_map(|t| t.times().last()).fold(0.0_f32, |a, &t| a.max(t));
        if self.movers.iter().any(|m| m.circles) { keys.max(circle::TURN_S) } else { keys }
    }

    /// Box around `rest` and every pose at the keys, the moments between two keys halved where there are few keys,
    /// and all of the circles.
    pub(crate) fn bounds(&self, rest: &Geometry) -> Aabb {
        let mut bounds = rest.bounds();
        let moving_vertices = rest.positions.len() - rest.static_vertex_count() as usize;
        let Some(samples) = BOUNDS_WORK.checked_div(moving_vertices) else { return bounds };
        let mut geometry = rest.clone();
        for time in self.sample_times(samples.clamp(FEWEST_SAMPLES, MOST_SAMPLES)) {
            self.animate(time, rest, &mut geometry);
            for (mover, object) in self.movers.iter().zip(moving(rest)) {
                let own = Aabb::of(geometry.positions[vertices(object)].iter().copied());
                bounds = bounds.union(if mover.circles { circle::swept(own) } else { own });
            }
        }
        bounds
    }

    /// Time 0 and the keys, at most `most` times in all, spread evenly.
    fn sample_times(&self, most: usize) -> Vec<f32> {
        let mut times: Vec<f32> =
            self.rig.tracks.iter().flat_map(|t| t.times()).copied().chain([0.0]).collect();
        times.sort_by(f32::total_cmp);
        times.dedup();
        if 2 * times.len() <= most {
            let halves: Vec<f32> = times.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect();
            times.extend(halves);
        }
        if times.len() <= most {
            return times;
        }
        (0..most).map(|i| times[i * (times.len() - 1) / (most - 1)]).collect()
    }
}

/// The objects that movers pose, in their order.
fn moving(rest: &Geometry) -> impl Iterator<Item = &Object> {
    rest.objects.iter().skip_while(|o| !o.moving)
}

fn vertices(object: &Object) -> Range<usize> {
    object.vertices.start as usize..object.vertices.end as usize
}

/// A glTF camera: at the origin of its node, looking along -Z, +Y up. Its target is 1 m ahead.
pub(crate) fn camera_at(world: &Affine3A, name: String, vfov: f32) -> Camera {
    let eye = Vec3::from(world.translation);
    let forward = Vec3::from(-world.matrix3.z_axis).normalize_or(Vec3::NEG_Z);
    let up = Vec3::from(world.matrix3.y_axis).normalize_or(Vec3::Y);
    Camera { name, eye, target: eye + forward, up, vfov }
}

/// The same triangle seen from the other side.
pub(crate) fn flipped(triangle: Triangle) -> Triangle {
    let [a, b, c] = triangle.vertices;
    Triangle { vertices: [a, c, b], ..triangle }
}

/// Room for `count` vertices that no part has written yet: positions are NaN until then.
pub(crate) fn unwritten(geometry: &mut Geometry, count: usize) {
    let total = geometry.positions.len() + count;
    geometry.positions.resize(total, Vec3::NAN);
    geometry.normals.resize(total, Vec3::Y);
    geometry.tangents.resize(total, Vec4::new(1.0, 0.0, 0.0, 1.0));
}
