//! What a voxel's record holds: only what the scene needs, decided once at load.
//!
//! In: [`SceneNeeds`]. Out: which of the four words of [`frame::surface`] are stored, and the snippets that read and write
//! them; all define the same functions, so that kernels are assembled and never branch. The first two words, normal and
//! colour, are always there.
//!
//! | word | stored where some surface | else |
//! | --- | --- | --- |
//! | 2, light | gives off light or absorbs | 0 |
//! | 3, lobe | is specular, lets light through or has holes | rough, no specular reflection, solid |
//!
//! So a scene of opaque diffuse surfaces takes 8 bytes per voxel, a lamp in it 12, anything glossy without lamps 12.

use scene::SceneNeeds;

const FULL_WGSL: &str = include_str!("full.inc.wgsl");
const LEAN_WGSL: &str = include_str!("lean.inc.wgsl");
const LIGHT_WGSL: &str = include_str!("light.inc.wgsl");
const LOBE_WGSL: &str = include_str!("lobe.inc.wgsl");
const PLACES_OF_NEITHER: &str =
    "const RECORD_WORDS = 2u;\nconst RECORD_LIGHT_AT = 0u;\nconst RECORD_LOBE_AT = 0u;\n";
const PLACES_OF_LIGHT: &str =
    "const RECORD_WORDS = 3u;\nconst RECORD_LIGHT_AT = 2u;\nconst RECORD_LOBE_AT = 0u;\n";
const PLACES_OF_LOBE: &str =
    "const RECORD_WORDS = 3u;\nconst RECORD_LIGHT_AT = 0u;\nconst RECORD_LOBE_AT = 2u;\n";

/// `record_plane` and binding 17 of group 1, whatever records hold; after [`crate::GRID_WGSL`].
pub const ANY_WGSL: &str = include_str!("any.inc.wgsl");

/// What is left out of a record without a lobe.
const NO_LOBE: u32 = 0xffff;

/// Which words a record has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RecordLayout {
    /// Emission or absorption.
    pub light: bool,
    /// Roughness, reflectance, metalness, transmission, coverage.
    pub lobe: bool,
}

impl RecordLayout {
    /// All four words.
    pub const FULL: Self = Self { light: true, lobe: true };

    /// What this scene's surfaces need.
    pub fn of(needs: &SceneNeeds) -> Self {
        Self {
            light: needs.emission || needs.absorption,
            lobe: needs.specular || needs.transmission || needs.coverage,
        }
    }

    /// Words per voxel, 2 to 4.
    pub fn words(self) -> u32 {
        2 + u32::from(self.light) + u32::from(self.lobe)
    }

    /// Bytes per voxel.
    pub fn bytes(self) -> u64 {
        4 * u64::from(self.words())
    }

    /// Snippets that read records: `record_plane`, `record_words`, binding 17 of group 1. Need nothing.
    pub fn sources(self) -> Vec<&'static str> {
        let no_light = include_str!("no_light.inc.wgsl");
        let no_lobe = include_str!("no_lobe.inc.wgsl");
        match (self.light, self.lobe) {
            (true, true) => vec![FULL_WGSL],
            (true, false) => vec![PLACES_OF_LIGHT, LEAN_WGSL, LIGHT_WGSL, no_lobe],
            (false, true) => vec![PLACES_OF_LOBE, LEAN_WGSL, no_light, LOBE_WGSL],
            (false, false) => vec![PLACES_OF_NEITHER, LEAN_WGSL, no_light, no_lobe],
        }
    }

    /// Snippets that write records: `record_store`, binding 0 of group 3.
    pub(crate) fn stores(self) -> Vec<&'static str> {
        let lean = include_str!("store_lean.inc.wgsl");
        match (self.light, self.lobe) {
            (true, true) => vec![include_str!("store_full.inc.wgsl")],
            (true, false) => vec![PLACES_OF_LIGHT, lean],
            (false, true) => vec![PLACES_OF_LOBE, lean],
            (false, false) => vec![PLACES_OF_NEITHER, lean],
        }
    }

    /// Stored words as four per record.
    pub fn expand(self, stored: &[u32]) -> Vec<[u32; 4]> {
        let expand = |record: &[u32]| {
            let mut words = record.iter().copied();
            let mut next = |kept: bool, else_word| if kept { words.next().unwrap_or(0) } else { else_word };
            [next(true, 0), next(true, 0), next(self.light, 0), next(self.lobe, NO_LOBE)]
        };
        stored.chunks_exact(self.words() as usize).map(expand).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_diffuse_scene_pays_for_nothing_else() {
        let lean = RecordLayout::of(&SceneNeeds::default());
        assert_eq!(lean.bytes(), 8);
        for paid in [LIGHT_WGSL, LOBE_WGSL, FULL_WGSL] {
            assert!(!lean.sources().contains(&paid));
        }
        assert_eq!(lean.expand(&[1, 2, 3, 4]), [[1, 2, 0, 0xffff], [3, 4, 0, 0xffff]]);
        let lamp = RecordLayout::of(&SceneNeeds { emission: true, ..SceneNeeds::default() });
        assert!(lamp.sources().contains(&LIGHT_WGSL) && !lamp.sources().contains(&LOBE_WGSL));
        assert_eq!(lamp.expand(&[1, 2, 3]), [[1, 2, 3, 0xffff]]);
        let gloss = RecordLayout::of(&SceneNeeds { specular: true, ..SceneNeeds::default() });
        assert_eq!(gloss.expand(&[1, 2, 3]), [[1, 2, 0, 3]]);
        assert_eq!(RecordLayout::FULL.expand(&[1, 2, 3, 4]), [[1, 2, 3, 4]]);
    }
}
