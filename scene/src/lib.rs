//! What is to be seen: glTF 2.0 files and built-in scenes, materials, cameras, sky, animation.
//!
//! Everything here runs on the CPU and knows no wgpu. A [`Scene`] is loaded once; [`Scene::rest`] is its geometry
//! at time 0 and [`Scene::pose`] moves the moving part of it to another moment. Units: metres, seconds, radians,
//! linear Rec. 709 radiance; axes: glTF's (right-handed, +Y up).

mod budget;
pub mod built_in;
mod camera;
mod error;
mod geometry;
mod gltf_file;
mod light;
mod material;
mod motion;
mod needs;
mod sky;

pub use budget::LoadBudget;
pub use camera::Camera;
pub use error::SceneError;
pub use geometry::{Aabb, Geometry, Object, Triangle};
pub use light::{PunctualKind, PunctualLight, Sky, SkyMap, Sun};
pub use material::{Alpha, HeightMap, Material, TextureSlot, Volume, Wrap};
pub use needs::SceneNeeds;

use std::path::Path;

/// An 8-bit picture, decoded, not yet interpreted: the slot that uses it says whether it is sRGB.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// File name or index, for messages.
    pub name: String,
    /// Columns, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
    /// RGBA, row by row from the top.
    pub rgba: Vec<[u8; 4]>,
}

/// A scene, loaded whole.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Built-in name or file stem.
    pub name: String,
    /// All materials; a triangle names one by index. Never empty.
    pub materials: Vec<Material>,
    /// All pictures.
    pub images: Vec<Image>,
    /// Cameras of the file at time 0, in file order.
    pub cameras: Vec<Camera>,
    /// Light from far away.
    pub sky: Sky,
    /// At most one sun.
    pub sun: Option<Sun>,
    /// What the file asked for that is not honoured, one line each.
    pub warnings: Vec<String>,
    rest: Geometry,
    bounds: Aabb,
    origin: glam::Vec3,
    motion: motion::Motion,
}

impl Scene {
    /// A built-in name, or a path ending in `.gltf` or `.glb`.
    ///
    /// # Errors
    /// A name that is neither, or a file that cannot be read, is malformed, or requires what is not supported.
    pub fn load(name: &str) -> Result<Self, SceneError> {
        Self::load_within(name, LoadBudget::default())
    }

    /// The same, taking no more memory than `budget` on the way.
    ///
    /// # Errors
    /// As [`Scene::load`], or the file asks for more.
    pub fn load_within(name: &str, budget: LoadBudget) -> Result<Self, SceneError> {
        match built_in::by_name(name) {
            Some(build) => Ok(build()),
            None => gltf_file::load(Path::new(name), budget),
        }
    }

    /// The content of a `.gltf` or `.glb` file; what it names is looked for in the folder of `path`.
    ///
    /// # Errors
    /// As [`Scene::load_within`].
    pub fn of_bytes(path: &Path, bytes: &[u8], budget: LoadBudget) -> Result<Self, SceneError> {
        gltf_file::load_bytes(path, bytes, budget)
    }

    /// A scene made by code: no sun, nothing moves.
    pub(crate) fn assemble(
        name: &str,
        materials: Vec<Material>,
        images: Vec<Image>,
        mut rest: Geometry,
        mut cameras: Vec<Camera>,
        sky: Sky,
    ) -> Self {
        let origin = rest.bounds().better_origin();
        rest.positions.iter_mut().for_each(|p| *p -= origin);
        for camera in &mut cameras {
            camera.eye -= origin;
            camera.target -= origin;
        }
        let bounds = rest.bounds();
        Self {
            name: name.into(),
            materials,
            images,
            cameras,
            sky,
            sun: None,
            warnings: Vec::new(),
            rest,
            bounds,
            origin,
            motion: motion::Motion::default(),
        }
    }

    /// World-space geometry at time 0.
    pub fn rest(&self) -> &Geometry {
        &self.rest
    }

    /// Geometry at `time` seconds: `geometry` must come from [`Scene::rest`]; only its moving tail is rewritten.
    pub fn pose(&self, time: f32, geometry: &mut Geometry) {
        self.motion.pose(time, &self.rest, geometry);
    }

    /// Camera number `index` of the file at `time` seconds.
    pub fn camera(&self, index: usize, time: f32) -> Option<Camera> {
        self.cameras.get(index).map(|rest| self.motion.camera(index, rest, time))
    }

    /// Box around every pose: the union over animation keys and the radius of `--move`. Fixed at load.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// The point of the file's world that is the origin of everything here, m: 0 but for scenes that are so far away from
    /// theirs that floats would not suffice. Whoever brings places of their own subtracts it.
    pub fn origin(&self) -> glam::Vec3 {
        self.origin
    }

    /// Length of the animation in seconds; 0 when nothing is animated.
    pub fn duration(&self) -> f32 {
        self.motion.duration()
    }

    /// What has to be modelled.
    pub fn needs(&self) -> SceneNeeds {
        SceneNeeds::of(self)
    }

    /// Makes every material of this name glow (`--emit`).
    ///
    /// # Errors
    /// No material has this name; the message lists those there are.
    pub fn emit(&mut self, material: &str, radiance: glam::Vec3) -> Result<(), SceneError> {
        let mut found = false;
        for m in self.materials.iter_mut().filter(|m| m.name == material) {
            m.emission = radiance;
            m.emission_texture = None;
            found = true;
        }
        if found {
            return Ok(());
        }
        Err(SceneError::NoSuchMaterial {
            name: material.into(),
            known: self.materials.iter().map(|m| m.name.clone()).collect::<Vec<_>>().join(", "),
        })
    }

    /// Sets every k-th connected part in file order, k = 1 / `share`, circling: 0.5 m radius in XZ, 2 s a turn (`--move`).
    pub fn set_moving(&mut self, share: f32) {
        motion::circle(self, share);
    }
}
