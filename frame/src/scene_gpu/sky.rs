//! The sky as a texture.
//!
//! In: [`scene::Sky`], radiance by direction. Out: an equirectangular `rgba32float` texture of radiance times
//! `radiance_scale`, looked up as [`scene::Sky::radiance`] does; a constant sky is one texel. A map wider than the
//! device's textures is averaged down, which keeps its mean.

use super::texels::Plane;
use crate::{Bind, Gpu, GpuError, Room, Texture};
use glam::Vec4;
use scene::Sky;
use wgpu::{TextureFormat, TextureUsages};

/// The snippet: `sky_radiance`.
pub const SKY_WGSL: &str = include_str!("sky.inc.wgsl");
/// The map.
pub const SKY_BIND: Bind = Bind::texture(1, 13, "sky_map");

/// Uploads it, and says where it had to be made smaller.
pub(super) fn upload(
    gpu: &Gpu,
    sky: &Sky,
    radiance_scale: f32,
) -> Result<(Texture, Option<String>), GpuError> {
    let mut warning = None;
    let mut plane = match sky {
        Sky::Constant(radiance) => Plane { size: [1, 1], texels: vec![radiance.extend(1.0)] },
        Sky::Map(map) => Plane {
            size: [map.width as usize, map.height as usize],
            texels: map.radiance.iter().map(|texel| texel.extend(1.0)).collect(),
        },
    };
    let most = gpu.device.limits().max_texture_dimension_2d as usize;
    let size = plane.size;
    while plane.size[0] > most || plane.size[1] > most {
        plane = plane.averaged(plane.size.map(|n| n.div_ceil(2)));
    }
    if plane.size != size {
        let ([w, h], [to_w, to_h]) = (size, plane.size);
        warning =
            Some(format!("sky of {w} x {h} is averaged to {to_w} x {to_h}: textures end at {most} texels"));
    }
    let size = plane.size.map(|n| n as u32);
    let usage = TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST;
    let texture = gpu.texture(
        Room::Scene,
        "GpuScene::sky",
        [size[0], size[1], 1],
        1,
        TextureFormat::Rgba32Float,
        usage,
    )?;
    let scale = Vec4::new(radiance_scale, radiance_scale, radiance_scale, 1.0);
    plane.texels.iter_mut().for_each(|texel| *texel *= scale);
    super::write(gpu, &texture, 0, 0, size, bytemuck::cast_slice(&plane.texels));
    Ok((texture, warning))
}
