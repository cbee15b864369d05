//! What a display pixel asks of the trace pixels around it, and the outward search for the best of them.
//!
//! Paper: "an outward search from the center fragment to find the best candidate", for whoever searches:
//! [`crate::best_candidate`] alone, [`crate::joint_bilateral`] and [`crate::temporal`] where their own taps fail.
//!
//! In: light and G-buffer at trace size, G-buffer at display size. With n, x (m), z (m) the normal, position and distance of
//! display pixel p, and c the trace pixel under its centre:
//!
//! - A trace pixel counts for a lobe if it hit something, was traced, and its surface has the lobe.
//! - Candidates are the pixels of rings 0 to `rings` about c, ordered by their distance from c *on the display* (trace
//!   pixels need not be square), then by ring, row and column.
//! - The first with `n . n_q >= least_cosine` and `|n . (x_q - x)| <= plane_distance z` is taken. If none is, the one
//!   with the greatest `n . n_q`; if none counts at all, c.
//! - Both lobes are searched in one loop and may end at different pixels.

pub(crate) mod mix;
pub(crate) mod reference;

use crate::modulate;
use frame::info::FrameInfo;
use frame::{Bind, GBuffer, Knob, RadianceImage, Uniform, gpu_struct};
use wgpu::BindingResource;

/// Rings about the centre at most.
pub const RINGS: u32 = 3;
const OFFSETS: usize = (2 * RINGS as usize + 1).pow(2);

gpu_struct! {
    /// See `search.inc.wgsl`.
    pub struct SearchParams {
        /// dx in the low half, dy in the high half, nearest first.
        pub offsets: [[u32; 4]; OFFSETS.div_ceil(4)],
        /// How many of them.
        pub offset_count: u32,
        /// Of the angle between normals.
        pub least_cosine: f32,
        /// Metres off the plane per metre of distance; negative: no test.
        pub plane_distance: f32,
        /// 0: one lobe only.
        pub has_specular: u32,
        /// Lobes of direct light.
        pub direct_lobes: u32,
        /// To 16 bytes.
        pub _pad: [u32; 3],
    }
}

/// Settings of the search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Rings about the centre.
    pub rings: u32,
    /// Cosine of the angle between normals from which on they are "highly similar".
    pub least_cosine: f32,
    /// Whether a candidate must lie on the pixel's plane.
    pub plane_test: bool,
    /// How far from the plane, in metres per metre of distance.
    pub plane_distance: f32,
}

impl Default for Settings {
    fn default() -> Self {
        Self { rings: RINGS, least_cosine: 0.95, plane_test: true, plane_distance: 0.02 }
    }
}

impl Settings {
    /// As knobs.
    pub(crate) fn knobs(&mut self) -> Vec<Knob<'_>> {
        let Self { rings, least_cosine, plane_test, plane_distance } = self;
        vec![
            Knob::int(
                "rings",
                rings,
                0..=RINGS,
                "px",
                "rings of trace pixels searched; more finds light behind thin things and costs time there. The paper \
                 gives none: 3, beyond which light is seldom the right one",
            ),
            Knob::float(
                "least_cosine",
                least_cosine,
                -1.0..=1.0,
                "",
                "least cosine between normals to be taken at once; higher follows creases and normal maps and searches \
                 longer. The paper says \"highly similar\": 0.95, 18 degrees",
            ),
            Knob::bool(
                "plane_test",
                plane_test,
                "a candidate must also lie on the pixel's plane; off lets light leak between parallel surfaces behind \
                 each other. The paper names normals only: off there, on by default",
            ),
            Knob::float(
                "plane_distance",
                plane_distance,
                0.0..=1.0,
                "",
                "metres off the pixel's plane allowed per metre of distance; lower searches longer on curved things. \
                 Ours: 0.02, the plane test of NRD",
            ),
        ]
    }

    /// Steps to all candidates in the order they are tried.
    pub fn offsets(&self, trace_size: [u32; 2], display_size: [u32; 2]) -> Vec<[i32; 2]> {
        let rings = self.rings.min(RINGS) as i32;
        let mut offsets: Vec<[i32; 2]> =
            (-rings..=rings).flat_map(|dy| (-rings..=rings).map(move |dx| [dx, dy])).collect();
        // Squared length on the display, times both trace sizes squared so that it stays an integer: ties are exact.
        let length = |[dx, dy]: [i32; 2]| {
            let x = i128::from(dx) * i128::from(display_size[0]) * i128::from(trace_size[1]);
            let y = i128::from(dy) * i128::from(display_size[1]) * i128::from(trace_size[0]);
            x * x + y * y
        };
        offsets.sort_by_key(|&[dx, dy]| (length([dx, dy]), dx.abs().max(dy.abs()), dy, dx));
        offsets
    }

    pub(crate) fn params(
        &self,
        frame: &FrameInfo,
        light: &RadianceImage,
        direct: Option<&RadianceImage>,
    ) -> SearchParams {
        let offsets = self.offsets(frame.trace_size, frame.display_size);
        let mut packed = [[0; 4]; OFFSETS.div_ceil(4)];
        for (word, [dx, dy]) in packed.as_flattened_mut().iter_mut().zip(&offsets) {
            *word = (*dx as u32 & 0xffff) | ((*dy as u32) << 16);
        }
        SearchParams {
            offsets: packed,
            offset_count: offsets.len() as u32,
            least_cosine: self.least_cosine,
            plane_distance: if self.plane_test { self.plane_distance } else { -1.0 },
            has_specular: u32::from(light.specular.is_some()),
            direct_lobes: modulate::lobe_count(direct),
            _pad: [0; 3],
        }
    }
}

/// `mix_*`: light of several trace pixels, mixed by weight.
pub(crate) const MIX_WGSL: &str = include_str!("mix.inc.wgsl");

/// What comes before the shader of whoever searches.
pub(crate) fn sources<'a>(own: &[&'a str]) -> Vec<&'a str> {
    [&modulate::SOURCES[..], &[include_str!("search.inc.wgsl")], own].concat()
}

/// What these sources bind, then `own`.
pub(crate) fn binds(own: &[Bind]) -> Vec<Bind> {
    let search = [
        Bind::uniform::<SearchParams>(0, 1, "search_params"),
        Bind::texture_uint(2, 6, "trace_surface"),
        Bind::texture(2, 7, "trace_distance"),
        Bind::texture_uint(2, 8, "light_samples"),
    ];
    [&modulate::BINDS[..], &search, own].concat()
}

/// The resources of what [`binds`] puts after those of [`modulate`].
pub(crate) fn resources<'a>(
    params: &'a Uniform,
    trace: &'a GBuffer,
    light: &'a RadianceImage,
) -> [BindingResource<'a>; 4] {
    use BindingResource::TextureView as View;
    [params.binding(), View(trace.surface.view()), View(trace.distance.view()), View(light.samples.view())]
}
