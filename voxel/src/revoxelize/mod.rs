//! Moving things: per frame only the bricks that moving triangles touch in this frame, or touched in the last, are made
//! anew.
//!
//! Paper: "only re-voxelize dynamic segments".
//!
//! In: the grid of what stands still and the winner of each of its voxels ([`Rest`]); the mesh of this frame (world, m).
//! Out: the same grid with the moving triangles in it; cell by cell what a build of the whole mesh would give.
//!
//! - **Two pools**: bricks of what stands still keep their slots and records, which never move. A brick that a moving
//!   triangle touches gets one of the slots behind them, in the order of brick cells, and 512 records there, enough for
//!   every cell. The table points to the one or the other; leaving is a pointer back, to the brick beneath or to nothing.
//!   Bricks of last frame that nothing touches any more cost a word of the table.
//! - **Winners**: a slot begins with the keys of what stands still, 4 bytes per voxel kept from the build, and the moving
//!   triangles vote against them. The key is the same total order as in a build and its minimum does not ask who came
//!   first; so no history can show. (Lists of triangles per brick, the other way to have them, would be drawn anew each
//!   frame; the keys are less: at 512 cells Sponza's are 8.6 MB, and nothing where nothing moves.)
//! - **All else is shared**: masks, scan, list, factors of emitters and resolve are those of the build, over these bricks.
//! - **Waiting**: the number of bricks sizes the dispatches. It is asked for by [`Voxelizer::mark_moving`] and awaited by
//!   [`Voxelizer::revoxelize`]: whoever has other work for the device records it in between. Nothing else is read back,
//!   but where an emitter moves: its factor is counted on the CPU, as in a build.
//! - **Growing**: where slots are too few, both pools move to buffers with a quarter to spare, before anything is written.
//!   What does not fit a binding is an error.
//!
//! Moving triangles that reach outside the grid are clipped, and counted in `clipped_triangles`.

#[cfg(test)]
mod tests;

use crate::cover::Found;
use crate::emitters::{Counted, Emitters, Factors};
use crate::grid::{BRICK_CELLS, GRID_WGSL, Layout};
use crate::raster::{Input, Raster, Rounds};
use crate::structure::{Batch, SCAN_CONSTANTS, Sums, rows};
use crate::voxelizer::words;
use crate::{Grid, VoxelError, VoxelGrid, Voxelizer};
use frame::scene_gpu::{GpuMesh, GpuScene, MESH_BINDS, MESH_WGSL};
use frame::{Bind, Buffer, FrameLog, Gpu, GpuError, Kernel, KernelDesc, KernelError, Recorder, Room};
use frame::{Texture, surface};
use std::ops::Range;
use std::sync::mpsc::Receiver;
use wgpu::BufferUsages;

/// Bricks whose keys, lists and records are on their way at a time: 8 MB of keys.
const MOST_SLOTS: u32 = 4096;

/// Records begin at multiples of this many: buffers are bound at multiples of 256 bytes.
const RECORD_ALIGNMENT: u32 = 16;

/// Names of the counters, in the order of `out_counters` in `revoxelize.wgsl`.
const COUNTERS: [&str; 4] = ["dirty_bricks", COVERED_BRICKS, COVERED_VOXELS, MOVING_VOXELS];
const COVERED_BRICKS: &str = "covered_bricks";
const COVERED_VOXELS: &str = "covered_voxels";
const MOVING_VOXELS: &str = "moving_voxels";

const STAGE: &str = "voxel/revoxelize";

frame::gpu_struct! {
    /// See `revoxelize.wgsl`.
    pub struct RevoxelizeParams {
        /// Brick cells, bricks or voxels.
        pub count: u32,
        /// Of the second pool, or of the batch.
        pub first_slot: u32,
        /// Invocations per row of the dispatch.
        pub row: u32,
        /// Word that holds the sum of all.
        pub total_word: u32,
    }
}

frame::gpu_struct! {
    /// See `clip.wgsl`.
    pub struct ClipParams {
        /// The first that moves.
        pub first_triangle: u32,
        /// Moving triangles.
        pub count: u32,
        /// Invocations per row of the dispatch.
        pub row: u32,
        /// WGSL rounds uniforms up.
        pub _pad: u32,
    }
}

/// The passes that only moving frames have.
pub(crate) struct Revoxelizer {
    slots: Kernel,
    keys: Kernel,
    keep: Kernel,
    size: Kernel,
    clip: Kernel,
}

/// What stands still, and the memory that moving frames share.
pub struct Rest {
    layout: Layout,
    /// Triangles that never move.
    static_triangles: u32,
    moves_light: bool,
    /// Bricks of what stands still: the first slot of the second pool.
    brick_count: u32,
    voxel_count: u32,
    /// Slots that the grid's buffers have room for behind those.
    capacity: u32,
    /// Entries of the table.
    home: Buffer,
    /// The winner of each voxel.
    keys: Buffer,
    counted: Vec<Counted>,
    factors: Option<Factors>,
    target: Texture,
    marks: Buffer,
    sums: Sums,
    rounds: Rounds,
    counters: Buffer,
    clipped: Buffer,
    /// Bricks that something moves in, in the last frame that was recorded.
    moving_bricks: u32,
    scratch: Option<Scratch>,
    marked: Option<Marked>,
}

/// The number of marked bricks, on its way.
struct Marked {
    staging: Buffer,
    submission: wgpu::SubmissionIndex,
    arrival: Receiver<Result<(), wgpu::BufferAsyncError>>,
    /// What marking left for voting.
    found: Found,
}

impl Marked {
    /// Copies a word, once everything submitted so far is done.
    fn ask(gpu: &Gpu, buffer: &Buffer, word: u32, found: Found) -> Result<Self, GpuError> {
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

    fn wait(self, gpu: &Gpu) -> Result<(u32, Found), GpuError> {
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
struct Scratch {
    /// Brick cell by slot, those of the first pool left out.
    bricks: Buffer,
    keys: Buffer,
    counts: Buffer,
    sums: Sums,
    list: Buffer,
    resolve: Buffer,
    groups: Buffer,
}

impl Scratch {
    fn new(gpu: &Gpu, first_slot: u32, capacity: u32) -> Result<Self, GpuError> {
        let slots = capacity.min(MOST_SLOTS);
        let cells = u64::from(slots) * u64::from(BRICK_CELLS);
        let storage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
        Ok(Self {
            bricks: words(gpu, "Revoxelizer::bricks", u64::from(first_slot + capacity))?,
            keys: words(gpu, "Revoxelizer::keys", cells)?,
            counts: words(gpu, "Revoxelizer::counts", u64::from(slots))?,
            sums: Sums::new(gpu, slots)?,
            list: words(gpu, "Revoxelizer::list", 2 * cells)?,
            resolve: gpu.buffer(Room::Voxels, "Revoxelizer::resolve", 16, storage | BufferUsages::UNIFORM)?,
            groups: gpu.buffer(Room::Voxels, "Revoxelizer::groups", 12, storage | BufferUsages::INDIRECT)?,
        })
    }
}

impl Revoxelizer {
    pub(crate) fn new(gpu: &Gpu, scene: &GpuScene) -> Result<Self, KernelError> {
        let kernel = |entry, workgroup, bindings: &[Bind]| {
            let mut all = vec![Bind::uniform::<RevoxelizeParams>(0, 1, "params")];
            all.extend(bindings);
            Kernel::new(
                gpu,
                &KernelDesc {
                    name: entry,
                    sources: &[SCAN_CONSTANTS, GRID_WGSL, include_str!("revoxelize.wgsl")],
                    entry,
                    workgroup: [workgroup, 1, 1],
                    bindings: &all,
                    constants: &[],
                },
            )
        };
        let grid = Bind::uniform::<Grid>(1, 18, "grid");
        let home = Bind::storage_read(2, 0, "in_home");
        let before = Bind::storage_read(2, 1, "in_before");
        let blocks = Bind::storage_read(2, 2, "in_blocks");
        let keys = Bind::storage_read(2, 3, "in_keys");
        let bricks = Bind::storage_read(2, 4, "in_bricks");
        let kept = Bind::storage_read(2, 5, "in_kept");
        let list = Bind::storage_read(2, 6, "in_list");
        let structure = Bind::storage(3, 0, "out_structure");
        let out_bricks = Bind::storage(3, 1, "out_bricks");
        let marks = Bind::storage(3, 2, "out_marks");
        let out_keys = Bind::storage(3, 3, "out_keys");
        let out_kept = Bind::storage(3, 4, "out_kept");
        let counters = Bind::storage(3, 5, "out_counters");
        let resolve = Bind::storage(3, 6, "out_resolve");
        let groups = Bind::storage(3, 7, "out_groups");
        let mut clip = vec![Bind::uniform::<ClipParams>(0, 1, "params")];
        clip.extend(MESH_BINDS);
        clip.extend([grid, Bind::storage(3, 0, "out_clipped")]);
        Ok(Self {
            slots: kernel(
                "revoxelize_slots",
                64,
                &[grid, home, before, blocks, structure, out_bricks, marks, counters],
            )?,
            keys: kernel(
                "revoxelize_keys",
                64,
                &[Bind::storage_read(1, 16, "grid_structure"), grid, home, bricks, kept, out_keys],
            )?,
            keep: kernel("revoxelize_keep", 64, &[keys, list, out_kept])?,
            size: kernel("revoxelize_size", 1, &[blocks, counters, resolve, groups])?,
            clip: Kernel::new(
                gpu,
                &KernelDesc {
                    name: "voxel/revoxelize/clip",
                    sources: &[surface::WGSL, MESH_WGSL, GRID_WGSL, include_str!("clip.wgsl")],
                    entry: "clip_count",
                    workgroup: [64, 1, 1],
                    bindings: &clip,
                    constants: &scene.mesh.layout.constants(),
                },
            )?,
        })
    }

    /// Points the table to the slots of this frame, and to what is beneath those of the last.
    fn slots(&self, recorder: &mut Recorder<'_>, grid: &VoxelGrid, rest: &Rest, scratch: &Scratch) {
        recorder.clear(&rest.counters);
        for (at, name) in (0u64..).zip(COUNTERS) {
            recorder.counter(name, &rest.counters, 8 * at);
        }
        let (workgroups, row) = rows(rest.brick_cells());
        let (count, first_slot) = (rest.brick_cells(), rest.brick_count);
        let params = RevoxelizeParams { count, first_slot, row, total_word: 0 };
        let Sums { before, blocks, .. } = &rest.sums;
        let read = [&grid.uniform, &rest.home, before, blocks];
        let written = [&grid.structure, &scratch.bricks, &rest.marks, &rest.counters];
        Self::run(recorder, "slots", &self.slots, params, &[read, written].concat(), workgroups);
    }

    /// Fills the cells of a batch with the winners of what stands still.
    fn keys(
        &self,
        recorder: &mut Recorder<'_>,
        grid: &VoxelGrid,
        rest: &Rest,
        scratch: &Scratch,
        slots: Range<u32>,
    ) {
        let params = RevoxelizeParams { first_slot: slots.start, ..Default::default() };
        let buffers =
            [&grid.structure, &grid.uniform, &rest.home, &scratch.bricks, &rest.keys, &scratch.keys];
        Self::run(recorder, "keys", &self.keys, params, &buffers, [slots.len() as u32, 1, 1]);
    }

    /// Sizes the resolve of a batch by its voxels.
    fn size(&self, recorder: &mut Recorder<'_>, rest: &Rest, scratch: &Scratch, slots: Range<u32>) {
        let total_word = Sums::total_word(slots.len() as u32);
        let params = RevoxelizeParams { first_slot: slots.start, total_word, ..Default::default() };
        let buffers = [&scratch.sums.blocks, &rest.counters, &scratch.resolve, &scratch.groups];
        Self::run(recorder, "size", &self.size, params, &buffers, [1, 1, 1]);
    }

    /// Counts moving triangles that reach outside the grid.
    fn clip(&self, recorder: &mut Recorder<'_>, mesh: &GpuMesh, grid: &VoxelGrid, rest: &Rest) {
        recorder.clear(&rest.clipped);
        recorder.counter("clipped_triangles", &rest.clipped, 0);
        let first_triangle = mesh.static_triangle_count;
        let count = mesh.triangle_count - first_triangle;
        let (workgroups, row) = rows(count);
        let params = recorder.uniform(&ClipParams { first_triangle, count, row, _pad: 0 });
        let mut resources = vec![params.binding()];
        resources.extend(mesh.resources());
        resources.extend([&grid.uniform, &rest.clipped].map(|b| b.as_entire_binding()));
        recorder.compute(&format!("{STAGE}/clip"), &self.clip, &resources, workgroups);
    }

    fn run(
        recorder: &mut Recorder<'_>,
        part: &str,
        kernel: &Kernel,
        params: RevoxelizeParams,
        buffers: &[&Buffer],
        workgroups: [u32; 3],
    ) {
        let params = recorder.uniform(&params);
        let mut resources = vec![params.binding()];
        resources.extend(buffers.iter().map(|b| b.as_entire_binding()));
        recorder.compute(&format!("{STAGE}/{part}"), kernel, &resources, workgroups);
    }

    /// Writes the winner of each voxel of a batch of what stands still.
    pub(crate) fn keep(
        &self,
        recorder: &mut Recorder<'_>,
        count: u32,
        keys: &Buffer,
        list: &Buffer,
        kept: &Buffer,
    ) {
        let (workgroups, row) = rows(count);
        let params = RevoxelizeParams { count, row, ..Default::default() };
        Self::run(recorder, "keep", &self.keep, params, &[keys, list, kept], workgroups);
    }
}

impl Rest {
    pub(crate) fn new(
        gpu: &Gpu,
        scene: &GpuScene,
        layout: &Layout,
        mesh: &GpuMesh,
        grid: &VoxelGrid,
        keys: Buffer,
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
            counted,
            factors,
            target: Raster::target(gpu, layout.longest())?,
            marks: words(gpu, "Revoxelizer::marks", brick_cells.into())?,
            sums: Sums::new(gpu, brick_cells)?,
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
    fn brick_cells(&self) -> u32 {
        let grid = self.layout.uniform(0);
        grid.bricks_at - grid.table_at
    }

    /// The first record of the second pool.
    fn first_record(&self) -> u32 {
        self.voxel_count.next_multiple_of(RECORD_ALIGNMENT)
    }

    /// Makes room for this many slots in the grid's buffers, keeping what is there.
    fn grow(
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
        let allowed = gpu.device.limits().max_storage_buffer_binding_size / 16;
        let fits = allowed.saturating_sub(self.first_record().into()) / u64::from(BRICK_CELLS);
        let spare = (slots + slots / 4).next_multiple_of(64);
        let capacity = spare.min(u32::try_from(fits).unwrap_or(u32::MAX)).max(slots);
        let structure =
            words(gpu, "VoxelGrid::structure", self.layout.structure_words(self.brick_count + capacity))?;
        let records = u64::from(self.first_record()) + u64::from(BRICK_CELLS) * u64::from(capacity);
        let records = words(gpu, "VoxelGrid::records", 4 * records)?;
        recorder.copy_buffer(&grid.structure, &structure, 4 * self.layout.structure_words(self.brick_count));
        recorder.copy_buffer(&grid.records, &records, 16 * u64::from(self.voxel_count));
        self.scratch = Some(Scratch::new(gpu, self.brick_count, capacity)?);
        (grid.structure, grid.records, self.capacity) = (structure, records, capacity);
        Ok(())
    }
}

impl Voxelizer {
    /// Whether a grid of a mesh can be made from the one of which this stands still.
    pub fn can_follow(&self, rest: &Rest, mesh: &GpuMesh) -> bool {
        self.follows(mesh) && rest.static_triangles == mesh.static_triangle_count
    }

    /// Finds the bricks that moving triangles touch, and asks for their number, which [`Voxelizer::revoxelize`] awaits.
    /// Submits what is recorded so far.
    ///
    /// # Errors
    /// Out of memory.
    pub fn mark_moving(
        &self,
        recorder: &mut Recorder<'_>,
        scene: &GpuScene,
        mesh: &GpuMesh,
        grid: &VoxelGrid,
        rest: &mut Rest,
    ) -> Result<(), VoxelError> {
        let brick_cells = rest.brick_cells();
        recorder.clear(&rest.marks);
        let input = self.moving(scene, mesh, grid, rest);
        let found = self.finders.mark(recorder, &self.structure, &input, brick_cells, &rest.marks)?;
        self.structure.scan(recorder, STAGE, &rest.marks, brick_cells, &rest.sums);
        recorder.flush();
        let total = Sums::total_word(brick_cells);
        rest.marked = Some(Marked::ask(recorder.gpu(), &rest.sums.blocks, total, found)?);
        Ok(())
    }

    /// Puts the moving triangles of this frame into a grid, whose buffers may become others, and takes those of the last
    /// one out. The frame's log gets, beside what [`Rest::settle`] makes of it, `dirty_bricks`, the bricks that moving
    /// triangles touch in this frame or touched in the last, and `clipped_triangles`.
    ///
    /// # Errors
    /// The bricks they touch do not fit the device.
    pub fn revoxelize(
        &self,
        recorder: &mut Recorder<'_>,
        scene: &GpuScene,
        mesh: &GpuMesh,
        grid: &mut VoxelGrid,
        rest: &mut Rest,
    ) -> Result<(), VoxelError> {
        let Some(revoxelizer) = &self.revoxelizer else { return Ok(()) };
        if rest.marked.is_none() {
            self.mark_moving(recorder, scene, mesh, grid, rest)?;
        }
        let gpu = recorder.gpu();
        let Some(marked) = rest.marked.take() else { return Ok(()) };
        let (moving_bricks, found) = marked.wait(gpu)?;
        rest.moving_bricks = moving_bricks;
        rest.grow(recorder, grid, rest.moving_bricks)?;
        let moves_light = rest.moves_light;
        let merged = match moves_light {
            true => {
                let of_mesh = mesh.static_triangle_count..mesh.triangle_count;
                let counted = Emitters::count(gpu, scene, mesh, of_mesh, &rest.layout, self.cover())?;
                Emitters::factors(gpu, rest.counted.iter().chain(&counted))?
            }
            false => None,
        };
        let factors = if moves_light { &merged } else { &rest.factors };
        let Some(scratch) = &rest.scratch else { return Ok(()) };

        revoxelizer.slots(recorder, grid, rest, scratch);
        let shared = rest.layout.uniform(0);
        self.structure.skips(recorder, STAGE, &shared, &grid.uniform, &rest.marks, &grid.structure);
        revoxelizer.clip(recorder, mesh, grid, rest);
        rest.rounds.count(recorder);
        for first in (0..rest.moving_bricks).step_by(MOST_SLOTS as usize) {
            let slots = first..(first + MOST_SLOTS).min(rest.moving_bricks);
            self.moving_batch(
                recorder,
                revoxelizer,
                scene,
                mesh,
                grid,
                rest,
                scratch,
                &found,
                factors.as_ref(),
                slots,
            );
        }
        if moves_light {
            recorder.flush();
            let glowing = factors.as_ref().map(|factors| self.emitters.glowing(gpu, factors, grid));
            grid.glowing = glowing.transpose()?.unwrap_or_default();
        }
        Ok(())
    }

    fn moving<'a>(
        &self,
        scene: &'a GpuScene,
        mesh: &'a GpuMesh,
        grid: &'a VoxelGrid,
        rest: &'a Rest,
    ) -> Input<'a> {
        let triangles = mesh.static_triangle_count..mesh.triangle_count;
        let (uniform, target, cover) = (&grid.uniform, &rest.target, self.cover());
        Input { stage: STAGE, scene, mesh, triangles, uniform, target, cover }
    }

    /// Winners and records of a run of slots of the second pool.
    fn moving_batch(
        &self,
        recorder: &mut Recorder<'_>,
        revoxelizer: &Revoxelizer,
        scene: &GpuScene,
        mesh: &GpuMesh,
        grid: &VoxelGrid,
        rest: &Rest,
        scratch: &Scratch,
        found: &Found,
        factors: Option<&Factors>,
        moving_slots: Range<u32>,
    ) {
        let count = moving_slots.len() as u32;
        let slots = rest.brick_count + moving_slots.start..rest.brick_count + moving_slots.end;
        let first_record = rest.first_record() + BRICK_CELLS * moving_slots.start;
        let (uniform, structure) = (&grid.uniform, &grid.structure);
        revoxelizer.keys(recorder, grid, rest, scratch, slots.clone());
        let input = self.moving(scene, mesh, grid, rest);
        self.finders.vote(recorder, &input, found, structure, slots.clone(), &scratch.keys, &rest.rounds);
        let batch = Batch { stage: STAGE, uniform, structure, slots: slots.clone() };
        self.structure.masks(recorder, &batch, &scratch.keys, &scratch.bricks, &scratch.counts);
        self.structure.scan(recorder, STAGE, &scratch.counts, count, &scratch.sums);
        self.structure.list(recorder, &batch, first_record, &scratch.sums, &scratch.list);
        if let Some(factors) = factors {
            let records = first_record..first_record + BRICK_CELLS * count;
            self.emitters.record(recorder, factors, structure, uniform, records, &scratch.list);
        }
        revoxelizer.size(recorder, rest, scratch, slots);
        let mut resources = vec![scratch.resolve.as_entire_binding()];
        resources.extend(mesh.resources());
        resources.extend(scene.material_resources());
        let read = [uniform, &scratch.keys, &scratch.bricks, &scratch.list];
        resources.extend(read.map(|b| b.as_entire_binding()));
        resources.push(wgpu::BindingResource::Buffer(wgpu::BufferBinding {
            buffer: &grid.records,
            offset: 16 * u64::from(first_record),
            size: None,
        }));
        let pass = format!("{STAGE}/resolve");
        recorder.compute_indirect(&pass, &self.resolve, &resources, &scratch.groups, 0);
    }
}
