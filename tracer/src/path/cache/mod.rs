//! Radiance kept in the voxels: what a path's second hit would find by more bounces, from the frames before.
//!
//! Paper: none; the design's 5.8, after SHaRC (NVIDIA 2024) without its hash: the voxel is the cell.
//!
//! In: paths that meet a voxel after at least one scattering. Out: per voxel and side, `C = mean of L_i (1 - R(wi)) / (1 -
//! mean R)` over the hemisphere by the cosine, radiance times `radiance_scale`: the light that a diffuse surface gives off
//! over its albedo and `1 - R(wo)` (see [`frame::brdf`]). The two sides of a thin wall are apart.
//!
//! A path that may read a voxel adds `M_d (1 - R(wo)) C` and ends, unless it goes on as a reflection. What it would have
//! cost to go on is spent on the voxel instead: of all paths of a frame's first sample that ended at one side of one voxel,
//! one ([`FEED_SHARE`]) takes up where it ended, samples lights, and follows one diffuse direction to the next voxel, whose
//! own C it reads. So light crosses one voxel more each frame, and the fixed point has all bounces. A voxel side without
//! a value is followed explicitly by half of its paths, at twice their weight; the other half feed it.
//!
//! Each side keeps two means and the spread of its samples. The fast mean has a memory of 8 samples, the slow one, which
//! is read, of up to 64. When they are apart by more than two of the fast one's standard errors, the light has changed:
//! the slow mean becomes the fast one, and counts as three samples. One side's samples are too noisy to show a change of
//! less than half soon. So blocks of 16^3 cells, the regions, watch how far the samples of all their sides are from what
//! was expected: where the mean deviation of about the last four frames is beyond four of its standard errors and 5 % of
//! the light, the region enters another epoch, and each of its sides starts anew when it next gets a sample.
//!
//! Unbiased from the first frame on but for what follows: a path that feeds goes on through sides without a value as
//! others do, by random numbers of its own, until it meets one that has it.
//!
//! Deterministic: which path feeds a side is decided by the largest of their keys, results are stored when all have read,
//! and regions sum in integers. An entry is the voxel's record's: 40 bytes, 32 of values in half floats, rounded by chance
//! so that small steps count, and one key per side. Regions are 128 KiB, found by a hash of their place.
//!
//! Where things move, a record's number may name another voxel in the next frame: its first samples then find the light
//! changed. What stands still keeps its number.
//!
//! Bias: light is even over a voxel's side, and a change takes some frames; both are measured in `docs/light.md`.

use super::Structure;
use frame::{Bind, Buffer, Gpu, GpuError, Recorder, Room};
use voxel::VoxelGrid;

/// What a kernel reads and offers.
pub(super) const WGSL: &str = include_str!("cache.inc.wgsl");
/// The same functions for structures without voxels, or with the cache off.
pub(super) const NONE_WGSL: &str = include_str!("none.inc.wgsl");
/// After [`WGSL`] and a snippet of segments.
pub(super) const FEED_WGSL: &str = include_str!("feed.wgsl");
pub(super) const FEED_SEGMENT_WGSL: &str = include_str!("feed_segment.wgsl");
pub(super) const STORE_WGSL: &str = include_str!("store.wgsl");
pub(super) const BIND: Bind = Bind::storage(1, 34, "cache");

/// Of a record: both sides' values, both sides' keys.
const ENTRY_BYTES: u64 = 40;
/// Behind the entries, `CACHE_REGIONS` of `CACHE_REGION_WORDS`.
const REGIONS: u32 = 4096;
const REGIONS_BYTES: u64 = 32 * REGIONS as u64;
/// Workgroups of 64 that look at the regions.
pub(super) const REGION_GROUPS: [u32; 3] = [REGIONS / 64, 1, 1];
/// Paths of the first sample that may feed, per sample of the frame. A path costs at least the rays that feeding costs, so
/// that feeding takes at most this over one more than this of all rays: a fifth.
pub(super) const FEED_SHARE: f32 = 0.25;
/// Most segments of a path that feeds: it ends at the first diffuse voxel that has a value, but glass may come first.
pub(super) const FEED_SEGMENTS: u32 = 12;
/// Most scatterings of the light that is fed: the path's own, which has two behind it.
pub(super) const FEED_BOUNCES: u32 = 2 + FEED_SEGMENTS;
/// Least limit of scatterings of paths that read: they end at the first diffuse voxel, but mirrors and glass may come first.
pub(super) const BOUNCES: u32 = 8;

/// The entries of one grid, all without a value.
pub struct RadianceCache {
    pub(crate) entries: Buffer,
}

impl RadianceCache {
    /// For the records that `grid` has.
    ///
    /// # Errors
    /// Out of memory, or more records than a binding holds entries of.
    pub fn new(gpu: &Gpu, grid: &VoxelGrid) -> Result<Self, GpuError> {
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC;
        Ok(Self { entries: gpu.buffer(Room::Radiance, "RadianceCache", bytes_for(grid), usage)? })
    }

    /// Whether it has an entry for each of a grid's records.
    pub fn is_for(&self, grid: &VoxelGrid) -> bool {
        self.entries.bytes() == bytes_for(grid)
    }

    /// Forgets the light of all records from this one on: they are other voxels now.
    pub fn forget_from(&self, recorder: &mut Recorder<'_>, record: u32) {
        let words = (self.entries.bytes() - REGIONS_BYTES) / 4;
        recorder.clear_words(&self.entries, (ENTRY_BYTES / 4 * u64::from(record)).min(words)..words);
    }

    /// Bytes kept from frame to frame.
    pub fn bytes(&self) -> u64 {
        self.entries.bytes()
    }
}

fn bytes_for(grid: &VoxelGrid) -> u64 {
    ENTRY_BYTES * (grid.records.bytes() / grid.record.bytes()).max(1) + REGIONS_BYTES
}

/// Whether paths through this structure can have a cache.
pub(super) fn is_for(structure: &Structure) -> bool {
    !structure.of_triangles
}
