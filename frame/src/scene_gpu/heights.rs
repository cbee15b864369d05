//! Height maps as a compute pass reads them: one buffer with a record per material and all maps' texels and mips as f32.
//!
//! In: [`scene::HeightMap`] of each material (red channel of an 8-bit picture, linear; `scale` m over 0..1, depth counted
//! downwards). Out: [`Heights`]. Texels are kept as f32 and averaged so, because a mip of bytes makes terraces of slopes.
//! Apart from the texture arrays, because nothing that shades a surface reads heights: only a pass that moves vertices pays.
//!
//! | word of a record | content |
//! | --- | --- |
//! | 0 to 2, 3 to 5 | dot with (u, v, 1) gives the transformed u and v |
//! | 6 | metres over 0..1, negative where bright means deep; 0 = no map |
//! | 7, 8 | columns and rows of mip 0 |
//! | 9 | first word of mip 0; each next one follows the last |
//! | 10 | last mip 8, wrap of u 2, wrap of v 2, second coordinates 1 |
//! | 11 | unused |

use super::at_least_one;
use super::texels::{Encoding, Plane};
use crate::{Bind, Buffer, Gpu, GpuError, Room};
use glam::{Mat3, Vec2};
use scene::{Aabb, Geometry, Image, Material, Wrap};

/// The snippet: `height_*`.
pub const HEIGHT_WGSL: &str = include_str!("height.inc.wgsl");
/// What it reads.
pub const HEIGHTS_BIND: Bind = Bind::storage_read(1, 21, "heights");

const RECORD_WORDS: usize = 12;
/// How far a corner may move per metre of height: where three hard edges meet it is the root of 3.
const LONGEST: f32 = 1.75;

/// How a material's height map lies on its triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeightUse {
    /// Which texture coordinates: 0 or 1.
    pub uv_set: u32,
    /// Applied to (u, v, 1).
    pub uv_transform: Mat3,
    /// Whether the material has a normal map besides.
    pub has_normal_map: bool,
}

/// All height maps of a scene.
#[derive(Clone)]
pub struct Heights {
    /// Records, then texels.
    pub buffer: Buffer,
    /// Around everything that may be displaced and where it may be displaced to, m; empty where there is nothing.
    pub bounds: Aabb,
    uses: Vec<Option<HeightUse>>,
}

impl Heights {
    /// Uploads those that materials name.
    ///
    /// # Errors
    /// They do not fit a binding, or memory is out.
    pub fn new(
        gpu: &Gpu,
        materials: &[Material],
        images: &[Image],
        geometry: &Geometry,
        bounds: Aabb,
    ) -> Result<Self, GpuError> {
        let mut words = vec![0u32; RECORD_WORDS * materials.len()];
        let mut uses = vec![None; materials.len()];
        // First word and last mip of each picture that is there already.
        let mut places = std::collections::HashMap::new();
        for (index, material) in materials.iter().enumerate() {
            let Some(height) = material.height.filter(|height| height.scale != 0.0) else { continue };
            let Some(image) = images.get(height.texture.image as usize) else { continue };
            let (first, last_mip) =
                *places.entry(height.texture.image).or_insert_with(|| push_mips(&mut words, image));
            let wrap = |wrap| match wrap {
                Wrap::Repeat => 0,
                Wrap::Mirror => 1,
                Wrap::Clamp => 2,
            };
            let slot = height.texture;
            let scale = if height.is_depth { -height.scale } else { height.scale };
            let [to_u, to_v] = [0, 1].map(|row| slot.uv_transform.row(row).to_array().map(f32::to_bits));
            let record = [
                &to_u[..],
                &to_v,
                &[
                    scale.to_bits(),
                    image.width,
                    image.height,
                    first,
                    last_mip
                        | (wrap(slot.wrap[0]) << 8)
                        | (wrap(slot.wrap[1]) << 10)
                        | (slot.uv_set.min(1) << 12),
                ],
            ]
            .concat();
            words[RECORD_WORDS * index..][..record.len()].copy_from_slice(&record);
            uses[index] = Some(HeightUse {
                uv_set: slot.uv_set.min(1),
                uv_transform: slot.uv_transform,
                has_normal_map: material.normal_texture.is_some(),
            });
        }
        let buffer = gpu.storage(Room::Scene, "Heights::buffer", &at_least_one(&words))?;
        Ok(Self { buffer, bounds: reach(materials, &uses, geometry, bounds), uses })
    }

    /// How a material's map lies, if it has one.
    pub fn of(&self, material: u32) -> Option<HeightUse> {
        self.uses.get(material as usize).copied().flatten()
    }

    /// Whether any material has one.
    pub fn is_empty(&self) -> bool {
        self.uses.iter().all(Option::is_none)
    }
}

impl HeightUse {
    /// Coordinates in the map.
    pub fn place(&self, uv: [Vec2; 2]) -> Vec2 {
        self.uv_transform.transform_point2(uv[self.uv_set as usize])
    }
}

/// A box around both ends of every displacement. What moves may do so anywhere in the scene's `bounds`.
fn reach(materials: &[Material], uses: &[Option<HeightUse>], geometry: &Geometry, bounds: Aabb) -> Aabb {
    let mut reach = Aabb::EMPTY;
    for triangle in &geometry.triangles {
        let material = triangle.material as usize;
        let (Some(Some(map)), Some(height)) =
            (uses.get(material), materials.get(material).and_then(|m| m.height))
        else {
            continue;
        };
        let uv = |list: &[Vec2], vertex: u32| list.get(vertex as usize).copied().unwrap_or_default();
        let [a, b, c] =
            triangle.vertices.map(|vertex| map.place([uv(&geometry.uv0, vertex), uv(&geometry.uv1, vertex)]));
        // Coordinates at one point displace nothing.
        if (b - a).perp_dot(c - a) == 0.0 {
            continue;
        }
        let amount = LONGEST * if height.is_depth { -height.scale } else { height.scale };
        if geometry.objects.get(triangle.object as usize).is_some_and(|object| object.moving) {
            reach.grow(bounds.min - amount.abs());
            reach.grow(bounds.max + amount.abs());
        }
        for vertex in triangle.vertices {
            let position = geometry.positions[vertex as usize];
            reach.grow(position);
            reach.grow(position + amount * geometry.normals[vertex as usize]);
        }
    }
    reach
}

/// Appends all mips; the first word and the number of the last.
fn push_mips(words: &mut Vec<u32>, image: &Image) -> (u32, u32) {
    let first = words.len() as u32;
    let size = [image.width as usize, image.height as usize];
    let mut plane = Plane::decode(size, &image.rgba, Encoding::Linear, None);
    let last_mip = image.width.max(image.height).ilog2();
    for mip in 0..=last_mip {
        if mip > 0 {
            plane = plane.mip();
        }
        words.extend(plane.texels.iter().map(|texel| texel.x.to_bits()));
    }
    (first, last_mip)
}
