//! Nested grids around the viewer: each has voxels half as large as those of the one around it, the outermost is the
//! whole scene.
//!
//! Paper: "voxel cascades" [McLaren 2015], which it names as the way to large scenes.
//!
//! In: the mesh (world, m), the viewer's place. Out: one structure and one buffer of records that hold all levels, and
//! [`GridLevels`] that says where each of them begins.
//!
//! # Levels
//! The coarsest level is the grid of the whole scene, R cells on its longest axis. A finer one is a cube of R cells (a
//! multiple of 8, at least 32) around the viewer, on a lattice with the same origin and half the voxel size; so L levels
//! have voxels 2^(L - 1) times as fine for at most L times the memory, whatever the size of the scene. [`crate::compute`]
//! finds the voxels: it looks at a triangle from the brick at hand and so finds the same wherever a grid is, which no
//! rasterizer does that clips.
//!
//! # Moving
//! A level is placed on whole bricks and moves by whole bricks. What stays in it keeps its voxels: only the triangles in
//! bricks that came in are voxelized, on a grid of their own, and both are copied together (`merge`). A table addressed
//! modulo its size would save the copy, but skip levels would end at its seam; copying costs what memory costs, and gives
//! the very words that a build there gives, which a test compares.
//!
//! # Rays
//! A level is for a box around the viewer, not around the level's own place: its side is 16 cells shorter, so that it is
//! always inside. A ray is in the finest level whose box holds it, and goes from level to level, inwards and outwards. Each
//! ray has boxes up to a quarter smaller, by a hash of its direction. So what a ray meets does not depend on where levels
//! are placed, and what its light is worth changes gradually as the viewer moves: nothing is seen to pop.
//!
//! At a change of levels a ray is beside what it came past: the point before the change takes the place of the one beside
//! its start ([`crate::grid`], "Sides"), so that it leaves the coarser voxels of the floor that it flies over.
//!
//! # Light
//! Each level has the voxels of its part of each emitter; factors are those of the whole emitter at its voxel size
//! ([`crate::emitters`]). All of them are listed, but those of a coarser level that no ray sees. A sample of one that its ray
//! would meet in another level is worth nothing, so that what is listed twice is not counted twice.
//!
//! Departs from the paper: none, it has no cascades. Moving things, contours and the radiance cache know one grid only:
//! with levels everything is built anew where something moves, and the other two are refused.

mod merge;
#[cfg(test)]
mod tests;

pub(crate) use merge::Merger;

use crate::emitters::{Emitters, Lamps};
use crate::grid::{BRICK_WORDS, FADE, Glowing, GridLevels, LEVELS, Layout};
use crate::record::RecordLayout;
use crate::voxelizer::{Order, words};
use crate::{Grid, VoxelError, VoxelGrid, Voxelizer};
use frame::scene_gpu::{GpuMesh, GpuScene};
use frame::{Buffer, FrameLog, Gpu, GpuError, Room};
use glam::{IVec3, Vec3};
use merge::kept;
use scene::Aabb;
use wgpu::BufferUsages;

/// Least cells per axis of a level: its box is then 16, and paths start in one of 4.
pub const LEAST_CELLS: u32 = 32;
/// Cells between a level's end and its box, where the level is placed best; at least 4 are left.
const BORDER: u32 = 8;
/// Finest cells on the longest axis: beyond, f32 cannot place a corner on the grain of 1/256 cell.
const MOST_CELLS: u64 = 1 << 16;
/// Steps per axis of packed points.
const POINT_STEPS: u32 = 1 << 21;
/// Records of a level begin at multiples of this.
const RECORD_ALIGNMENT: u32 = 64;

/// One level, wherever its words are.
#[derive(Clone)]
pub(crate) struct Level {
    layout: Layout,
    structure: Buffer,
    /// First word of its table.
    table_at: u32,
    /// First word of its bricks.
    bricks_at: u32,
    records: Buffer,
    first_record: u32,
    brick_count: u32,
    voxel_count: u32,
    /// All that glow, wherever rays see them.
    glowing: Vec<Glowing>,
}

/// What follows the viewer.
pub struct Cascades {
    /// Of the whole scene.
    coarsest: Layout,
    /// Coarsest first.
    levels: Vec<Level>,
    lamps: Option<Lamps>,
    record: RecordLayout,
    elevation: u32,
    /// [`GridLevels`].
    uniform: Buffer,
}

impl Level {
    /// A grid of its own.
    fn alone(layout: Layout, grid: &VoxelGrid, glowing: Vec<Glowing>) -> Self {
        let shared = layout.uniform(0);
        Self {
            layout,
            structure: grid.structure.clone(),
            table_at: shared.table_at,
            bricks_at: shared.bricks_at,
            records: grid.records.clone(),
            first_record: 0,
            brick_count: grid.brick_count,
            voxel_count: grid.voxel_count,
            glowing,
        }
    }

    /// Of its table and its bricks.
    fn words(&self) -> u64 {
        self.layout.brick_cells() + u64::from(BRICK_WORDS) * u64::from(self.brick_count)
    }

    /// Half the side of its box, m.
    fn reach(&self) -> f32 {
        self.layout.voxel_size * (self.layout.cells[0] / 2 - BORDER) as f32
    }
}

/// The place of a finer level around the viewer.
fn around(eye: Vec3, coarsest: &Layout, halvings: u32) -> Layout {
    let voxel_size = coarsest.voxel_size / (1u32 << halvings) as f32;
    let cells = (coarsest.longest() / 8 * 8).max(LEAST_CELLS);
    let bricks = ((eye - coarsest.origin) / (8.0 * voxel_size) - (cells / 16) as f32).round();
    Layout { origin: coarsest.origin, voxel_size, cells: [cells; 3], low: 8 * bricks.as_ivec3() }
}

impl Voxelizer {
    /// Nested levels; 1 is one grid.
    pub fn cascades(&self) -> u32 {
        self.cascades
    }

    /// As [`Voxelizer::voxelize`], with finer levels around the viewer. The log's counts are sums over levels.
    ///
    /// # Errors
    /// As [`Voxelizer::voxelize`]; contours, or more levels than the numbers have digits for.
    pub fn voxelize_levels(
        &mut self,
        gpu: &Gpu,
        scene: &GpuScene,
        mesh: &GpuMesh,
        bounds: Aabb,
        grid: u32,
        eye: Vec3,
    ) -> Result<(VoxelGrid, Cascades, FrameLog), VoxelError> {
        if !self.bend().is_of_sides() {
            return Err(VoxelError::CascadedContours { cascades: self.cascades });
        }
        let cells = u64::from(grid.max(LEAST_CELLS)) << (self.cascades - 1);
        if cells > MOST_CELLS {
            let (cascades, most) = (self.cascades, MOST_CELLS);
            return Err(VoxelError::Cascades { grid, cascades, cells, most });
        }
        let coarsest = Order::of(gpu, scene, mesh, bounds, grid)?.layout;
        let eye = inside(eye, &coarsest);
        let layouts: Vec<Layout> = (0..self.cascades)
            .map(|halvings| if halvings == 0 { coarsest } else { around(eye, &coarsest, halvings) })
            .collect();
        let lamps = Lamps::new(gpu, scene, mesh, &layouts, self.cover())?;
        let mut log = FrameLog::default();
        let mut levels = Vec::new();
        for (number, layout) in layouts.into_iter().enumerate() {
            levels.push(self.level(gpu, scene, mesh, (number, layout), lamps.as_ref(), None, &mut log)?);
        }
        let usage = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
        let uniform =
            gpu.buffer(Room::Voxels, "VoxelGrid::uniform", size_of::<GridLevels>() as u64, usage)?;
        let record = RecordLayout::of(&scene.needs);
        let elevation = self.elevation();
        let mut cascades = Cascades { coarsest, levels, lamps, record, elevation, uniform };
        let grid = cascades.joined(gpu, &mut log)?;
        cascades.look(gpu, eye);
        Ok((grid, cascades, log))
    }

    /// Moves levels after the viewer: only what came into them is voxelized. Whether any moved, with what was recorded for
    /// it: the grid's buffers are then others, and so are the voxels that glow.
    ///
    /// # Errors
    /// Out of memory.
    pub fn follow(
        &mut self,
        gpu: &Gpu,
        scene: &GpuScene,
        mesh: &GpuMesh,
        grid: &mut VoxelGrid,
        cascades: &mut Cascades,
        eye: Vec3,
    ) -> Result<Option<FrameLog>, VoxelError> {
        let Cascades { coarsest, levels, lamps, .. } = cascades;
        let eye = inside(eye, coarsest);
        let mut moved = None;
        for (number, level) in levels.iter_mut().enumerate().skip(1) {
            let layout = around(eye, coarsest, number as u32);
            if layout != level.layout {
                let log = moved.get_or_insert_with(FrameLog::default);
                *level = self.level(gpu, scene, mesh, (number, layout), lamps.as_ref(), Some(level), log)?;
            }
        }
        if let Some(log) = &mut moved {
            *grid = cascades.joined(gpu, log)?;
        }
        cascades.look(gpu, eye);
        Ok(moved)
    }

    /// Builds a level, as far as it is not there already.
    fn level(
        &mut self,
        gpu: &Gpu,
        scene: &GpuScene,
        mesh: &GpuMesh,
        (number, layout): (usize, Layout),
        lamps: Option<&Lamps>,
        old: Option<&Level>,
        log: &mut FrameLog,
    ) -> Result<Level, VoxelError> {
        let counted = lamps.map(|lamps| lamps.counted(number, &layout, self.cover())).unwrap_or_default();
        let factors = Emitters::factors(gpu, &counted)?;
        let order = Order {
            scene,
            mesh,
            triangles: 0..mesh.triangle_count,
            layout,
            keeps: false,
            kept: old.map_or([IVec3::ZERO; 2], |old| kept(&old.layout, &layout).0),
            counted: Some(counted),
        };
        let built = self.build(gpu, order)?;
        let mut built_log = built.log;
        if number > 0 {
            // Those that are elsewhere.
            built_log.counts.remove("lost_emitters");
        }
        log.append(built_log);
        let mut grid = built.grid;
        *log.counts.entry("new_bricks".into()).or_default() += f64::from(grid.brick_count);
        if let Some(old) = old {
            if self.merger.is_none() {
                self.merger = Some(Merger::new(gpu)?);
            }
            if let Some(merger) = &self.merger {
                grid = merger.merge(gpu, &self.structure, &layout, grid, old)?;
            }
        }
        let glowing = factors.map(|factors| self.emitters.glowing(gpu, &factors, &grid)).transpose()?;
        Ok(Level::alone(layout, &grid, glowing.unwrap_or_default()))
    }
}

/// The nearest point of the scene's grid: beyond it levels would hold nothing.
fn inside(eye: Vec3, coarsest: &Layout) -> Vec3 {
    let low = coarsest.corner();
    let high = low + coarsest.voxel_size * Vec3::from(coarsest.cells.map(|n| n as f32));
    if eye.is_finite() { eye.clamp(low, high) } else { low }
}

impl Cascades {
    /// Whether [`Voxelizer::follow`] has anything to voxelize.
    pub fn moves(&self, eye: Vec3) -> bool {
        let eye = inside(eye, &self.coarsest);
        let mut finer = (0..).zip(&self.levels).skip(1);
        finer.any(|(number, level)| around(eye, &self.coarsest, number) != level.layout)
    }

    /// Puts all levels into new buffers, one behind the other.
    fn joined(&mut self, gpu: &Gpu, log: &mut FrameLog) -> Result<VoxelGrid, GpuError> {
        let (mut word_count, mut record_count) = (0, 0);
        let mut places = Vec::new();
        for level in &self.levels {
            places.push((word_count, record_count));
            word_count += level.words();
            record_count += u64::from(level.voxel_count.next_multiple_of(RECORD_ALIGNMENT));
        }
        let structure = words(gpu, "VoxelGrid::structure", word_count)?;
        let record_bytes = self.record.bytes();
        let records = words(gpu, "VoxelGrid::records", record_bytes / 4 * record_count.max(1))?;
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        for (level, (word, record)) in self.levels.iter_mut().zip(places) {
            // The table and the bricks, which the skip levels are before.
            let bytes = 4 * level.words();
            let from = 4 * u64::from(level.table_at);
            encoder.copy_buffer_to_buffer(&level.structure, from, &structure, 4 * word, bytes);
            let from = record_bytes * u64::from(level.first_record);
            let bytes = record_bytes * u64::from(level.voxel_count);
            encoder.copy_buffer_to_buffer(&level.records, from, &records, record_bytes * record, bytes);
            // What was allocated is a number of 32 bits.
            level.table_at = word as u32;
            level.bricks_at = (word + level.layout.brick_cells()) as u32;
            level.first_record = record as u32;
            (level.structure, level.records) = (structure.clone(), records.clone());
        }
        gpu.queue.submit([encoder.finish()]);
        let Layout { origin, voxel_size, cells, .. } = self.coarsest;
        let voxel_count = self.levels.iter().map(|level| level.voxel_count).sum();
        let brick_count = self.levels.iter().map(|level| level.brick_count).sum();
        log.counts.insert("voxels".into(), f64::from(voxel_count));
        log.counts.insert("bricks".into(), f64::from(brick_count));
        Ok(VoxelGrid {
            cells,
            voxel_size,
            origin,
            structure,
            records,
            record: self.record,
            uniform: self.uniform.clone(),
            levels: self.levels.len() as u32,
            contours: false,
            voxel_count,
            brick_count,
            glowing: self.glowing(),
        })
    }

    /// Tells shaders where the viewer is.
    fn look(&self, gpu: &Gpu, eye: Vec3) {
        let mut uniform = GridLevels { eye: eye.into(), ..GridLevels::default() };
        for (number, place) in uniform.levels.iter_mut().rev().enumerate() {
            *place = match self.levels.get(number) {
                Some(level) => self.uniform(number, level),
                None => Grid { reach: -1.0, voxel_size: 1.0, ..Grid::default() },
            };
        }
        gpu.queue.write_buffer(&self.uniform, 0, bytemuck::bytes_of(&uniform));
    }

    fn uniform(&self, number: usize, level: &Level) -> Grid {
        let steps = (POINT_STEPS / self.coarsest.longest().next_power_of_two()) as f32;
        Grid {
            table_at: level.table_at,
            bricks_at: level.bricks_at,
            first_record: level.first_record,
            record_words: self.record.words(),
            point_steps: steps / (1u32 << number) as f32,
            reach: level.reach(),
            ..level.layout.uniform(self.elevation)
        }
    }

    /// The voxels of all levels that give off light and that a ray may see.
    fn glowing(&self) -> Vec<Glowing> {
        let mut all = Vec::new();
        for (number, level) in self.levels.iter().enumerate() {
            let finer = self.levels.get(number + 1).map(|finer| hidden(finer, &level.layout));
            let is_seen = |glowing: &&Glowing| {
                let cell = IVec3::from(glowing.cell.map(|c| c as i32));
                !finer.is_some_and(|[low, high]| cell.cmpge(low).all() && cell.cmplt(high).all())
            };
            let of_level = |glowing: &Glowing| Glowing {
                level: LEVELS - 1 - number as u32,
                face_share: 0.25f32.powi(number as i32),
                ..*glowing
            };
            all.extend(level.glowing.iter().filter(is_seen).map(of_level));
        }
        all
    }
}

/// The cells of a coarser level that every ray sees in this one, wherever the viewer is: the first, and one behind the
/// last.
fn hidden(finer: &Level, coarser: &Layout) -> [IVec3; 2] {
    let cells = finer.layout.cells[0] as f32;
    // The viewer is within half a brick of the middle.
    let half = (1.0 - FADE) * (cells / 2.0 - BORDER as f32) - 4.0;
    let low = finer.layout.low.as_vec3() + (0.5 * cells - half);
    let high = finer.layout.low.as_vec3() + (0.5 * cells + half);
    let ratio = finer.layout.voxel_size / coarser.voxel_size;
    [(low * ratio).ceil().as_ivec3() - coarser.low, (high * ratio).floor().as_ivec3() - coarser.low]
}
