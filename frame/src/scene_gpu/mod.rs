//! The scene, uploaded: what binds as group 1, and the snippets that read it.
//!
//! In: [`scene::Scene`] and its [`scene::Geometry`] at one moment (world space, m, linear Rec. 709). Out: [`GpuScene`].
//! Group 1, the same in every kernel:
//!
//! | binding | name | from |
//! | --- | --- | --- |
//! | 0, 1, 20 | `mesh_vertices`, `mesh_triangles`, `mesh_previous` | [`MESH_WGSL`] |
//! | 2, 3 to 12 | `materials`, `textures_{srgb,linear}_{128..2048}` | [`MATERIAL_WGSL`] |
//! | 13 | `sky_map` | [`SKY_WGSL`] |
//! | 14 | `brdf_table` | [`crate::brdf::WGSL`] |
//! | 15 | `lights` | [`LIGHT_WGSL`] |
//! | 19 | `sky_table` | [`SKY_TABLE_WGSL`] |
//! | 21 | `heights` | [`HEIGHT_WGSL`] |
//!
//! (16 to 18 are the voxel grid's.) Emission, sky and lights are stored times [`GpuScene::radiance_scale`].

mod emitters;
mod heights;
mod lights;
mod materials;
mod mesh;
pub mod reference;
mod sky;
mod sky_table;
#[cfg(test)]
mod tests;
mod texels;
mod textures;

pub use emitters::Emitter;
pub use heights::{HEIGHT_WGSL, HEIGHTS_BIND, HeightUse, Heights};
pub use lights::{LIGHT_VECTORS, LIGHT_WGSL, LIGHTS_BIND, Light, RadianceScale};
pub use materials::{MATERIAL_BINDS, MATERIAL_WGSL, Material, MaterialSlot};
pub use mesh::{GpuMesh, MESH_BINDS, MESH_PREVIOUS_BIND, MESH_WGSL, VertexLayout};
pub use sky::{SKY_BIND, SKY_WGSL};
pub use sky_table::{SKY_TABLE_BIND, SKY_TABLE_WGSL};
pub use texels::Encoding;
pub use textures::{CLASSES, Place, TexturePool, Use};

use crate::brdf::BrdfTable;
use crate::{Bind, Buffer, Gpu, GpuError, Room, Texture, cpu};
use glam::Vec3;
pub use scene::Aabb;
use scene::{Geometry, Scene, SceneNeeds};
use wgpu::BindingResource;

/// The table.
pub const BRDF_TABLE_BIND: Bind = Bind::uniform_array(1, 14, "brdf_table");

/// Texture bytes where nobody says otherwise: 97 textures of 1024 texels a side with their mips.
const TEXTURE_BUDGET_BYTES: u64 = 512_000_000;

/// Why a scene does not fit the GPU.
#[derive(Debug, thiserror::Error)]
pub enum SceneGpuError {
    /// More materials than a triangle's record can name.
    #[error("the scene has {count} materials, a triangle's record names at most {allowed}; merge some")]
    TooManyMaterials {
        /// In the scene.
        count: usize,
        /// At most.
        allowed: usize,
    },
    /// More pictures than the arrays have layers.
    #[error(
        "the scene uses {count} textures, the texture arrays hold at most {allowed} of a kind; merge some"
    )]
    TooManyTextures {
        /// In the scene.
        count: usize,
        /// At most.
        allowed: usize,
    },
    /// An allocation was refused.
    #[error(transparent)]
    Gpu(#[from] GpuError),
}

/// How much of a material is modelled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Model {
    /// All of glTF 2.0 and the extensions [`scene`] reads.
    #[default]
    Gltf,
    /// Base colour, masks and emission; no normal maps, nothing specular, nothing goes through.
    Lambert,
}

/// How a scene is uploaded.
#[derive(Clone, Copy, Debug, Default)]
pub struct SceneOptions {
    /// How much of a material is modelled.
    pub model: Model,
    /// Bytes of textures above which they are averaged down; none means 512 MB.
    pub texture_budget_bytes: Option<u64>,
    /// Leaves out what the shared reference images leave out of transmissive materials: textures of roughness and of
    /// transmission, absorption, and the roughness of thin panes.
    pub as_references: bool,
}

/// A scene on the GPU.
pub struct GpuScene {
    /// The triangles of this moment.
    pub mesh: GpuMesh,
    /// Array of [`Material`].
    pub materials: Buffer,
    /// All pictures.
    pub textures: TexturePool,
    /// All height maps.
    pub heights: Heights,
    /// Radiance by direction.
    pub sky: Texture,
    /// Where the sky is bright: what [`SKY_TABLE_WGSL`] samples it by; one texel where it is the same everywhere.
    pub sky_table: Texture,
    /// Luminance of the irradiance that a whole sky of its mean would give, times `radiance_scale`.
    pub sky_power: f32,
    /// [`BrdfTable`].
    pub brdf_table: Buffer,
    /// Array of [`Light`], the sun first.
    pub lights: Buffer,
    /// How many of them count: an empty list still has one element.
    pub light_count: u32,
    /// Stored radiance = radiance times this power of two.
    pub radiance_scale: f32,
    /// Box around every pose, m.
    pub bounds: Aabb,
    /// What has to be modelled, under the chosen [`Model`].
    pub needs: SceneNeeds,
    /// Per material, whether light may pass straight through: masks, blends, thin panes.
    pub sheets: Vec<bool>,
    /// Per material the mean luminance of what its front side emits, times `radiance_scale`.
    pub glows: Vec<f32>,
    /// Objects that glow, at the moment of upload.
    pub emitters: Vec<Emitter>,
    tail: Vec<Vec3>,
    sun: Option<scene::Sun>,
}

impl GpuScene {
    /// Uploads everything. The second value are warnings, one line each, with numbers.
    ///
    /// # Errors
    /// More materials or textures than can be addressed, a list larger than a binding may be, or out of memory.
    pub fn new(
        gpu: &Gpu,
        scene: &Scene,
        geometry: &Geometry,
        options: &SceneOptions,
    ) -> Result<(Self, Vec<String>), SceneGpuError> {
        let simplified = materials::simplified(&scene.materials, options)?;
        let budget = options.texture_budget_bytes.unwrap_or(TEXTURE_BUDGET_BYTES);
        let (textures, mut warnings) =
            TexturePool::new(gpu, &scene.images, &materials::uses(&simplified), budget)?;
        let RadianceScale { scale, lost } = RadianceScale::of(scene, geometry);
        if lost > 0 {
            warnings.push(format!("radiance_scale {scale}: {lost} radiances stay below the smallest step"));
        }
        let glows: Vec<f32> =
            simplified.iter().map(|m| scale * emitters::mean_luminance(m, &scene.images)).collect();
        let mut encoded: Vec<_> = simplified
            .iter()
            .zip(&glows)
            .map(|(m, glow)| materials::encode(m, &textures, scale, *glow))
            .collect();
        let sheets = encoded.iter().map(materials::is_sheet).collect();
        // A binding of an array holds at least one element.
        if encoded.is_empty() {
            encoded.push(Material::default());
        }
        let (sky, warning) = sky::upload(gpu, &scene.sky, scale)?;
        warnings.extend(warning);
        let sky_table = sky_table::upload(gpu, &scene.sky)?;
        let lights = lights::lights(scene.sun, geometry, scale);
        let result = Self {
            mesh: GpuMesh::new(gpu, geometry)?,
            materials: gpu.storage(Room::Scene, "GpuScene::materials", &encoded)?,
            textures,
            heights: Heights::new(gpu, &simplified, &scene.images, geometry, scene.bounds())?,
            sky,
            brdf_table: BrdfTable::new().upload(gpu)?,
            lights: gpu.storage(Room::Scene, "GpuScene::lights", &at_least_one(&lights))?,
            light_count: lights.len() as u32,
            radiance_scale: scale,
            bounds: scene.bounds(),
            needs: needs(scene, options.model),
            sheets,
            glows,
            sky_table,
            sky_power: scale * cpu::luminance(scene.sky.mean_radiance().to_array()) * std::f32::consts::PI,
            emitters: emitters::emitters(geometry, &simplified, &scene.images),
            tail: moving(geometry).to_vec(),
            sun: scene.sun,
        };
        Ok((result, warnings))
    }

    /// Takes over another moment: rewrites the moving tail of the mesh and the lights. What was there until now becomes
    /// the frame before; called again with the same geometry, everything stands still.
    pub fn update(&mut self, gpu: &Gpu, geometry: &Geometry) {
        self.mesh.rewrite_tail(gpu, geometry, &self.tail);
        self.tail.clear();
        self.tail.extend_from_slice(moving(geometry));
        let lights = lights::lights(self.sun, geometry, self.radiance_scale);
        if lights.len() as u32 == self.light_count && !lights.is_empty() {
            gpu.queue.write_buffer(&self.lights, 0, bytemuck::cast_slice(&lights));
        }
    }

    /// Values of the `override` constants of [`MESH_WGSL`] and [`MATERIAL_WGSL`] that are made for this scene alone.
    pub fn constants(&self) -> [(&'static str, f64); 4] {
        let [stride, uv1, color] = self.mesh.layout.constants();
        [stride, uv1, color, ("material_arrays", self.textures.used_arrays().into())]
    }

    /// Whether light comes from surfaces or from a sky that is brighter somewhere: what is worth aiming at.
    pub fn has_areas(&self) -> bool {
        self.has_sky_map() || self.glows.iter().any(|glow| *glow > 0.0)
    }

    /// Whether the sky is a map.
    pub fn has_sky_map(&self) -> bool {
        self.sky_table.width() > 1
    }

    /// What [`MATERIAL_BINDS`] binds.
    pub fn material_resources(&self) -> [BindingResource<'_>; 11] {
        let texture = |i: usize| BindingResource::TextureView(self.textures.arrays[i].view());
        std::array::from_fn(|i| match i {
            0 => self.materials.as_entire_binding(),
            _ => texture(i - 1),
        })
    }
}

/// Positions of the vertices that move, m.
fn moving(geometry: &Geometry) -> &[Vec3] {
    &geometry.positions[geometry.static_vertex_count() as usize..]
}

/// A binding of an array holds at least one element.
fn at_least_one<T: Clone + Default>(list: &[T]) -> Vec<T> {
    if list.is_empty() { vec![T::default()] } else { list.to_vec() }
}

fn needs(scene: &Scene, model: Model) -> SceneNeeds {
    let needs = scene.needs();
    match model {
        Model::Gltf => needs,
        Model::Lambert => SceneNeeds {
            specular: false,
            anisotropy: false,
            transmission: false,
            absorption: false,
            normal_maps: false,
            ..needs
        },
    }
}

/// Writes the top left corner of a layer of a mip.
fn write(gpu: &Gpu, texture: &Texture, mip_level: u32, layer: u32, size: [u32; 2], texels: &[u8]) {
    let [width, height] = size;
    let texel_bytes = texture.format().block_copy_size(None).unwrap_or(4);
    gpu.queue.write_texture(
        wgpu::TexelCopyTextureInfo {
            texture,
            mip_level,
            origin: wgpu::Origin3d { x: 0, y: 0, z: layer },
            aspect: wgpu::TextureAspect::All,
        },
        texels,
        wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(width * texel_bytes),
            rows_per_image: Some(height),
        },
        wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
    );
}
