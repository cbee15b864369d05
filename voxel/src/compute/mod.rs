//! Triangles to cells without a rasterizer: cubes that a triangle meets, by separating axes.
//!
//! Paper: none; it rasterises. Schwarz and Seidel 2010, sections 3 and 4, in the form with centres.
//!
//! In: a mesh in the world, m. Out: as [`crate::raster`], marks by brick cell, and keys by cell of a batch of bricks.
//!
//! - **Test** of a triangle with corners `v_i`, edges `e_i` and normal `N` against the cube of half a side `h` around `c`:
//!   boxes overlap; `|N . (c - v_0)| <= h |N|_1`; and in each of the three projections, for each edge turned inwards `m`,
//!   `m . (c - v_i) + h |m|_1 >= 0`. *Conservative*: misses no cell (it allows for 2^-12 cell and for what rounding may
//!   do to each product). *Thin*: `|.|_inf` for `|.|_1` and no allowance; the core that is left is 6-separating: a walk
//!   through faces of cells does not get past. There, as in [`crate::raster`], faces on a boundary between two layers go
//!   to the one behind.
//! - **Corners** are moved to multiples of 1/256 cell, and are given from the low corner of the brick at hand.
//! - **Lists**: a triangle is split into tiles of 8 x 8 columns of bricks along the axis its normal is longest on, one
//!   invocation each, so that one as large as the scene is as much work as many small ones; its bricks are those whose
//!   cubes it meets. Counting, a scan and a second visit make a list of triangles per brick.
//! - **Chunks**: lists are cut after [`CHUNK`] triangles. A workgroup takes a chunk, with the least key of each cell in
//!   its own memory, and writes that of the cells it found; a million triangles in one voxel are a thousand workgroups.
//! - **Bends**: a last visit of the same cells compares each triangle with the winner ([`crate::bend`]).
//! - **Key** and **holes**: as in [`crate::raster`]; the distance of the plane in 1/128 cell where thin, in 1/72 cell where
//!   conservative: the largest are 1/2 and 0.87.
//!
//! Minima do not ask who came first, so lists may be in any order and the voxels are the same.
//!
//! Longest loops: 64 columns x 5 bricks per tile, 16 triangles x 64 columns x 5 cells per invocation, and 16,384 chunks of
//! a brick that holds all 2^24 triangles. Triangles with a corner beyond 10^18 cells, or none, have no cells.

pub mod reference;
#[cfg(test)]
mod tests;

use crate::bend::{self, Bend};
use crate::grid::GRID_WGSL;
use crate::raster::{CONSTANTS as RASTER_CONSTANTS, Input};
use crate::structure::{Structure, Sums, rows};
use crate::voxelizer::words;
use crate::{Cover, Grid, resolve};
use frame::scan::SCAN_WGSL;
use frame::scene_gpu::{GpuScene, MATERIAL_BINDS, MATERIAL_WGSL, MESH_BINDS, MESH_WGSL};
use frame::{Bind, Buffer, Gpu, GpuError, Kernel, KernelDesc, KernelError, Recorder, Room, brdf, surface};
use std::ops::Range;

macro_rules! shared_constants {
    ($($(#[$doc:meta])* $name:ident: $type:ident = $value:literal;)*) => {
        $($(#[$doc])* pub const $name: $type = $value;)*

        const CONSTANTS: &str =
            concat!($("const COMPUTE_", stringify!($name), ": ", stringify!($type), " = ", stringify!($value), ";\n",)*);
    };
}

shared_constants! {
    /// Most triangles that a workgroup takes.
    CHUNK: u32 = 1024;
    /// Columns of bricks per side of a tile.
    TILE: u32 = 8;
    /// Steps per cell of a key's distance, thin.
    STEPS_THIN: f32 = 128.0;
    /// The same, conservative.
    STEPS_CONSERVATIVE: f32 = 72.0;
}

frame::gpu_struct! {
    /// See `params.inc.wgsl`.
    pub struct ComputeParams {
        /// Triangles, items, brick cells or chunks.
        pub count: u32,
        /// Invocations, or workgroups, per row of the dispatch.
        pub row: u32,
        /// Number of the first triangle.
        pub first_triangle: u32,
        /// Of the batch.
        pub first_slot: u32,
        /// Of the batch.
        pub slot_count: u32,
        /// 1: thin, 0: conservative.
        pub is_thin: u32,
        /// Of [`Bend`].
        pub flat: f32,
        /// Of [`Bend`].
        pub apart: f32,
        /// The first triangle that moves.
        pub first_moving: u32,
        /// WGSL aligns vectors.
        pub _pad: [u32; 3],
        /// Bricks that are made already: the first.
        pub kept_low: [i32; 3],
        /// WGSL aligns vectors.
        pub _pad_low: u32,
        /// One behind the last.
        pub kept_high: [i32; 3],
        /// WGSL rounds uniforms up.
        pub _pad_high: u32,
    }
}

/// All passes; the last three as a kernel for triangles without holes and, where the scene has any, one for those with.
pub(crate) struct Compute {
    measure: Kernel,
    split: Kernel,
    count: Kernel,
    measure_chunks: Kernel,
    cut: Kernel,
    fill: Kernel,
    mark: Vec<Kernel>,
    vote: Vec<Kernel>,
    bend: Vec<Kernel>,
}

/// Triangles by brick, cut into chunks.
pub(crate) struct Lists {
    chunks: Buffer,
    chunk_count: u32,
    triangles: Buffer,
}

impl Compute {
    pub(crate) fn new(gpu: &Gpu, scene: &GpuScene) -> Result<Self, KernelError> {
        let tests = [
            RASTER_CONSTANTS,
            SCAN_WGSL,
            CONSTANTS,
            include_str!("params.inc.wgsl"),
            include_str!("sat.inc.wgsl"),
        ];
        let bins = |last: &[&'static str]| {
            let tiles = [include_str!("tiles.inc.wgsl")];
            [&[surface::WGSL, MESH_WGSL, GRID_WGSL], &tests[..], &tiles, last].concat()
        };
        let (count, fill, visit) =
            (include_str!("count.inc.wgsl"), include_str!("fill.inc.wgsl"), include_str!("visit.wgsl"));
        let (counting, filling) = (bins(&[count, visit]), bins(&[fill, visit]));
        let bins = bins(&[include_str!("bin.wgsl")]);
        let surfaces = [surface::WGSL, brdf::WGSL, MESH_WGSL, MATERIAL_WGSL, GRID_WGSL, resolve::POINT_WGSL];
        let cells = |last: &[&'static str]| {
            [&surfaces[..], &tests, &[bend::WGSL, include_str!("cells.wgsl")], last].concat()
        };
        let (voting, bending) = (cells(&[include_str!("votes.wgsl")]), cells(&[include_str!("bends.wgsl")]));
        let of_mesh = scene.mesh.layout.constants();
        let kernel = |sources: &[&str], entry, bindings: Vec<&[Bind]>, constants: &[(&'static str, f64)]| {
            let params = [Bind::uniform::<ComputeParams>(0, 1, "params")];
            let bindings: Vec<_> = std::iter::once(&params[..]).chain(bindings).flatten().copied().collect();
            let desc = KernelDesc {
                name: entry,
                sources,
                entry,
                workgroup: [64, 1, 1],
                bindings: &bindings,
                constants,
            };
            Kernel::new(gpu, &desc)
        };
        let grid = [Bind::uniform::<Grid>(1, 18, "grid")];
        let sums = [Bind::storage_read(2, 0, "in_before"), Bind::storage_read(2, 1, "in_blocks")];
        let items = [Bind::storage_read(2, 2, "in_items")];
        let counts = [Bind::storage_read(2, 3, "in_counts")];
        let lists = [Bind::storage_read(2, 4, "in_chunks"), Bind::storage_read(2, 5, "in_lists")];
        let of_chunks =
            [Bind::storage_read(2, 6, "in_chunks_before"), Bind::storage_read(2, 7, "in_chunks_blocks")];
        let out = |at, name| [Bind::storage(3, at, name)];
        let (tiles, out_items, out_counts) = (out(0, "out_tiles"), out(1, "out_items"), out(2, "out_counts"));
        let (out_lists, chunk_counts) = (out(3, "out_lists"), out(4, "out_chunk_counts"));
        let (out_chunks, marks, keys) = (out(5, "out_chunks"), out(6, "out_marks"), out(7, "out_keys"));
        let structure = [Bind::storage_read(1, 16, "grid_structure")];
        let (winners, bends) = ([Bind::storage_read(2, 0, "in_keys")], out(0, "out_bends"));
        let mesh = &MESH_BINDS;
        let variants = |cells: &[&str], entry, marks: bool, after: Vec<&[Bind]>| {
            let holes = std::iter::once(false).chain(scene.needs.coverage.then_some(true));
            let of = |holes: bool| {
                let bindings =
                    [vec![&mesh[..], &MATERIAL_BINDS, &grid], after.clone(), vec![&lists]].concat();
                let mut constants = scene.constants().to_vec();
                constants.push(("compute_holes", f64::from(u8::from(holes))));
                constants.push(("compute_marks", f64::from(u8::from(marks))));
                kernel(cells, entry, bindings, &constants)
            };
            holes.map(of).collect::<Result<Vec<_>, _>>()
        };
        Ok(Self {
            measure: kernel(&bins, "compute_measure", vec![mesh, &grid, &tiles], &of_mesh)?,
            split: kernel(&bins, "compute_split", vec![&sums, &tiles, &out_items], &of_mesh)?,
            count: kernel(&counting, "compute_visit", vec![mesh, &grid, &items, &out_counts], &of_mesh)?,
            measure_chunks: kernel(&bins, "compute_measure_chunks", vec![&counts, &chunk_counts], &of_mesh)?,
            cut: kernel(&bins, "compute_cut", vec![&sums, &counts, &of_chunks, &out_chunks], &of_mesh)?,
            fill: kernel(
                &filling,
                "compute_visit",
                vec![mesh, &grid, &sums, &items, &out_counts, &out_lists],
                &of_mesh,
            )?,
            mark: variants(&voting, "compute_mark", true, vec![&marks])?,
            vote: variants(&voting, "compute_vote", false, vec![&structure, &keys])?,
            bend: variants(&bending, "compute_bend", false, vec![&structure, &winners, &bends])?,
        })
    }

    /// Lists of the triangles that each brick holds. Waits for their sizes.
    pub(crate) fn bin(
        &self,
        recorder: &mut Recorder<'_>,
        structure: &Structure,
        input: &Input<'_>,
        brick_cells: u32,
    ) -> Result<Lists, GpuError> {
        let gpu = recorder.gpu();
        let of_mesh = input.mesh.resources();
        let stage = input.stage;
        let pass = |recorder: &mut Recorder<'_>, part: &str, kernel, count, resources: &[Vec<_>]| {
            let (workgroups, row) = rows(count);
            let params = ComputeParams { count, row, ..input.params() };
            input.compute(recorder, part, kernel, params, resources, workgroups);
        };
        let triangles = input.triangles.len() as u32;
        let tiles = words(gpu, "Compute::tiles", u64::from(triangles))?;
        pass(
            recorder,
            "measure",
            &self.measure,
            triangles,
            &[of_mesh.to_vec(), bound(&[input.uniform, &tiles])],
        );
        let sums = Sums::new(gpu, Room::Voxels, triangles)?;
        structure.scan(recorder, stage, &tiles, triangles, &sums);
        let item_count = sums.total(recorder)?;
        let items = words(gpu, "Compute::items", 2 * u64::from(item_count.max(1)))?;
        let before = [&sums.before, &sums.blocks, &tiles, &items];
        pass(recorder, "split", &self.split, triangles, &[bound(&before)]);

        let counts = words(gpu, "Compute::counts", u64::from(brick_cells))?;
        let after = [input.uniform, &items, &counts];
        pass(recorder, "count", &self.count, item_count, &[of_mesh.to_vec(), bound(&after)]);
        let chunk_counts = words(gpu, "Compute::chunk_counts", u64::from(brick_cells))?;
        let measured = [&counts, &chunk_counts];
        pass(recorder, "measure_chunks", &self.measure_chunks, brick_cells, &[bound(&measured)]);
        let (sums, of_chunks) =
            (Sums::new(gpu, Room::Voxels, brick_cells)?, Sums::new(gpu, Room::Voxels, brick_cells)?);
        structure.scan(recorder, stage, &counts, brick_cells, &sums);
        structure.scan(recorder, stage, &chunk_counts, brick_cells, &of_chunks);
        let listed = sums.total(recorder)?;
        let chunk_count = of_chunks.total(recorder)?;
        let lists = Lists {
            chunks: words(gpu, "Compute::chunks", 4 * u64::from(chunk_count.max(1)))?,
            chunk_count,
            triangles: words(gpu, "Compute::lists", u64::from(listed))?,
        };
        let before =
            [&sums.before, &sums.blocks, &counts, &of_chunks.before, &of_chunks.blocks, &lists.chunks];
        pass(recorder, "cut", &self.cut, brick_cells, &[bound(&before)]);
        let after = [input.uniform, &sums.before, &sums.blocks, &items, &counts, &lists.triangles];
        pass(recorder, "fill", &self.fill, item_count, &[of_mesh.to_vec(), bound(&after)]);
        Ok(lists)
    }

    /// Writes 1 for each brick cell that something is in; `marks` must be clear.
    pub(crate) fn mark(&self, recorder: &mut Recorder<'_>, input: &Input<'_>, lists: &Lists, marks: &Buffer) {
        self.chunks(recorder, "mark", &self.mark, input, input.params(), lists, &[marks]);
    }

    /// Finds the winner of each cell of a batch; `keys` hold 0 or what is there already.
    pub(crate) fn vote(
        &self,
        recorder: &mut Recorder<'_>,
        input: &Input<'_>,
        lists: &Lists,
        structure: &Buffer,
        slots: Range<u32>,
        keys: &Buffer,
    ) {
        let params = input.params_of(slots);
        self.chunks(recorder, "vote", &self.vote, input, params, lists, &[structure, keys]);
    }

    /// Sets the bits of cells of a batch that are bent.
    pub(crate) fn bend(
        &self,
        recorder: &mut Recorder<'_>,
        input: &Input<'_>,
        lists: &Lists,
        structure: &Buffer,
        slots: Range<u32>,
        keys: &Buffer,
        bends: &Buffer,
    ) {
        let Bend { flat, apart } = input.bend;
        let first_moving = input.mesh.static_triangle_count;
        let params = ComputeParams { flat, apart, first_moving, ..input.params_of(slots) };
        self.chunks(recorder, "bend", &self.bend, input, params, lists, &[structure, keys, bends]);
    }

    fn chunks(
        &self,
        recorder: &mut Recorder<'_>,
        part: &str,
        kernels: &[Kernel],
        input: &Input<'_>,
        params: ComputeParams,
        lists: &Lists,
        buffers: &[&Buffer],
    ) {
        if lists.chunk_count == 0 {
            return;
        }
        // A workgroup per chunk, in rows of at most the default limit.
        let width = lists.chunk_count.min(65_535);
        let workgroups = [width, lists.chunk_count.div_ceil(width), 1];
        let params = ComputeParams { count: lists.chunk_count, row: width, ..params };
        let mut resources = input.mesh.resources().to_vec();
        resources.extend(input.scene.material_resources());
        resources.push(input.uniform.as_entire_binding());
        resources
            .extend(buffers.iter().chain(&[&lists.chunks, &lists.triangles]).map(|b| b.as_entire_binding()));
        for kernel in kernels {
            input.compute(recorder, part, kernel, params, &[resources.clone()], workgroups);
        }
    }
}

fn bound<'b>(buffers: &[&'b Buffer]) -> Vec<wgpu::BindingResource<'b>> {
    buffers.iter().map(|b| b.as_entire_binding()).collect()
}

impl Input<'_> {
    fn params(&self) -> ComputeParams {
        let is_thin = u32::from(self.cover != Cover::Conservative);
        let [kept_low, kept_high] = self.kept.map(Into::into);
        ComputeParams {
            first_triangle: self.triangles.start,
            is_thin,
            kept_low,
            kept_high,
            ..Default::default()
        }
    }

    fn params_of(&self, slots: Range<u32>) -> ComputeParams {
        ComputeParams { first_slot: slots.start, slot_count: slots.len() as u32, ..self.params() }
    }

    fn compute(
        &self,
        recorder: &mut Recorder<'_>,
        part: &str,
        kernel: &Kernel,
        params: ComputeParams,
        resources: &[Vec<wgpu::BindingResource<'_>>],
        workgroups: [u32; 3],
    ) {
        let params = recorder.uniform(&params);
        let resources: Vec<_> =
            std::iter::once(params.binding()).chain(resources.iter().flatten().cloned()).collect();
        recorder.compute(&format!("{}/{part}", self.stage), kernel, &resources, workgroups);
    }
}
