//! Directions in proportion to the sky's light, by an alias table over a coarse map of it.
//!
//! In: [`scene::Sky`]. Out: an equirectangular `rgba32float` texture of at most 256 x 128 cells: the cell's alias, the share of
//! the time it keeps itself (0..1), its density over the unit square of both texture coordinates. A constant sky is one cell:
//! there is nothing to aim at.
//!
//! A cell's weight is its mean luminance times the sine of its polar angle, and at least a thousandth of the mean weight, so
//! that no light of a bilinear look-up is out of reach. Per solid angle the density is that over `2 pi^2 sin(theta)`.

use super::texels::Plane;
use crate::{Alias, Bind, Gpu, GpuError, Room, Texture, cpu};
use glam::Vec4Swizzles;
use scene::Sky;
use std::f64::consts::PI;
use wgpu::{TextureFormat, TextureUsages};

/// The snippet: `sky_sample`, `sky_pdf`.
pub const SKY_TABLE_WGSL: &str = include_str!("sky_table.inc.wgsl");
/// The table.
pub const SKY_TABLE_BIND: Bind = Bind::texture(1, 19, "sky_table");

const MOST_CELLS: [usize; 2] = [256, 128];
/// Of the mean weight.
const LEAST_WEIGHT: f64 = 1e-3;

pub(super) fn upload(gpu: &Gpu, sky: &Sky) -> Result<Texture, GpuError> {
    let (size, texels) = table(sky);
    let [width, height] = size.map(|n| n as u32);
    let usage = TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST;
    let texture = gpu.texture(
        Room::Scene,
        "GpuScene::sky_table",
        [width, height, 1],
        1,
        TextureFormat::Rgba32Float,
        usage,
    )?;
    super::write(gpu, &texture, 0, 0, [width, height], bytemuck::cast_slice(&texels));
    Ok(texture)
}

fn table(sky: &Sky) -> ([usize; 2], Vec<[f32; 4]>) {
    let Sky::Map(map) = sky else { return ([1, 1], vec![[0.0, 1.0, 1.0, 0.0]]) };
    let full = Plane {
        size: [map.width as usize, map.height as usize],
        texels: map.radiance.iter().map(|texel| texel.extend(1.0)).collect(),
    };
    let size = [0, 1].map(|axis| full.size[axis].min(MOST_CELLS[axis]));
    let plane = full.averaged(size);
    let mut weights: Vec<f64> = plane
        .texels
        .iter()
        .enumerate()
        .map(|(i, texel)| {
            let sine = (PI * ((i / size[0]) as f64 + 0.5) / size[1] as f64).sin();
            f64::from(cpu::luminance(texel.xyz().to_array())) * sine
        })
        .collect();
    let mean = weights.iter().sum::<f64>() / weights.len() as f64;
    weights.iter_mut().for_each(|w| *w = w.max(LEAST_WEIGHT * mean));
    let alias = Alias::new(&weights);
    let mean = alias.total / weights.len() as f64;
    let density = |w: f64| if mean > 0.0 { (w / mean) as f32 } else { 1.0 };
    let texels =
        alias.entries.iter().zip(&weights).map(|((other, keep), w)| [*other as f32, *keep, density(*w), 0.0]);
    (size, texels.collect())
}
