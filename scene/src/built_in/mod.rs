//! Scenes made by code, no files needed: the same bits on every run.
//!
//! Each constructor gathers [`part::Part`]s, one per object, in an [`assembly::Assembly`]. All of them keep one
//! convention: metres, +Y up, triangles counter-clockwise from the front, unit normals on the front side, unit
//! tangents along growing u.

mod arcade;
mod assembly;
mod cornell;
mod courtyard;
mod furnace;
mod glass;
pub mod hard;
mod part;
mod relief;
pub mod sealed;
mod shapes;
mod spheres;
#[cfg(test)]
mod tests;
mod textures;

pub use furnace::furnace;

use crate::Scene;

/// Name, one line about it, constructor.
pub type BuiltIn = (&'static str, &'static str, fn() -> Scene);

/// All of them, in the order `gridlight list` prints.
pub fn all() -> &'static [BuiltIn] {
    &[
        ("cornell", "the Cornell box with its measured geometry: Lambert walls, one lamp", cornell::cornell),
        (
            "courtyard",
            "arcades around an open court: stone, wood, cloth, glass, metal, sun, sky",
            courtyard::courtyard,
        ),
        (
            "spheres",
            "roughness across, metalness down, a last row that glows, under a white sky",
            spheres::spheres,
        ),
        ("furnace", "a closed room of albedo 1/2 that emits 1/2: radiance is 1 everywhere", furnace::half),
        (
            "glass",
            "three solid balls of index 1.33, 1.5 and 2, and thin panes at grazing angles",
            glass::glass,
        ),
        ("relief", "a brick wall with a height map in low sun", relief::relief),
    ]
}

/// Looks a name up.
pub fn by_name(name: &str) -> Option<fn() -> Scene> {
    all().iter().find(|(known, ..)| *known == name).map(|(.., build)| *build)
}
