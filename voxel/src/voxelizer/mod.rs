//! The whole way from triangles to a [`VoxelGrid`], once at load.
//!
//! mark bricks -> scan -> slots and skip levels -> per batch of bricks: vote until nothing changes -> masks -> scan ->
//! list -> factors of emitters -> bends -> resolve. Sizes are read back where the next buffer depends on them, so everything is
//! allocated exactly; keys and lists are given back at the end. Where something moves, this is the way of what stands
//! still, and [`crate::revoxelize`] adds the rest frame by frame.

mod knobs;

use crate::bend::BEND_WORDS;
use crate::cascades::Merger;
use crate::cover::{Finders, Found};
use crate::emitters::{Counted, Emitters, Factors};
use crate::grid::{BRICK_CELLS, Layout};
use crate::raster::{Input, MOST_TRIANGLES, Raster, Rounds};
use crate::record::RecordLayout;
use crate::resolve::{self, ResolveParams};
use crate::revoxelize::{Rest, Revoxelizer};
use crate::structure::{Batch, Structure, Sums, rows};
use crate::{Cover, Grid, VoxelError, VoxelGrid};
use frame::scene_gpu::{GpuMesh, GpuScene};
use frame::{Buffer, FrameLog, Gpu, GpuError, Kernel, Recorder, Room};
use glam::IVec3;
use scene::Aabb;
use std::ops::Range;
use wgpu::BufferUsages;

/// Bricks whose keys fill the 128 MiB that a binding may have by default.
const MOST_SLOTS: u32 = 65_536;

/// Turns triangles into voxels.
pub struct Voxelizer {
    pub(crate) finders: Finders,
    pub(crate) structure: Structure,
    pub(crate) emitters: Emitters,
    pub(crate) resolve: Kernel,
    /// Made when something moves.
    pub(crate) revoxelizer: Option<Revoxelizer>,
    /// Made when a level of [`crate::cascades`] moves.
    pub(crate) merger: Option<Merger>,
    elevation: u32,
    voxelizer: u32,
    cover: u32,
    axes: u32,
    contours: u32,
    rebuild: u32,
    pub(crate) cascades: u32,
    /// Bricks whose keys are held at a time.
    pub(crate) slots_per_batch: u32,
}

/// What all batches share.
struct Build<'a> {
    input: Input<'a>,
    record: RecordLayout,
    factors: Option<Factors>,
    structure: Buffer,
    bricks: Buffer,
    keys: Buffer,
    rounds: Rounds,
    found: Found,
    /// Whether the winner of each voxel is kept.
    keeps: bool,
}

/// What is to be built.
pub(crate) struct Order<'a> {
    pub(crate) scene: &'a GpuScene,
    pub(crate) mesh: &'a GpuMesh,
    /// Of the mesh.
    pub(crate) triangles: Range<u32>,
    pub(crate) layout: Layout,
    /// Whether the winner of each voxel is kept.
    pub(crate) keeps: bool,
    /// Bricks that are left out: the first, and one behind the last.
    pub(crate) kept: [IVec3; 2],
    /// Emitters, where they are counted already.
    pub(crate) counted: Option<Vec<Counted>>,
}

impl<'a> Order<'a> {
    /// A grid around bounds.
    ///
    /// # Errors
    /// A grid or bounds that cannot be.
    pub(crate) fn of(
        gpu: &Gpu,
        scene: &'a GpuScene,
        mesh: &'a GpuMesh,
        bounds: Aabb,
        grid: u32,
    ) -> Result<Self, VoxelError> {
        let layout = Layout::fit(bounds, grid, gpu.device.limits().max_texture_dimension_2d)?;
        let triangles = 0..mesh.triangle_count;
        Ok(Self { scene, mesh, triangles, layout, keeps: false, kept: [IVec3::ZERO; 2], counted: None })
    }
}

/// What a build leaves.
pub(crate) struct Built {
    pub(crate) grid: VoxelGrid,
    layout: Layout,
    /// Per record the key of its winner; empty unless they are kept.
    kept: Buffer,
    /// Its bends; empty unless they are kept.
    bends: Buffer,
    pub(crate) counted: Vec<Counted>,
    factors: Option<Factors>,
    pub(crate) log: FrameLog,
}

/// A batch's part of what is joined at the end.
struct Part {
    records: Buffer,
    count: u32,
    /// Keys of winners and bends.
    kept: Option<[Buffer; 2]>,
    slot_count: u32,
}

impl Voxelizer {
    /// Builds all kernels for scenes whose vertices are laid out as this one's and whose textures are in the same arrays.
    ///
    /// # Errors
    /// The driver refuses a kernel.
    pub fn new(gpu: &Gpu, scene: &GpuScene) -> Result<Self, VoxelError> {
        Ok(Self {
            finders: Finders::new(gpu, scene)?,
            structure: Structure::new(gpu)?,
            emitters: Emitters::new(gpu, RecordLayout::of(&scene.needs))?,
            resolve: resolve::kernel(gpu, scene)?,
            revoxelizer: None,
            merger: None,
            elevation: 0,
            voxelizer: 0,
            cover: 0,
            axes: 0,
            contours: 0,
            rebuild: 0,
            cascades: 1,
            slots_per_batch: MOST_SLOTS,
        })
    }

    /// Whether a grid of this mesh is to keep what stands still apart from what moves.
    pub fn follows(&self, mesh: &GpuMesh) -> bool {
        self.rebuild == 0 && self.cascades == 1 && mesh.static_triangle_count < mesh.triangle_count
    }

    /// Voxelizes a mesh within bounds, `grid` cells on the longest axis. The log's counts are `voxels`, `bricks`,
    /// `raster_rounds`, `atomic_rounds` (0 unless plain stores did not settle) and `lost_emitters`.
    ///
    /// # Errors
    /// A grid, bounds or a number of triangles that cannot be, or what the device refuses.
    pub fn voxelize(
        &mut self,
        gpu: &Gpu,
        scene: &GpuScene,
        mesh: &GpuMesh,
        bounds: Aabb,
        grid: u32,
    ) -> Result<(VoxelGrid, FrameLog), VoxelError> {
        let built = self.build(gpu, Order::of(gpu, scene, mesh, bounds, grid)?)?;
        Ok((built.grid, built.log))
    }

    /// The same for the triangles that never move, with what [`Voxelizer::revoxelize`] adds the others by.
    ///
    /// # Errors
    /// As [`Voxelizer::voxelize`].
    pub fn voxelize_rest(
        &mut self,
        gpu: &Gpu,
        scene: &GpuScene,
        mesh: &GpuMesh,
        bounds: Aabb,
        grid: u32,
    ) -> Result<(VoxelGrid, Rest, FrameLog), VoxelError> {
        if self.revoxelizer.is_none() {
            self.revoxelizer = Some(Revoxelizer::new(gpu, scene)?);
        }
        let order = Order::of(gpu, scene, mesh, bounds, grid)?;
        let triangles = 0..mesh.static_triangle_count;
        let built = self.build(gpu, Order { triangles, keeps: true, ..order })?;
        let Built { grid, layout, kept, bends, counted, factors, log } = built;
        let rest = Rest::new(gpu, scene, &layout, mesh, &grid, [kept, bends], counted, factors)?;
        Ok((grid, rest, log))
    }

    /// One grid, whatever it is for.
    pub(crate) fn build(&mut self, gpu: &Gpu, order: Order<'_>) -> Result<Built, VoxelError> {
        let Order { scene, mesh, triangles: of_mesh, layout, keeps, kept, counted } = order;
        let triangles = u64::from(mesh.triangle_count);
        if triangles > MOST_TRIANGLES {
            return Err(VoxelError::Triangles { triangles, most: MOST_TRIANGLES });
        }
        // Marks and table have a word per brick cell: their number must be one.
        let brick_cells = u32::try_from(layout.brick_cells()).map_err(|_| GpuError::TooLarge {
            what: "VoxelGrid::structure".into(),
            needed: 4 * layout.brick_cells(),
            allowed: gpu.device.limits().max_storage_buffer_binding_size,
            unit: "bytes",
            advice: "lower --grid",
        })?;
        let contours = self.contours == 1;
        match self.cover() {
            Cover::Boxes => {}
            _ if !contours => {}
            Cover::Conservative => return Err(VoxelError::ComputedContours),
            Cover::Columns(_) | Cover::Thin => return Err(VoxelError::ThinContours),
        }
        let record = RecordLayout::of(&scene.needs);
        let shared = Grid {
            contours: self.contours,
            record_words: record.words(),
            ..layout.uniform(self.elevation())
        };
        let usage = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
        let uniform = gpu.buffer(Room::Voxels, "VoxelGrid::uniform", size_of::<Grid>() as u64, usage)?;
        gpu.queue.write_buffer(&uniform, 0, bytemuck::bytes_of(&shared));
        let target = Raster::target(gpu, layout.longest())?;
        let cover = self.cover();
        let stage = match cover {
            Cover::Columns(_) | Cover::Boxes => "voxel/raster",
            Cover::Thin | Cover::Conservative => "voxel/compute",
        };
        self.finders.prepare(gpu, scene, cover)?;
        let input = Input {
            stage,
            scene,
            mesh,
            triangles: of_mesh.clone(),
            uniform: &uniform,
            target: &target,
            cover,
            bend: self.bend(),
            kept,
        };

        let mut recorder = Recorder::new(gpu);
        let marks = words(gpu, "Voxelizer::marks", u64::from(brick_cells))?;
        let found = self.finders.mark(&mut recorder, &self.structure, &input, brick_cells, &marks)?;
        let sums = Sums::new(gpu, Room::Voxels, brick_cells)?;
        self.structure.scan(&mut recorder, "voxel/structure", &marks, brick_cells, &sums);
        let brick_count = sums.total(&mut recorder)?;
        let structure = words(gpu, "VoxelGrid::structure", layout.structure_words(brick_count))?;
        let bricks = words(gpu, "Voxelizer::bricks", u64::from(brick_count))?;
        self.structure.levels(&mut recorder, &shared, &uniform, &marks, &sums, &structure, &bricks);

        let slots = brick_count.min(self.slots_per_batch);
        // A plane shines as its triangle does.
        let counted = match (contours, counted) {
            (true, _) => Vec::new(),
            (false, Some(counted)) => counted,
            (false, None) => Emitters::count(gpu, scene, mesh, of_mesh, &layout, cover)?,
        };
        let build = Build {
            factors: Emitters::factors(gpu, &counted)?,
            structure,
            bricks,
            keys: words(gpu, "Voxelizer::keys", u64::from(slots) * u64::from(BRICK_CELLS))?,
            rounds: Rounds::new(gpu)?,
            keeps,
            found,
            input,
            record,
        };
        build.rounds.count(&mut recorder);
        let mut parts = Vec::new();
        let mut voxel_count = 0;
        for first in (0..brick_count).step_by(self.slots_per_batch as usize) {
            let slots = first..(first + self.slots_per_batch).min(brick_count);
            let part = self.batch(&mut recorder, &build, slots, voxel_count)?;
            voxel_count += part.count;
            parts.push(part);
        }
        let mut log = recorder.finish()?;
        let lost = counted.iter().filter(|emitter| emitter.is_lost()).count();
        for (name, count) in
            [("voxels", voxel_count), ("bricks", brick_count), ("lost_emitters", lost as u32)]
        {
            log.counts.insert(name.into(), count.into());
        }
        let (structure, factors) = (build.structure, build.factors);
        let (mut records, mut kept, mut bends) = (Vec::new(), Vec::new(), Vec::new());
        for part in parts {
            records.push((part.records, part.count));
            if let Some([keys, bent]) = part.kept {
                kept.push((keys, part.count));
                bends.push((bent, part.slot_count));
            }
        }
        let mut grid = VoxelGrid {
            cells: layout.cells,
            voxel_size: layout.voxel_size,
            origin: layout.origin,
            structure,
            records: joined(gpu, "VoxelGrid::records", records, record.bytes())?,
            record,
            uniform,
            levels: 1,
            contours,
            voxel_count,
            brick_count,
            glowing: Vec::new(),
        };
        if contours && !scene.emitters.is_empty() {
            grid.glowing = Emitters::glowing_planes(gpu, &layout, &grid)?;
        } else if let Some(factors) = &factors {
            grid.glowing = self.emitters.glowing(gpu, factors, &grid)?;
        }
        let kept = joined(gpu, "Rest::keys", kept, 4)?;
        let bends = joined(gpu, "Rest::bends", bends, 4 * u64::from(BEND_WORDS))?;
        Ok(Built { grid, layout, kept, bends, counted, factors, log })
    }

    /// Records of a run of slots, and how many.
    fn batch(
        &self,
        recorder: &mut Recorder<'_>,
        build: &Build<'_>,
        slots: Range<u32>,
        first_record: u32,
    ) -> Result<Part, GpuError> {
        let gpu = recorder.gpu();
        recorder.clear(&build.keys);
        let structure = &build.structure;
        self.finders.vote(
            recorder,
            &build.input,
            &build.found,
            structure,
            slots.clone(),
            &build.keys,
            &build.rounds,
        );

        let uniform = build.input.uniform;
        let stage = "voxel/structure";
        let batch = Batch { stage, uniform, structure, slots: slots.clone() };
        let counts = words(gpu, "Voxelizer::counts", slots.len() as u64)?;
        self.structure.masks(recorder, &batch, &build.keys, &build.bricks, &counts);
        let sums = Sums::new(gpu, Room::Voxels, slots.len() as u32)?;
        self.structure.scan(recorder, stage, &counts, slots.len() as u32, &sums);
        let count = sums.total(recorder)?;
        let list = words(gpu, "Voxelizer::list", 2 * u64::from(count.max(1)))?;
        let record_words = u64::from(build.record.words());
        let records = words(gpu, "VoxelGrid::records", record_words * u64::from(count.max(1)))?;
        self.structure.list(recorder, &batch, first_record, &sums, &list);
        if let Some(factors) = &build.factors {
            let range = first_record..first_record + count;
            self.emitters.record(recorder, factors, &batch, range, &list);
        }
        let slot_count = slots.len() as u32;
        let bends = words(gpu, "Voxelizer::bends", u64::from(BEND_WORDS) * u64::from(slot_count))?;
        let found = &build.found;
        self.finders.bend(recorder, &build.input, found, structure, slots.clone(), &build.keys, &bends);
        let (workgroups, row) = rows(count);
        let params =
            recorder.uniform(&ResolveParams { first_slot: slots.start, voxel_count: count, row, _pad: 0 });
        let mut resources = vec![params.binding()];
        resources.extend(build.input.mesh.resources());
        resources.extend(build.input.scene.material_resources());
        resources.extend(
            [uniform, &build.keys, &build.bricks, &list, &bends, &records].map(|b| b.as_entire_binding()),
        );
        recorder.compute("voxel/resolve", &self.resolve, &resources, workgroups);
        let mut part = Part { records, count, kept: None, slot_count };
        if build.keeps
            && let Some(revoxelizer) = &self.revoxelizer
        {
            let kept = words(gpu, "Rest::keys", u64::from(count.max(1)))?;
            revoxelizer.keep(recorder, count, &build.keys, &list, &kept);
            part.kept = Some([kept, bends]);
        }
        Ok(part)
    }
}

/// A storage buffer of zeros.
pub(crate) fn words(gpu: &Gpu, label: &str, count: u64) -> Result<Buffer, GpuError> {
    let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
    gpu.buffer(Room::Voxels, label, 4 * count, usage)
}

/// The elements of all batches in one buffer; a single batch is that already.
fn joined(
    gpu: &Gpu,
    label: &str,
    mut parts: Vec<(Buffer, u32)>,
    element_bytes: u64,
) -> Result<Buffer, GpuError> {
    if parts.len() == 1
        && let Some((elements, _)) = parts.pop()
    {
        return Ok(elements);
    }
    let count: u64 = parts.iter().map(|(_, count)| u64::from(*count)).sum();
    let whole = words(gpu, label, element_bytes / 4 * count.max(1))?;
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let mut at = 0;
    for (part, count) in parts {
        let bytes = element_bytes * u64::from(count);
        encoder.copy_buffer_to_buffer(&part, 0, &whole, at, bytes);
        at += bytes;
    }
    gpu.queue.submit([encoder.finish()]);
    Ok(whole)
}
