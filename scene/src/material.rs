//! Materials as glTF 2.0 describes them, after the file's defaults have been filled in.
//!
//! Colours are linear Rec. 709; textures are named by slot, and say themselves how they wrap and filter.

use glam::{Mat3, Vec3, Vec4};

/// How a texture coordinate outside 0..1 is brought back, per axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Wrap {
    /// The fractional part (glTF's default).
    #[default]
    Repeat,
    /// Back and forth.
    Mirror,
    /// The border texel.
    Clamp,
}

/// A texture as one material slot uses it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureSlot {
    /// Index into [`crate::Scene::images`].
    pub image: u32,
    /// Which set of texture coordinates: 0 or 1.
    pub uv_set: u32,
    /// `KHR_texture_transform`, applied to `(u, v, 1)`; rotation counter-clockwise as the extension's text has it.
    pub uv_transform: Mat3,
    /// Along u and along v.
    pub wrap: [Wrap; 2],
    /// False when the sampler asks for the nearest texel.
    pub linear: bool,
}

/// What a fragment's alpha means.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub enum Alpha {
    /// Ignored.
    #[default]
    Opaque,
    /// Cut out below this value, solid from it on.
    Mask(f32),
    /// The share that is solid.
    Blend,
}

/// `KHR_materials_volume`: the surface closes off a solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Volume {
    /// Distance in metres at which `attenuation_color` of the light is left; infinite means clear.
    pub attenuation_distance: f32,
    /// Share of light left after `attenuation_distance`, 0..1.
    pub attenuation_color: Vec3,
}

impl Volume {
    /// Absorption coefficient in 1/m (Beer and Lambert): `-ln(color) / distance`, 0 where clear.
    pub fn absorption(&self) -> Vec3 {
        if !self.attenuation_distance.is_finite() || self.attenuation_distance <= 0.0 {
            return Vec3::ZERO;
        }
        self.attenuation_color.max(Vec3::splat(1e-6)).map(|c| -c.min(1.0).ln()) / self.attenuation_distance
    }
}

/// `extras.heightTexture` (this project's own; glTF has no height map).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeightMap {
    /// Red channel, linear.
    pub texture: TextureSlot,
    /// Metres over the whole range 0..1.
    pub scale: f32,
    /// Bright means deep instead of high.
    pub is_depth: bool,
}

/// One material. Factors multiply textures.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// From the file; may be empty.
    pub name: String,
    /// Linear RGB and opacity, 0..1.
    pub base_color: Vec4,
    /// sRGB colour and linear alpha.
    pub base_color_texture: Option<TextureSlot>,
    /// 0..1.
    pub metallic: f32,
    /// Perceptual roughness, 0..1; alpha is its square.
    pub roughness: f32,
    /// Green is roughness, blue is metalness, linear.
    pub metallic_roughness_texture: Option<TextureSlot>,
    /// Tangent space, linear, +Y up.
    pub normal_texture: Option<TextureSlot>,
    /// Scales the normal map's x and y.
    pub normal_scale: f32,
    /// Radiance leaving the front face: factor times strength, any non-negative value.
    pub emission: Vec3,
    /// sRGB.
    pub emission_texture: Option<TextureSlot>,
    /// What alpha means.
    pub alpha: Alpha,
    /// Both faces are seen; the back one with its normal turned.
    pub double_sided: bool,
    /// Index of refraction, 1 or more; 1.5 by default.
    pub ior: f32,
    /// `KHR_materials_specular` factor, 0..1.
    pub specular: f32,
    /// Alpha channel, linear.
    pub specular_texture: Option<TextureSlot>,
    /// Tint of the dielectric's reflection at normal incidence.
    pub specular_color: Vec3,
    /// sRGB.
    pub specular_color_texture: Option<TextureSlot>,
    /// Share of the light that is not reflected that goes through, 0..1.
    pub transmission: f32,
    /// Red channel, linear.
    pub transmission_texture: Option<TextureSlot>,
    /// Present where the surface closes off a solid; absent means a thin sheet.
    pub volume: Option<Volume>,
    /// `KHR_materials_anisotropy` strength, 0..1.
    pub anisotropy: f32,
    /// Radians, counter-clockwise from the tangent.
    pub anisotropy_rotation: f32,
    /// Red and green are a direction, blue a strength, linear.
    pub anisotropy_texture: Option<TextureSlot>,
    /// `KHR_materials_unlit`: the base colour is shown as it is.
    pub unlit: bool,
    /// A height map, if any.
    pub height: Option<HeightMap>,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            name: String::new(),
            base_color: Vec4::ONE,
            base_color_texture: None,
            metallic: 1.0,
            roughness: 1.0,
            metallic_roughness_texture: None,
            normal_texture: None,
            normal_scale: 1.0,
            emission: Vec3::ZERO,
            emission_texture: None,
            alpha: Alpha::Opaque,
            double_sided: false,
            ior: 1.5,
            specular: 1.0,
            specular_texture: None,
            specular_color: Vec3::ONE,
            specular_color_texture: None,
            transmission: 0.0,
            transmission_texture: None,
            volume: None,
            anisotropy: 0.0,
            anisotropy_rotation: 0.0,
            anisotropy_texture: None,
            unlit: false,
            height: None,
        }
    }
}

impl Material {
    /// A Lambert surface: no specular lobe at all.
    pub fn lambert(name: &str, albedo: Vec3) -> Self {
        Self {
            name: name.into(),
            base_color: albedo.extend(1.0),
            metallic: 0.0,
            specular: 0.0,
            ..Self::default()
        }
    }

    /// A Lambert surface that also emits from its front.
    pub fn emitter(name: &str, albedo: Vec3, emission: Vec3) -> Self {
        Self { emission, ..Self::lambert(name, albedo) }
    }

    /// Whether this material gives off light (an unlit one shows its base colour, which counts).
    pub fn emits(&self) -> bool {
        self.unlit || self.emission.max_element() > 0.0
    }

    /// The slots in use, in the fixed order of the shader's record, each with whether it holds sRGB colours.
    pub fn textures(&self) -> [(Option<TextureSlot>, bool); 8] {
        [
            (self.base_color_texture, true),
            (self.metallic_roughness_texture, false),
            (self.normal_texture, false),
            (self.emission_texture, true),
            (self.transmission_texture, false),
            (self.specular_texture, false),
            (self.specular_color_texture, true),
            (self.anisotropy_texture, false),
        ]
    }
}
