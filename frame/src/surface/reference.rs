//! The CPU half: the same functions as `surface.inc.wgsl`, in the same order, in f32 like the shader.

use glam::{IVec2, IVec3, Vec2, Vec3};
use std::f32::consts::TAU;

const SELECT_NONE: u32 = 0;
const SELECT_METAL: u32 = 1;
const SELECT_TRANSMISSION: u32 = 2;
const SELECT_COVERAGE: u32 = 3;

pub(super) const NORMAL_STEPS: i32 = 2047;
pub(super) const FACE_NORMAL_STEPS: i32 = 32767;
const TANGENT_STEPS: f32 = 128.0;
/// sqrt(3) / 2, the farthest a plane through a cell lies from its centre, over 127 codes.
pub const CONTOUR_STEP: f32 = 0.006_819_176;
/// Code of the contour of a cell whose surface bends: just outside the range of offsets.
pub const CREASE_CODE: i32 = -128;

/// The same as an offset.
pub const CREASE: f32 = CREASE_CODE as f32 * CONTOUR_STEP;

/// What a ray needs to know about the place it hit. The default is a white, rough Lambert surface facing +Z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// Unit shading normal (or the face's, in voxels with contours), world space.
    pub normal: Vec3,
    /// Unit tangent across the normal, world space.
    pub tangent: Vec3,
    /// +1 or -1: the bitangent is `cross(normal, tangent) * handedness`.
    pub handedness: f32,
    /// Base colour, linear, 0..1.
    pub base: Vec3,
    /// 0..1.
    pub metalness: f32,
    /// Emitted radiance, multiplied by the scene's `radiance_scale`.
    pub emission: Vec3,
    /// Absorption of the solid behind a transmissive surface, 1/m.
    pub absorption: Vec3,
    /// Perceptual roughness along tangent and bitangent, 0..1; alpha is its square.
    pub roughness: Vec2,
    /// Dielectric reflectance at normal incidence; 0 means no dielectric specular lobe.
    pub f0: f32,
    /// Share of the light not reflected that passes instead of scattering, 0..1.
    pub transmission: f32,
    /// Share of the place that is solid, 0..1.
    pub coverage: f32,
    /// Voxels only: signed offset of the surface's plane from the cell's centre in voxels, or [`CREASE`].
    pub contour: f32,
    /// Seen from behind with its normal turned.
    pub two_sided: bool,
    /// A sheet without an inside: it does not bend what passes.
    pub thin: bool,
}

impl Default for Surface {
    fn default() -> Self {
        Self {
            normal: Vec3::Z,
            tangent: Vec3::X,
            handedness: 1.0,
            base: Vec3::ONE,
            metalness: 0.0,
            emission: Vec3::ZERO,
            absorption: Vec3::ZERO,
            roughness: Vec2::ONE,
            f0: 0.0,
            transmission: 0.0,
            coverage: 1.0,
            contour: 0.0,
            two_sided: false,
            thin: false,
        }
    }
}

/// PCG (Jarzynski and Olano 2020, "Hash Functions for GPU Rendering").
pub fn hash(x: u32) -> u32 {
    let state = x.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

fn uniform(x: u32) -> f32 {
    (hash(x) >> 8) as f32 * (1.0 / 16_777_216.0)
}

fn unit(x: f32) -> f32 {
    if x > 0.0 { x.min(1.0) } else { 0.0 }
}

fn byte(x: f32) -> u32 {
    (unit(x) * 255.0 + 0.5).floor() as u32
}

// ---- directions ----

fn sign(x: f32) -> f32 {
    if x >= 0.0 { 1.0 } else { -1.0 }
}

fn oct_pack(n: Vec3, steps: i32) -> IVec2 {
    let length_1 = n.x.abs() + n.y.abs() + n.z.abs();
    if !(length_1 > 1e-30 && length_1 < 1e30) {
        return IVec2::ZERO;
    }
    let mut p = Vec2::new(n.x / length_1, n.y / length_1);
    if n.z < 0.0 {
        p = Vec2::new((1.0 - p.y.abs()) * sign(p.x), (1.0 - p.x.abs()) * sign(p.y));
    }
    let mut code = (p * steps as f32 + 0.5).floor().as_ivec2();
    if code.x.abs() == steps {
        code.y = code.y.abs();
    }
    if code.y.abs() == steps {
        code.x = code.x.abs();
    }
    code
}

pub(super) fn oct_unpack(code: IVec2, steps: i32) -> IVec3 {
    let z = steps - code.x.abs() - code.y.abs();
    if z >= 0 {
        return code.extend(z);
    }
    let sign = |x: i32| if x >= 0 { 1 } else { -1 };
    IVec3::new((steps - code.y.abs()) * sign(code.x), (steps - code.x.abs()) * sign(code.y), z)
}

fn normal_integers(code: u32) -> IVec3 {
    let p = IVec2::new((code << 20) as i32 >> 20, (code << 8) as i32 >> 20);
    oct_unpack(p, NORMAL_STEPS)
}

/// A direction in 24 bits; a vector without one (zero, NaN) gives code 0, which is +Z.
pub fn normal_pack(n: Vec3) -> u32 {
    let code = oct_pack(n, NORMAL_STEPS);
    (code.x as u32 & 0xfff) | ((code.y as u32 & 0xfff) << 12)
}

/// The unit direction of the low 24 bits.
pub fn normal_unpack(code: u32) -> Vec3 {
    normal_integers(code).as_vec3().normalize()
}

/// A direction in 16 + 16 bits, for the G-buffer's `face_normal`.
pub fn face_normal_pack(n: Vec3) -> u32 {
    let code = oct_pack(n, FACE_NORMAL_STEPS);
    (code.x as u32 & 0xffff) | ((code.y as u32) << 16)
}

/// The unit direction of a `face_normal` texel.
pub fn face_normal_unpack(code: u32) -> Vec3 {
    let p = IVec2::new((code << 16) as i32 >> 16, code as i32 >> 16);
    oct_unpack(p, FACE_NORMAL_STEPS).as_vec3().normalize()
}

/// The tangents at angle 0 and at a quarter turn about a coded normal.
pub fn basis(normal_code: u32) -> [Vec3; 2] {
    let integers = normal_integers(normal_code);
    let n = integers.as_vec3().normalize();
    let s = if integers.z >= 0 { 1.0 } else { -1.0 };
    let a = -1.0 / (s + n.z);
    let b = n.x * n.y * a;
    [Vec3::new(1.0 + s * n.x * n.x * a, s * b, -s * n.x), Vec3::new(b, s + n.y * n.y * a, -n.y)]
}

/// A tangent about a coded normal in 8 bits: angle 7, handedness 1. A tangent without a direction across the normal
/// gives angle 0.
pub fn tangent_pack(normal_code: u32, tangent: Vec3, handedness: f32) -> u32 {
    let [first, second] = basis(normal_code);
    let (x, y) = (tangent.dot(first), tangent.dot(second));
    let length_2 = x * x + y * y;
    let mut angle = 0;
    if length_2 > 1e-12 && length_2 < 1e30 {
        let turns = y.atan2(x) / TAU + 1.0;
        angle = (turns * TANGENT_STEPS + 0.5).floor() as u32 & 127;
    }
    angle | if handedness < 0.0 { 128 } else { 0 }
}

/// The tangent of word 0 (normal in the low 24 bits, tangent in the high 8).
pub fn tangent_unpack(word: u32) -> Vec3 {
    let [first, second] = basis(word);
    let angle = ((word >> 24) & 127) as f32 * (TAU / TANGENT_STEPS);
    angle.cos() * first + angle.sin() * second
}

// ---- colours ----

/// The sRGB curve, inverted; 0..1 to 0..1.
pub fn linear_from_srgb(x: f32) -> f32 {
    if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
}

/// The sRGB curve; 0..1 to 0..1.
pub fn srgb_from_linear(x: f32) -> f32 {
    if x <= 0.003_130_8 { x * 12.92 } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}

fn srgb8_pack(linear: f32, u: f32) -> u32 {
    let x = unit(linear);
    let mut code = (255.0 * srgb_from_linear(x)).clamp(0.0, 254.0) as u32;
    if code > 0 && x < srgb8_unpack(code) {
        code -= 1;
    } else if code < 254 && x >= srgb8_unpack(code + 1) {
        code += 1;
    }
    let (below, above) = (srgb8_unpack(code), srgb8_unpack(code + 1));
    code + u32::from(u < (x - below) / (above - below))
}

fn srgb8_unpack(code: u32) -> f32 {
    linear_from_srgb((code & 0xff) as f32 / 255.0)
}

pub(super) fn base_pack(base: Vec3, hash: u32) -> u32 {
    let u = uniform(hash);
    srgb8_pack(base.x, u) | (srgb8_pack(base.y, u) << 8) | (srgb8_pack(base.z, u) << 16)
}

pub(super) fn base_unpack(word: u32) -> Vec3 {
    Vec3::new(srgb8_unpack(word), srgb8_unpack(word >> 8), srgb8_unpack(word >> 16))
}

/// Three non-negative numbers up to 65,408 in 32 bits with a shared exponent; larger ones saturate, negative ones and
/// NaN become 0.
pub fn rgb9e5_pack(colour: Vec3) -> u32 {
    let c = colour.map(|c| if c > 0.0 { c.min(65408.0) } else { 0.0 });
    let largest = c.x.max(c.y.max(c.z));
    let mut exponent = ((largest.to_bits() >> 23) as i32 - 127).max(-16) + 16;
    if (largest * exp2(24 - exponent) + 0.5).floor() >= 512.0 {
        exponent += 1;
    }
    let mantissas = (c * exp2(24 - exponent) + 0.5).floor().as_uvec3();
    mantissas.x | (mantissas.y << 9) | (mantissas.z << 18) | ((exponent as u32) << 27)
}

/// The three numbers of an RGB9E5 word, exactly.
pub fn rgb9e5_unpack(code: u32) -> Vec3 {
    let mantissa = |shift: u32| ((code >> shift) & 511) as f32;
    Vec3::new(mantissa(0), mantissa(9), mantissa(18)) * exp2((code >> 27) as i32 - 24)
}

fn exp2(exponent: i32) -> f32 {
    f32::from_bits(((exponent + 127) as u32) << 23)
}

// ---- the record ----

pub(super) fn amount_pack(metalness: f32, transmission: f32, coverage: f32, hash: u32) -> u32 {
    let clear = unit(transmission);
    let hole = 1.0 - unit(coverage);
    let mut which = SELECT_METAL;
    let mut share = unit(metalness);
    if clear > share {
        which = SELECT_TRANSMISSION;
        share = clear;
    }
    if hole > share {
        which = SELECT_COVERAGE;
        share = hole;
    }
    let scaled = share * 15.0;
    let code = scaled.floor();
    let amount = code as u32 + u32::from(uniform(hash) < scaled - code);
    if amount == 0 { SELECT_NONE } else { which | (amount << 2) }
}

impl Surface {
    /// The cross product that completes the tangent frame.
    pub fn bitangent(&self) -> Vec3 {
        self.normal.cross(self.tangent) * self.handedness
    }

    fn pack(&self, metalness: f32, last_byte: u32, hash: u32) -> [u32; 4] {
        let normal_code = normal_pack(self.normal);
        let tangent_code = tangent_pack(normal_code, self.tangent, self.handedness);
        let amount = amount_pack(metalness, self.transmission, self.coverage, hash ^ 0x9e37_79b9);
        let transmissive = amount & 3 == SELECT_TRANSMISSION;
        let mut light = rgb9e5_pack(self.emission);
        let thin = self.thin || (transmissive && light != 0);
        if transmissive && !thin {
            light = rgb9e5_pack(self.absorption);
        }
        let lobe = byte(self.roughness.x)
            | (byte(self.roughness.y) << 8)
            | (byte(unit(self.f0).sqrt()) << 16)
            | (amount << 24)
            | (u32::from(self.two_sided) << 30)
            | (u32::from(thin) << 31);
        [normal_code | (tangent_code << 24), base_pack(self.base, hash) | (last_byte << 24), light, lobe]
    }

    /// As a voxel: the last byte of word 1 is the contour, metalness goes through select and amount. `hash` is the
    /// cell's.
    pub fn pack_voxel(&self, hash: u32) -> [u32; 4] {
        let steps = if self.contour.abs() < 2.0 { self.contour / CONTOUR_STEP } else { 0.0 };
        let last_byte = (steps + 0.5).floor().clamp(-128.0, 127.0) as i32 as u32 & 0xff;
        self.pack(self.metalness, last_byte, hash)
    }

    /// As a G-buffer texel: the last byte of word 1 is the metalness; the contour is lost. `hash` is the pixel's.
    pub fn pack_gbuffer(&self, hash: u32) -> [u32; 4] {
        self.pack(0.0, byte(self.metalness), hash)
    }

    fn unpack(v: [u32; 4]) -> Self {
        let root = ((v[3] >> 16) & 0xff) as f32 / 255.0;
        let thin = v[3] >> 31 == 1;
        let which = (v[3] >> 24) & 3;
        let amount = ((v[3] >> 26) & 15) as f32 / 15.0;
        let share = |select: u32| if which == select { amount } else { 0.0 };
        let light = rgb9e5_unpack(v[2]);
        let solid = which == SELECT_TRANSMISSION && !thin;
        Self {
            normal: normal_unpack(v[0]),
            tangent: tangent_unpack(v[0]),
            handedness: if v[0] >> 31 == 1 { -1.0 } else { 1.0 },
            base: base_unpack(v[1]),
            metalness: share(SELECT_METAL),
            emission: if solid { Vec3::ZERO } else { light },
            absorption: if solid { light } else { Vec3::ZERO },
            roughness: Vec2::new((v[3] & 0xff) as f32, ((v[3] >> 8) & 0xff) as f32) / 255.0,
            f0: root * root,
            transmission: share(SELECT_TRANSMISSION),
            coverage: 1.0 - share(SELECT_COVERAGE),
            contour: 0.0,
            two_sided: (v[3] >> 30) & 1 == 1,
            thin,
        }
    }

    /// Of a voxel's record.
    pub fn unpack_voxel(v: [u32; 4]) -> Self {
        Self { contour: (v[1] as i32 >> 24) as f32 * CONTOUR_STEP, ..Self::unpack(v) }
    }

    /// Of a G-buffer texel.
    pub fn unpack_gbuffer(v: [u32; 4]) -> Self {
        Self { metalness: (v[1] >> 24) as f32 / 255.0, ..Self::unpack(v) }
    }
}
