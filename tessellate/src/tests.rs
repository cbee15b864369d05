//! Promises of every tessellator, and the meshes that tests of this crate are made on.
#![allow(clippy::unwrap_used, clippy::panic)]

use crate::{Tessellator, all};
use frame::info::FrameInfo;
use frame::scene_gpu::{GpuMesh, GpuScene, SceneOptions};
use frame::{FrameLog, Gpu, Recorder, surface};
use glam::{Mat3, Vec2, Vec3};
use scene::{Camera, Geometry, HeightMap, Image, Material, Object, Scene, TextureSlot, Triangle, Wrap};
use std::collections::HashMap;
use std::f32::consts::{PI, TAU};

/// A mesh with one height map.
#[derive(Clone)]
pub(crate) struct Subject {
    pub(crate) geometry: Geometry,
    pub(crate) material: Material,
    pub(crate) image: Image,
}

/// A height map of this many texels, 0 to 1 from the middle of each.
pub(crate) fn picture([width, height]: [u32; 2], at: impl Fn(f32, f32) -> f32) -> Image {
    let texel = |i: u32| {
        let (x, y) = (i % width, i / width);
        let value = at((x as f32 + 0.5) / width as f32, (y as f32 + 0.5) / height as f32);
        let code = (255.0 * value).round().clamp(0.0, 255.0) as u8;
        [code, code, code, 255]
    };
    Image { name: "heights".into(), width, height, rgba: (0..width * height).map(texel).collect() }
}

/// Hills without a pattern.
pub(crate) fn noise(size: u32) -> Image {
    picture([size; 2], |u, v| {
        let cell = surface::hash((u * size as f32) as u32 + size * (v * size as f32) as u32);
        (cell >> 8) as f32 / 16_777_216.0
    })
}

impl Subject {
    /// `scale` metres, repeated.
    pub(crate) fn new(geometry: Geometry, image: Image, scale: f32) -> Self {
        let texture = TextureSlot {
            image: 0,
            uv_set: 0,
            uv_transform: Mat3::IDENTITY,
            wrap: [Wrap::Repeat; 2],
            linear: true,
        };
        let material = Material {
            height: Some(HeightMap { texture, scale, is_depth: false }),
            ..Material::lambert("relief", Vec3::ONE)
        };
        Self { geometry, material, image }
    }

    /// On the device; material 0 has the map, material 1 has none.
    pub(crate) fn upload(&self, gpu: &Gpu) -> GpuScene {
        let mut scene = Scene::load("cornell").unwrap();
        scene.materials = vec![self.material.clone(), Material::lambert("flat", Vec3::ONE)];
        scene.images = vec![self.image.clone()];
        GpuScene::new(gpu, &scene, &self.geometry, &SceneOptions::default()).unwrap().0
    }
}

/// Adds a grid of quads; `at` gives position and normal, `uv` the coordinates of a point of the unit square.
pub(crate) fn sheet(
    geometry: &mut Geometry,
    [columns, rows]: [u32; 2],
    at: impl Fn(f32, f32) -> (Vec3, Vec3),
    uv: impl Fn(f32, f32) -> Vec2,
) {
    let first = geometry.positions.len() as u32;
    for i in 0..(columns + 1) * (rows + 1) {
        let (x, y) = (i % (columns + 1), i / (columns + 1));
        let (s, t) = (x as f32 / columns as f32, y as f32 / rows as f32);
        let (position, normal) = at(s, t);
        geometry.positions.push(position);
        geometry.normals.push(normal);
        geometry.tangents.push(normal.any_orthonormal_vector().extend(1.0));
        geometry.uv0.push(uv(s, t));
    }
    let begin = geometry.triangles.len() as u32;
    for i in 0..columns * rows {
        let a = first + i % columns + i / columns * (columns + 1);
        let c = a + columns + 1;
        for vertices in [[a, a + 1, c + 1], [a, c + 1, c]] {
            geometry.triangles.push(Triangle { vertices, material: 0, object: 0 });
        }
    }
    if geometry.objects.is_empty() {
        geometry.objects.push(Object {
            name: "subject".into(),
            vertices: 0..0,
            triangles: begin..begin,
            moving: false,
        });
    }
    let object = &mut geometry.objects[0];
    object.vertices.end = geometry.positions.len() as u32;
    object.triangles.end = geometry.triangles.len() as u32;
}

/// A ball about the origin with a seam of texture coordinates and poles of triangles that have no area.
pub(crate) fn ball(radius: f32, cells: [u32; 2]) -> Geometry {
    let mut geometry = Geometry::default();
    let wrapped = |s: f32| if s == 1.0 { 0.0 } else { s };
    let at = |s: f32, t: f32| {
        let (sin, cos) = (wrapped(s) * TAU).sin_cos();
        let (across, up) = match t {
            0.0 => (0.0, -1.0),
            1.0 => (0.0, 1.0),
            _ => ((t * PI).sin(), -(t * PI).cos()),
        };
        let normal = Vec3::new(across * cos, up, -across * sin);
        (radius * normal, normal)
    };
    sheet(&mut geometry, cells, at, |s, t| Vec2::new(4.0 * s, 2.0 * t));
    geometry
}

/// A closed box of six sides that share no vertices; every second one has mirrored coordinates.
pub(crate) fn cube(side: f32, cells: u32) -> Geometry {
    let mut geometry = Geometry::default();
    for (i, (right, up)) in (0..).zip([
        (Vec3::X, Vec3::Y),
        (Vec3::Y, Vec3::X),
        (Vec3::Y, Vec3::Z),
        (Vec3::Z, Vec3::Y),
        (Vec3::Z, Vec3::X),
        (Vec3::X, Vec3::Z),
    ]) {
        let out = right.cross(up);
        let at = |s: f32, t: f32| (0.5 * side * (out + (2.0 * s - 1.0) * right + (2.0 * t - 1.0) * up), out);
        sheet(&mut geometry, [cells; 2], at, |s, t| Vec2::new(if i % 2 == 0 { s } else { 1.0 - s }, t));
    }
    geometry
}

/// What came out, read back.
pub(crate) struct Made {
    pub(crate) positions: Vec<Vec3>,
    pub(crate) previous: Vec<Vec3>,
    pub(crate) normals: Vec<Vec3>,
    pub(crate) tangents: Vec<glam::Vec4>,
    pub(crate) uv: Vec<Vec2>,
    pub(crate) triangles: Vec<[u32; 4]>,
    pub(crate) static_triangles: u32,
}

impl Made {
    pub(crate) fn read(gpu: &Gpu, mesh: &GpuMesh) -> Self {
        let words: Vec<u32> = gpu.read_buffer(&mesh.vertices).unwrap();
        let previous: Vec<[f32; 3]> = gpu.read_buffer(&mesh.previous).unwrap();
        let vertices: Vec<_> = words.chunks_exact(mesh.layout.stride as usize).collect();
        let floats = |i: usize, at: usize| f32::from_bits(vertices[i][at]);
        let each = 0..mesh.vertex_count as usize;
        let tangent = |i: usize| {
            let word = vertices[i][4];
            let w = if word & 1 == 1 { -1.0 } else { 1.0 };
            surface::face_normal_unpack(word & !1).extend(w)
        };
        Self {
            positions: each.clone().map(|i| Vec3::new(floats(i, 0), floats(i, 1), floats(i, 2))).collect(),
            previous: previous.into_iter().map(Vec3::from).take(each.len()).collect(),
            normals: each.clone().map(|i| surface::face_normal_unpack(vertices[i][3])).collect(),
            tangents: each.clone().map(tangent).collect(),
            uv: each.clone().map(|i| Vec2::new(floats(i, 5), floats(i, 6))).collect(),
            triangles: gpu.read_buffer(&mesh.triangles).unwrap(),
            static_triangles: mesh.static_triangle_count,
        }
    }

    /// Corners of triangles.
    pub(crate) fn corners(&self) -> impl Iterator<Item = [Vec3; 3]> + '_ {
        self.triangles.iter().map(|t| [0, 1, 2].map(|k| self.positions[t[k] as usize]))
    }

    /// Each vertex that a triangle uses, once.
    pub(crate) fn used(&self) -> Vec<usize> {
        let mut used: Vec<_> =
            self.triangles.iter().flat_map(|t| [t[0], t[1], t[2]]).map(|v| v as usize).collect();
        used.sort_unstable();
        used.dedup();
        used
    }

    /// How often each edge is used, by the bits of its ends.
    fn edges(&self) -> HashMap<[[u32; 3]; 2], u32> {
        let mut edges = HashMap::new();
        for corners in self.corners() {
            let bits = corners.map(|p| p.to_array().map(f32::to_bits));
            for k in 0..3 {
                let (a, b) = (bits[k], bits[(k + 1) % 3]);
                assert!(a != b, "a triangle with two corners at {:?}", corners[k]);
                *edges.entry([a.min(b), a.max(b)]).or_insert(0) += 1;
            }
        }
        edges
    }

    /// Edges that are not shared by exactly two triangles.
    pub(crate) fn open_edges(&self) -> usize {
        self.edges().values().filter(|&&count| count != 2).count()
    }

    /// Nothing is NaN, frames are unit and square, normals are on their triangle's side.
    pub(crate) fn check_frames(&self, what: &str) {
        for v in self.used() {
            let (normal, tangent) = (self.normals[v], self.tangents[v].truncate());
            assert!(self.positions[v].is_finite() && self.previous[v].is_finite(), "{what}: vertex {v}");
            assert!(
                (normal.length() - 1.0).abs() < 1e-5 && (tangent.length() - 1.0).abs() < 1e-5,
                "{what}: {v}"
            );
            // Two octahedral codes of 16 bits, one of them with its lowest bit taken.
            assert!(normal.dot(tangent).abs() < 5e-4, "{what}: vertex {v}: {normal} and {tangent}");
        }
        let turned = self.corners().zip(&self.triangles).filter(|([a, b, c], t)| {
            let face = (b - a).cross(c - a).normalize_or_zero();
            (0..3).any(|k| self.normals[t[k] as usize].dot(face) < -1e-3)
        });
        assert_eq!(turned.count(), 0, "{what}: normals behind their triangles");
    }
}

/// A frame of a camera that looks at the mesh.
pub(crate) fn frame(geometry: &Geometry) -> FrameInfo {
    let camera = Camera::framing(geometry.bounds());
    FrameInfo {
        previous_camera: camera.clone(),
        camera,
        trace_size: [64, 48],
        display_size: [64, 48],
        jitter: [0.0; 2],
        previous_jitter: [0.0; 2],
        frame_index: 0,
        seed: 1,
        time: 0.0,
        dt: 0.0,
        radiance_scale: 1.0,
        diagonal: geometry.bounds().diagonal(),
        restart: true,
        sun_elsewhere: false,
    }
}

/// Runs a tessellator once.
pub(crate) fn run(
    gpu: &Gpu,
    tessellator: &mut dyn Tessellator,
    subject: &Subject,
    voxel_size: f32,
) -> (Made, FrameLog) {
    let scene = subject.upload(gpu);
    let mut recorder = Recorder::new(gpu);
    let mesh = tessellator.tessellate(&mut recorder, &frame(&subject.geometry), voxel_size, &scene);
    let log = recorder.finish().unwrap();
    (Made::read(gpu, &mesh), log)
}

pub(crate) fn gpu() -> Gpu {
    Gpu::new(None).expect("tests need an adapter, a software one will do")
}

#[test]
fn identity_returns_the_same_buffers_and_runs_nothing() {
    let gpu = gpu();
    let scene = Subject::new(ball(1.0, [8, 4]), noise(8), 0.1).upload(&gpu);
    let mut recorder = Recorder::new(&gpu);
    let mesh = crate::identity::Identity.tessellate(&mut recorder, &frame(&ball(1.0, [8, 4])), 0.01, &scene);
    assert!(recorder.finish().unwrap().passes.is_empty());
    for (after, before) in [
        (&mesh.vertices, &scene.mesh.vertices),
        (&mesh.previous, &scene.mesh.previous),
        (&mesh.triangles, &scene.mesh.triangles),
    ] {
        assert!(**after == **before, "another {}", before.label());
    }
    assert_eq!(
        (mesh.vertex_count, mesh.triangle_count),
        (scene.mesh.vertex_count, scene.mesh.triangle_count)
    );
}

#[test]
fn names_are_those_of_the_list() {
    let gpu = gpu();
    for (name, make) in all() {
        let mut tessellator = make(&gpu).unwrap();
        assert_eq!(tessellator.name(), *name);
        let mut knobs: Vec<_> = tessellator.knobs().into_iter().map(|knob| knob.name).collect();
        knobs.sort_unstable();
        assert!(knobs.windows(2).all(|pair| pair[0] != pair[1]), "{name}: a knob twice in {knobs:?}");
    }
}

#[test]
fn closed_meshes_stay_closed() {
    let gpu = gpu();
    for (name, make) in all().iter().filter(|(name, _)| *name != "identity") {
        for (what, geometry) in
            [("ball", ball(1.0, [12, 7])), ("cube", cube(1.0, 3)), ("two cells", cube(1.0, 1))]
        {
            // A longest side of 1: factors from 1 to 5 on edges of one mesh.
            for voxel_size in [0.5, 0.1, 0.15] {
                let subject = Subject::new(geometry.clone(), noise(16), 0.05);
                let (made, _) = run(&gpu, make(&gpu).unwrap().as_mut(), &subject, voxel_size);
                assert_eq!(made.open_edges(), 0, "{name} of a {what} with voxels of {voxel_size}");
                made.check_frames(&format!("{name} of a {what}"));
            }
        }
    }
}

#[test]
fn the_same_mesh_gives_the_same_bits_and_is_made_once() {
    let gpu = gpu();
    let subject = Subject::new(ball(1.0, [12, 7]), noise(16), 0.05);
    for (name, make) in all() {
        let (first, _) = run(&gpu, make(&gpu).unwrap().as_mut(), &subject, 0.1);
        let mut tessellator = make(&gpu).unwrap();
        let (second, _) = run(&gpu, tessellator.as_mut(), &subject, 0.1);
        assert!(first.positions == second.positions && first.triangles == second.triangles, "{name}");
        assert!(first.normals == second.normals, "{name}");
        let scene = subject.upload(&gpu);
        for is_again in [false, true] {
            let mut recorder = Recorder::new(&gpu);
            tessellator.tessellate(&mut recorder, &frame(&subject.geometry), 0.1, &scene);
            let passes = recorder.finish().unwrap().passes;
            assert!(!is_again || passes.is_empty(), "{name} works again on what stands still: {passes:?}");
        }
    }
}
