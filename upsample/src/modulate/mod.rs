//! Light meets the surface it fell on: the one place where it is multiplied by colour and emission is added.
//!
//! Paper: "its light amount is modulated with the center fragment's albedo".
//!
//! In: demodulated light of both lobes for a display pixel, that pixel of the display-size G-buffer, the light found
//! elsewhere (`direct`). Out: radiance times the scene's `radiance_scale`, linear Rec. 709, at most 65,504:
//!
//! ```text
//! out = M_d diffuse + M_s specular + emission        M_d, M_s: frame::brdf
//! out = sky(view ray)                                where nothing was hit
//! ```
//!
//! Departs from the paper: two lobes, each with its own modulator, where the paper has one light and the albedo; and
//! the emission of what is seen, on which the paper is silent.

pub mod reference;

use frame::info::{self, Frame};
use frame::scene_gpu::{self, GpuScene};
use frame::{Bind, GBuffer, RadianceImage, Uniform, brdf, surface};
use wgpu::BindingResource;

/// What comes before an upsampler's own shader.
pub(crate) const SOURCES: [&str; 6] = [
    info::WGSL,
    surface::WGSL,
    brdf::WGSL,
    frame::HALF_WGSL,
    scene_gpu::SKY_WGSL,
    include_str!("modulate.inc.wgsl"),
];

/// What these sources bind, before an upsampler's own.
pub(crate) const BINDS: [Bind; 9] = [
    Bind::uniform::<Frame>(0, 0, "frame"),
    scene_gpu::SKY_BIND,
    scene_gpu::BRDF_TABLE_BIND,
    Bind::texture_uint(2, 0, "display_surface"),
    Bind::texture(2, 1, "display_distance"),
    Bind::texture(2, 2, "direct_diffuse"),
    Bind::texture(2, 3, "direct_specular"),
    Bind::texture(2, 4, "light_diffuse"),
    Bind::texture(2, 5, "light_specular"),
];

/// The resources of [`BINDS`]. What stands in for a missing lobe or missing direct light is bound and never looked at.
pub(crate) fn resources<'a>(
    uniform: &'a Uniform,
    scene: &'a GpuScene,
    light: &'a RadianceImage,
    display: &'a GBuffer,
    direct: Option<&'a RadianceImage>,
) -> [BindingResource<'a>; 9] {
    use BindingResource::TextureView as View;
    let direct = direct.unwrap_or(light);
    let specular = |image: &'a RadianceImage| View(image.specular.as_ref().unwrap_or(&image.diffuse).view());
    [
        uniform.binding(),
        View(scene.sky.view()),
        scene.brdf_table.as_entire_binding(),
        View(display.surface.view()),
        View(display.distance.view()),
        View(direct.diffuse.view()),
        specular(direct),
        View(light.diffuse.view()),
        specular(light),
    ]
}

/// How many lobes of an image hold something.
pub(crate) fn lobe_count(image: Option<&RadianceImage>) -> u32 {
    image.map_or(0, |image| 1 + u32::from(image.specular.is_some()))
}
