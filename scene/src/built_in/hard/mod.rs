//! Hard cases: small scenes made by code, each aimed at one way in which light transport breaks.
//!
//! Most have a closed form: in a closed grey room that emits (radiance `e / (1 - a)`) and around anything white under a
//! white sky (radiance 1) every pixel must have one known value, whatever stands in the way. The others are measured
//! against a converged reference of the same scene. All have one camera, in the scene; metres, +Y up.

mod rooms;
mod skies;

use crate::Scene;

/// What is known about a scene's picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Truth {
    /// Every pixel has this radiance in every channel, with any number of bounces allowed; the lamp's side and the sky
    /// included.
    Everywhere(f32),
    /// No closed form: paths through the triangles are converged.
    Converged,
}

/// One case.
#[derive(Clone, Copy, Debug)]
pub struct HardScene {
    /// Unique.
    pub name: &'static str,
    /// What it is aimed at.
    pub about: &'static str,
    /// What its picture must be.
    pub truth: Truth,
    /// No light leaves it and none comes in from outside: energy is kept within it.
    pub closed: bool,
    /// Makes it.
    pub build: fn() -> Scene,
}

/// All of them, in the order of the report.
pub fn all() -> &'static [HardScene] {
    ALL
}

const fn room(name: &'static str, about: &'static str, build: fn() -> Scene) -> HardScene {
    HardScene { name, about, truth: Truth::Everywhere(1.0), closed: true, build }
}

const fn white(name: &'static str, about: &'static str, build: fn() -> Scene) -> HardScene {
    HardScene { name, about, truth: Truth::Everywhere(1.0), closed: false, build }
}

const fn open(name: &'static str, about: &'static str, truth: Truth, build: fn() -> Scene) -> HardScene {
    HardScene { name, about, truth, closed: false, build }
}

const ALL: &[HardScene] = &[
    room("room_1m", "the plain closed room: albedo 1/2, emission 1/2", || rooms::plain(1.0)),
    room("room_1mm", "the same, 1 mm wide", || rooms::plain(1e-3)),
    room("room_10km", "the same, 10 km wide", || rooms::plain(1e4)),
    room("far_from_origin", "the same, 10 km from the origin: floats there are 1 mm apart", rooms::far),
    room("coplanar", "every wall twice in one plane", rooms::coplanar),
    room("million_to_one", "one wall of triangles whose sides differ a million times", rooms::million_to_one),
    room("touching_a_wall", "the camera 10 micrometres from a wall", rooms::touching),
    room("inside_geometry", "the camera inside a solid ball", rooms::inside_ball),
    white("white_world", "albedo 1 under a white sky: nothing may be lost", skies::white_world),
    open("black_world", "nothing shines and nothing reflects", Truth::Everywhere(0.0), skies::black_world),
    white("inverted", "two-sided surfaces whose fronts face away", skies::inverted),
    white("roughness_ladder", "white metal of roughness 0, 0.001 and 1", skies::roughness_ladder),
    white("index_ladder", "clear glass of index 1, 1.0001 and 3", skies::index_ladder),
    white("nested_glass", "glass in glass in glass", skies::nested_glass),
    open("inside_glass", "the camera inside a glass ball", skies::INSIDE_GLASS, skies::inside_glass),
    white("facing_mirrors", "two white mirrors face each other", skies::facing_mirrors),
    white(
        "mirrored_uvs",
        "a normal map on mirrored and on degenerate texture coordinates",
        skies::mirrored_uvs,
    ),
    open("grazing_sun", "a plane in sun one degree above it", skies::GRAZING, skies::grazing_sun),
    open("micro_to_mega", "emitters of 1e-6 and 1e6 in one picture", Truth::Converged, skies::micro_to_mega),
    open("small_lamp", "a lamp of one voxel in a large hall", Truth::Converged, rooms::small_lamp),
    open("keyhole", "a room lit through a keyhole", Truth::Converged, rooms::keyhole),
    open("thin_walls", "paper-thin walls between sun and dark", Truth::Everywhere(0.0), rooms::thin_walls),
    open("wires", "wires of a millimetre, a curtain and leaf cards", Truth::Converged, skies::wires),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_every_scene_is_whole_with_a_camera() {
        let mut names: Vec<_> = all().iter().map(|case| case.name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), all().len());
        for case in all() {
            let scene = (case.build)();
            assert_eq!((scene.name.as_str(), scene.cameras.len()), (case.name, 1));
            let g = scene.rest();
            assert!(!g.triangles.is_empty(), "{}", case.name);
            assert!(g.positions.iter().all(|p| p.is_finite()) && g.normals.iter().all(|n| n.is_normalized()));
            assert!(g.tangents.iter().all(|t| t.truncate().is_normalized()), "{}", case.name);
        }
    }

    #[test]
    fn the_sides_of_the_million_fold_wall_are_that_far_apart() {
        let scene = rooms::million_to_one();
        let g = scene.rest();
        let sides = g.triangles.iter().flat_map(|t| {
            let [a, b, c] = g.corners(t);
            [(b - a).length(), (c - b).length(), (a - c).length()]
        });
        let (least, most) = sides.fold((f32::INFINITY, 0.0_f32), |(l, m), side| (l.min(side), m.max(side)));
        assert!(most / least >= 1e6, "{least} m to {most} m");
    }
}
