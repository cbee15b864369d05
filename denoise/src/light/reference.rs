//! The CPU half: the same functions as `light.inc.wgsl`, in the same order, in f32 like the shader.

use frame::cpu::Image;
use glam::{IVec2, Vec3};
use half::f16;

const HALF_LARGEST: f32 = 65504.0;

/// Light of both lobes at trace size, as [`frame::RadianceImage`] holds it.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// rgb, and metres.
    pub diffuse: Image<[f32; 4]>,
    /// rgb, and metres.
    pub specular: Option<Image<[f32; 4]>>,
    /// Samples: diffuse in the low half, specular in the high half.
    pub samples: Image<u32>,
}

impl Light {
    /// Diffuse is 0, specular 1.
    pub fn lobe(&self, lobe: usize) -> Option<&Image<[f32; 4]>> {
        if lobe == 0 { Some(&self.diffuse) } else { self.specular.as_ref() }
    }
}

/// The texel of a pixel that is known to lie inside.
pub fn at<T: Copy>(image: &Image<T>, p: IVec2) -> T {
    image.get(p.x, p.y).expect("a pixel inside the picture")
}

/// Pixels.
pub fn size_of<T: Copy>(image: &Image<T>) -> IVec2 {
    let [width, height] = image.size();
    IVec2::new(width as i32, height as i32)
}

/// Finite and not negative.
pub fn is_valid(light: [f32; 4]) -> bool {
    light.iter().all(|x| x.is_finite() && *x >= 0.0)
}

/// Weighted sums of a lobe; lengths only over taps that have one.
#[derive(Clone, Copy, Default)]
pub struct LightSum {
    rgb: Vec3,
    weight: f32,
    length: f32,
    length_weight: f32,
}

impl LightSum {
    /// One more tap.
    pub fn add(&mut self, [r, g, b, a]: [f32; 4], weight: f32) {
        let length_weight = if a > 0.0 { weight } else { 0.0 };
        self.rgb += weight * Vec3::new(r, g, b);
        self.weight += weight;
        self.length += length_weight * a;
        self.length_weight += length_weight;
    }

    /// Sum of the weights.
    pub fn weight(&self) -> f32 {
        self.weight
    }

    /// The sums over `weight`; the length over its own, at least `least`.
    pub fn over(&self, weight: f32, least: f32) -> [f32; 4] {
        (self.rgb / weight).extend(self.length / self.length_weight.max(least)).to_array()
    }

    /// As a half float stores it; what was there before where there is nothing to average.
    pub fn mean(&self, [r, g, b, a]: [f32; 4]) -> [f32; 4] {
        let rgb = if self.weight > 1e-20 { self.rgb / self.weight } else { Vec3::new(r, g, b) };
        let length = if self.length_weight > 1e-20 { self.length / self.length_weight } else { a };
        stored(rgb.extend(length).to_array())
    }
}

/// Each number as a half float stores it.
pub fn stored(light: [f32; 4]) -> [f32; 4] {
    light.map(|x| f16::from_f32(x.min(HALF_LARGEST)).to_f32())
}

/// The light of a pixel; where it is not valid, the mean of the valid ones around it, or 0.
pub fn mended(image: &Image<[f32; 4]>, p: IVec2) -> [f32; 4] {
    let light = at(image, p);
    if is_valid(light) {
        return light;
    }
    let mut sum = LightSum::default();
    for q in (0..9).map(|k| p + IVec2::new(k % 3, k / 3) - 1) {
        if let Some(tap) = image.get(q.x, q.y).filter(|tap| is_valid(*tap)) {
            sum.add(tap, 1.0);
        }
    }
    sum.mean([0.0; 4])
}

/// The pixel whose mirror image lies at `q`.
pub fn mirrored(q: IVec2, size: IVec2) -> IVec2 {
    let inside = q.rem_euclid(2 * size);
    inside.min(2 * size - 1 - inside)
}
