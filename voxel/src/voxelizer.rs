//! The whole way from triangles to a [`VoxelGrid`], once at load.
//!
//! mark bricks -> scan -> slots and skip levels -> per batch of bricks: vote until nothing changes -> masks -> scan ->
//! list -> factors of emitters -> resolve. Sizes are read back where the next buffer depends on them, so everything is
//! allocated exactly; keys and lists are given back at the end.

use crate::emitters::{Emitters, Factors};
use crate::grid::{BRICK_CELLS, Layout};
use crate::raster::{Axes, Bend, Input, MOST_TRIANGLES, Raster, Thickness};
use crate::record::RecordLayout;
use crate::resolve::{self, ResolveParams};
use crate::structure::{Batch, Structure, rows};
use crate::{Grid, VoxelError, VoxelGrid};
use frame::scene_gpu::{GpuMesh, GpuScene};
use frame::{Buffer, FrameLog, Gpu, GpuError, Kernel, Knob, Recorder, Room};
use scene::Aabb;
use wgpu::BufferUsages;

/// Bricks whose keys fill the 128 MiB that a binding may have by default.
const MOST_SLOTS: u32 = 65_536;

/// Turns triangles into voxels.
pub struct Voxelizer {
    thin: Raster,
    conservative: Option<Raster>,
    structure: Structure,
    emitters: Emitters,
    resolve: Kernel,
    elevation: u32,
    axes: u32,
    contours: u32,
    thickness: u32,
    /// Bricks whose keys are held at a time.
    pub(crate) slots_per_batch: u32,
}

/// What all batches share.
struct Build<'a> {
    raster: &'a Raster,
    bend: Bend,
    input: Input<'a>,
    factors: Option<Factors>,
    structure: Buffer,
    bricks: Buffer,
    keys: Buffer,
    changed: Buffer,
    rounds: u32,
    atomic_rounds: u32,
}

impl Voxelizer {
    /// Builds all kernels for scenes whose vertices are laid out as this one's.
    ///
    /// # Errors
    /// The driver refuses a kernel.
    pub fn new(gpu: &Gpu, scene: &GpuScene) -> Result<Self, VoxelError> {
        Ok(Self {
            thin: Raster::new(gpu, scene, Thickness::Thin)?,
            conservative: None,
            structure: Structure::new(gpu)?,
            emitters: Emitters::new(gpu, RecordLayout::of(&scene.needs))?,
            resolve: resolve::kernel(gpu, scene)?,
            elevation: 0,
            axes: 0,
            contours: 0,
            thickness: 0,
            slots_per_batch: MOST_SLOTS,
        })
    }

    /// Settings.
    pub fn knobs(&mut self) -> Vec<Knob<'_>> {
        vec![
            Knob::choice(
                "elevation",
                &mut self.elevation,
                &["normal", "voxel"],
                "How far above a surface paths start. `normal`: (|n|_1 + |n|_inf) / 2 voxels along the face normal n, \
                 the least that clears the surface's own voxels (1 to 1.23; derived). `voxel`: one voxel, as the paper \
                 says; 1.25 % of starts then lie inside their own surface.",
            ),
            Knob::choice(
                "contours",
                &mut self.contours,
                &["off", "on"],
                "What a ray meets of a voxel. `off`: its cube. `on`: the plane of its surface (Laine and Karras 2010), \
                 which needs conservative voxels; normal maps are left out.",
            ),
            Knob::choice(
                "thickness",
                &mut self.thickness,
                &["auto", "thin", "conservative"],
                "Which cells a triangle sets. `thin`: those that stop rays. `conservative`: all that it passes, some 1.8 \
                 times as many. `auto`: conservative with contours, thin without.",
            ),
            Knob::choice(
                "axes",
                &mut self.axes,
                &["all", "dominant"],
                "Axes that triangles are projected along. `all` closes closed surfaces and draws three times as many \
                 triangles. `dominant` is the paper's; some 0.4 % of rays leave a sphere of radius 44 voxels (measured).",
            ),
        ]
    }

    /// Hands settings that need no new voxels to a grid.
    pub fn apply_knobs(&self, gpu: &Gpu, grid: &VoxelGrid) {
        gpu.queue.write_buffer(
            &grid.uniform,
            std::mem::offset_of!(Grid, elevation) as u64,
            bytemuck::bytes_of(&self.elevation()),
        );
    }

    /// As shaders have it.
    fn elevation(&self) -> u32 {
        if self.elevation == 0 && self.thickness() == Thickness::Conservative { 2 } else { self.elevation }
    }

    fn thickness(&self) -> Thickness {
        match (self.thickness, self.contours) {
            (2, _) | (0, 1) => Thickness::Conservative,
            _ => Thickness::Thin,
        }
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
        let triangles = u64::from(mesh.triangle_count);
        if triangles > MOST_TRIANGLES {
            return Err(VoxelError::Triangles { triangles, most: MOST_TRIANGLES });
        }
        let layout = Layout::fit(bounds, grid, gpu.device.limits().max_texture_dimension_2d)?;
        // Marks and table have a word per brick cell: their number must be one.
        let brick_cells = u32::try_from(layout.brick_cells()).map_err(|_| GpuError::TooLarge {
            what: "VoxelGrid::structure".into(),
            needed: 4 * layout.brick_cells(),
            allowed: gpu.device.limits().max_storage_buffer_binding_size,
            unit: "bytes",
            advice: "lower --grid",
        })?;
        let words = |label, count: u64| {
            let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
            gpu.buffer(Room::Voxels, label, 4 * count, usage)
        };
        let (thickness, contours) = (self.thickness(), self.contours == 1);
        if contours && thickness == Thickness::Thin {
            return Err(VoxelError::ThinContours);
        }
        if thickness == Thickness::Conservative && self.conservative.is_none() {
            self.conservative = Some(Raster::new(gpu, scene, thickness)?);
        }
        let record = RecordLayout::of(&scene.needs);
        let raster = match &self.conservative {
            Some(conservative) if thickness == Thickness::Conservative => conservative,
            _ => &self.thin,
        };
        let shared = Grid {
            contours: self.contours,
            record_words: record.words(),
            ..layout.uniform(self.elevation())
        };
        let usage = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
        let uniform = gpu.buffer(Room::Voxels, "VoxelGrid::uniform", size_of::<Grid>() as u64, usage)?;
        gpu.queue.write_buffer(&uniform, 0, bytemuck::bytes_of(&shared));
        let target = Raster::target(gpu, layout.longest())?;
        let axes = if self.axes == 0 { Axes::All } else { Axes::Dominant };
        let input = Input { scene, mesh, uniform: &uniform, target: &target, axes, thickness };

        let mut recorder = Recorder::new(gpu);
        let marks = words("Voxelizer::marks", u64::from(brick_cells))?;
        raster.mark(&mut recorder, &input, &marks);
        let sums = self.structure.scan(&mut recorder, &marks, brick_cells)?;
        let brick_count = sums.total(&mut recorder)?;
        let structure = words("VoxelGrid::structure", layout.structure_words(brick_count))?;
        let bricks = words("Voxelizer::bricks", u64::from(brick_count))?;
        self.structure.levels(&mut recorder, &shared, &uniform, &marks, &sums, &structure, &bricks);

        let slots = brick_count.min(self.slots_per_batch);
        let mut build = Build {
            raster,
            bend: if contours { Bend::OF_CONTOURS } else { Bend::OF_SIDES },
            // A plane shines as its triangle does.
            factors: if contours { None } else { Emitters::factors(gpu, scene, mesh, &layout, axes)? },
            structure,
            bricks,
            keys: words("Voxelizer::keys", u64::from(slots) * u64::from(BRICK_CELLS))?,
            changed: words("Voxelizer::changed", 1)?,
            rounds: 0,
            atomic_rounds: 0,
            input,
        };
        let mut parts: Vec<(Buffer, u32)> = Vec::new();
        let mut voxel_count = 0;
        for first in (0..brick_count).step_by(self.slots_per_batch as usize) {
            let slots = first..(first + self.slots_per_batch).min(brick_count);
            let (records, count) = self.batch(&mut recorder, &mut build, slots, voxel_count)?;
            voxel_count += count;
            parts.push((records, count));
        }
        let mut log = recorder.finish()?;
        let records = joined(gpu, parts, record, voxel_count)?;
        let lost = build.factors.as_ref().map_or(0, |f| f.lost);
        for (name, count) in [
            ("voxels", voxel_count),
            ("bricks", brick_count),
            ("raster_rounds", build.rounds),
            ("atomic_rounds", build.atomic_rounds),
            ("lost_emitters", lost),
        ] {
            log.counts.insert(name.into(), count.into());
        }
        let Layout { cells, voxel_size, origin } = layout;
        let (structure, factors) = (build.structure, build.factors);
        let mut grid = VoxelGrid {
            cells,
            voxel_size,
            origin,
            structure,
            records,
            record,
            uniform,
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
        Ok((grid, log))
    }

    /// Records of a run of slots, and how many.
    fn batch(
        &self,
        recorder: &mut Recorder<'_>,
        build: &mut Build<'_>,
        slots: std::ops::Range<u32>,
        first_record: u32,
    ) -> Result<(Buffer, u32), GpuError> {
        let gpu = recorder.gpu();
        recorder.clear(&build.keys);
        let (rounds, atomic) = build.raster.vote(
            recorder,
            &build.input,
            &build.structure,
            slots.clone(),
            &build.keys,
            &build.changed,
        )?;
        build.rounds += rounds;
        build.atomic_rounds += u32::from(atomic);

        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
        let record = RecordLayout::of(&build.input.scene.needs);
        let uniform = build.input.uniform;
        let batch = Batch { uniform, structure: &build.structure, slots: slots.clone() };
        let counts = gpu.buffer(Room::Voxels, "Voxelizer::counts", 4 * slots.len() as u64, usage)?;
        self.structure.masks(recorder, &batch, &build.keys, &build.bricks, &counts);
        let sums = self.structure.scan(recorder, &counts, slots.len() as u32)?;
        let count = sums.total(recorder)?;
        let list = gpu.buffer(Room::Voxels, "Voxelizer::list", 8 * u64::from(count.max(1)), usage)?;
        let records =
            gpu.buffer(Room::Voxels, "VoxelGrid::records", record.bytes() * u64::from(count.max(1)), usage)?;
        self.structure.list(recorder, &batch, first_record, &sums, &list);
        if let Some(factors) = &build.factors {
            let range = first_record..first_record + count;
            self.emitters.record(recorder, factors, &build.structure, uniform, range, &list);
        }
        let bends = gpu.buffer(Room::Voxels, "Voxelizer::bends", 4 * u64::from(count.max(1)), usage)?;
        recorder.clear(&bends);
        build.raster.bend(recorder, &build.input, &batch, first_record, build.bend, &build.keys, &bends);
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
        Ok((records, count))
    }
}

/// The records of all batches in one buffer; a single batch is that already.
fn joined(
    gpu: &Gpu,
    mut parts: Vec<(Buffer, u32)>,
    record: RecordLayout,
    voxel_count: u32,
) -> Result<Buffer, GpuError> {
    if parts.len() == 1
        && let Some((records, _)) = parts.pop()
    {
        return Ok(records);
    }
    let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
    let bytes = record.bytes() * u64::from(voxel_count.max(1));
    let records = gpu.buffer(Room::Voxels, "VoxelGrid::records", bytes, usage)?;
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let mut at = 0;
    for (part, count) in parts {
        let bytes = record.bytes() * u64::from(count);
        encoder.copy_buffer_to_buffer(&part, 0, &records, at, bytes);
        at += bytes;
    }
    gpu.queue.submit([encoder.finish()]);
    Ok(records)
}
