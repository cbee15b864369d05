//! Materials as shaders read them, and the snippet that makes a [`crate::surface::Surface`] of a point of a triangle.
//!
//! In: [`scene::Material`] (glTF 2.0 and its extensions, linear Rec. 709) and the [`TexturePool`]. Out: an array of
//! [`Material`], factors that multiply textures. What a shader finds:
//!
//! - `F0 = ((ior - 1) / (ior + 1))^2 * specular * luminance(specular colour)`; where light goes through, the first
//!   factor alone, because the index of refraction is read back from it.
//! - `alpha_t = mix(alpha, 1, strength^2)`, `alpha_b = alpha = roughness^2` (`KHR_materials_anisotropy`); the surface
//!   keeps their square roots.
//! - Emission is factor times texture times `radiance_scale`. An unlit material emits its base colour and reflects
//!   nothing.
//! - A mask's cutoff is applied to its texture's alpha before mips are made, as 0 or 1. The alpha of a mip is then the
//!   covered share, and a texel of it is solid from 1/2 on. (Vertex alpha multiplies that share.)
//! - Transmission without a volume is a thin sheet.
//!
//! Textures: bilinear in the mip whose texels have the area of the footprint, `round(log2(area of the footprint in
//! texels) / 2)`. Departs from glTF: one scalar F0, so a specular tint changes how much is reflected and not its colour.

use super::textures::{TexturePool, Use};
use super::{Model, SceneGpuError, SceneOptions, texels::Encoding};
use crate::{Bind, cpu};
use scene::{Alpha, TextureSlot, Wrap};

/// The snippet: `material_*` and its bindings, after [`crate::surface::WGSL`], [`crate::brdf::WGSL`] and
/// [`super::MESH_WGSL`].
pub const MATERIAL_WGSL: &str = include_str!("material.inc.wgsl");
/// Materials and the ten texture arrays.
pub const MATERIAL_BINDS: [Bind; 11] = [
    Bind::storage_read(1, 2, "materials").of::<Material>(),
    Bind::texture_array(1, 3, "textures_srgb_128"),
    Bind::texture_array(1, 4, "textures_srgb_256"),
    Bind::texture_array(1, 5, "textures_srgb_512"),
    Bind::texture_array(1, 6, "textures_srgb_1024"),
    Bind::texture_array(1, 7, "textures_srgb_2048"),
    Bind::texture_array(1, 8, "textures_linear_128"),
    Bind::texture_array(1, 9, "textures_linear_256"),
    Bind::texture_array(1, 10, "textures_linear_512"),
    Bind::texture_array(1, 11, "textures_linear_1024"),
    Bind::texture_array(1, 12, "textures_linear_2048"),
];

crate::gpu_struct! {
    /// See `material.inc.wgsl`.
    pub struct MaterialSlot {
        /// Dot with (u, v, 1).
        pub to_u: [f32; 3],
        /// Array 4 bits, layer 8, last mip 4, uv set 1, linear 1, wrap of u 2, wrap of v 2.
        pub texture: u32,
        /// Dot with (u, v, 1).
        pub to_v: [f32; 3],
        /// Columns in the low half, rows in the high one.
        pub size: u32,
    }
}

crate::gpu_struct! {
    /// See `material.inc.wgsl`.
    pub struct Material {
        /// Linear RGBA.
        pub base: [f32; 4],
        /// Times `radiance_scale`.
        pub emission: [f32; 3],
        /// Of a mask.
        pub cutoff: f32,
        /// 1/m.
        pub absorption: [f32; 3],
        /// 0..1.
        pub metalness: f32,
        /// Cosine and sine of the rotation, strength.
        pub anisotropy: [f32; 3],
        /// Perceptual.
        pub roughness: f32,
        /// Dielectric reflectance at normal incidence.
        pub f0: f32,
        /// 0..1.
        pub transmission: f32,
        /// Of the normal map's x and y.
        pub normal_scale: f32,
        /// Mask 1, blend 2, two-sided 4, thin 8, unlit 16; bit 8 + i: slot i is used.
        pub flags: u32,
        /// Dielectric reflectance at grazing incidence. A surface that is stored forgets it and has `min(1, F0 / 0.02)`.
        pub f90: f32,
        /// Mean luminance of what its front side emits, times `radiance_scale`; 0 = nothing. What light is looked for by.
        pub glow: f32,
        /// WGSL aligns the slots to 16.
        pub _pad: [u32; 2],
        /// In the order of `scene::Material::textures`.
        pub slots: [MaterialSlot; 8],
    }
}

const MASK: u32 = 1;
const BLEND: u32 = 2;
const TWO_SIDED: u32 = 4;
const THIN: u32 = 8;
const UNLIT: u32 = 16;
const FIRST_SLOT: u32 = 8;

/// More do not fit the 16 bits that a triangle has for its material.
const MOST: usize = 0xffff;

/// Whether light may pass straight through it.
pub(super) fn is_sheet(material: &Material) -> bool {
    let thin_pane = material.flags & THIN != 0 && material.transmission > 0.0;
    material.flags & (MASK | BLEND) != 0 || thin_pane
}

/// Materials with everything left out that cannot be seen, so that it costs neither memory nor look-ups.
pub(super) fn simplified(
    materials: &[scene::Material],
    options: &SceneOptions,
) -> Result<Vec<scene::Material>, SceneGpuError> {
    if materials.len() > MOST {
        return Err(SceneGpuError::TooManyMaterials { count: materials.len(), allowed: MOST });
    }
    Ok(materials.iter().map(|material| simplify(material, options)).collect())
}

fn simplify(material: &scene::Material, options: &SceneOptions) -> scene::Material {
    let mut m = material.clone();
    if options.model == Model::Lambert || m.unlit {
        m = scene::Material {
            metallic: 0.0,
            roughness: 1.0,
            metallic_roughness_texture: None,
            normal_texture: None,
            specular: 0.0,
            transmission: 0.0,
            anisotropy: 0.0,
            ..m
        };
    }
    if m.transmission > 0.0 {
        m.specular = 1.0;
        m.specular_texture = None;
        m.specular_color = glam::Vec3::ONE;
        m.specular_color_texture = None;
        if options.as_references {
            m.transmission_texture = None;
            if let Some(volume) = &mut m.volume {
                volume.attenuation_distance = f32::INFINITY;
            }
            // A mere dielectric there, by the factors alone.
            if m.transmission >= 0.999 {
                m.metallic = 0.0;
                m.metallic_roughness_texture = None;
                m.roughness = if m.volume.is_some() { m.roughness } else { 0.0 };
            }
        }
    } else {
        m.transmission_texture = None;
        m.volume = None;
    }
    if m.specular == 0.0 || m.specular_color == glam::Vec3::ZERO {
        m.specular = 0.0;
        m.specular_texture = None;
        m.specular_color_texture = None;
    }
    if m.emission == glam::Vec3::ZERO || m.unlit {
        m.emission_texture = None;
    }
    if m.anisotropy == 0.0 {
        m.anisotropy_rotation = 0.0;
        m.anisotropy_texture = None;
    }
    m
}

/// What the slots of these materials read, each once, in the order of materials.
pub(super) fn uses(materials: &[scene::Material]) -> Vec<Use> {
    let mut known = std::collections::HashSet::new();
    materials.iter().flat_map(slots).flatten().map(|(_, u)| u).filter(|u| known.insert(*u)).collect()
}

/// The slots in use, in the shader's order.
fn slots(material: &scene::Material) -> [Option<(TextureSlot, Use)>; 8] {
    let mut is_base = true;
    material.textures().map(|(slot, is_srgb)| {
        let threshold = if std::mem::take(&mut is_base) { threshold(material) } else { None };
        let encoding = if is_srgb { Encoding::Srgb } else { Encoding::Linear };
        slot.map(|slot| (slot, Use { image: slot.image, encoding, threshold }))
    })
}

/// The least 8-bit alpha of a mask's texture that is solid; 256 where nothing is.
fn threshold(material: &scene::Material) -> Option<u16> {
    let Alpha::Mask(cutoff) = material.alpha else { return None };
    let factor = material.base_color.w;
    let codes = (0..=255u16).find(|&code| f32::from(code) / 255.0 * factor >= cutoff);
    Some(codes.unwrap_or(256))
}

/// As the shader reads it.
/// `glow` is the mean luminance of its emission, times `radiance_scale`.
pub(super) fn encode(
    material: &scene::Material,
    pool: &TexturePool,
    radiance_scale: f32,
    glow: f32,
) -> Material {
    let mut flags = 0;
    let mut base = material.base_color;
    let mut cutoff = 0.0;
    match material.alpha {
        Alpha::Opaque => {}
        Alpha::Blend => flags |= BLEND,
        Alpha::Mask(value) => {
            flags |= MASK;
            cutoff = value;
            if material.base_color_texture.is_some() {
                base.w = 1.0;
                cutoff = 0.5;
            }
        }
    }
    if material.double_sided {
        flags |= TWO_SIDED;
    }
    if material.transmission > 0.0 && material.volume.is_none() {
        flags |= THIN;
    }
    if material.unlit {
        flags |= UNLIT;
    }
    let mut encoded = [MaterialSlot::default(); 8];
    for (index, (slot, u)) in
        slots(material).into_iter().enumerate().filter_map(|(i, used)| used.map(|u| (i, u)))
    {
        if let Some(place) = pool.place(&u) {
            encoded[index] = encode_slot(&slot, &place);
            flags |= 1 << (FIRST_SLOT + index as u32);
        }
    }
    let emission = if material.unlit { glam::Vec3::ONE } else { material.emission };
    let (sin, cos) = material.anisotropy_rotation.sin_cos();
    let root = (material.ior - 1.0) / (material.ior + 1.0);
    let tint = cpu::luminance(material.specular_color.to_array());
    Material {
        base: base.into(),
        emission: (radiance_scale * emission).into(),
        cutoff,
        absorption: material.volume.map(|volume| volume.absorption()).unwrap_or_default().into(),
        metalness: material.metallic,
        anisotropy: [cos, sin, material.anisotropy],
        roughness: material.roughness,
        f0: (root * root * material.specular * tint).min(1.0),
        transmission: material.transmission,
        normal_scale: material.normal_scale,
        flags,
        f90: material.specular,
        glow,
        _pad: [0; 2],
        slots: encoded,
    }
}

fn encode_slot(slot: &TextureSlot, place: &super::textures::Place) -> MaterialSlot {
    let wrap = |wrap: Wrap| match wrap {
        Wrap::Repeat => 0,
        Wrap::Mirror => 1,
        Wrap::Clamp => 2,
    };
    MaterialSlot {
        to_u: slot.uv_transform.row(0).into(),
        texture: place.array
            | (place.layer << 4)
            | (place.last_mip() << 12)
            | (slot.uv_set.min(1) << 16)
            | (u32::from(slot.linear) << 17)
            | (wrap(slot.wrap[0]) << 18)
            | (wrap(slot.wrap[1]) << 20),
        to_v: slot.uv_transform.row(1).into(),
        size: place.size[0] | (place.size[1] << 16),
    }
}
