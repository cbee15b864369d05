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
//!   After [`MOST_ROUNDS`] one round of atomic minima finishes the rest.
//! - **Conservative** voxels ([`Thickness`]) are all cells that a triangle enters by 2^-12: drawn are the columns of its box
//!   along the dominant axis, and a fragment tests the up to three cells that the plane passes in its column, in all three
//!   projections (Schwarz and Seidel 2010). What is nearest to the cell's centre wins.
//! - **Bends**: a last draw marks cells in which triangles are not one surface, for [`crate::grid`]: normals too far apart,
//!   seen from either side, or planes. What lets light through is left out.
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

use crate::grid::GRID_WGSL;
use crate::structure::Batch;
use crate::{Grid, resolve};
use frame::scene_gpu::{GpuMesh, GpuScene, MATERIAL_BINDS, MATERIAL_WGSL, MESH_BINDS, MESH_WGSL};
use frame::{Bind, Buffer, Gpu, GpuError, KernelError, RasterDesc, RasterKernel, RasterTargets, Recorder};
use frame::{Room, Texture, brdf, surface};

/// Rounds without atomics. The mean of k contenders takes ln k + 0.6; 14 is the most that was seen.
pub const MOST_ROUNDS: u32 = 16;

/// Which cells a triangle sets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Thickness {
    /// One per column: what stops rays.
    Thin,
    /// Each that it passes: what planes within cells need.
    Conservative,
}

/// Where triangles of a cell stop being one surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bend {
    /// Cosine between normals.
    pub(crate) flat: f32,
    /// Cells from one plane to the other.
    pub(crate) apart: f32,
}

impl Bend {
    /// Planes only tell sides: 30 degrees, and two sides of a sheet may share a cell.
    pub(crate) const OF_SIDES: Self = Self { flat: 0.866_025_4, apart: 1e9 };
    /// Planes are where surfaces are: 20 degrees, which are 0.15 cell at a cell's corner.
    pub(crate) const OF_CONTOURS: Self = Self { flat: 0.939_692_6, apart: 0.1 };
}

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

        const CONSTANTS: &str = concat!($("const RASTER_", stringify!($name), " = ", stringify!($value), ";\n",)*);
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
        /// Records before this batch.
        pub first_record: u32,
        /// Cosine between normals of triangles that are one surface.
        pub flat: f32,
        /// Cells that one surface's triangles in a cell are apart at most.
        pub apart: f32,
        /// WGSL rounds uniforms up.
        pub _pad: u32,
    }
}

const TARGET: wgpu::TextureFormat = wgpu::TextureFormat::R8Unorm;

/// All passes, each as a kernel for triangles without holes and, where the scene has any, one for those with holes.
pub(crate) struct Raster {
    mark: Vec<RasterKernel>,
    vote: Vec<RasterKernel>,
    bend: Vec<RasterKernel>,
}

/// What a pass reads.
pub(crate) struct Input<'a> {
    pub scene: &'a GpuScene,
    pub mesh: &'a GpuMesh,
    pub uniform: &'a Buffer,
    pub target: &'a Texture,
    pub axes: Axes,
    pub thickness: Thickness,
}

impl Input<'_> {
    fn axis_count(&self) -> u32 {
        match (self.axes, self.thickness) {
            (Axes::All, Thickness::Thin) => 3,
            (Axes::Dominant, _) | (_, Thickness::Conservative) => 1,
        }
    }

    /// Three corners per axis, or two triangles around all columns; 9 x 2^24 is a u32.
    fn vertices_per_triangle(&self) -> u32 {
        let per_axis = if self.thickness == Thickness::Thin { 3 } else { 6 };
        per_axis * self.axis_count()
    }

    fn draw(
        &self,
        recorder: &mut Recorder<'_>,
        pass: &str,
        kernels: &[RasterKernel],
        params: RasterParams,
        after: &[&Buffer],
    ) {
        let params = recorder.uniform(&RasterParams { axes: self.axis_count(), ..params });
        let mut resources = vec![params.binding()];
        resources.extend(self.mesh.resources());
        resources.extend(self.scene.material_resources());
        resources.extend(after.iter().map(|b| b.as_entire_binding()));
        let colors = [(self.target.view(), Some(wgpu::Color::TRANSPARENT))];
        let targets = RasterTargets { colors: &colors, depth: None };
        let vertices = 0..self.vertices_per_triangle() * self.mesh.triangle_count;
        for kernel in kernels {
            recorder.raster(pass, kernel, &resources, &targets, vertices.clone());
        }
    }
}

impl Raster {
    pub(crate) fn new(gpu: &Gpu, scene: &GpuScene, thickness: Thickness) -> Result<Self, KernelError> {
        let cells = match thickness {
            Thickness::Thin => include_str!("thin.inc.wgsl"),
            Thickness::Conservative => include_str!("conservative.inc.wgsl"),
        };
        let sources = [
            surface::WGSL,
            brdf::WGSL,
            MESH_WGSL,
            MATERIAL_WGSL,
            GRID_WGSL,
            resolve::POINT_WGSL,
            CONSTANTS,
            include_str!("raster.wgsl"),
            cells,
        ];
        let kernel = |name, fragment, after: &[Bind], holes: bool| {
            let mut constants = scene.mesh.layout.constants().to_vec();
            constants.push(("raster_holes", f64::from(u8::from(holes))));
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
        })
    }

    /// One pixel per column, never written.
    pub(crate) fn target(gpu: &Gpu, side: u32) -> Result<Texture, GpuError> {
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT;
        gpu.texture(Room::Voxels, "Raster::target", [side, side, 1], 1, TARGET, usage)
    }

    /// Writes 1 for each brick cell that something is in; `marks` must be clear.
    pub(crate) fn mark(&self, recorder: &mut Recorder<'_>, input: &Input<'_>, marks: &Buffer) {
        input.draw(
            recorder,
            "voxel/raster/mark",
            &self.mark,
            RasterParams::default(),
            &[input.uniform, marks],
        );
    }

    /// Finds the winner of each cell of a batch; `keys` must be clear. Gives the rounds it took, and whether the last one
    /// was atomic.
    pub(crate) fn vote(
        &self,
        recorder: &mut Recorder<'_>,
        input: &Input<'_>,
        structure: &Buffer,
        slots: std::ops::Range<u32>,
        keys: &Buffer,
        changed: &Buffer,
    ) -> Result<(u32, bool), GpuError> {
        let round = |recorder: &mut Recorder<'_>, atomic_round| {
            let (first_slot, slot_count) = (slots.start, slots.len() as u32);
            let params = RasterParams { first_slot, slot_count, atomic_round, ..Default::default() };
            recorder.clear(changed);
            let buffers = [structure, input.uniform, keys, changed];
            input.draw(recorder, "voxel/raster/vote", &self.vote, params, &buffers);
        };
        for done in 1..=MOST_ROUNDS {
            round(recorder, 0);
            recorder.flush();
            if recorder.gpu().read_buffer::<u32>(changed)?.first() == Some(&0) {
                return Ok((done, false));
            }
        }
        round(recorder, 1);
        Ok((MOST_ROUNDS + 1, true))
    }

    /// Writes 1 for each record of a batch in whose cell surfaces meet at an angle; `bends` must be clear.
    pub(crate) fn bend(
        &self,
        recorder: &mut Recorder<'_>,
        input: &Input<'_>,
        batch: &Batch<'_>,
        first_record: u32,
        bend: Bend,
        keys: &Buffer,
        bends: &Buffer,
    ) {
        let (first_slot, slot_count) = (batch.slots.start, batch.slots.len() as u32);
        let Bend { flat, apart } = bend;
        let params = RasterParams { first_slot, slot_count, first_record, flat, apart, ..Default::default() };
        let buffers = [batch.structure, input.uniform, keys, bends];
        input.draw(recorder, "voxel/raster/bend", &self.bend, params, &buffers);
    }
}
