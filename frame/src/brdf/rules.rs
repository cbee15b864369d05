//! Whose rules the lobes follow, where the field has more than one.

/// The shape of the specular lobe.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u32)]
pub enum Lobe {
    /// GGX facets.
    #[default]
    Ggx,
    /// The paper's: see `paper.rs`.
    Paper,
}

/// How clear surfaces divide light between reflection and refraction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u32)]
pub enum Fresnel {
    /// Unpolarised, exact.
    #[default]
    Exact,
    /// Schlick's approximation of 1994, the paper's.
    Schlick,
}

/// Whose rules the lobes follow. Shaders get it as constants.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Rules {
    /// Of the specular lobe.
    pub lobe: Lobe,
    /// Of clear surfaces.
    pub fresnel: Fresnel,
    /// Masking is a product of two factors instead of height-correlated, and what facets keep from each other is lost: the
    /// convention of the shared references.
    pub lossy: bool,
}

impl Rules {
    /// Values of the shader's constants.
    pub fn constants(self) -> [(&'static str, f64); 4] {
        [
            ("brdf_paper_lobe", f64::from(self.lobe == Lobe::Paper)),
            ("brdf_schlick_glass", f64::from(self.fresnel == Fresnel::Schlick)),
            ("brdf_separable", f64::from(self.lossy)),
            ("brdf_compensated", f64::from(!self.lossy)),
        ]
    }
}
