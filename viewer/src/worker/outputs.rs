//! What passes wrote, brought back and unpacked: as a picture to look at, or every value at one place.

use frame::cpu::Image;
use frame::surface::{Surface, face_normal_unpack};
use frame::{Gpu, Texture};
use glam::Vec3;
use gridlight::Error;
use gridlight::pipeline::Rendered;
use half::f16;

/// How the numbers of an output are to be looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Meaning {
    /// Radiance: exposure applies.
    Radiance,
    /// 0..1 as it is.
    Share,
    /// Metres, counts: from 0 to the largest, in the colours of a map.
    Amount,
}

/// What a pass wrote.
pub struct Output {
    /// The pass that was asked for.
    pub pass: String,
    /// What is seen of it.
    pub what: String,
    /// How to look at it.
    pub meaning: Meaning,
    /// Its texels; none where the pass left nothing that has a place on the screen.
    pub texels: Option<Image<[f32; 3]>>,
}

/// Reads what the pass of this name wrote: its own output, that of the last pass under its path, or its stage's.
///
/// # Errors
/// Reading back fails.
pub fn read(gpu: &Gpu, last: &Rendered, pass: &str) -> Result<Output, Error> {
    let scale = last.frame.radiance_scale;
    if let Some(part) = Part::ALL.into_iter().find(|part| part.name() == pass) {
        let words: Vec<[u32; 4]> = gpu.read_texture(&last.display.surface)?;
        let texels = words.into_iter().map(|words| part.of(words, scale)).collect();
        let (texels, meaning) = (Image::from_texels(last.display.size(), texels), part.meaning());
        return Ok(Output { pass: pass.into(), what: pass.into(), meaning, texels });
    }
    let Some((name, texture)) = find(last, pass) else {
        let what = format!("{pass} leaves no picture");
        return Ok(Output { pass: pass.into(), what, meaning: Meaning::Share, texels: None });
    };
    let (what, meaning) = reading(&texture);
    let texels = unpacked(gpu, &texture, scale)?;
    Ok(Output { pass: pass.into(), what: format!("{name}: {what}"), meaning, texels })
}

/// A part of what the G-buffer of display size holds, looked at as if a pass had written it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Base colour.
    Base,
    /// Shading normal, -1..1 as 0..1.
    Normal,
    /// Along tangent and bitangent, and metalness.
    Roughness,
    /// Radiance.
    Emission,
    /// Transmission.
    Transmission,
}

impl Part {
    /// In the order of the list.
    pub const ALL: [Self; 5] =
        [Self::Base, Self::Normal, Self::Roughness, Self::Emission, Self::Transmission];

    /// As the list calls it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Base => "base colour",
            Self::Normal => "normal",
            Self::Roughness => "roughness, metalness",
            Self::Emission => "emission",
            Self::Transmission => "transmission",
        }
    }

    fn meaning(self) -> Meaning {
        if self == Self::Emission { Meaning::Radiance } else { Meaning::Share }
    }

    fn of(self, words: [u32; 4], radiance_scale: f32) -> [f32; 3] {
        if words == [0; 4] {
            return [0.0; 3];
        }
        let surface = Surface::unpack_gbuffer(words);
        match self {
            Self::Base => surface.base.into(),
            Self::Normal => (0.5 * surface.normal + Vec3::splat(0.5)).into(),
            Self::Roughness => [surface.roughness.x, surface.roughness.y, surface.metalness],
            Self::Emission => (surface.emission / radiance_scale).into(),
            Self::Transmission => [surface.transmission; 3],
        }
    }
}

fn find(last: &Rendered, pass: &str) -> Option<(String, Texture)> {
    // A pass may keep what it wrote to itself.
    let outputs = || last.log.outputs.iter().filter(|(_, texture)| can_be_read(texture));
    let exact = outputs().find(|(name, _)| name == pass);
    let is_under = |name: &str| name.strip_prefix(pass).is_some_and(|rest| rest.starts_with('/'));
    if let Some((name, texture)) = exact.or_else(|| outputs().find(|(name, _)| is_under(name))) {
        return Some((name.clone(), texture.clone()));
    }
    let (name, texture) = match pass.split('/').next()? {
        "gather" if pass.contains("display") => ("G-buffer, display size", &last.display.surface),
        "gather" => ("G-buffer, trace size", &last.trace.surface),
        "trace" => ("light as traced, diffuse", &last.noisy.diffuse),
        "denoise" => ("light as filtered, diffuse", &last.denoised.diffuse),
        "upsample" => ("picture", &last.color.texture),
        _ => return None,
    };
    Some((name.into(), texture.clone()))
}

fn can_be_read(texture: &Texture) -> bool {
    texture.usage().contains(wgpu::TextureUsages::COPY_SRC)
}

/// What a texture holds, by its label where the format does not say.
fn reading(texture: &Texture) -> (&'static str, Meaning) {
    match (texture.format(), texture.label()) {
        (wgpu::TextureFormat::Rgba16Float, _) => ("radiance", Meaning::Radiance),
        (wgpu::TextureFormat::R32Float, _) => ("metres", Meaning::Amount),
        (wgpu::TextureFormat::Rgba32Uint, _) => ("base colour", Meaning::Share),
        (wgpu::TextureFormat::R32Uint, "GBuffer::face_normal") => ("face normal", Meaning::Share),
        (wgpu::TextureFormat::Rg32Uint, _) => ("object", Meaning::Amount),
        _ => ("count", Meaning::Amount),
    }
}

fn unpacked(gpu: &Gpu, texture: &Texture, radiance_scale: f32) -> Result<Option<Image<[f32; 3]>>, Error> {
    let size = [texture.width(), texture.height()];
    let grey = |value: f32| [value; 3];
    let texels: Vec<[f32; 3]> = match (texture.format(), texture.label()) {
        (wgpu::TextureFormat::Rgba16Float, _) => gpu
            .read_texture::<[f16; 4]>(texture)?
            .into_iter()
            .map(|[r, g, b, _]| [r, g, b].map(|v| v.to_f32() / radiance_scale))
            .collect(),
        (wgpu::TextureFormat::R32Float, _) => {
            gpu.read_texture::<f32>(texture)?.into_iter().map(grey).collect()
        }
        (wgpu::TextureFormat::Rgba32Uint, "GBuffer::surface") => gpu
            .read_texture::<[u32; 4]>(texture)?
            .into_iter()
            .map(|words| if words == [0; 4] { [0.0; 3] } else { Surface::unpack_gbuffer(words).base.into() })
            .collect(),
        (wgpu::TextureFormat::R32Uint, "GBuffer::face_normal") => gpu
            .read_texture::<u32>(texture)?
            .into_iter()
            .map(|code| (0.5 * face_normal_unpack(code) + Vec3::splat(0.5)).into())
            .collect(),
        (wgpu::TextureFormat::R32Uint, _) => {
            gpu.read_texture::<u32>(texture)?.into_iter().map(|v| grey((v & 0xffff) as f32)).collect()
        }
        (wgpu::TextureFormat::Rg32Uint, _) => gpu
            .read_texture::<[u32; 2]>(texture)?
            .into_iter()
            .map(|[_, id]| grey((id & 0x7fff_ffff) as f32))
            .collect(),
        _ => return Ok(None),
    };
    Ok(Image::from_texels(size, texels))
}

/// Every value the passes saw at a place of the picture (0..1 across and down), by name.
///
/// # Errors
/// Reading back fails.
pub fn values(gpu: &Gpu, last: &Rendered, at: [f32; 2]) -> Result<Vec<(String, String)>, Error> {
    let mut all = Vec::new();
    let scale = last.frame.radiance_scale;
    let spot = |texture: &Texture| -> usize {
        let [x, y] = [(at[0], texture.width()), (at[1], texture.height())]
            .map(|(share, side)| ((share * side as f32) as u32).min(side.saturating_sub(1)));
        (y * texture.width() + x) as usize
    };
    for (name, gbuffer) in [("trace", &last.trace), ("display", &last.display)] {
        let at = spot(&gbuffer.surface);
        let words: Vec<[u32; 4]> = gpu.read_texture(&gbuffer.surface)?;
        let distance: Vec<f32> = gpu.read_texture(&gbuffer.distance)?;
        let normal: Vec<u32> = gpu.read_texture(&gbuffer.face_normal)?;
        let motion: Vec<[u32; 2]> = gpu.read_texture(&gbuffer.motion_id)?;
        let values = (words.get(at), distance.get(at), normal.get(at), motion.get(at));
        let (Some(words), Some(distance), Some(normal), Some([motion, id])) = values else { continue };
        let [width, height] = gbuffer.size();
        all.push((
            format!("{name} pixel"),
            format!("{}, {} of {width}x{height}", at as u32 % width, at as u32 / width),
        ));
        if *distance == 0.0 {
            all.push((format!("{name} hit"), "nothing".into()));
            continue;
        }
        let seen = Surface::unpack_gbuffer(*words);
        let [mx, my] = [*motion as u16, (*motion >> 16) as u16].map(|bits| f16::from_bits(bits).to_f32());
        let mut push = |what: &str, value: String| all.push((format!("{name} {what}"), value));
        push("distance", format!("{distance:.4} m"));
        push("normal", vector(seen.normal.into()));
        push("face normal", vector(face_normal_unpack(*normal).into()));
        push("base colour", vector(seen.base.into()));
        push("metalness", format!("{:.3}", seen.metalness));
        push("roughness", format!("{:.3}, {:.3}", seen.roughness.x, seen.roughness.y));
        push("f0", format!("{:.4}", seen.f0));
        push("transmission", format!("{:.3}", seen.transmission));
        push("emission", vector((seen.emission / scale).into()));
        push("motion", format!("{mx:.3}, {my:.3} px"));
        push("object", format!("{}", (id & 0x7fff_ffff).saturating_sub(1)));
    }
    for (name, light) in [("traced", &last.noisy), ("filtered", &last.denoised)] {
        let lobes = std::iter::once(("diffuse", &light.diffuse))
            .chain(light.specular.iter().map(|s| ("specular", s)));
        for (lobe, texture) in lobes {
            let texels: Vec<[f16; 4]> = gpu.read_texture(texture)?;
            if let Some(texel) = texels.get(spot(texture)) {
                let [r, g, b, a] = texel.map(f16::to_f32);
                let radiance = vector([r, g, b].map(|v| v / scale));
                all.push((format!("{name} {lobe}"), format!("{radiance}; path {a:.3} m")));
            }
        }
        let counts: Vec<u32> = gpu.read_texture(&light.samples)?;
        if let Some(count) = counts.get(spot(&light.samples)) {
            all.push((
                format!("{name} samples"),
                format!("{} diffuse, {} specular", count & 0xffff, count >> 16),
            ));
        }
    }
    for (name, texture) in &last.log.outputs {
        // The light and the G-buffers have been there already.
        let known = ["RadianceImage::", "GBuffer::"].iter().any(|label| texture.label().starts_with(label));
        if known || !can_be_read(texture) {
            continue;
        }
        let image = unpacked(gpu, texture, scale)?;
        let value = image.as_ref().and_then(|image| image.texels().get(spot(texture)));
        all.extend(value.map(|value| (name.clone(), vector(*value))));
    }
    Ok(all)
}

fn vector(v: [f32; 3]) -> String {
    format!("{:.4}, {:.4}, {:.4}", v[0], v[1], v[2])
}
