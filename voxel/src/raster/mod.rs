//! Triangles to cells, on the rasterizer: which bricks they touch, and which triangle wins each cell.
//!
//! Paper: "voxelizing the entire scene every frame using [Crassin and Green 2012] without the use of atomics".
//!
//! In: a mesh in the world, m. Out: per brick cell whether anything is in it; per cell of a batch of bricks the key of
//! its winner.
//!
//! - **Columns**: a triangle with normal `g` is projected along an axis, one pixel per column. A fragment is a column
//!   whose centre `(u, v)` is covered; the cell is `floor(w)`, `w = w0 - (g_u (u - u0) + g_v (v - v0)) / g_w`, kept
//!   within the corners' depths. So the surface passes the cell within `|g|_inf / (2 |g|)` of its centre.
//! - **Axes**: `dominant` is the paper's: the axis `g` is longest on (x before y before z where they are within 0.1 % of
//!   each other, so that triangles of one plane at 45 degrees agree). A plane then stops every path through faces of
//!   cells, but where neighbours have different axes a cell can be missing between the last column of one and the first
//!   of the other. `all` projects along each axis in turn: wherever a surface crosses the line between the centres of two
//!   neighbouring cells one of both is set, so a closed surface stops every such path. Inside a triangle that sets no
//!   further cell.
//! - **Ties**: corners are first moved to multiples of 1/256 cell, the grain of rasterizers. A face on the boundary
//!   between two layers of cells goes to the layer behind it (`w` is moved 2^-10 cell against the normal): a closed
//!   room whose walls lie on such boundaries keeps its inside whole.
//! - **Key**, smaller wins: class 2 bits (0 emits, 1 opaque, 2 lets something through), distance of the plane from the
//!   cell's centre in 1/128 cell 6 bits, number of the triangle 24 bits. Keys are stored complemented, so that a
//!   cleared buffer holds none.
//! - **Rounds**: a fragment that finds a larger key stores its own, with plain relaxed loads and stores. Rounds repeat
//!   until none stores anything: every round lowers each contended cell, so the end is the minimum whoever came first.
//!   After [`MOST_ROUNDS`] one round of atomic minima finishes the rest. All are recorded at once; a word that says if the
//!   last one stored anything arms the next, so that nobody waits to ask.
//! - **Conservative** ([`Cover::Boxes`]): all cells that a triangle enters by 2^-12. Drawn are the columns of its box along
//!   the dominant axis, and a fragment tests the up to three cells that the plane passes in its column, in all three
//!   projections (Schwarz and Seidel 2010). The distance in a key is that of the triangle, in 1/72 cell.
//! - **Bends**: a last draw compares each triangle with the winner ([`crate::bend`]).
//! - **Holes**: where a material is masked or blended, its coverage is read at the point and the mip the voxel will
//!   have. Less than half a step of the 4 bits that will store it is nothing.
//!
//! Triangles that cover no column's centre are lost; so are parts thinner than a column. What lies outside the grid is
//! clipped.
//!
//! Departs from the paper: one winner per cell instead of whoever came last, so that two builds are equal; three axes
//! instead of one.

pub mod reference;
#[cfg(test)]
mod tests;

use crate::bend::{self, Bend};
use crate::grid::GRID_WGSL;
use crate::{Cover, Grid, resolve};
use frame::scene_gpu::{GpuMesh, GpuScene, MATERIAL_BINDS, MATERIAL_WGSL, MESH_BINDS, MESH_WGSL};
use frame::{Bind, Buffer, Gpu, GpuError, Kernel, KernelDesc, KernelError, RasterDesc, RasterKernel};
use frame::{RasterTargets, Recorder, Room, Texture, brdf, surface};
use glam::IVec3;
use std::ops::Range;
use wgpu::BufferUsages;

/// Rounds without atomics. The mean of k contenders takes ln k + 0.6; 14 is the most that was seen.
pub const MOST_ROUNDS: u32 = 16;

/// Axes that triangles are projected along.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axes {
    /// Each of the three: closed surfaces are closed.
    All,
    /// The one the normal is longest on, as in the paper.
    Dominant,
}

/// Keys hold 24 bits of triangle number.
pub const MOST_TRIANGLES: u64 = 1 << 24;

macro_rules! shared_constants {
    ($($(#[$doc:meta])* $name:ident = $value:literal;)*) => {
        $($(#[$doc])* pub(crate) const $name: f32 = $value;)*

        pub(crate) const CONSTANTS: &str = concat!($("const RASTER_", stringify!($name), " = ", stringify!($value), ";\n",)*);
    };
}

shared_constants! {
    /// Steps per cell that corners are moved to.
    GRAIN = 256.0;
    /// By which factor a later component of a normal must exceed an earlier one to be the longest.
    PREFERENCE = 1.001;
    /// Cells by which depths are moved behind the face: 2^-10.
    TIE = 0.0009765625;
}

frame::gpu_struct! {
    /// See `raster.wgsl`.
    pub struct RasterParams {
        /// First slot of this batch.
        pub first_slot: u32,
        /// Bricks of this batch.
        pub slot_count: u32,
        /// 1: atomic minima.
        pub atomic_round: u32,
        /// 3, or 1 for the one the normal is longest on.
        pub axes: u32,
        /// Of [`Bend`].
        pub flat: f32,
        /// Of [`Bend`].
        pub apart: f32,
        /// The first triangle that moves.
        pub first_moving: u32,
        /// WGSL rounds uniforms up.
        pub _pad: u32,
    }
}

frame::gpu_struct! {
    /// See `rounds.wgsl`.
    pub struct RoundsParams {
        /// Vertices of a round.
        pub vertex_count: u32,
        /// The first of them.
        pub first_vertex: u32,
        /// 1: the round to come is the one with atomic minima.
        pub atomic_round: u32,
        /// 1: the round to come is drawn in any case.
        pub first_round: u32,
    }
}

const TARGET: wgpu::TextureFormat = wgpu::TextureFormat::R8Unorm;

/// All passes, each as a kernel for triangles without holes and, where the scene has any, one for those with holes.
pub(crate) struct Raster {
    mark: Vec<RasterKernel>,
    vote: Vec<RasterKernel>,
    bend: Vec<RasterKernel>,
    arm: Kernel,
}

/// Whether rounds are needed, and how many were: kept from build to build.
pub(crate) struct Rounds {
    /// 1 where the last round stored something.
    changed: Buffer,
    /// Counts and first indices of the next round's draw.
    draw: Buffer,
    /// Rounds drawn and, of those, atomic ones: two counters of 64 bits.
    counts: Buffer,
}

impl Rounds {
    pub(crate) fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let words = |label, count: u64, more| {
            let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST | more;
            gpu.buffer(Room::Voxels, label, 4 * count, usage)
        };
        Ok(Self {
            changed: words("Rounds::changed", 1, BufferUsages::empty())?,
            draw: words("Rounds::draw", 4, BufferUsages::INDIRECT)?,
            counts: words("Rounds::counts", 4, BufferUsages::empty())?,
        })
    }

    /// Begins to count, `raster_rounds` and `atomic_rounds` in the log.
    pub(crate) fn count(&self, recorder: &mut Recorder<'_>) {
        recorder.clear(&self.counts);
        recorder.counter("raster_rounds", &self.counts, 0);
        recorder.counter("atomic_rounds", &self.counts, 8);
    }
}

/// What a pass reads.
pub(crate) struct Input<'a> {
    /// Who draws, for the names of passes: `voxel/raster`, or who uses it.
    pub stage: &'a str,
    pub scene: &'a GpuScene,
    pub mesh: &'a GpuMesh,
    /// Of the mesh: those that are drawn.
    pub triangles: Range<u32>,
    pub uniform: &'a Buffer,
    pub target: &'a Texture,
    /// [`Cover::Columns`] or [`Cover::Boxes`] for what is drawn.
    pub cover: Cover,
    pub bend: Bend,
    /// Bricks that [`crate::compute`] leaves out: the first, and one behind the last.
    pub kept: [IVec3; 2],
}

impl Input<'_> {
    fn axis_count(&self) -> u32 {
        match self.cover {
            Cover::Columns(Axes::Dominant) | Cover::Boxes => 1,
            _ => 3,
        }
    }

    /// Three corners per triangle and axis, or two triangles around all columns; 9 x 2^24 is a u32.
    fn vertices(&self) -> Range<u32> {
        let per_axis = if self.cover == Cover::Boxes { 6 } else { 3 };
        let per_triangle = per_axis * self.axis_count();
        per_triangle * self.triangles.start..per_triangle * self.triangles.end
    }

    /// Draws all triangles, or as many as `armed` says.
    fn draw(
        &self,
        recorder: &mut Recorder<'_>,
        part: &str,
        kernels: &[RasterKernel],
        params: RasterParams,
        after: &[&Buffer],
        armed: Option<&Buffer>,
    ) {
        let pass = format!("{}/{part}", self.stage);
        let params = recorder.uniform(&RasterParams { axes: self.axis_count(), ..params });
        let mut resources = vec![params.binding()];
        resources.extend(self.mesh.resources());
        resources.extend(self.scene.material_resources());
        resources.extend(after.iter().map(|b| b.as_entire_binding()));
        let colors = [(self.target.view(), Some(wgpu::Color::TRANSPARENT))];
        let targets = RasterTargets { colors: &colors, depth: None };
        for kernel in kernels {
            match armed {
                None => recorder.raster(&pass, kernel, &resources, &targets, self.vertices()),
                Some(draw) => recorder.raster_indirect(&pass, kernel, &resources, &targets, draw),
            }
        }
    }
}

impl Raster {
    /// For [`Cover::Columns`], or [`Cover::Boxes`].
    pub(crate) fn new(gpu: &Gpu, scene: &GpuScene, boxes: bool) -> Result<Self, KernelError> {
        let cells = if boxes { include_str!("conservative.inc.wgsl") } else { include_str!("thin.inc.wgsl") };
        let sources = [
            surface::WGSL,
            brdf::WGSL,
            MESH_WGSL,
            MATERIAL_WGSL,
            GRID_WGSL,
            resolve::POINT_WGSL,
            bend::WGSL,
            CONSTANTS,
            include_str!("raster.wgsl"),
            cells,
        ];
        let kernel = |name, fragment, after: &[Bind], holes: bool| {
            let mut constants = scene.constants().to_vec();
            constants.push(("raster_holes", f64::from(u8::from(holes))));
            if fragment == "raster_bend" {
                constants.push(("bend_meets_planes", f64::from(u8::from(boxes))));
            }
            let params = Bind::uniform::<RasterParams>(0, 1, "params");
            let shared = std::iter::once(&params).chain(&MESH_BINDS).chain(&MATERIAL_BINDS);
            let bindings: Vec<_> = shared.chain(after).copied().collect();
            RasterKernel::new(
                gpu,
                &RasterDesc {
                    name,
                    sources: &sources,
                    entries: ["raster_vertex", fragment],
                    bindings: &bindings,
                    constants: &constants,
                    // A pass must draw into something; nothing is written.
                    targets: &[wgpu::ColorTargetState {
                        format: TARGET,
                        blend: None,
                        write_mask: wgpu::ColorWrites::empty(),
                    }],
                    depth: None,
                },
            )
        };
        let grid = Bind::uniform::<Grid>(1, 18, "grid");
        let structure = Bind::storage_read(1, 16, "grid_structure");
        let [marks, keys, changed, bends] =
            [(0, "out_marks"), (1, "out_keys"), (2, "out_changed"), (3, "out_bends")]
                .map(|(at, name)| Bind::storage(3, at, name));
        let variants = || std::iter::once(false).chain(scene.needs.coverage.then_some(true));
        let mark = |holes| kernel("voxel/raster/mark", "raster_mark", &[grid, marks], holes);
        let vote =
            |holes| kernel("voxel/raster/vote", "raster_vote", &[structure, grid, keys, changed], holes);
        let bend = |holes| kernel("voxel/raster/bend", "raster_bend", &[structure, grid, keys, bends], holes);
        Ok(Self {
            mark: variants().map(mark).collect::<Result<_, _>>()?,
            vote: variants().map(vote).collect::<Result<_, _>>()?,
            bend: variants().map(bend).collect::<Result<_, _>>()?,
            arm: Kernel::new(
                gpu,
                &KernelDesc {
                    name: "voxel/raster/arm",
                    sources: &[include_str!("rounds.wgsl")],
                    entry: "rounds_arm",
                    workgroup: [1, 1, 1],
                    bindings: &[
                        Bind::uniform::<RoundsParams>(0, 1, "params"),
                        Bind::storage(3, 0, "out_changed"),
                        Bind::storage(3, 1, "out_draw"),
                        Bind::storage(3, 2, "out_counts"),
                    ],
                    constants: &[],
                },
            )?,
        })
    }

    /// One pixel per column, never written.
    pub(crate) fn target(gpu: &Gpu, side: u32) -> Result<Texture, GpuError> {
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT;
        gpu.texture(Room::Voxels, "Raster::target", [side, side, 1], 1, TARGET, usage)
    }

    /// Writes 1 for each brick cell that something is in; `marks` must be clear.
    pub(crate) fn mark(&self, recorder: &mut Recorder<'_>, input: &Input<'_>, marks: &Buffer) {
        input.draw(recorder, "mark", &self.mark, RasterParams::default(), &[input.uniform, marks], None);
    }

    /// Finds the winner of each cell of a batch. `keys` hold 0 or what is there already; `rounds` adds up how many it took.
    pub(crate) fn vote(
        &self,
        recorder: &mut Recorder<'_>,
        input: &Input<'_>,
        structure: &Buffer,
        slots: Range<u32>,
        keys: &Buffer,
        rounds: &Rounds,
    ) {
        let buffers = [structure, input.uniform, keys, &rounds.changed];
        let (first_slot, slot_count) = (slots.start, slots.len() as u32);
        let vertices = input.vertices();
        let (first_vertex, vertex_count) = (vertices.start, vertices.len() as u32);
        recorder.clear(&rounds.changed);
        for round in 0..=MOST_ROUNDS {
            let (atomic_round, first_round) = (u32::from(round == MOST_ROUNDS), u32::from(round == 0));
            let arm =
                recorder.uniform(&RoundsParams { vertex_count, first_vertex, atomic_round, first_round });
            let [changed, draw, counts] =
                [&rounds.changed, &rounds.draw, &rounds.counts].map(|b| b.as_entire_binding());
            let pass = format!("{}/arm", input.stage);
            recorder.compute(&pass, &self.arm, &[arm.binding(), changed, draw, counts], [1, 1, 1]);
            let params = RasterParams { first_slot, slot_count, atomic_round, ..Default::default() };
            input.draw(recorder, "vote", &self.vote, params, &buffers, Some(&rounds.draw));
        }
    }

    /// Sets the bits of cells of a batch that are bent.
    pub(crate) fn bend(
        &self,
        recorder: &mut Recorder<'_>,
        input: &Input<'_>,
        structure: &Buffer,
        slots: Range<u32>,
        keys: &Buffer,
        bends: &Buffer,
    ) {
        let Bend { flat, apart } = input.bend;
        let params = RasterParams {
            first_slot: slots.start,
            slot_count: slots.len() as u32,
            flat,
            apart,
            first_moving: input.mesh.static_triangle_count,
            ..Default::default()
        };
        input.draw(recorder, "bend", &self.bend, params, &[structure, input.uniform, keys, bends], None);
    }
}
