//! Scenes for tests: triangles from code, on the device, and a voxelized scene read back.

use crate::grid::Layout;
use crate::grid::reference::CpuGrid;
use crate::{VoxelGrid, Voxelizer};
use frame::scene_gpu::{GpuScene, SceneOptions};
use frame::{FrameLog, Gpu};
use glam::{IVec3, Vec2, Vec3};
use scene::{Aabb, Geometry, Material, Object, Scene, Triangle};

/// One adapter per test, or none where the machine has none.
pub(crate) fn gpu() -> Option<Gpu> {
    Gpu::new(None).map_err(|e| println!("skipped: {e}")).ok()
}

/// Uniform numbers in 0..1 from a counter.
pub(crate) struct Random(pub u32);

impl Random {
    pub(crate) fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(1);
        (frame::surface::hash(self.0) >> 8) as f32 / 16_777_216.0
    }

    pub(crate) fn point(&mut self) -> Vec3 {
        Vec3::new(self.next(), self.next(), self.next())
    }

    pub(crate) fn direction(&mut self) -> Vec3 {
        let z = 1.0 - 2.0 * self.next();
        let (sin, cos) = (std::f32::consts::TAU * self.next()).sin_cos();
        let r = (1.0 - z * z).max(0.0).sqrt();
        Vec3::new(r * cos, r * sin, z).normalize()
    }
}

/// One object: a material and its triangles.
pub(crate) type Part = (Material, Vec<[Vec3; 3]>);

/// Two triangles around a, a + u, a + u + v, a + v; the front is towards u x v.
pub(crate) fn quad(a: Vec3, u: Vec3, v: Vec3) -> Vec<[Vec3; 3]> {
    vec![[a, a + u, a + u + v], [a, a + u + v, a + v]]
}

/// A closed sphere of latitude and longitude, front outside.
pub(crate) fn sphere(center: Vec3, radius: f32, rows: u32) -> Vec<[Vec3; 3]> {
    let point = |row: u32, column: u32| {
        let (theta, phi) = (
            std::f32::consts::PI * row as f32 / rows as f32,
            std::f32::consts::TAU * (column % (2 * rows)) as f32 / (2 * rows) as f32,
        );
        center + radius * Vec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
    };
    let mut triangles = Vec::new();
    for row in 0..rows {
        for column in 0..2 * rows {
            let [a, b] = [point(row, column), point(row, column + 1)];
            let [c, d] = [point(row + 1, column), point(row + 1, column + 1)];
            triangles.extend([[a, c, d], [a, d, b]]);
        }
    }
    triangles
}

/// Triangle soup.
pub(crate) fn soup(count: u32, size: f32) -> Vec<[Vec3; 3]> {
    let mut random = Random(3);
    (0..count)
        .map(|_| {
            let a = random.point();
            let reach = size * random.next();
            [a, a + reach * random.direction(), a + reach * random.direction()]
                .map(|p| p.clamp(Vec3::ZERO, Vec3::ONE))
        })
        .collect()
}

/// A part per triangle, each with its number as base colour: six bits per channel, in the upper bits of the code, because
/// a code that differs in the last bit between the powers of the CPU and the device may be rounded to its neighbour.
pub(crate) fn numbered(triangles: &[[Vec3; 3]]) -> Vec<Part> {
    let code = |number: usize, shift: u32| {
        frame::surface::linear_from_srgb((4 * ((number >> shift) & 63) + 1) as f32 / 255.0)
    };
    let color = |number: usize| Vec3::new(code(number, 0), code(number, 6), code(number, 12));
    triangles.iter().enumerate().map(|(n, t)| (Material::lambert("", color(n)), vec![*t])).collect()
}

/// The number in a record.
pub(crate) fn number(record: [u32; 4]) -> u32 {
    let channel = |shift: u32| (record[1] >> (shift + 2)) & 63;
    channel(0) | (channel(8) << 6) | (channel(16) << 12)
}

/// One material and one object per part, normals those of the faces; parts from `first_moving` on move.
pub(crate) fn geometry(parts: &[Part], first_moving: usize) -> Geometry {
    let mut geometry = Geometry::default();
    for (object, (_, triangles)) in (0..).zip(parts) {
        let vertices =
            geometry.positions.len() as u32..(geometry.positions.len() + 3 * triangles.len()) as u32;
        let first = geometry.triangles.len() as u32;
        for corners in triangles {
            let v = geometry.positions.len() as u32;
            let n =
                (corners[1] - corners[0]).cross(corners[2] - corners[0]).try_normalize().unwrap_or(Vec3::Z);
            geometry.positions.extend(corners);
            geometry.normals.extend([n; 3]);
            geometry.tangents.extend([n.any_orthonormal_vector().extend(1.0); 3]);
            geometry.uv0.extend([Vec2::ZERO; 3]);
            geometry.triangles.push(Triangle { vertices: [v, v + 1, v + 2], material: object, object });
        }
        let triangles = first..geometry.triangles.len() as u32;
        let moving = object as usize >= first_moving;
        geometry.objects.push(Object { name: String::new(), vertices, triangles, moving });
    }
    geometry
}

/// On the device, nothing moves.
pub(crate) fn upload(gpu: &Gpu, parts: &[Part]) -> GpuScene {
    upload_geometry(gpu, parts, &geometry(parts, parts.len()))
}

/// On the device, with the materials of parts.
pub(crate) fn upload_geometry(gpu: &Gpu, parts: &[Part], geometry: &Geometry) -> GpuScene {
    let mut scene = Scene::load("furnace").unwrap();
    scene.materials = parts.iter().map(|(material, _)| material.clone()).collect();
    GpuScene::new(gpu, &scene, geometry, &SceneOptions::default()).unwrap().0
}

/// A grid on the device with everything in it read back.
pub(crate) struct Built {
    pub(crate) voxels: VoxelGrid,
    pub(crate) log: FrameLog,
    pub(crate) grid: CpuGrid,
    pub(crate) layout: Layout,
    pub(crate) records: Vec<[u32; 4]>,
}

pub(crate) fn voxelize(gpu: &Gpu, scene: &GpuScene, bounds: Aabb, grid: u32) -> Built {
    build(gpu, &mut Voxelizer::new(gpu, scene).unwrap(), scene, bounds, grid)
}

pub(crate) fn build(
    gpu: &Gpu,
    voxelizer: &mut Voxelizer,
    scene: &GpuScene,
    bounds: Aabb,
    grid: u32,
) -> Built {
    let (voxels, log) = voxelizer.voxelize(gpu, scene, &scene.mesh, bounds, grid).unwrap();
    Built::read(gpu, voxels, log)
}

impl Built {
    pub(crate) fn read(gpu: &Gpu, voxels: VoxelGrid, log: FrameLog) -> Self {
        let layout = Layout {
            origin: voxels.origin,
            voxel_size: voxels.voxel_size,
            cells: voxels.cells,
            low: IVec3::ZERO,
        };
        let structure = gpu.read_buffer(&voxels.structure).unwrap();
        let records = voxels.record.expand(&gpu.read_buffer(&voxels.records).unwrap());
        let uniform = crate::Grid { contours: u32::from(voxels.contours), ..layout.uniform(0) };
        let grid = CpuGrid { grid: uniform, structure, voxel_count: voxels.voxel_count };
        Self { voxels, log, grid, layout, records }
    }

    pub(crate) fn cells(&self) -> Vec<IVec3> {
        self.grid.cells()
    }

    pub(crate) fn record(&self, cell: IVec3) -> Option<[u32; 4]> {
        self.grid.record(cell).map(|record| self.records[record as usize])
    }
}
