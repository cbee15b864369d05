//! Materials with their textures: metallic-roughness and the KHR extensions that [`Material`] models.
//!
//! Numbers out of their range are brought into it. A texture that cannot be read (a coordinate set above 1, no
//! source) is left out with a warning; the factor stays.

use super::{Document, Fault, item, spec_gloss, valid};
use crate::{Alpha, HeightMap, Material, TextureSlot, Volume, Wrap};
use glam::{Mat3, Vec2, Vec3, Vec4};
use gltf::json::extensions::texture::TextureTransform;
use gltf::json::material::AlphaMode;
use gltf::json::texture::{Info, MagFilter, WrappingMode};
use gltf::json::{Index, Root, Texture, material, validation::Checked};
use serde::de::DeserializeOwned;
use serde_json::Value;

/// All materials, and which pictures of the file their slots name, in the order of [`TextureSlot::image`].
pub(super) fn read(document: &mut Document) -> Result<(Vec<Material>, Vec<usize>), Fault> {
    let mut reader = Reader { root: &document.root, pictures: Vec::new(), warnings: Vec::new() };
    let mut materials = Vec::with_capacity(document.root.materials.len());
    for (i, material) in document.root.materials.iter().enumerate() {
        materials.push(reader.material(material, &format!("materials[{i}]"))?);
    }
    let Reader { pictures, warnings, .. } = reader;
    document.warnings.extend(warnings);
    Ok((materials, pictures))
}

struct Reader<'a> {
    root: &'a Root,
    pictures: Vec<usize>,
    warnings: Vec<String>,
}

impl Reader<'_> {
    fn material(&mut self, file: &material::Material, place: &str) -> Result<Material, Fault> {
        let pbr = &file.pbr_metallic_roughness;
        let base = pbr.base_color_factor.0;
        let mut m = Material {
            name: file.name.clone().unwrap_or_default(),
            base_color: Vec4::from(base.map(|x| share(x, 1.0))),
            base_color_texture: self.slot(&pbr.base_color_texture, place, "baseColorTexture")?,
            metallic: share(pbr.metallic_factor.0, 1.0),
            roughness: share(pbr.roughness_factor.0, 1.0),
            metallic_roughness_texture: self.slot(
                &pbr.metallic_roughness_texture,
                place,
                "metallicRoughnessTexture",
            )?,
            emission: color(file.emissive_factor.0),
            emission_texture: self.slot(&file.emissive_texture, place, "emissiveTexture")?,
            alpha: match valid(&file.alpha_mode, &format!("{place}.alphaMode"))? {
                AlphaMode::Opaque => Alpha::Opaque,
                AlphaMode::Mask => Alpha::Mask(positive(file.alpha_cutoff.map_or(0.5, |c| c.0), 0.5)),
                AlphaMode::Blend => Alpha::Blend,
            },
            double_sided: file.double_sided,
            ..Material::default()
        };
        if let Some(normal) = &file.normal_texture {
            let transform = normal.extensions.as_ref().and_then(|e| e.others.get("KHR_texture_transform"));
            let transform =
                transform.and_then(|t| serde_json::from_value::<TextureTransform>(t.clone()).ok());
            let asker = format!("{place}.normalTexture");
            m.normal_texture = self.texture(normal.index, normal.tex_coord, transform.as_ref(), &asker)?;
            m.normal_scale = if normal.scale.is_finite() { normal.scale } else { 1.0 };
        }
        if let Some(extensions) = &file.extensions {
            self.extensions(&mut m, extensions, place)?;
        }
        if let Some(extras) = &file.extras {
            m.height = self.height(extras.get(), place)?;
        }
        Ok(m)
    }

    fn extensions(
        &mut self,
        m: &mut Material,
        file: &gltf::json::extensions::material::Material,
        place: &str,
    ) -> Result<(), Fault> {
        m.unlit = file.unlit.is_some();
        if let Some(strength) = &file.emissive_strength {
            m.emission *= positive(strength.emissive_strength.0, 1.0);
        }
        if let Some(ior) = &file.ior {
            // 0 stands for full reflection at every angle; a very high index is that to within half a percent.
            m.ior = if ior.ior.0 == 0.0 { 1000.0 } else { positive(ior.ior.0, 1.5).max(1.0) };
        }
        if let Some(transmission) = &file.transmission {
            m.transmission = share(transmission.transmission_factor.0, 0.0);
            m.transmission_texture =
                self.slot(&transmission.transmission_texture, place, "transmissionTexture")?;
        }
        if let Some(volume) = &file.volume
            && volume.thickness_factor.0 > 0.0
        {
            let distance = volume.attenuation_distance.0;
            m.volume = Some(Volume {
                attenuation_distance: if distance > 0.0 { distance } else { f32::INFINITY },
                attenuation_color: Vec3::from(volume.attenuation_color.0.map(|x| share(x, 1.0))),
            });
        }
        if let Some(specular) = &file.specular {
            m.specular = share(specular.specular_factor.0, 1.0);
            m.specular_texture = self.slot(&specular.specular_texture, place, "specularTexture")?;
            m.specular_color = color(specular.specular_color_factor.0);
            m.specular_color_texture =
                self.slot(&specular.specular_color_texture, place, "specularColorTexture")?;
        }
        if let Some(anisotropy) = file.others.get("KHR_materials_anisotropy") {
            m.anisotropy = share(number(anisotropy, "anisotropyStrength", 0.0), 0.0);
            let rotation = number(anisotropy, "anisotropyRotation", 0.0);
            m.anisotropy_rotation = if rotation.is_finite() { rotation } else { 0.0 };
            m.anisotropy_texture =
                self.slot(&of_json(anisotropy.get("anisotropyTexture"), place)?, place, "anisotropyTexture")?;
        }
        if let Some(old) = file.others.get("KHR_materials_pbrSpecularGlossiness") {
            spec_gloss::convert(m, old);
            m.base_color_texture =
                self.slot(&of_json(old.get("diffuseTexture"), place)?, place, "diffuseTexture")?;
            m.metallic_roughness_texture = None;
            if old.get("specularGlossinessTexture").is_some() {
                self.warnings.push(format!("{place}: specularGlossinessTexture is left out"));
            }
        }
        Ok(())
    }

    /// `extras.heightTexture`, this project's own.
    fn height(&mut self, extras: &str, place: &str) -> Result<Option<HeightMap>, Fault> {
        // Extras are free: what is no height map is none of our business.
        let Ok(extras) = serde_json::from_str::<Value>(extras) else { return Ok(None) };
        let slot = self.slot(&of_json(extras.get("heightTexture"), place)?, place, "extras.heightTexture")?;
        let scale = number(&extras, "heightScale", 1.0);
        let is_depth = extras.get("heightIsDepth").and_then(Value::as_bool).unwrap_or(false);
        Ok(slot.filter(|_| scale.is_finite()).map(|texture| HeightMap { texture, scale, is_depth }))
    }

    fn slot(&mut self, info: &Option<Info>, place: &str, name: &str) -> Result<Option<TextureSlot>, Fault> {
        let Some(info) = info else { return Ok(None) };
        let transform = info.extensions.as_ref().and_then(|e| e.texture_transform.as_ref());
        self.texture(info.index, info.tex_coord, transform, &format!("{place}.{name}"))
    }

    fn texture(
        &mut self,
        index: Index<Texture>,
        tex_coord: u32,
        transform: Option<&TextureTransform>,
        asker: &str,
    ) -> Result<Option<TextureSlot>, Fault> {
        let texture = item(&self.root.textures, index, "textures", asker)?;
        let uv_set = transform.and_then(|t| t.tex_coord).unwrap_or(tex_coord);
        if uv_set > 1 {
            self.warnings
                .push(format!("{asker} is left out: it reads TEXCOORD_{uv_set}, only 0 and 1 are read"));
            return Ok(None);
        }
        let place = format!("textures[{}]", index.value());
        if texture.source.value() == u32::MAX as usize {
            self.warnings.push(format!("{asker} is left out: {place} has no PNG or JPEG source"));
            return Ok(None);
        }
        item(&self.root.images, texture.source, "images", &place)?;
        let picture = texture.source.value();
        let known = self.pictures.iter().position(|&p| p == picture);
        let image = known.unwrap_or_else(|| {
            self.pictures.push(picture);
            self.pictures.len() - 1
        });
        let (mut wraps, mut linear) = ([Wrap::Repeat; 2], true);
        if let Some(sampler) = texture.sampler {
            let sampler = item(&self.root.samplers, sampler, "samplers", &place)?;
            wraps = [wrap(&sampler.wrap_s, &place)?, wrap(&sampler.wrap_t, &place)?];
            linear = sampler.mag_filter != Some(Checked::Valid(MagFilter::Nearest));
        }
        let uv_transform = transform.map_or(Mat3::IDENTITY, uv_transform);
        Ok(Some(TextureSlot { image: image as u32, uv_set, uv_transform, wrap: wraps, linear }))
    }
}

/// Offset after rotation after scale. The rotation is counter-clockwise as the extension's text and most viewers have
/// it, with v pointing down; the extension's own GLSL turns the other way.
fn uv_transform(transform: &TextureTransform) -> Mat3 {
    let (offset, scale) = (Vec2::from(transform.offset.0), Vec2::from(transform.scale.0));
    let matrix =
        Mat3::from_translation(offset) * Mat3::from_angle(-transform.rotation.0) * Mat3::from_scale(scale);
    if matrix.is_finite() { matrix } else { Mat3::IDENTITY }
}

fn wrap(mode: &Checked<WrappingMode>, place: &str) -> Result<Wrap, Fault> {
    Ok(match valid(mode, &format!("the sampler of {place}"))? {
        WrappingMode::ClampToEdge => Wrap::Clamp,
        WrappingMode::MirroredRepeat => Wrap::Mirror,
        WrappingMode::Repeat => Wrap::Repeat,
    })
}

/// Part of an extension that the structs do not know.
fn of_json<T: DeserializeOwned>(value: Option<&Value>, place: &str) -> Result<Option<T>, Fault> {
    let Some(value) = value else { return Ok(None) };
    serde_json::from_value(value.clone()).map(Some).map_err(|fault| format!("{place}: {fault}"))
}

/// A number named in an extension that the structs do not know.
pub(super) fn number(value: &Value, key: &str, default: f32) -> f32 {
    value.get(key).and_then(Value::as_f64).map_or(default, |x| x as f32)
}

/// Within 0..1.
pub(super) fn share(x: f32, default: f32) -> f32 {
    if x.is_nan() { default } else { x.clamp(0.0, 1.0) }
}

/// Finite and not negative.
fn positive(x: f32, default: f32) -> f32 {
    if x.is_finite() { x.max(0.0) } else { default }
}

fn color(rgb: [f32; 3]) -> Vec3 {
    Vec3::from(rgb.map(|x| positive(x, 0.0)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use gltf::json::extensions::texture::{
        TextureTransformOffset, TextureTransformRotation, TextureTransformScale,
    };

    #[test]
    fn uvs_turn_counter_clockwise_seen_with_v_down() {
        let quarter = TextureTransform {
            rotation: TextureTransformRotation(std::f32::consts::FRAC_PI_2),
            ..TextureTransform::default()
        };
        // Right (1, 0) turns up, and up is -v.
        let up = uv_transform(&quarter).transform_point2(Vec2::X);
        assert!(up.abs_diff_eq(Vec2::NEG_Y, 1e-6), "{up}");
    }

    #[test]
    fn scale_comes_before_rotation_before_offset() {
        let transform = TextureTransform {
            offset: TextureTransformOffset([10.0, 20.0]),
            rotation: TextureTransformRotation(std::f32::consts::FRAC_PI_2),
            scale: TextureTransformScale([2.0, 3.0]),
            ..TextureTransform::default()
        };
        let uv = uv_transform(&transform).transform_point2(Vec2::new(1.0, 1.0));
        // (2, 3) turned counter-clockwise with v down is (3, -2). 1e-5: cos(pi/2) in f32 times 20.
        assert!(uv.abs_diff_eq(Vec2::new(13.0, 18.0), 1e-5), "{uv}");
    }
}
