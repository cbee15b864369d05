//! Small worlds of cells, given to the device and to the twin alike; the camera sees the cells' own cubes.

use super::super::VoxelTracer;
use super::super::reference::CpuVoxels;
use crate::path::reference::{
    NO_OWN, Pixel, Ray, Structure, Tally, Texel, World as CpuWorld, view_direction,
};
use crate::path::{ENDLESS, PathParams, PathSettings, RadianceCache};
use crate::{LightList, Tracer, World};
use frame::brdf::BrdfTable;
use frame::cpu::Image;
use frame::scene_gpu::{GpuScene, Light, SceneOptions};
use frame::surface::{Surface, face_normal_pack, hash};
use frame::{FrameInfo, FrameLog, GBuffer, Gpu, Recorder, Room, Texture};
use glam::{DVec3, IVec3, UVec2, Vec3};
use half::f16;
use scene::{Camera, PunctualLight, Sky, Sun};
use std::cell::RefCell;
use std::collections::BTreeMap;
use voxel::grid::reference::CpuGrid;
use voxel::grid::{Glowing, Layout};
use voxel::{RecordLayout, VoxelGrid};

/// Metres; nothing special.
pub const VOXEL: f32 = 0.2;
/// World position of cell 0.
pub const ORIGIN: Vec3 = Vec3::new(-1.3, 0.4, 2.1);

/// The middle of a cell, world.
pub fn at(x: f32, y: f32, z: f32) -> Vec3 {
    ORIGIN + VOXEL * Vec3::new(x, y, z)
}

pub fn cells(low: [i32; 3], high: [i32; 3]) -> impl Iterator<Item = IVec3> {
    let range = move |axis: usize| low[axis]..high[axis];
    range(2).flat_map(move |z| range(1).flat_map(move |y| range(0).map(move |x| IVec3::new(x, y, z))))
}

/// Cells and their records.
#[derive(Clone)]
pub struct Model {
    size: i32,
    records: BTreeMap<[i32; 3], [u32; 4]>,
}

impl Model {
    pub fn new(size: i32) -> Self {
        Self { size, records: BTreeMap::new() }
    }

    pub fn set(&mut self, cell: IVec3, surface: &Surface) {
        let seed = (cell.x + 64 * (cell.y + 64 * cell.z)) as u32;
        self.set_record(cell, surface.pack_voxel(hash(seed)));
    }

    pub fn set_record(&mut self, cell: IVec3, record: [u32; 4]) {
        self.records.insert(cell.to_array(), record);
    }

    pub fn clear(&mut self, cell: IVec3) {
        self.records.remove(&cell.to_array());
    }

    /// Keeps the cells of which this holds.
    pub fn retain(&mut self, keep: impl Fn(IVec3) -> bool) {
        self.records.retain(|cell, _| keep(IVec3::from(*cell)));
    }

    /// Walls one cell thick, their normals inwards.
    pub fn room(&mut self, wall: impl Fn(Vec3) -> Surface) {
        let last = self.size - 1;
        for cell in cells([0; 3], [self.size; 3]) {
            let normal = cell.cmpeq(IVec3::ZERO).bitmask();
            let other = cell.cmpeq(IVec3::splat(last)).bitmask();
            if normal | other != 0 {
                let axis = (normal | other).trailing_zeros() as usize;
                let n = Vec3::AXES[axis] * if normal >> axis & 1 == 1 { 1.0 } else { -1.0 };
                self.set(cell, &Surface { normal: n, ..wall(n) });
            }
        }
    }

    /// The shell of a block, faces on the outer sides of cells, normals outwards; one face has the edge.
    pub fn block(&mut self, low: [i32; 3], high: [i32; 3], surface: &Surface) {
        let (first, last) = (IVec3::from(low), IVec3::from(high) - 1);
        for cell in cells(low, high) {
            let side = |m: glam::BVec3| Vec3::select(m, Vec3::ONE, Vec3::ZERO);
            let normal = side(cell.cmpeq(last)) - side(cell.cmpeq(first));
            if normal != Vec3::ZERO {
                let axis = (0..3).find(|k| normal[*k] != 0.0).unwrap_or(0);
                let normal = Vec3::AXES[axis] * normal[axis];
                self.set(cell, &Surface { normal, contour: 0.5, ..*surface });
            }
        }
    }

    pub fn build(&self) -> CpuVoxels {
        let layout =
            Layout { origin: ORIGIN, voxel_size: VOXEL, cells: [self.size as u32; 3], low: IVec3::ZERO };
        let grid = CpuGrid::new(&layout, self.records.keys().map(|c| IVec3::from(*c)));
        let mut records = vec![[0; 4]; grid.voxel_count as usize];
        for (cell, record) in &self.records {
            records[grid.record(IVec3::from(*cell)).unwrap() as usize] = *record;
        }
        CpuVoxels { grid, records }
    }
}

/// Both lobes as the device made them.
pub struct Traced {
    pub lobes: [Vec<[f32; 4]>; 2],
    /// Bits of the half floats, for tests of equality.
    pub bits: [Vec<[u16; 4]>; 2],
    pub samples: Vec<u32>,
    pub log: FrameLog,
}

impl Traced {
    /// Mean of one lobe over all pixels and channels, and its standard error from the spread over pixels.
    pub fn mean(&self, lobe: usize) -> (f64, f64) {
        statistics(self.lobes[lobe].iter().map(|p| f64::from(p[0] + p[1] + p[2]) / 3.0))
    }
}

/// Mean and standard error.
pub fn statistics(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let count = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / count;
    let variance = values.map(|v| (v - mean).powi(2)).sum::<f64>() / (count - 1.0);
    (mean, (variance / count).sqrt())
}

/// A device, and the light that is no voxel.
pub struct Fixture {
    pub gpu: Gpu,
    pub scene: GpuScene,
    pub sky: Sky,
    pub lights: Vec<Light>,
    pub table: BrdfTable,
    pub frame: FrameInfo,
    /// Kept, so that its kernels are compiled once.
    pub tracer: RefCell<VoxelTracer>,
    /// What the voxels keep, from the first frame that asks for it on.
    pub cache: RefCell<Option<RadianceCache>>,
}

impl Fixture {
    /// A camera of 48 by 32 pixels at `eye` looking at `target`.
    pub fn new(sky: Sky, sun: Option<Sun>, punctual: &[PunctualLight], eye: Vec3, target: Vec3) -> Self {
        let gpu = Gpu::new(None).expect("this test needs an adapter");
        let mut source = scene::Scene::load("cornell").unwrap();
        source.sky = sky.clone();
        source.sun = sun;
        let mut geometry = source.rest().clone();
        geometry.lights.extend_from_slice(punctual);
        let (mut scene, _) = GpuScene::new(&gpu, &source, &geometry, &SceneOptions::default()).unwrap();
        // The box has no gloss and no glass; the cells may.
        scene.needs.specular = true;
        scene.needs.transmission = true;
        scene.needs.coverage = true;
        scene.needs.shadow_rays = scene.light_count > 0;
        let lights = gpu.read_buffer(&scene.lights).unwrap()[..scene.light_count as usize].to_vec();
        let camera = Camera { name: String::new(), eye, target, up: Vec3::new(0.1, 1.0, 0.2), vfov: 1.0 };
        let frame = FrameInfo {
            camera: camera.clone(),
            previous_camera: camera,
            trace_size: [48, 32],
            display_size: [96, 64],
            jitter: [0.25, -0.125],
            previous_jitter: [0.0; 2],
            frame_index: 0,
            seed: 1,
            time: 0.0,
            dt: 0.0,
            radiance_scale: scene.radiance_scale,
            diagonal: 10.0,
            restart: true,
            sun_elsewhere: false,
        };
        Self {
            gpu,
            scene,
            sky,
            lights,
            table: BrdfTable::new(),
            frame,
            tracer: RefCell::default(),
            cache: RefCell::default(),
        }
    }

    /// What the camera sees of the cells' cubes.
    pub fn gbuffer(&self, voxels: &CpuVoxels) -> Image<Texel> {
        let uniform = self.frame.uniform();
        Image::from_fn(self.frame.trace_size, |x, y| {
            let direction = view_direction(&uniform, UVec2::new(x, y));
            let eye = self.frame.camera.eye;
            let ray = Ray { origin: eye, direction, distance: 1e3, own: NO_OWN };
            let Some(hit) = voxels.trace(&ray, &mut Tally::default()) else {
                return Texel::default();
            };
            let is_back = hit.surface.normal.dot(direction) > 0.0;
            Texel {
                surface: Surface { normal: hit.face, ..hit.surface }.pack_gbuffer(hash(x + 4096 * y)),
                distance: hit.distance,
                face_normal: face_normal_pack(hit.entry),
                motion_id: [0, 1 | (u32::from(is_back) << 31)],
            }
        })
    }

    /// Moves the camera.
    pub fn look(&mut self, eye: Vec3, target: Vec3) {
        self.frame.camera = Camera { eye, target, ..self.frame.camera.clone() };
    }

    /// On the CPU, a share of the pixels per processor.
    pub fn twin(
        &self,
        voxels: &CpuVoxels,
        texels: &Image<Texel>,
        settings: &PathSettings,
    ) -> (Vec<Pixel>, Tally) {
        let uniform = self.frame.uniform();
        let world = CpuWorld {
            frame: &uniform,
            structure: voxels,
            sky: &self.sky,
            lights: &self.lights,
            table: &self.table,
        };
        let params = PathParams {
            sample: 0,
            samples: settings.most_samples(),
            first_sample: self.frame.frame_index.wrapping_mul(settings.most_samples()),
            bounces: settings.bounces.unwrap_or(ENDLESS),
            lights: self.lights.len() as u32,
            rule: settings.samples as u32,
            roulette_from: if settings.bounces.is_some() { u32::MAX } else { settings.roulette_from },
            segments: 1,
            branch: u32::from(settings.both_branches && self.scene.needs.transmission),
            ..PathParams::default()
        };
        let width = texels.size()[0];
        let all = texels.texels().len();
        let workers = std::thread::available_parallelism().map_or(1, usize::from);
        let share = all.div_ceil(workers);
        let work = &|from: usize| {
            let mut tally = Tally::default();
            let traced = |index: usize| {
                let pixel = UVec2::new(index as u32 % width, index as u32 / width);
                world.pixel(&params, pixel, &texels.texels()[index], &mut tally)
            };
            let pixels: Vec<Pixel> = (from..all.min(from + share)).map(traced).collect();
            (pixels, tally)
        };
        let parts: Vec<(Vec<Pixel>, Tally)> = std::thread::scope(|scope| {
            let workers: Vec<_> =
                (0..all).step_by(share).map(|from| scope.spawn(move || work(from))).collect();
            workers.into_iter().map(|worker| worker.join().unwrap()).collect()
        });
        let mut total = Tally::default();
        for (_, tally) in &parts {
            total.rays += tally.rays;
            total.cut += tally.cut;
            total.iterations += tally.iterations;
            total.paths += tally.paths;
        }
        (parts.into_iter().flat_map(|(pixels, _)| pixels).collect(), total)
    }

    /// On the device.
    pub fn traced(&self, voxels: &CpuVoxels, texels: &Image<Texel>, settings: &PathSettings) -> Traced {
        let tracer = &mut *self.tracer.borrow_mut();
        let gpu = &self.gpu;
        let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        let grid = &voxels.grid.grid;
        let grid = VoxelGrid {
            cells: grid.cells.map(|n| n as u32),
            voxel_size: grid.voxel_size,
            origin: Vec3::from(grid.origin),
            structure: gpu.storage(Room::Voxels, "structure", &voxels.grid.structure).unwrap(),
            records: gpu.storage(Room::Voxels, "records", &voxels.records).unwrap(),
            uniform: gpu.buffer(Room::Voxels, "uniform", size_of_val(grid) as u64, usage).unwrap(),
            record: RecordLayout::FULL,
            levels: 1,
            contours: grid.contours != 0,
            voxel_count: voxels.grid.voxel_count,
            brick_count: 0,
            glowing: glowing(voxels),
        };
        let lights = LightList::of_voxels(gpu, &self.scene, &grid).unwrap();
        let mut cache = self.cache.borrow_mut();
        if settings.build.cache {
            cache.get_or_insert_with(|| RadianceCache::new(gpu, &grid).unwrap());
        }
        gpu.queue.write_buffer(&grid.uniform, 0, bytemuck::bytes_of(&voxels.grid.grid));
        let gbuffer = GBuffer {
            surface: self.channel(texels, GBuffer::FORMATS[0], |t| t.surface),
            distance: self.channel(texels, GBuffer::FORMATS[1], |t| t.distance),
            face_normal: self.channel(texels, GBuffer::FORMATS[2], |t| t.face_normal),
            motion_id: self.channel(texels, GBuffer::FORMATS[3], |t| t.motion_id),
        };
        tracer.resize(gpu, &self.scene, self.frame.trace_size, settings).unwrap();
        let mut recorder = Recorder::new(gpu);
        let uniform = recorder.uniform(&self.frame.uniform());
        let world = World {
            scene: &self.scene,
            mesh: &self.scene.mesh,
            grid: Some(&grid),
            lbvh: None,
            cwbvh: None,
            grid_lights: Some(&lights),
            cache: cache.as_ref(),
            triangle_lights: None,
        };
        let light = tracer.trace(&mut recorder, &self.frame, &uniform, world, &gbuffer, settings);
        let log = recorder.finish().unwrap();
        let bits = [&light.diffuse, light.specular.as_ref().unwrap()].map(|t| gpu.read_texture(t).unwrap());
        let float = |texel: &[u16; 4]| texel.map(|half| f16::from_bits(half).to_f32());
        let lobes = [0, 1].map(|lobe| bits[lobe].iter().map(float).collect());
        Traced { lobes, bits, samples: gpu.read_texture(&light.samples).unwrap(), log }
    }

    fn channel<T: bytemuck::Pod>(
        &self,
        texels: &Image<Texel>,
        format: wgpu::TextureFormat,
        of: impl Fn(&Texel) -> T,
    ) -> Texture {
        let [width, height] = texels.size();
        let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST;
        let texture =
            self.gpu.texture(Room::GBuffer, "channel", [width, height, 1], 1, format, usage).unwrap();
        let values: Vec<T> = texels.texels().iter().map(of).collect();
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(width * size_of::<T>() as u32),
            rows_per_image: None,
        };
        self.gpu.queue.write_texture(
            texture.as_image_copy(),
            bytemuck::cast_slice(&values),
            layout,
            texture.size(),
        );
        texture
    }
}

/// The cells that give off light.
fn glowing(voxels: &CpuVoxels) -> Vec<Glowing> {
    let size = voxels.grid.grid.cells;
    let luminance = |cell| {
        let record = voxels.grid.record(cell)?;
        let emission = Surface::unpack_voxel(voxels.records[record as usize]).emission;
        let luminance = frame::cpu::luminance(emission.to_array());
        let cell = cell.to_array().map(|c| c as u32);
        (luminance > 0.0).then_some(Glowing { cell, level: 0, face_share: 1.0, luminance })
    };
    cells([0; 3], size).filter_map(luminance).collect()
}

/// Mean of a twin's lobe over pixels and channels.
pub fn twin_mean(pixels: &[Pixel], lobe: usize) -> f64 {
    statistics(pixels.iter().map(|p| p.lobes[lobe].truncate().dot(DVec3::splat(1.0 / 3.0)))).0
}
