//! Light that is not a surface: sky, sun, and the punctual lights of `KHR_lights_punctual`.

use glam::Vec3;

/// Radiance from infinitely far, by direction.
#[derive(Clone, Debug, PartialEq)]
pub enum Sky {
    /// The same linear radiance from everywhere.
    Constant(Vec3),
    /// An equirectangular map.
    Map(SkyMap),
}

/// Equirectangular radiance: row 0 is +Y, column 0 looks along -Z, u grows towards +X
/// (`u = atan2(x, -z) / 2 pi`, `v = acos(y) / pi`).
#[derive(Clone, Debug, PartialEq)]
pub struct SkyMap {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Linear radiance, row by row from the top; finite and not negative.
    pub radiance: Vec<Vec3>,
}

/// A distant disc of light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sun {
    /// Unit vector the light travels along.
    pub direction: Vec3,
    /// On a plane perpendicular to `direction`.
    pub irradiance: Vec3,
    /// Angle across the disc in radians; 0 is a point.
    pub angle: f32,
}

/// What kind of punctual light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PunctualKind {
    /// From infinitely far; intensity is irradiance on a perpendicular plane.
    Directional,
    /// From a point, alike in all directions; intensity is radiant intensity.
    Point,
    /// From a point, inside a cone: full inside `inner`, none outside `outer` (radians from the axis).
    Spot {
        /// Half angle of the bright core.
        inner: f32,
        /// Half angle of the whole cone.
        outer: f32,
    },
}

/// A punctual light in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PunctualLight {
    /// What kind.
    pub kind: PunctualKind,
    /// Metres; unused for a directional light.
    pub position: Vec3,
    /// Unit vector the light travels along; unused for a point light.
    pub direction: Vec3,
    /// Colour times intensity. glTF's photometric units (candela, lux) are taken as radiometric ones, 1 to 1.
    pub intensity: Vec3,
    /// Metres beyond which it gives nothing; infinite by default.
    pub range: f32,
}
