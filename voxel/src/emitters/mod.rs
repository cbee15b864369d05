//! Keeps the power of each emitter: the factor that every voxel's emission is multiplied with.
//!
//! Paper: voxels hold "emissivity"; it says nothing about power, which a voxel's cube would change.
//!
//! In: the mesh (world, m) as it is on the device, and which objects glow. Out: per voxel of an emitter a factor, handed
//! to the list that resolve reads. Two steps, both on the CPU with the raster reference, each emitter alone:
//!
//! 1. **Share**: the part of the voxel's column, along the axis the winner's normal is longest on, that the object's
//!    triangles cover on the winner's side, 0..1. Triangles count for the cell that their plane passes at the column's
//!    centre; so the two triangles of a quadrilateral add up along their diagonal.
//! 2. **Factor** of the emitter: the light that leaves its triangles over the light that leaves its voxels, by [`flux`].
//!
//! Emission is taken as uniform over the object; a texture's pattern is in the records. Where emitters share a cell the
//! winner's factor counts. An emitter that covers no column's centre has no voxels: it is lost, and counted.
//!
//! [`LINES`] lines are cast per emitter while there are at most 16; beyond, [`ALL_LINES`] are shared, down to 2^10 each
//! from 4,096 emitters on. Emitters are counted on all cores, one per thread.

mod cast;
pub mod flux;
mod levels;
#[cfg(test)]
mod tests;

pub(crate) use levels::Lamps;

use crate::compute::reference::Sat;
use crate::grid::reference::CpuGrid;
use crate::grid::{GRID_BINDS, GRID_WGSL, Glowing, Layout};
use crate::raster::Axes;
use crate::raster::reference::Columns;
use crate::record::RecordLayout;
use crate::structure::{Batch, rows};
use crate::{Cover, Grid, VoxelGrid};
use flux::Lit;
use frame::scene_gpu::{GpuMesh, GpuScene};
use frame::surface::Surface;
use frame::{Bind, Buffer, Gpu, GpuError, Kernel, KernelDesc, KernelError, Recorder, Room, surface};
use glam::{IVec3, Vec3};
use std::collections::{BTreeMap, HashMap};
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Lines per emitter.
pub const LINES: u32 = 1 << 18;
/// Lines of all emitters together, but for the least that each gets.
pub const ALL_LINES: u32 = 1 << 22;
const LEAST_LINES: u32 = 1 << 10;

/// Numbers of the lines that factors are counted with.
const SEED: u32 = 1;

frame::gpu_struct! {
    /// See `emitters.wgsl`.
    pub struct EmittersParams {
        /// Voxels of emitters.
        pub count: u32,
        /// Invocations per row of the dispatch.
        pub row: u32,
        /// Records before the batch.
        pub first_record: u32,
        /// Records of the batch.
        pub record_count: u32,
    }
}

/// The pass that hands factors to records, and the one that reads what became of them.
pub(crate) struct Emitters {
    kernel: Kernel,
    glowing: Kernel,
}

/// Factors of emitters, by cell.
pub(crate) struct Factors {
    voxels: Buffer,
    cells: Vec<[u32; 3]>,
    count: u32,
}

impl Emitters {
    pub(crate) fn new(gpu: &Gpu, record: RecordLayout) -> Result<Self, KernelError> {
        let kernel = Kernel::new(
            gpu,
            &KernelDesc {
                name: "voxel/emitters",
                sources: &[surface::WGSL, GRID_WGSL, include_str!("emitters.wgsl")],
                entry: "emitters",
                workgroup: [64, 1, 1],
                bindings: &[
                    Bind::uniform::<EmittersParams>(0, 1, "params"),
                    Bind::storage_read(1, 16, "grid_structure"),
                    Bind::uniform::<Grid>(1, 18, "grid"),
                    Bind::storage_read(2, 0, "in_voxels"),
                    Bind::storage(3, 0, "out_list"),
                ],
                constants: &[],
            },
        )?;
        let [of_structure, of_records, of_grid] = GRID_BINDS;
        let mut sources = vec![surface::WGSL, GRID_WGSL];
        sources.extend(record.sources());
        sources.push(include_str!("glowing.wgsl"));
        let glowing = Kernel::new(
            gpu,
            &KernelDesc {
                name: "voxel/glowing",
                sources: &sources,
                entry: "glowing",
                workgroup: [64, 1, 1],
                bindings: &[
                    Bind::uniform::<EmittersParams>(0, 1, "params"),
                    of_structure,
                    of_records,
                    of_grid,
                    Bind::storage_read(2, 0, "in_voxels"),
                    Bind::storage(3, 1, "out_luminances"),
                ],
                constants: &[],
            },
        )?;
        Ok(Self { kernel, glowing })
    }

    /// Counts the emitters among a run of triangles, each alone; none where nothing glows. Reads that part of the mesh
    /// back.
    pub(crate) fn count(
        gpu: &Gpu,
        scene: &GpuScene,
        mesh: &GpuMesh,
        triangles: Range<u32>,
        layout: &Layout,
        cover: Cover,
    ) -> Result<Vec<Counted>, GpuError> {
        if scene.emitters.is_empty() || triangles.is_empty() {
            return Ok(Vec::new());
        }
        let lines = (ALL_LINES / scene.emitters.len() as u32).clamp(LEAST_LINES, LINES);
        Ok(counted(layout, cover, &ReadMesh::new(gpu, scene, mesh, triangles)?, lines))
    }

    /// Factors of emitters that were counted; none where nothing glows.
    pub(crate) fn factors<'a>(
        gpu: &Gpu,
        counted: impl IntoIterator<Item = &'a Counted>,
    ) -> Result<Option<Factors>, GpuError> {
        let voxels = won(counted);
        if voxels.is_empty() {
            return Ok(None);
        }
        let buffer = gpu.storage(Room::Voxels, "Emitters::voxels", &voxels)?;
        let cells = voxels.iter().map(|[x, y, z, _]| [*x, *y, *z]).collect();
        Ok(Some(Factors { voxels: buffer, cells, count: voxels.len() as u32 }))
    }

    /// The voxels that give off light, once all records are made. Waits for the device.
    pub(crate) fn glowing(
        &self,
        gpu: &Gpu,
        factors: &Factors,
        grid: &VoxelGrid,
    ) -> Result<Vec<Glowing>, GpuError> {
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
        let bytes = 4 * u64::from(factors.count);
        let luminances = gpu.buffer(Room::Voxels, "Emitters::luminances", bytes, usage)?;
        let mut recorder = Recorder::new(gpu);
        let (workgroups, row) = rows(factors.count);
        let params =
            recorder.uniform(&EmittersParams { count: factors.count, row, ..EmittersParams::default() });
        let mut resources = vec![params.binding()];
        resources.extend(grid.resources());
        resources.extend([factors.voxels.as_entire_binding(), luminances.as_entire_binding()]);
        recorder.compute("voxel/glowing", &self.glowing, &resources, workgroups);
        recorder.finish()?;
        let luminances: Vec<f32> = gpu.read_buffer(&luminances)?;
        let all = factors.cells.iter().zip(luminances);
        let mut glowing: Vec<Glowing> = all
            .filter(|(_, luminance)| *luminance > 0.0)
            .map(|(cell, luminance)| Glowing { cell: *cell, level: 0, face_share: 1.0, luminance })
            .collect();
        // The factors come out of a hash map: in which order, differs from run to run.
        glowing.sort_by_key(|g| g.cell);
        Ok(glowing)
    }

    /// The voxels that give off light where planes are met and not cubes: whatever record shines, as it is. Waits for the
    /// device.
    pub(crate) fn glowing_planes(
        gpu: &Gpu,
        layout: &Layout,
        grid: &VoxelGrid,
    ) -> Result<Vec<Glowing>, GpuError> {
        let structure = gpu.read_buffer(&grid.structure)?;
        let records = grid.record.expand(&gpu.read_buffer(&grid.records)?);
        let cpu = CpuGrid { grid: layout.uniform(0), structure, voxel_count: grid.voxel_count };
        let glows = |cell: IVec3| {
            let record = *records.get(cpu.record(cell)? as usize)?;
            let luminance = frame::cpu::luminance(Surface::unpack_voxel(record).emission.to_array());
            let cell = cell.to_array().map(|c| c as u32);
            (luminance > 0.0).then_some(Glowing { cell, level: 0, face_share: 1.0, luminance })
        };
        let mut glowing: Vec<Glowing> = cpu.cells().into_iter().filter_map(glows).collect();
        glowing.sort_by_key(|g| g.cell);
        Ok(glowing)
    }

    /// Hands the factors of a batch's records to their list.
    pub(crate) fn record(
        &self,
        recorder: &mut Recorder<'_>,
        factors: &Factors,
        batch: &Batch<'_>,
        records: Range<u32>,
        list: &Buffer,
    ) {
        let (workgroups, row) = rows(factors.count);
        let (first_record, record_count) = (records.start, records.len() as u32);
        let params =
            recorder.uniform(&EmittersParams { count: factors.count, row, first_record, record_count });
        let [structure, uniform, voxels, list] =
            [batch.structure, batch.uniform, &factors.voxels, list].map(|b| b.as_entire_binding());
        let resources = [params.binding(), structure, uniform, voxels, list];
        recorder.compute(&format!("{}/emitters", batch.stage), &self.kernel, &resources, workgroups);
    }
}

/// The glowing part of a mesh, read back.
struct ReadMesh {
    vertices: Vec<u32>,
    /// Number of the first of them.
    first_vertex: u32,
    stride: usize,
    /// Number and vertices of each triangle, by object.
    objects: BTreeMap<u32, Vec<(u32, [u32; 3])>>,
}

impl ReadMesh {
    fn new(gpu: &Gpu, scene: &GpuScene, mesh: &GpuMesh, range: Range<u32>) -> Result<Self, GpuError> {
        // A triangle's record has 16 bits for its object.
        let mut objects: BTreeMap<_, _> =
            scene.emitters.iter().map(|e| (e.object.min(0xffff), Vec::new())).collect();
        let triangles: Vec<[u32; 4]> =
            read(gpu, &mesh.triangles, 16 * u64::from(range.start)..16 * u64::from(range.end))?;
        let (mut first_vertex, mut end_vertex) = (u32::MAX, 0);
        for (number, [a, b, c, names]) in range.zip(triangles) {
            if let Some(object) = objects.get_mut(&(names >> 16)) {
                object.push((number, [a, b, c]));
                first_vertex = first_vertex.min(a).min(b).min(c);
                end_vertex = end_vertex.max(a + 1).max(b + 1).max(c + 1);
            }
        }
        // Those whose triangles are elsewhere.
        objects.retain(|_, triangles| !triangles.is_empty());
        let stride = mesh.layout.stride;
        let bytes = |vertex: u32| (4 * u64::from(stride) * u64::from(vertex)).min(mesh.vertices.bytes());
        let vertices = if objects.is_empty() {
            Vec::new()
        } else {
            read(gpu, &mesh.vertices, bytes(first_vertex)..bytes(end_vertex))?
        };
        Ok(Self { vertices, first_vertex, stride: stride as usize, objects })
    }

    /// What `work` makes of each object, given its place among them and its triangles; on all cores.
    fn each<T: Send>(&self, work: impl Fn(usize, &[(u32, [u32; 3])]) -> T + Sync) -> Vec<T> {
        let objects: Vec<_> = self.objects.values().collect();
        let next = AtomicUsize::new(0);
        let run = || {
            let mut done = Vec::new();
            loop {
                let at = next.fetch_add(1, Ordering::Relaxed);
                let Some(triangles) = objects.get(at) else { break };
                done.push((at, work(at, triangles)));
            }
            done
        };
        let threads = std::thread::available_parallelism().map_or(1, usize::from).min(objects.len());
        let mut done: Vec<_> = std::thread::scope(|scope| {
            let workers: Vec<_> = (0..threads).map(|_| scope.spawn(run)).collect();
            let join = |w: std::thread::ScopedJoinHandle<'_, Vec<(usize, T)>>| {
                w.join().unwrap_or_else(|e| std::panic::resume_unwind(e))
            };
            workers.into_iter().flat_map(join).collect()
        });
        done.sort_by_key(|(at, _)| *at);
        done.into_iter().map(|(_, made)| made).collect()
    }

    /// The first words of a vertex: position and packed normal. Zeros where a triangle names none.
    fn vertex(&self, vertex: u32) -> (Vec3, Vec3) {
        let at = (vertex - self.first_vertex) as usize * self.stride;
        let words = self.vertices.get(at..).and_then(|words| words.first_chunk());
        let [x, y, z, normal] = words.copied().unwrap_or([0; 4]);
        (Vec3::from([x, y, z].map(f32::from_bits)), surface::face_normal_unpack(normal))
    }
}

/// Part of a buffer, read back once everything submitted so far is done.
fn read<T: bytemuck::Pod>(gpu: &Gpu, buffer: &Buffer, bytes: Range<u64>) -> Result<Vec<T>, GpuError> {
    let usage = wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
    let part = gpu.buffer(Room::Frame, buffer.label(), bytes.end - bytes.start, usage)?;
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    encoder.copy_buffer_to_buffer(buffer, bytes.start, &part, 0, bytes.end - bytes.start);
    gpu.queue.submit([encoder.finish()]);
    gpu.read_buffer(&part)
}

/// A triangle's part in a column.
struct Part {
    cell: IVec3,
    side: Side,
    cover: f32,
    /// If the column's centre is covered.
    vote: Option<Vote>,
}

/// An axis, and whether the front looks along it.
type Side = (usize, bool);

/// What a triangle brings into a cell.
#[derive(Clone, Copy)]
struct Vote {
    key: u32,
    normal: Vec3,
    /// Along the axis its normal is longest on.
    dominant: Side,
}

/// One emitter's voxels with the keys they won with.
pub(crate) struct Counted {
    voxels: Vec<(Lit, u32)>,
    factor: f32,
}

impl Counted {
    /// Whether nothing of it is left: it is too small for the grid, or outside.
    pub(crate) fn is_lost(&self) -> bool {
        self.voxels.is_empty()
    }
}

/// Counts every emitter of a mesh.
fn counted(layout: &Layout, cover: Cover, mesh: &ReadMesh, lines: u32) -> Vec<Counted> {
    mesh.each(|_, triangles| alone(layout, cover, mesh, triangles).counted(lines))
}

/// Cell and factor of every emitter's voxels. The key decides between emitters in one cell, whatever order threads
/// finished in.
fn won<'a>(counted: impl IntoIterator<Item = &'a Counted>) -> Vec<[u32; 4]> {
    let mut winners: HashMap<IVec3, (u32, f32)> = HashMap::new();
    for emitter in counted {
        for (lit, key) in &emitter.voxels {
            let won = (*key, lit.share * emitter.factor);
            winners.entry(lit.cell).and_modify(|w| *w = if won.0 < w.0 { won } else { *w }).or_insert(won);
        }
    }
    winners
        .into_iter()
        .map(|(cell, (_, factor))| {
            // No bits at all would mean that nothing was counted.
            let factor = factor.max(f32::MIN_POSITIVE).to_bits();
            [cell.x as u32, cell.y as u32, cell.z as u32, factor]
        })
        .collect()
}

/// An emitter alone in a grid.
struct Alone {
    voxels: Vec<(Lit, u32)>,
    /// Triangles in cells, and their area in cell faces.
    triangles: Vec<[Vec3; 3]>,
    area: f64,
}

impl Alone {
    fn factor(self, lines: u32) -> f32 {
        let lit: Vec<Lit> = self.voxels.iter().map(|(lit, _)| *lit).collect();
        flux::factor(&lit, self.triangles, self.area, lines, SEED)
    }

    fn counted(self, lines: u32) -> Counted {
        let voxels = self.voxels.clone();
        Counted { voxels, factor: self.factor(lines) }
    }
}

fn alone(layout: &Layout, cover: Cover, mesh: &ReadMesh, triangles: &[(u32, [u32; 3])]) -> Alone {
    let (mut parts, mut area, mut in_cells) = (Vec::new(), 0.0, Vec::new());
    for &(number, vertices) in triangles {
        let corners = vertices.map(|v| mesh.vertex(v));
        let [a, b, c] = corners.map(|(position, _)| (position - layout.corner()) / layout.voxel_size);
        if ![a, b, c].iter().all(|p| p.is_finite()) {
            continue;
        }
        let face = (b - a).as_dvec3().cross((c - a).as_dvec3());
        area += 0.5 * face.length();
        in_cells.push([a, b, c]);
        let normal = |columns: &Columns, [u, v]: [i32; 2]| {
            let weights = columns.weights(u, v);
            let [m, n, o] = corners.map(|(_, normal)| normal);
            let normal = (weights.x * m + weights.y * n + weights.z * o).try_normalize();
            normal.unwrap_or(face.normalize_or_zero().as_vec3())
        };
        let positions = corners.map(|(position, _)| position);
        let Cover::Columns(axes) = cover else {
            let Some(sat) = Sat::new(layout, positions, cover) else { continue };
            for columns in Columns::all(layout, positions, Axes::Dominant) {
                for cell in sat.cells(layout) {
                    let [u, v] = columns.column(cell);
                    let (key, dominant) = (sat.key(cell, 0, number), columns.side());
                    let vote = Some(Vote { key, normal: normal(&columns, [u, v]), dominant });
                    parts.push(Part { cell, side: dominant, cover: columns.cover(u, v) as f32, vote });
                }
            }
            continue;
        };
        let all = Columns::all(layout, positions, axes);
        for columns in &all {
            for [u, v] in columns.bounds(layout) {
                let (cover, cell) = (columns.cover(u, v) as f32, columns.cell(u, v));
                if cover <= 0.0 || !layout.contains(cell) {
                    continue;
                }
                let vote = columns.covers(u, v).then(|| {
                    let key = columns.key(u, v, 0, number);
                    Vote { key, normal: normal(columns, [u, v]), dominant: all[0].side() }
                });
                parts.push(Part { cell, side: columns.side(), cover, vote });
            }
        }
    }
    parts.sort_unstable_by_key(|p| (p.cell.to_array(), p.vote.map_or(u32::MAX, |vote| vote.key)));
    let mut voxels = Vec::new();
    for in_cell in parts.chunk_by(|a, b| a.cell == b.cell) {
        if let Some(Part { cell, side, vote: Some(vote), .. }) = in_cell.first() {
            let covered =
                |side: Side| in_cell.iter().filter(|p| p.side == side).map(|p| p.cover).sum::<f32>();
            let along = covered(vote.dominant);
            // A cell that only another axis found, at an edge, has no column along the dominant one.
            let share = if along > 0.0 { along } else { covered(*side) };
            voxels.push((Lit { cell: *cell, normal: vote.normal, share: share.min(1.0) }, vote.key));
        }
    }
    Alone { voxels, triangles: in_cells, area }
}
