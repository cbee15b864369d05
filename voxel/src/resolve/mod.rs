//! What each occupied voxel looks like: its winning triangle, seen once.
//!
//! Paper: "the voxelized image encodes such information as refractive index, bi-directional roughness, albedo,
//! emissivity, world space normals, tangents and bitangents".
//!
//! In: winners by cell, the mesh (world, m), materials; per voxel a factor of its emission. Out: a packed
//! [`frame::surface`] record per voxel. The surface is taken at the point of the triangle that is nearest to the voxel's
//! centre, through a footprint of one voxel face (`voxel_size^2`, m^2): textures are read at the mip whose texels are
//! voxels. Rounding of colours is decided by a hash of the cell.
//!
//! Departs from the paper: shading happens once per voxel and not once per fragment, so a record is never torn between
//! two triangles.

use crate::Grid;
use crate::grid::GRID_WGSL;
use crate::record::RecordLayout;
use frame::scene_gpu::{GpuScene, MATERIAL_BINDS, MATERIAL_WGSL, MESH_BINDS, MESH_WGSL};
use frame::{Bind, Gpu, Kernel, KernelDesc, KernelError, brdf, surface};

/// `voxel_point` and its kin, after surface, mesh and grid.
pub(crate) const POINT_WGSL: &str = include_str!("point.inc.wgsl");

frame::gpu_struct! {
    /// See `resolve.wgsl`.
    pub struct ResolveParams {
        /// First slot of the batch.
        pub first_slot: u32,
        /// Voxels of the batch.
        pub voxel_count: u32,
        /// Invocations per row of the dispatch.
        pub row: u32,
        /// WGSL rounds uniforms up.
        pub _pad: u32,
    }
}

/// Takes, in order: params, mesh (2), materials (11), grid, keys, bricks, list, bends, records.
pub(crate) fn kernel(gpu: &Gpu, scene: &GpuScene) -> Result<Kernel, KernelError> {
    let mut bindings = vec![Bind::uniform::<ResolveParams>(0, 1, "params")];
    bindings.extend(MESH_BINDS);
    bindings.extend(MATERIAL_BINDS);
    bindings.extend([
        Bind::uniform::<Grid>(1, 18, "grid"),
        Bind::storage_read(2, 0, "in_keys"),
        Bind::storage_read(2, 1, "in_bricks"),
        Bind::storage_read(2, 2, "in_list"),
        Bind::storage_read(2, 3, "in_bends"),
        Bind::storage(3, 0, "out_records"),
    ]);
    let mut sources = vec![surface::WGSL, brdf::WGSL, MESH_WGSL, MATERIAL_WGSL, GRID_WGSL, POINT_WGSL];
    sources.extend(RecordLayout::of(&scene.needs).stores());
    sources.push(include_str!("resolve.wgsl"));
    Kernel::new(
        gpu,
        &KernelDesc {
            name: "voxel/resolve",
            sources: &sources,
            entry: "resolve",
            workgroup: [64, 1, 1],
            bindings: &bindings,
            constants: &scene.constants(),
        },
    )
}
