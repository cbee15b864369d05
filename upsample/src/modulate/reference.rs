//! The CPU half: the same functions as `modulate.inc.wgsl`, in the same order; modulators in f64.

use frame::brdf::{self, BrdfTable};
use frame::cpu::Image;
use frame::info::Frame;
use frame::surface::Surface;
use glam::{IVec2, UVec2, Vec2, Vec3};

/// Light of one size, as [`frame::RadianceImage`] holds it.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// rgb, and metres.
    pub diffuse: Image<[f32; 4]>,
    /// rgb, and metres.
    pub specular: Option<Image<[f32; 4]>>,
    /// Samples: diffuse in the low half, specular in the high half.
    pub samples: Image<u32>,
}

/// What upsamplers read of a G-buffer.
#[derive(Clone, Debug, PartialEq)]
pub struct Guides {
    /// Packed surfaces.
    pub surface: Image<[u32; 4]>,
    /// Metres along the ray; 0 = miss.
    pub distance: Image<f32>,
}

/// Everything an upsampler is given.
pub struct Inputs<'a> {
    /// As shaders see it.
    pub frame: Frame,
    /// At trace size.
    pub trace: &'a Guides,
    /// At trace size.
    pub light: &'a Light,
    /// At display size.
    pub display: &'a Guides,
    /// At display size.
    pub direct: Option<&'a Light>,
    /// Of the specular lobe.
    pub table: &'a BrdfTable,
    /// Radiance from a direction, times `radiance_scale`.
    pub sky: &'a dyn Fn(Vec3) -> Vec3,
}

/// The texel at `p`, or the default outside.
pub(crate) fn load<T: Copy + Default>(image: &Image<T>, p: UVec2) -> T {
    image.get(p.x as i32, p.y as i32).unwrap_or_default()
}

/// rgb of the texel at `p`.
pub(crate) fn rgb(image: &Image<[f32; 4]>, p: UVec2) -> Vec3 {
    let [r, g, b, _] = load(image, p);
    Vec3::new(r, g, b)
}

/// What a half float holds; not finite becomes 0.
fn stored(color: Vec3) -> [f32; 4] {
    color.map(|x| if x.is_finite() { x.min(65504.0) } else { 0.0 }).extend(1.0).to_array()
}

impl Inputs<'_> {
    /// The trace pixel under the centre of a display pixel.
    pub fn trace_pixel(&self, pixel: UVec2) -> UVec2 {
        (2 * pixel + 1) * UVec2::from(self.frame.trace_size) / (2 * UVec2::from(self.frame.display_size))
    }

    /// Unit direction through a point of a picture of this size, `frame_view_direction`.
    pub fn view_direction(&self, point: Vec2, size: [u32; 2]) -> Vec3 {
        let frame = &self.frame;
        let ndc = Vec2::new(2.0, -2.0) * (point / UVec2::from(size).as_vec2()) + Vec2::new(-1.0, 1.0);
        (Vec3::from(frame.forward) + ndc.x * Vec3::from(frame.right) + ndc.y * Vec3::from(frame.up))
            .normalize()
    }

    /// Through the centre of a display pixel.
    pub fn display_direction(&self, pixel: UVec2) -> Vec3 {
        self.view_direction(pixel.as_vec2() + 0.5, self.frame.display_size)
    }

    /// The picture's value from demodulated light.
    pub fn modulate(&self, pixel: UVec2, diffuse: Vec3, specular: Vec3) -> [f32; 4] {
        let direction = self.display_direction(pixel);
        let is_hit = load(&self.display.distance, pixel) > 0.0;
        if !is_hit {
            return stored((self.sky)(direction));
        }
        let (mut diffuse, mut specular) = (diffuse, specular);
        if let Some(direct) = self.direct {
            diffuse += rgb(&direct.diffuse, pixel);
            specular += direct.specular.as_ref().map_or(Vec3::ZERO, |image| rgb(image, pixel));
        }
        let surface = Surface::unpack_gbuffer(load(&self.display.surface, pixel));
        let mu = surface.normal.dot(-direction);
        let m = brdf::modulators(&surface, mu.into(), self.table);
        let out =
            m.diffuse * diffuse.as_dvec3() + m.specular * specular.as_dvec3() + surface.emission.as_dvec3();
        stored(out.as_vec3())
    }

    /// One value per display pixel.
    pub(crate) fn picture(&self, mut value: impl FnMut(UVec2) -> [f32; 4]) -> Image<[f32; 4]> {
        Image::from_fn(self.frame.display_size, |x, y| value(UVec2::new(x, y)))
    }
}

/// A signed pixel as an unsigned one, if it lies in a picture of this size.
pub(crate) fn inside(p: IVec2, size: [u32; 2]) -> Option<UVec2> {
    let unsigned = p.as_uvec2();
    (p.min_element() >= 0 && unsigned.cmplt(UVec2::from(size)).all()).then_some(unsigned)
}
