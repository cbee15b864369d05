//! The sparse voxel grid: which cells are occupied, and how a ray finds the first of them.
//!
//! Paper: "uni-directional path tracing", through the grid that voxelizing filled.
//!
//! In: occupancy by cell. Out: for a ray in the world (metres, unit direction) the first occupied cell, the distance to
//! its face in metres and the index of its record. Grid space has its origin at the low corner of cell 0 and the cell
//! as its unit.
//!
//! # Layout
//! A brick is 8^3 cells, a group 4^3 bricks, a region 4^3 groups. Each of these holds 64-bit masks over 4^3 children,
//! bit `x + 4 y + 16 z`, so that a mask tells empty blocks of 1, 2 and 4 children. Building carries what the masks of
//! groups and regions tell into the table of bricks, so that a step of a ray reads one word in empty space and two near
//! voxels: a step costs what it loads (Sponza at 256, software adapter: 1.5 times as fast as asking the levels one after
//! the other). One buffer of words holds, in order:
//!
//! | section | per | words |
//! | --- | --- | --- |
//! | regions | region, x fastest | mask over groups, 2 |
//! | groups | group, x fastest | mask over bricks, 2 |
//! | table | brick cell, x fastest | of a brick: its slot, and from bit [`PARTS_BIT`] on which of its masks hold a voxel; else [`EMPTY`] plus the side of the largest empty block around it, cells: 8 to 128 |
//! | bricks | slot | 8 masks over 4^3 cells in Morton order, 16; index of the first record, 1; voxels in the masks before each mask, 16 bits each, 4 |
//!
//! The record of a cell is `base + voxels in earlier masks + bits before its own`: records are compact.
//!
//! # A step
//! State is the cell `c`, an integer. With `[lo, lo + s)` the largest empty block that holds it, the exit planes are
//! `b_k = lo_k + (d_k > 0 ? s : 0)` at `t_k = (b_k - o_k) / d_k`; the axis is the first one with the least `t_k`. On that
//! axis the cell becomes the one across the plane, on the others `floor(o_k + t d_k)`, clamped to the block and never
//! behind `c_k`. So every step moves at least one cell, whatever rounding does, and a ray takes at most 3 R of them. No
//! distance is accumulated, no epsilon is added; components below 2^-40 never form an inverse.
//!
//! # Sides
//! A cell is a cube of a voxel around a surface that may be much thinner: a ray that leaves a surface crosses cubes of it
//! that it must not meet, and in a corner those of the next wall, that it must. What tells them apart is a point *beside*
//! the ray, with no surface between it and the origin: the cell's record has a plane `n . x = o` (from its centre, voxels),
//! and a ray leaves it where it moves away from it on the point's side: `(n . b - o) (n . d) > 0`. Such cells are passed,
//! however many, within 8 voxels of the start and of each cell passed; farther on the point is the centre
//! of the empty cell that a ray comes from, and every occupied cell is met. Voxelized sheets separate empty cells, so that
//! this point is on the ray's side.
//!
//! Cells in which surfaces meet at an angle have no plane (the code of a crease): no plane tells the side of both. Their
//! cubes are met and light leaves them through the face it came by, so that nothing gets through a corner.
//!
//! Departs from the paper: it stores voxels in a dense image; this holds occupied cells only.

mod layout;
pub mod reference;
#[cfg(test)]
mod tests;

pub use layout::{Layout, SNAP};

use crate::record::RecordLayout;
use frame::{Bind, Buffer};
use glam::Vec3;

/// Numbers that Rust and shaders share, each written once.
macro_rules! shared_constants {
    ($($(#[$doc:meta])* $name:ident = $value:literal;)*) => {
        $($(#[$doc])* pub const $name: u32 = $value;)*

        /// The shader's half of the structure: bindings 16 and 18 of group 1 and functions named `grid_*`. Needs nothing else.
        pub const GRID_WGSL: &str = concat!(
            $("const GRID_", stringify!($name), " = ", stringify!($value), "u;\n",)*
            include_str!("grid.inc.wgsl"),
            include_str!("one.inc.wgsl")
        );

        /// The same over nested levels ([`crate::cascades`]): `grid` is the one at hand.
        pub const LEVELS_WGSL: &str = concat!(
            $("const GRID_", stringify!($name), " = ", stringify!($value), "u;\n",)*
            include_str!("grid.inc.wgsl"),
            include_str!("levels.inc.wgsl")
        );
    };
}

shared_constants! {
    /// Of a brick in the structure buffer.
    BRICK_WORDS = 21;
    /// Word of a brick that holds the index of its first record; the masks are before it.
    BASE_WORD = 16;
    /// First word of a brick's 16-bit counts of voxels before each mask.
    PREFIX_WORD = 17;
    /// A brick cell without a brick: this, plus the side of the empty block that holds it.
    EMPTY = 0x80000000;
    /// Bits of a slot. A structure's binding of 128 MiB ends at 1.6 million bricks.
    SLOTS = 0x007fffff;
    /// First of the eight bits that tell which masks of a brick hold a voxel.
    PARTS_BIT = 23;
    /// Most steps of a ray per cell of the longest axis: no straight line crosses more cells.
    STEPS_PER_CELL = 3;
    /// Cells of a brick.
    BRICK_CELLS = 512;
    /// Most nested levels.
    LEVELS = 8;
}

frame::gpu_struct! {
    /// See `grid.inc.wgsl`.
    pub struct Grid {
        /// World position of the low corner of cell 0, m.
        pub origin: [f32; 3],
        /// Side of a cell, m.
        pub voxel_size: f32,
        /// Cells per axis.
        pub cells: [i32; 3],
        /// 0: paths start h(n) of thin voxels above their surface, 1: one voxel above, 2: h(n) of conservative ones.
        pub elevation: u32,
        /// Bricks per axis.
        pub bricks: [i32; 3],
        /// First word of the brick table.
        pub table_at: u32,
        /// Groups per axis.
        pub groups: [i32; 3],
        /// First word of the groups' masks.
        pub groups_at: u32,
        /// Regions per axis.
        pub regions: [i32; 3],
        /// First word of the bricks.
        pub bricks_at: u32,
        /// 1: surfaces are where the records' planes are; 0: planes only tell sides.
        pub contours: u32,
        /// Words per record.
        pub record_words: u32,
        /// Records before the grid's own, where a buffer holds those of several.
        pub first_record: u32,
        /// Of packed points, per cell.
        pub point_steps: f32,
        /// Cell 0 on its lattice.
        pub low: [i32; 3],
        /// Where levels are nested: half the side of the box around the viewer that it is for, m.
        pub reach: f32,
        /// World position of the low corner of the lattice's cell 0, m.
        pub lattice: [f32; 3],
        /// WGSL rounds uniforms up.
        pub _pad: u32,
    }
}

/// The walk, `grid_trace` and `grid_first`; after [`frame::surface::WGSL`], [`GRID_WGSL`] and a snippet of
/// [`crate::record`].
pub const TRACE_WGSL: &str = concat!(include_str!("trace.inc.wgsl"), include_str!("first_one.inc.wgsl"));

macro_rules! fade {
    () => {
        0.25
    };
}

/// Rays change levels between this share of the way to the side of a level's box and the side itself, each at its own
/// place: nothing is seen to change when the boxes move.
pub(crate) const FADE: f32 = fade!();

/// The walk through nested levels; the same, after [`LEVELS_WGSL`].
pub const TRACE_LEVELS_WGSL: &str = concat!(
    include_str!("trace.inc.wgsl"),
    "const GRID_FADE = ",
    fade!(),
    ";\n",
    include_str!("first_levels.inc.wgsl")
);

/// What [`TRACE_WGSL`] binds when a kernel uses all of it; the order is that of [`VoxelGrid::resources`].
pub const GRID_BINDS: [Bind; 3] = [
    Bind::storage_read(1, 16, "grid_structure"),
    Bind::storage_read(1, 17, "grid_records"),
    Bind::uniform::<Grid>(1, 18, "grid"),
];

frame::gpu_struct! {
    /// See `levels.inc.wgsl`.
    pub struct GridLevels {
        /// What the boxes are around, m.
        pub eye: [f32; 3],
        /// WGSL aligns structs.
        pub _pad: u32,
        /// Finest first; the last is the whole scene.
        pub levels: [Grid; LEVELS as usize],
    }
}

/// The same as [`GRID_BINDS`] for [`TRACE_LEVELS_WGSL`].
pub const LEVELS_BINDS: [Bind; 3] =
    [GRID_BINDS[0], GRID_BINDS[1], Bind::uniform::<GridLevels>(1, 18, "grid_levels")];

/// A voxelized scene on the device.
#[derive(Clone)]
pub struct VoxelGrid {
    /// Cells per axis.
    pub cells: [u32; 3],
    /// Side of a cell, m.
    pub voxel_size: f32,
    /// World position of the low corner of cell 0.
    pub origin: Vec3,
    /// Masks, table and bricks; see the module's table.
    pub structure: Buffer,
    /// One packed surface per occupied cell.
    pub records: Buffer,
    /// The words of each.
    pub record: RecordLayout,
    /// [`Grid`], or [`GridLevels`] where levels are nested.
    pub uniform: Buffer,
    /// Nested levels; 1 is this grid alone.
    pub levels: u32,
    /// Surfaces are where the records' planes are.
    pub contours: bool,
    /// Occupied cells.
    pub voxel_count: u32,
    /// Bricks with an occupied cell.
    pub brick_count: u32,
    /// Cells that give off light, in the order of x, then y, then z.
    pub glowing: Vec<Glowing>,
}

/// A voxel that gives off light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Glowing {
    /// Its place.
    pub cell: [u32; 3],
    /// Its level, as [`GridLevels`] counts them; 0 where there is one.
    pub level: u32,
    /// A face of its cube as a share of one of the coarsest level.
    pub face_share: f32,
    /// Of its emission as stored, times `radiance_scale`.
    pub luminance: f32,
}

impl VoxelGrid {
    /// In the order of [`GRID_BINDS`].
    pub fn resources(&self) -> [wgpu::BindingResource<'_>; 3] {
        [
            self.structure.as_entire_binding(),
            self.records.as_entire_binding(),
            self.uniform.as_entire_binding(),
        ]
    }

    /// Bytes that stay allocated.
    pub fn bytes(&self) -> u64 {
        self.structure.bytes() + self.records.bytes() + self.uniform.bytes()
    }
}
