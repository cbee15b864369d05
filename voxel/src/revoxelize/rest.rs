//! What stands still in a grid, and the memory that moving frames share.

use super::MOST_SLOTS;
use crate::VoxelGrid;
use crate::bend::BEND_WORDS;
use crate::cover::Found;
use crate::emitters::{Counted, Factors};
use crate::grid::{BRICK_CELLS, Layout};
use crate::raster::{Raster, Rounds};
use crate::structure::Sums;
use crate::voxelizer::words;
use frame::scene_gpu::{GpuMesh, GpuScene};
use frame::{Buffer, FrameLog, Gpu, GpuError, Recorder, Room, Texture};
use std::sync::mpsc::Receiver;
use wgpu::BufferUsages;

/// Records begin at multiples of this many, 8 to 16 bytes each: buffers are bound at multiples of 256 bytes.
const RECORD_ALIGNMENT: u32 = 64;

/// Names of the counters, in the order of `out_counters` in `revoxelize.wgsl`.
pub(super) const COUNTERS: [&str; 4] = ["dirty_bricks", COVERED_BRICKS, COVERED_VOXELS, MOVING_VOXELS];
const COVERED_BRICKS: &str = "covered_bricks";
const COVERED_VOXELS: &str = "covered_voxels";
const MOVING_VOXELS: &str = "moving_voxels";

/// What stands still, and the memory that moving frames share.
pub struct Rest {
    pub(super) layout: Layout,
    /// Triangles that never move.
    pub(super) static_triangles: u32,
    pub(super) moves_light: bool,
    /// Bricks of what stands still: the first slot of the second pool.
    pub(super) brick_count: u32,
    pub(super) voxel_count: u32,
    /// Slots that the grid's buffers have room for behind those.
    pub(super) capacity: u32,
    /// Entries of the table.
    pub(super) home: Buffer,
    /// The winner of each voxel.
    pub(super) keys: Buffer,
    /// A bit per cell of each brick: it is bent.
    pub(super) bends: Buffer,
    pub(super) counted: Vec<Counted>,
    pub(super) factors: Option<Factors>,
    pub(super) target: Texture,
    pub(super) marks: Buffer,
    pub(super) sums: Sums,
    pub(super) rounds: Rounds,
    pub(super) counters: Buffer,
    pub(super) clipped: Buffer,
    /// Bricks that something moves in, in the last frame that was recorded.
    pub(super) moving_bricks: u32,
    pub(super) scratch: Option<Scratch>,
    pub(super) marked: Option<Marked>,
}

/// The number of marked bricks, on its way.
pub(super) struct Marked {
    staging: Buffer,
    submission: wgpu::SubmissionIndex,
    arrival: Receiver<Result<(), wgpu::BufferAsyncError>>,
    /// What marking left for voting.
    found: Found,
}

impl Marked {
    /// Copies a word, once everything submitted so far is done.
    pub(super) fn ask(gpu: &Gpu, buffer: &Buffer, word: u32, found: Found) -> Result<Self, GpuError> {
        let usage = BufferUsages::MAP_READ | BufferUsages::COPY_DST;
        let staging = gpu.buffer(Room::Frame, "Revoxelizer::marked", 4, usage)?;
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        encoder.copy_buffer_to_buffer(buffer, 4 * u64::from(word), &staging, 0, 4);
        let submission = gpu.queue.submit([encoder.finish()]);
        let (sender, arrival) = std::sync::mpsc::channel();
        staging.map_async(wgpu::MapMode::Read, .., move |result| {
            // Nobody listens any more where a frame was given up.
            let _ = sender.send(result);
        });
        Ok(Self { staging, submission, arrival, found })
    }

    pub(super) fn wait(self, gpu: &Gpu) -> Result<(u32, Found), GpuError> {
        let lost =
            |message: String| GpuError::ReadBack { what: "the number of moving bricks".into(), message };
        let wait = wgpu::PollType::Wait { submission_index: Some(self.submission), timeout: None };
        gpu.device.poll(wait).map_err(|e| lost(e.to_string()))?;
        self.arrival.recv().map_err(|e| lost(e.to_string()))?.map_err(|e| lost(e.to_string()))?;
        let view = self.staging.get_mapped_range(..).map_err(|e| lost(e.to_string()))?;
        Ok((bytemuck::pod_read_unaligned(&view[..4]), self.found))
    }
}

/// What depends on the number of slots.
pub(super) struct Scratch {
    /// Brick cell by slot, those of the first pool left out.
    pub(super) bricks: Buffer,
    pub(super) keys: Buffer,
    pub(super) bends: Buffer,
    pub(super) counts: Buffer,
    pub(super) sums: Sums,
    pub(super) list: Buffer,
    pub(super) resolve: Buffer,
    pub(super) groups: Buffer,
}

impl Scratch {
    fn new(gpu: &Gpu, first_slot: u32, capacity: u32) -> Result<Self, GpuError> {
        let slots = capacity.min(MOST_SLOTS);
        let cells = u64::from(slots) * u64::from(BRICK_CELLS);
        let storage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
        Ok(Self {
            bricks: words(gpu, "Revoxelizer::bricks", u64::from(first_slot + capacity))?,
            keys: words(gpu, "Revoxelizer::keys", cells)?,
            bends: words(gpu, "Revoxelizer::bends", u64::from(BEND_WORDS) * u64::from(slots))?,
            counts: words(gpu, "Revoxelizer::counts", u64::from(slots))?,
            sums: Sums::new(gpu, Room::Voxels, slots)?,
            list: words(gpu, "Revoxelizer::list", 2 * cells)?,
            resolve: gpu.buffer(Room::Voxels, "Revoxelizer::resolve", 16, storage | BufferUsages::UNIFORM)?,
            groups: gpu.buffer(Room::Voxels, "Revoxelizer::groups", 12, storage | BufferUsages::INDIRECT)?,
        })
    }
}

impl Rest {
    pub(crate) fn new(
        gpu: &Gpu,
        scene: &GpuScene,
        layout: &Layout,
        mesh: &GpuMesh,
        grid: &VoxelGrid,
        [keys, bends]: [Buffer; 2],
        counted: Vec<Counted>,
        factors: Option<Factors>,
    ) -> Result<Self, GpuError> {
        let shared = layout.uniform(0);
        let brick_cells = shared.bricks_at - shared.table_at;
        let home = words(gpu, "Rest::home", brick_cells.into())?;
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let at = 4 * u64::from(shared.table_at);
        encoder.copy_buffer_to_buffer(&grid.structure, at, &home, 0, home.bytes());
        gpu.queue.submit([encoder.finish()]);
        Ok(Self {
            layout: *layout,
            static_triangles: mesh.static_triangle_count,
            moves_light: scene.emitters.iter().any(|e| e.triangles.start >= scene.mesh.static_triangle_count),
            brick_count: grid.brick_count,
            voxel_count: grid.voxel_count,
            capacity: 0,
            home,
            keys,
            bends,
            counted,
            factors,
            target: Raster::target(gpu, layout.longest())?,
            marks: words(gpu, "Revoxelizer::marks", brick_cells.into())?,
            sums: Sums::new(gpu, Room::Voxels, brick_cells)?,
            rounds: Rounds::new(gpu)?,
            counters: words(gpu, "Revoxelizer::counters", 2 * COUNTERS.len() as u64)?,
            clipped: words(gpu, "Revoxelizer::clipped", 2)?,
            moving_bricks: 0,
            scratch: None,
            marked: None,
        })
    }

    /// Whether emitters move: then the voxels that give off light are others each frame.
    pub fn moves_light(&self) -> bool {
        self.moves_light
    }

    /// Takes the counts of the frame over into the grid, and from what was counted makes `voxels`, `bricks` and
    /// `dirty_share`: the bricks that were made anew as a share of those that hold a voxel.
    pub fn settle(&self, grid: &mut VoxelGrid, log: &mut FrameLog) {
        let mut take = |name| log.counts.remove(name).map(|n| n as u32);
        let moving_bricks = self.moving_bricks;
        let (Some(covered_bricks), Some(moving_voxels), Some(covered_voxels)) =
            (take(COVERED_BRICKS), take(MOVING_VOXELS), take(COVERED_VOXELS))
        else {
            return;
        };
        grid.brick_count = self.brick_count - covered_bricks + moving_bricks;
        grid.voxel_count = self.voxel_count - covered_voxels + moving_voxels;
        let dirty = log.counts.get("dirty_bricks").copied().unwrap_or(0.0);
        let share = dirty / f64::from(grid.brick_count.max(1));
        for (name, count) in [
            ("voxels", f64::from(grid.voxel_count)),
            ("bricks", f64::from(grid.brick_count)),
            ("moving_bricks", f64::from(moving_bricks)),
            ("moving_voxels", f64::from(moving_voxels)),
            ("dirty_share", share),
        ] {
            log.counts.insert(name.into(), count);
        }
    }

    /// Words of the table.
    pub(super) fn brick_cells(&self) -> u32 {
        let grid = self.layout.uniform(0);
        grid.bricks_at - grid.table_at
    }

    /// The first record of the second pool: from here on records may be of other voxels in every frame.
    pub fn first_moving_record(&self) -> u32 {
        self.voxel_count.next_multiple_of(RECORD_ALIGNMENT)
    }

    /// Makes room for this many slots in the grid's buffers, keeping what is there.
    pub(super) fn grow(
        &mut self,
        recorder: &mut Recorder<'_>,
        grid: &mut VoxelGrid,
        slots: u32,
    ) -> Result<(), GpuError> {
        if slots <= self.capacity && self.scratch.is_some() {
            return Ok(());
        }
        let gpu = recorder.gpu();
        // A quarter to spare, unless that would be what no longer fits.
        let allowed = gpu.device.limits().max_storage_buffer_binding_size / grid.record.bytes();
        let fits = allowed.saturating_sub(self.first_moving_record().into()) / u64::from(BRICK_CELLS);
        let spare = (slots + slots / 4).next_multiple_of(64);
        let capacity = spare.min(u32::try_from(fits).unwrap_or(u32::MAX)).max(slots);
        let structure =
            words(gpu, "VoxelGrid::structure", self.layout.structure_words(self.brick_count + capacity))?;
        let records = u64::from(self.first_moving_record()) + u64::from(BRICK_CELLS) * u64::from(capacity);
        let records = words(gpu, "VoxelGrid::records", u64::from(grid.record.words()) * records)?;
        recorder.copy_buffer(&grid.structure, &structure, 4 * self.layout.structure_words(self.brick_count));
        recorder.copy_buffer(&grid.records, &records, grid.record.bytes() * u64::from(self.voxel_count));
        self.scratch = Some(Scratch::new(gpu, self.brick_count, capacity)?);
        (grid.structure, grid.records, self.capacity) = (structure, records, capacity);
        Ok(())
    }
}
