//! Finds the layers that a filter needs, by the names that renderers give them.
//!
//! | what | names of the layer, any case, last part of the path | channels |
//! | --- | --- | --- |
//! | picture | as [`Layers::picture`] has it; ours: `noisy_diffuse` and `noisy_specular` | R G B |
//! | albedo | `albedo`, `denoising albedo`, `diffcol`, `diffuse_color`, `basecolor`, `base_color` | R G B |
//! | normal | `normal`, `normals`, `n`, `denoising normal`, `shading_normal`, `sh_normal` | X Y Z or R G B |
//! | depth | `depth`, `z`, `denoising depth`, `distance` (along the ray) | one |
//! | roughness | `roughness` | T B, or one |
//! | emission | `emission`, `emit`, `emissive` | R G B |
//! | motion | `motion`, `vector`, `motion_vector` | X Y or R G: pixel now minus pixel last frame, right and down |
//!
//! Normals may be in any space, as they are only compared with each other. A depth of 0, below 0, not finite or above
//! 10^9 is sky.

use crate::Error;
use crate::input::Layers;
use denoise::{Guides, Need};
use frame::cpu::Image;
use std::path::Path;

const ALBEDO: &[&str] = &["albedo", "denoisingalbedo", "diffcol", "diffusecolor", "basecolor"];
const NORMAL: &[&str] = &["normal", "normals", "n", "denoisingnormal", "shadingnormal", "shnormal"];
const DEPTH: &[&str] = &["depth", "z", "denoisingdepth", "distance"];
const ROUGHNESS: &[&str] = &["roughness"];
const EMISSION: &[&str] = &["emission", "emit", "emissive"];
const MOTION: &[&str] = &["motion", "vector", "motionvector"];

/// A file's layers, by what they mean.
#[derive(Clone, Debug)]
pub struct Picture {
    /// Pixels.
    pub size: [u32; 2],
    /// Linear radiance.
    pub color: Image<[f32; 3]>,
    /// Instead of it: diffuse and specular light that was never modulated, a = hit distance, m.
    pub lobes: Option<[Image<[f32; 4]>; 2]>,
    /// 0..1.
    pub albedo: Option<Image<[f32; 3]>>,
    /// Of any length but 0.
    pub normal: Option<Image<[f32; 3]>>,
    /// Metres, as the file has it.
    pub depth: Option<Image<f32>>,
    /// The depth's layer says by its name that it runs along the ray.
    pub depth_is_distance: bool,
    /// Along tangent and bitangent, 0..1.
    pub roughness: Option<Image<[f32; 2]>>,
    /// Radiance.
    pub emission: Option<Image<[f32; 3]>>,
    /// Pixels.
    pub motion: Option<Image<[f32; 2]>>,
}

impl Picture {
    /// Looks for everything, and checks that what the denoiser cannot do without is there.
    ///
    /// # Errors
    /// The picture or a layer that is needed is missing; the message names what was looked for and what there is.
    pub fn of(
        path: &Path,
        layers: &Layers,
        denoiser: &str,
        guides: Guides,
        sequence: bool,
    ) -> Result<Self, Error> {
        let find = Finder { layers };
        let lobes = find.lobe("noisydiffuse").zip(find.lobe("noisyspecular")).map(|(d, s)| [d, s]);
        let picture = layers.picture().and_then(|layer| layers.color(layer));
        let size = layers.size();
        let missing = |what: &str, names: &[&str]| {
            let there: Vec<&str> = layers.names().collect();
            let message = format!(
                "denoiser {denoiser} needs {what}, and no layer is called so (looked for: {}); there are: {}",
                names.join(", "),
                there.join(", ")
            );
            Error::Read { path: path.into(), message }
        };
        let color = match (&lobes, picture) {
            (_, Some(color)) => color,
            (Some(_), None) => Image::filled(size, [0.0; 3]),
            (None, None) => {
                return Err(missing("the picture", &["R, G, B", "beauty", "combined", "rgba", "rgb"]));
            }
        };
        let (depth, depth_is_distance) = find.depth();
        let picture = Self {
            size,
            color,
            lobes,
            albedo: find.three(ALBEDO),
            normal: find.three(NORMAL),
            depth,
            depth_is_distance,
            roughness: find.roughness(),
            emission: find.three(EMISSION),
            motion: find.two(MOTION),
        };
        if guides.surface == Need::Required && picture.normal.is_none() {
            return Err(missing("normals", NORMAL));
        }
        if guides.distance == Need::Required && picture.depth.is_none() {
            return Err(missing("depth", DEPTH));
        }
        if sequence && guides.motion_id == Need::Required && picture.motion.is_none() {
            return Err(missing("motion from frame to frame", MOTION));
        }
        Ok(picture)
    }

    /// 1 where the file has none.
    pub fn albedo_at(&self, x: i32, y: i32) -> [f32; 3] {
        self.albedo.as_ref().map_or([1.0; 3], |albedo| albedo.get(x, y).unwrap_or([1.0; 3]))
    }
}

/// Lower case, letters and digits only: `Denoising Albedo` and `denoising_albedo` are one.
fn plain(name: &str) -> String {
    name.chars().filter(char::is_ascii_alphanumeric).map(|c| c.to_ascii_lowercase()).collect()
}

struct Finder<'a> {
    layers: &'a Layers,
}

impl Finder<'_> {
    /// The first layer of these names, in their order, as its channels' (letter, values).
    fn layer(&self, names: &[&str]) -> Option<Vec<(String, &[f32])>> {
        names.iter().find_map(|wanted| {
            let channels = self.layers.names().filter_map(|full| {
                let (layer, letter) = full.rsplit_once('.').unwrap_or(("", full));
                let last = layer.rsplit('.').next().unwrap_or(layer);
                // A channel without a layer is its own: `Z`.
                let is_meant = plain(last) == *wanted || layer.is_empty() && plain(letter) == *wanted;
                is_meant.then(|| Some((letter.to_ascii_uppercase(), self.layers.channel(full)?))).flatten()
            });
            let channels: Vec<_> = channels.collect();
            (!channels.is_empty()).then_some(channels)
        })
    }

    fn planes<const N: usize>(&self, names: &[&str], letters: [[&str; N]; 2]) -> Option<Image<[f32; N]>> {
        let channels = self.layer(names)?;
        let plane =
            |letter: &str| channels.iter().find(|(known, _)| known == letter).map(|(_, values)| *values);
        let planes: Vec<[&[f32]; N]> = letters
            .into_iter()
            .filter_map(|letters| {
                let planes: Vec<&[f32]> = letters.into_iter().filter_map(plane).collect();
                planes.try_into().ok()
            })
            .collect();
        let planes = planes.first()?;
        let texels = (0..planes[0].len()).map(|i| planes.map(|plane| plane[i])).collect();
        Image::from_texels(self.layers.size(), texels)
    }

    fn three(&self, names: &[&str]) -> Option<Image<[f32; 3]>> {
        self.planes(names, [["X", "Y", "Z"], ["R", "G", "B"]])
    }

    fn two(&self, names: &[&str]) -> Option<Image<[f32; 2]>> {
        self.planes(names, [["X", "Y"], ["R", "G"]])
    }

    fn lobe(&self, name: &str) -> Option<Image<[f32; 4]>> {
        self.planes(&[name], [["R", "G", "B", "A"]; 2])
    }

    fn one(&self, names: &[&str]) -> Option<Image<f32>> {
        let channels = self.layer(names)?;
        Image::from_texels(self.layers.size(), channels.first()?.1.to_vec())
    }

    /// And whether its name says that it runs along the ray.
    fn depth(&self) -> (Option<Image<f32>>, bool) {
        match self.one(&["distance"]) {
            Some(distance) => (Some(distance), true),
            None => (self.one(DEPTH), false),
        }
    }

    fn roughness(&self) -> Option<Image<[f32; 2]>> {
        let two = self.planes(ROUGHNESS, [["T", "B"]; 2]);
        two.or_else(|| self.one(ROUGHNESS).map(|one| one.map(|r| [r, r])))
    }
}
