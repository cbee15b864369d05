//! `gridlight info`: the adapter; with a scene, what it needs and the bytes each part takes.
//!
//! Bytes are those that were allocated: the street is built and one frame with a single path per pixel is rendered at
//! the sizes and the grid asked for.

use super::args::InfoArgs;
use super::bar::Bar;
use super::{json, print, table};
use crate::output::log::{Adapter, MemoryBytes};
use crate::pipeline::Pipeline;
use crate::{Error, RenderSettings};
use frame::Gpu;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write;
use voxel::VoxelGrid;

#[derive(Serialize)]
struct Info {
    adapter: Adapter,
    limits: BTreeMap<&'static str, u64>,
    features: Vec<&'static str>,
    scene: Option<SceneInfo>,
}

#[derive(Serialize)]
struct SceneInfo {
    name: String,
    triangles: u32,
    moving_triangles: u32,
    vertices: u32,
    materials: usize,
    images: usize,
    cameras: Vec<String>,
    lights: u32,
    bounds_min_m: [f32; 3],
    bounds_max_m: [f32; 3],
    duration_s: f32,
    needs: BTreeMap<&'static str, bool>,
    radiance_scale: f32,
    voxel_size_m: Option<f32>,
    /// Nested grids, each with voxels half as large as those of the one around it.
    voxel_levels: Option<u32>,
    finest_voxel_size_m: Option<f32>,
    voxels: Option<u32>,
    bricks: Option<u32>,
    /// Of a voxel's record: what the scene needs of 16.
    record_bytes: Option<u64>,
    /// What 16 bytes per voxel would take beyond that.
    saved_bytes: Option<u64>,
    /// What 16 bytes in every cell would take, of the finest level if there are more.
    dense_voxel_bytes: Option<u64>,
    memory_bytes: MemoryBytes,
    warnings: Vec<String>,
}

/// Describes the adapter, and the scene if there is one.
pub fn run(args: &InfoArgs) -> Result<(), Error> {
    let settings = args.street.settings()?;
    let gpu = Gpu::new(args.street.view.adapter.as_deref())?;
    let (adapter, limits) = (Adapter::of(&gpu), limits(&gpu));
    let features = gpu.device.features().iter_names().map(|(name, _)| name).collect();
    let scene = settings.map(|settings| describe(gpu, settings)).transpose()?;
    let info = Info { adapter, limits, features, scene };
    print(&if args.json { json(&info)? } else { info.text() })
}

/// The limits that scenes and pictures run into.
fn limits(gpu: &Gpu) -> BTreeMap<&'static str, u64> {
    let limits = gpu.device.limits();
    [
        ("max_buffer_size", limits.max_buffer_size),
        ("max_storage_buffer_binding_size", limits.max_storage_buffer_binding_size),
        ("max_texture_dimension_2d", limits.max_texture_dimension_2d.into()),
        ("max_texture_array_layers", limits.max_texture_array_layers.into()),
        ("max_bind_groups", limits.max_bind_groups.into()),
        ("max_storage_buffers_per_shader_stage", limits.max_storage_buffers_per_shader_stage.into()),
        ("max_sampled_textures_per_shader_stage", limits.max_sampled_textures_per_shader_stage.into()),
        ("max_storage_textures_per_shader_stage", limits.max_storage_textures_per_shader_stage.into()),
        ("max_compute_invocations_per_workgroup", limits.max_compute_invocations_per_workgroup.into()),
        ("max_compute_workgroup_storage_size", limits.max_compute_workgroup_storage_size.into()),
    ]
    .into()
}

fn describe(gpu: Gpu, settings: RenderSettings) -> Result<SceneInfo, Error> {
    let (bar, progress) = Bar::new(false);
    let settings = RenderSettings { spp: 1, bounces: Some(0), ..settings };
    let mut pipeline = Pipeline::new(gpu, &settings, progress)?;
    pipeline.render()?;
    drop(bar);
    let (scene, world, grid) = (pipeline.scene(), pipeline.world(), pipeline.grid());
    let bounds = scene.bounds();
    Ok(SceneInfo {
        name: scene.name.clone(),
        triangles: world.mesh.triangle_count,
        moving_triangles: world.mesh.triangle_count - world.mesh.static_triangle_count,
        vertices: world.mesh.vertex_count,
        materials: scene.materials.len(),
        images: scene.images.len(),
        cameras: scene.cameras.iter().map(|c| c.name.clone()).collect(),
        lights: world.light_count,
        bounds_min_m: (bounds.min + scene.origin()).into(),
        bounds_max_m: (bounds.max + scene.origin()).into(),
        duration_s: scene.duration(),
        needs: world.needs.list().into(),
        radiance_scale: world.radiance_scale,
        voxel_size_m: grid.map(|g| g.voxel_size),
        voxel_levels: grid.map(|g| g.levels),
        finest_voxel_size_m: grid.map(|g| g.voxel_size / finer(g) as f32),
        voxels: grid.map(|g| g.voxel_count),
        bricks: grid.map(|g| g.brick_count),
        record_bytes: grid.map(|g| g.record.bytes()),
        saved_bytes: grid.map(|g| (16 - g.record.bytes()) * u64::from(g.voxel_count)),
        dense_voxel_bytes: grid
            .map(|g| 16 * g.cells.map(|n| finer(g) * u64::from(n)).iter().product::<u64>()),
        memory_bytes: MemoryBytes::of(pipeline.gpu()),
        warnings: pipeline.warnings().to_vec(),
    })
}

/// Cells of the finest level per cell of the coarsest, along an axis.
fn finer(grid: &VoxelGrid) -> u64 {
    1 << (grid.levels - 1)
}

impl Info {
    fn text(&self) -> String {
        let Adapter { name, kind, backend, driver, driver_info, timestamps, loop_cap } = &self.adapter;
        let cap = loop_cap.map_or("none found".into(), |n| format!("{n} iterations"));
        let timestamps = if *timestamps { "yes" } else { "no" };
        let mut text = format!(
            "adapter     {name} ({kind}, {backend})\ndriver      {driver} {driver_info}\ntimestamps  {timestamps}\n\
             loop cap    {cap}\nfeatures    {}\nlimits\n",
            self.features.join(" ")
        );
        // Writing to a string cannot fail.
        for (limit, value) in &self.limits {
            let _ = writeln!(text, "  {limit:40} {value:>12}");
        }
        if let Some(scene) = &self.scene {
            text.push('\n');
            text.push_str(&scene.text());
        }
        text
    }
}

impl SceneInfo {
    fn text(&self) -> String {
        let needed: Vec<_> = self.needs.iter().filter(|(_, on)| **on).map(|(name, _)| *name).collect();
        let mut text = format!(
            "scene           {}\ntriangles       {} ({} moving)\nvertices        {}\nmaterials       {}\n\
             images          {}\ncameras         {}\nlights          {}\nbounds          {:?} to {:?} m\n\
             duration        {} s\nneeds           {}\nradiance scale  {}\n",
            self.name,
            self.triangles,
            self.moving_triangles,
            self.vertices,
            self.materials,
            self.images,
            self.cameras.len(),
            self.lights,
            self.bounds_min_m,
            self.bounds_max_m,
            self.duration_s,
            if needed.is_empty() { "nothing beyond Lambert".into() } else { needed.join(" ") },
            self.radiance_scale,
        );
        // Writing to a string cannot fail.
        if let (Some(voxels), Some(bricks), Some(size), Some(dense)) =
            (self.voxels, self.bricks, self.voxel_size_m, self.dense_voxel_bytes)
        {
            let dense = table::megabytes(dense);
            let _ =
                writeln!(text, "voxels          {voxels} of {size} m in {bricks} bricks (dense: {dense})");
            if let (Some(levels @ 2..), Some(finest)) = (self.voxel_levels, self.finest_voxel_size_m) {
                let _ = writeln!(text, "levels          {levels}, the finest of {finest} m");
            }
        }
        if let (Some(record), Some(saved)) = (self.record_bytes, self.saved_bytes) {
            let unneeded: Vec<_> = self.needs.iter().filter(|(_, on)| !**on).map(|(name, _)| *name).collect();
            let _ = writeln!(
                text,
                "records         {record} bytes of 16 per voxel, {} saved\nleft out        {}",
                table::megabytes(saved),
                unneeded.join(" ")
            );
        }
        text.push_str("memory\n");
        for (part, bytes) in self.memory_bytes.list() {
            let _ = writeln!(text, "  {part:12}  {:>12}", table::megabytes(bytes));
        }
        for warning in &self.warnings {
            let _ = writeln!(text, "warning: {warning}");
        }
        text
    }
}
