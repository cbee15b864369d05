//! What a caller may say about paths: how many, how long, by whose rules; and what `--set tracer.…` reaches.

use super::variance::Division;
use crate::Noise;
use frame::Knob;
use frame::brdf::{Fresnel, Lobe, Rules};

/// Which pixels get how many of the frame's samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[repr(u32)]
pub enum SampleRule {
    /// All `spp`.
    #[default]
    Fixed,
    /// The paper's, whatever `spp` is: `1 + floor(5 R + 1/2)` by the larger roughness R, 1 to 6.
    Roughness,
    /// `spp` in the mean, more where the light is noisy.
    Variance,
}

/// Most samples of [`SampleRule::Roughness`]: the paper's "maximum of six".
pub(super) const MOST_BY_ROUGHNESS: u32 = 6;

/// Whose rules are followed where the field has more than one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[repr(u32)]
pub enum Conventions {
    /// Height-correlated masking, what facets keep from each other put back; what a triangle reflects lies above the
    /// triangle, and normal maps are bent towards the viewer.
    #[default]
    Gridlight,
    /// Those of the shared reference images: separable masking, nothing put back, and the interpolated normal in place of
    /// the triangle's.
    Reference,
}

impl Conventions {
    /// Constants of `bvh_hit.inc.wgsl`.
    pub(super) fn of_triangles(self) -> [(&'static str, f64); 2] {
        let reference = f64::from(self == Self::Reference);
        [("bvh_bend", 1.0 - reference), ("bvh_smooth_horizon", reference)]
    }
}

/// How long paths are, how many, and what they do on the way.
#[derive(Clone, Debug, PartialEq)]
pub struct PathSettings {
    /// Paths per trace pixel in this frame, 1 to 65,535.
    pub spp: u32,
    /// At most so many scatterings: 0 emitters only, 1 direct light; none means roulette alone.
    pub bounces: Option<u32>,
    /// Who gets them.
    pub samples: SampleRule,
    /// Scatterings before roulette begins; 8 is the references' rule (contract, "Words for measuring").
    pub roulette_from: u32,
    /// A sample of smooth glass at the first hit follows what is reflected and what goes through, instead of one of both.
    pub both_branches: bool,
    /// Each vertex sends a ray to the sun or to a point, spot or directional light.
    pub shadow_rays: bool,
    /// What kernels are built with.
    pub build: PathBuild,
}

/// Settings that are constants of the kernels: read when these are built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PathBuild {
    /// Of masking and of normal maps.
    pub conventions: Conventions,
    /// Each vertex samples emitters and a sky that is a map, instead of finding them by chance alone.
    pub next_event: bool,
    /// Shape of the specular lobe.
    pub lobe: Lobe,
    /// What divides light between reflection and refraction.
    pub fresnel: Fresnel,
    /// What a first hit reflects takes its base colour, metal or not: the picture is one light times albedo. Filters go on
    /// seeing two lobes.
    pub one_lobe: bool,
    /// Where random numbers come from.
    pub noise: Noise,
    /// Voxels keep radiance from frame to frame, and paths read it from their second hit on. Bounces are then without a
    /// limit, if there is more than one.
    pub cache: bool,
    /// Voxels are in nested levels.
    pub levels: bool,
}

impl Default for PathSettings {
    fn default() -> Self {
        Self {
            spp: 1,
            bounces: Some(3),
            samples: SampleRule::default(),
            roulette_from: 8,
            both_branches: true,
            shadow_rays: true,
            build: PathBuild::default(),
        }
    }
}

impl Default for PathBuild {
    fn default() -> Self {
        Self {
            conventions: Conventions::default(),
            next_event: true,
            lobe: Lobe::default(),
            fresnel: Fresnel::default(),
            one_lobe: false,
            noise: Noise::default(),
            cache: false,
            levels: false,
        }
    }
}

impl PathBuild {
    /// Of the lobes.
    pub fn rules(&self) -> Rules {
        let lossy = self.conventions == Conventions::Reference;
        Rules { lobe: self.lobe, fresnel: self.fresnel, lossy }
    }
}

/// The choices among [`PathSettings`] by their place in a knob's list, while knobs are lent out.
#[derive(Clone, Copy, Debug)]
pub struct PathChoices {
    samples: u32,
    conventions: u32,
    lobe: u32,
    fresnel: u32,
    noise: u32,
}

impl PathSettings {
    /// Paths that a pixel of a frame may get.
    pub fn most_samples(&self) -> u32 {
        match self.samples {
            SampleRule::Fixed => self.spp,
            SampleRule::Roughness => MOST_BY_ROUGHNESS,
            SampleRule::Variance => Division::of(self.spp).most(),
        }
    }

    /// The choices as they are; give them back by [`PathSettings::choose`].
    pub fn choices(&self) -> PathChoices {
        PathChoices {
            samples: self.samples as u32,
            conventions: self.build.conventions as u32,
            lobe: self.build.lobe as u32,
            fresnel: self.build.fresnel as u32,
            noise: self.build.noise as u32,
        }
    }

    /// Takes choices that knobs may have changed.
    pub fn choose(&mut self, choices: PathChoices) {
        let is_second = |choice: u32| choice == 1;
        self.samples = match choices.samples {
            0 => SampleRule::Fixed,
            1 => SampleRule::Roughness,
            _ => SampleRule::Variance,
        };
        self.build.conventions =
            if is_second(choices.conventions) { Conventions::Reference } else { Conventions::Gridlight };
        self.build.lobe = if is_second(choices.lobe) { Lobe::Paper } else { Lobe::Ggx };
        self.build.fresnel = if is_second(choices.fresnel) { Fresnel::Schlick } else { Fresnel::Exact };
        self.build.noise = Noise::of_knob(choices.noise);
    }

    /// What `--set tracer.…` reaches, beside `--spp` and `--bounces`.
    pub fn knobs<'a>(&'a mut self, choices: &'a mut PathChoices) -> Vec<Knob<'a>> {
        vec![
            Knob::choice(
                "conventions",
                &mut choices.conventions,
                &["gridlight", "reference"],
                "whose rules of masking, lost light and normal maps: ours, or those the shared reference images were made with",
            ),
            Knob::choice(
                "samples",
                &mut choices.samples,
                &["fixed", "roughness", "variance"],
                "paths per pixel: --spp everywhere; 1 to 6 by roughness as in the paper, whatever --spp says; or --spp in \
                 the mean, half of them where the light is noisy",
            ),
            Knob::choice(
                "lobe",
                &mut choices.lobe,
                &["ggx", "paper"],
                "what glossy surfaces reflect into: GGX facets, or the mirror direction moved by a tenth of the roughnesses",
            ),
            Knob::choice(
                "fresnel",
                &mut choices.fresnel,
                &["exact", "schlick"],
                "what divides light between reflection and refraction in glass; schlick, the paper's, is off by up to 0.04 \
                 at an index of 1.5",
            ),
            Knob::choice(
                "noise",
                &mut choices.noise,
                &Noise::NAMES,
                "random numbers: the paper's texture in space, blue noise with R2 and a hash after it, or scrambled Sobol; \
                 docs/light.md has what each costs",
            ),
            Knob::bool(
                "one_lobe",
                &mut self.build.one_lobe,
                "the picture is light times base colour, as in the paper: highlights take the colour of what they lie on",
            ),
            Knob::bool(
                "shadow_rays",
                &mut self.shadow_rays,
                "each vertex sends a ray to one sun, point, spot or directional light; off leaves them out, as in the paper",
            ),
            Knob::bool(
                "both_branches",
                &mut self.both_branches,
                "smooth glass seen directly shows its reflection and what lies behind it in every sample; off flips a coin",
            ),
            Knob::bool(
                "next_event",
                &mut self.build.next_event,
                "each vertex sends a ray to an emitter or to a bright part of the sky, weighted against finding it by \
                 chance; off is the paper's way: more noise, less time a path",
            ),
            Knob::bool(
                "cache",
                &mut self.build.cache,
                "voxels keep diffuse light from frame to frame, and paths end where they read it: all bounces for the \
                 price of one, a few frames late",
            ),
            Knob::int(
                "roulette_from",
                &mut self.roulette_from,
                1..=512,
                "scatterings",
                "with --bounces inf, paths may be ended at random from here on; lower is faster and noisier; \
                 8 is what the reference images use",
            ),
        ]
    }
}
