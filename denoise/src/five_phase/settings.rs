//! What the paper leaves open about its blur, as settings, and the passes that follow from them.

use super::{GuideParams, PhaseParams};
use frame::{FrameInfo, Knob};

/// Phases of the blur, the paper's.
pub const PHASES: usize = 5;

/// Settings of the blur. Lengths in metres of the world, radii in trace rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Least overall roughness that phase k filters.
    pub tau: [f32; PHASES],
    /// Half width of phase k next to the viewer.
    pub kernel_radius: [u32; PHASES],
    /// What each growth step adds to the half width, and the most it adds.
    pub radius_growth: [f32; 2],
    /// Radial cut-off of phase k next to the viewer.
    pub radial_cutoff: [f32; PHASES],
    /// What each growth step adds to the cut-off, and the most it adds.
    pub cutoff_growth: [f32; 2],
    /// Metres from the viewer per growth step.
    pub growth_step: f32,
    /// Index into [`ORDERS`].
    pub order: u32,
    /// Index into [`FALLOFFS`].
    pub falloff: u32,
    /// A tap must be of the phase's bracket, too.
    pub same_bracket: bool,
    /// Index into [`BORDERS`].
    pub border: u32,
    /// Index into [`CUTOFFS`].
    pub cutoff: u32,
    /// Index into [`SCALES`].
    pub scale: u32,
    /// Index into [`PRESETS`].
    pub preset: u32,
}

/// Orders of the ten passes.
pub const ORDERS: &[&str] = &["ascending", "axes", "descending"];
/// Weights over the kernel.
pub const FALLOFFS: &[&str] = &["box", "triangular"];

/// What lies beyond the picture.
pub const BORDERS: &[&str] = &["nothing", "mirror"];
/// What the radial cut-off is measured on.
pub const CUTOFFS: &[&str] = &["points", "distances"];
/// What a half width counts.
pub const SCALES: &[&str] = &["rows", "height"];
/// Whose numbers the knobs start from.
pub const PRESETS: &[&str] = &["paper", "tuned"];

/// Rows that the half widths are made for, where they scale with the picture.
const HEIGHT: f32 = 480.0;

impl Default for Settings {
    fn default() -> Self {
        Self {
            tau: [0.02, 0.2, 0.4, 0.6, 0.8],
            kernel_radius: [1, 2, 3, 4, 6],
            radius_growth: [1.0, 8.0],
            radial_cutoff: [0.05, 0.1, 0.2, 0.3, 0.5],
            cutoff_growth: [0.05, 2.0],
            growth_step: 1.2192,
            order: 0,
            falloff: 0,
            same_bracket: true,
            border: 0,
            cutoff: 0,
            scale: 0,
            preset: 0,
        }
    }
}

/// Which way a pass blurs; the paper calls this a pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// Along a row.
    Horizontal,
    /// Along a column.
    Vertical,
}

impl Axis {
    /// As pass names have it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Horizontal => "horizontal",
            Self::Vertical => "vertical",
        }
    }
}

const TAU_NAMES: [&str; PHASES] = ["tau0", "tau1", "tau2", "tau3", "tau4"];
const RADIUS_NAMES: [&str; PHASES] = ["k0", "k1", "k2", "k3", "k4"];
const CUTOFF_NAMES: [&str; PHASES] = ["rho0", "rho1", "rho2", "rho3", "rho4"];

/// The tuned preset: small kernels that do not grow, cut-offs of less than half.
const TUNED_RADIUS: [u32; PHASES] = [1, 1, 2, 3, 4];
const TUNED_CUTOFF: [f32; PHASES] = [0.02, 0.04, 0.08, 0.12, 0.2];
const TUNED_RADIUS_GROWTH: f32 = 0.0;
const TUNED_CUTOFF_GROWTH: f32 = 0.02;

const TAU_DOC: &str = "least overall roughness that this phase filters; higher keeps more of glossy reflections and \
     their noise. The paper gives no edges: five equal brackets, the first cut down to 0.02 so that only mirrors are \
     left out";
const RADIUS_DOC: &str = "half width of this phase next to the viewer, in trace rows; wider costs taps and detail, \
     narrower leaves noise. The paper gives none: together these five leave 1/343 of the variance of a flat wall";
const CUTOFF_DOC: &str = "taps farther away in the world than this are left out; higher smears contact shadows, lower \
     leaves noise. The paper gives none: many kernel widths on a wall 3 m away in 480 rows, so that only depth \
     edges are cut";

impl Settings {
    /// All of them, lent out.
    pub fn knobs(&mut self) -> Vec<Knob<'_>> {
        let mut knobs = Vec::new();
        for (name, value) in TAU_NAMES.into_iter().zip(&mut self.tau) {
            knobs.push(Knob::float(name, value, 0.0..=1.0, "", TAU_DOC));
        }
        for (name, value) in RADIUS_NAMES.into_iter().zip(&mut self.kernel_radius) {
            knobs.push(Knob::int(name, value, 0..=32, "px", RADIUS_DOC));
        }
        for (name, value) in CUTOFF_NAMES.into_iter().zip(&mut self.radial_cutoff) {
            knobs.push(Knob::float(name, value, 0.0..=100.0, "m", CUTOFF_DOC));
        }
        let [radius, radius_max] = &mut self.radius_growth;
        let [cutoff, cutoff_max] = &mut self.cutoff_growth;
        knobs.extend([
            Knob::float(
                "k_growth",
                radius,
                0.0..=8.0,
                "px",
                "added to each half width per growth_step of distance; higher blurs more far away. The paper grows \
                 the kernel and names no amount: one, the least there is",
            ),
            Knob::float(
                "k_growth_max",
                radius_max,
                0.0..=32.0,
                "px",
                "the most that distance adds to a half width; bounds the cost. Ours: reached at 9.75 m, where a room \
                 ends",
            ),
            Knob::float(
                "rho_growth",
                cutoff,
                0.0..=10.0,
                "m",
                "added to each cut-off per growth_step of distance. The paper grows it and names no amount: as much \
                 as phase 0 has next to the viewer",
            ),
            Knob::float(
                "rho_growth_max",
                cutoff_max,
                0.0..=100.0,
                "m",
                "the most that distance adds to a cut-off. Ours: below the depth of a room",
            ),
            Knob::float(
                "growth_step",
                &mut self.growth_step,
                0.01..=100.0,
                "m",
                "distance from the viewer per step of growth: the paper's four feet",
            ),
            Knob::choice(
                "order",
                &mut self.order,
                ORDERS,
                "ascending: phases 0 to 4, each along rows, then columns; axes: all phases along rows, then all along \
                 columns (the paper's \"two-pass\", read literally); descending: phases 4 to 0. The paper does not \
                 say; ascending, because the wide kernels then meet the least noise",
            ),
            Knob::choice(
                "falloff",
                &mut self.falloff,
                FALLOFFS,
                "weights over the kernel; triangular hides its edges and leaves more noise. The paper names only the \
                 normals' weight: box",
            ),
            Knob::bool(
                "same_bracket",
                &mut self.same_bracket,
                "a tap must be of the phase's bracket or above, too; off lets the picture in a mirror bleed into rough \
                 neighbours. The paper speaks of the fragment only: on",
            ),
            Knob::choice(
                "border",
                &mut self.border,
                BORDERS,
                "what lies beyond the picture. mirror keeps the light of what is next to the border, nothing counts it up to \
                 twice. The paper does not say: nothing, the plainest reading",
            ),
            Knob::choice(
                "cutoff",
                &mut self.cutoff,
                CUTOFFS,
                "what the radial cut-off is measured on: points, the distance between two in the world; distances, the \
                 difference of theirs from the viewer, which lets walls across the view blur farther. The paper says radial: \
                 points",
            ),
            Knob::choice(
                "scale",
                &mut self.scale,
                SCALES,
                "what half widths count: rows; or height, rows of a picture 480 high, so that another size looks alike. The \
                 paper has one size only: rows",
            ),
            Knob::choice(
                "preset",
                &mut self.preset,
                PRESETS,
                "whose numbers the knobs start from; those that were moved keep their value. paper: the plainest reading; \
                 tuned: the least error at the same cost or less (docs/denoisers.md)",
            ),
        ]);
        knobs
    }

    /// The ten passes in order: phase and axis.
    pub fn schedule(&self) -> [(usize, Axis); 2 * PHASES] {
        use Axis::{Horizontal, Vertical};
        std::array::from_fn(|i| {
            let axis = if i % 2 == 0 { Horizontal } else { Vertical };
            match self.order {
                0 => (i / 2, axis),
                1 => (i % PHASES, if i < PHASES { Horizontal } else { Vertical }),
                _ => (PHASES - 1 - i / 2, axis),
            }
        })
    }

    /// For the guide. A threshold becomes the first of the 256 roughness codes that reaches it, so that a code which
    /// lies on a threshold is not left to the rounding of a division; 0.001 code forgives the threshold's own.
    pub fn guide_params(&self, has_specular: bool) -> GuideParams {
        let [first @ .., last] = self.tau.map(|tau| (255.0 * tau - 1e-3).ceil().max(0.0) as u32);
        GuideParams {
            thresholds: first,
            last_threshold: last,
            has_specular: u32::from(has_specular),
            _pad: [0; 2],
        }
    }

    /// With the preset's numbers for every knob of its that still has its default.
    pub fn effective(&self) -> Self {
        let (mut settings, paper) = (*self, Self::default());
        if self.preset == 0 {
            return settings;
        }
        if settings.kernel_radius == paper.kernel_radius {
            settings.kernel_radius = TUNED_RADIUS;
        }
        if settings.radial_cutoff == paper.radial_cutoff {
            settings.radial_cutoff = TUNED_CUTOFF;
        }
        if settings.radius_growth[0] == paper.radius_growth[0] {
            settings.radius_growth[0] = TUNED_RADIUS_GROWTH;
        }
        if settings.cutoff_growth[0] == paper.cutoff_growth[0] {
            settings.cutoff_growth[0] = TUNED_CUTOFF_GROWTH;
        }
        if settings.border == paper.border {
            settings.border = 1;
        }
        settings
    }

    /// For one pass.
    pub fn phase_params(&self, phase: usize, axis: Axis, frame: &FrameInfo) -> PhaseParams {
        let along = if axis == Axis::Horizontal { frame.columns_per_row() } else { 1.0 };
        let scale = if self.scale == 1 { frame.trace_size[1] as f32 / HEIGHT } else { 1.0 };
        PhaseParams {
            step: if axis == Axis::Horizontal { [1, 0] } else { [0, 1] },
            phase: phase as u32,
            radius_scale: along * scale,
            kernel_radius: self.kernel_radius[phase] as f32,
            radius_growth: self.radius_growth[0],
            radius_growth_max: self.radius_growth[1],
            radial_cutoff: self.radial_cutoff[phase],
            cutoff_growth: self.cutoff_growth[0],
            cutoff_growth_max: self.cutoff_growth[1],
            growth_step: self.growth_step,
            is_triangular: u32::from(self.falloff == 1),
            same_bracket: u32::from(self.same_bracket),
            is_mirrored: self.border,
            by_depth: self.cutoff,
            _pad: 0,
        }
    }
}
