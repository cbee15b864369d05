//! The paper's upsampler: takes the light of the nearest trace pixel that faces as the display pixel does.
//!
//! Paper: "an outward search from the center fragment to find the best candidate".
//!
//! In: light and G-buffer at trace size, G-buffer at display size. Out: the picture at display size, through
//! [`crate::modulate`]. With n, x (m), z (m) the normal, position and distance of display pixel p, and c the trace pixel
//! under its centre:
//!
//! - Candidates are the pixels of rings 0 to `rings` about c, ordered by their distance from c *on the display* (trace
//!   pixels need not be square), then by ring, row and column.
//! - One counts for a lobe if it hit something, was traced, and its surface has the lobe.
//! - The first with `n . n_q >= least_cosine` and `|n . (x_q - x)| <= plane_distance z` is taken. If none is, the one
//!   with the greatest `n . n_q`; if none counts at all, c. The pixels that had to do with less are counted as
//!   `upsample_fallbacks`.
//! - Both lobes are searched in one loop and may end at different pixels; a lobe that p's surface lacks is not searched
//!   and gets no light. Light is copied from one pixel, never mixed: mirrors keep their picture.
//! - At equal sizes c is p itself, and its light is taken without a search.
//!
//! Departs from the paper: the plane test, because with normals alone light leaks between parallel walls behind each
//! other (`plane_test=off` is the paper's reading); two lobes; nothing else. The paper gives no number for "highly
//! similar", nor a radius: knobs.

pub mod reference;

use crate::{Upsampler, modulate};
use frame::info::FrameInfo;
use frame::scene_gpu::GpuScene;
use frame::{
    Bind, Buffer, ColorImage, GBuffer, Gpu, GpuError, Kernel, KernelDesc, Knob, RadianceImage, Recorder,
    Room, Uniform, gpu_struct,
};

/// Rings about the centre at most.
pub const RINGS: u32 = 3;
const OFFSETS: usize = (2 * RINGS as usize + 1).pow(2);

gpu_struct! {
    /// See `best_candidate.wgsl`.
    pub struct BestCandidateParams {
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

    fn params(
        &self,
        frame: &FrameInfo,
        light: &RadianceImage,
        direct: Option<&RadianceImage>,
    ) -> BestCandidateParams {
        let offsets = self.offsets(frame.trace_size, frame.display_size);
        let mut packed = [[0; 4]; OFFSETS.div_ceil(4)];
        for (word, [dx, dy]) in packed.as_flattened_mut().iter_mut().zip(&offsets) {
            *word = (*dx as u32 & 0xffff) | ((*dy as u32) << 16);
        }
        BestCandidateParams {
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

const WORKGROUP: [u32; 3] = [8, 8, 1];
const NAME: &str = "upsample/best_candidate";

/// The paper's upsampler.
pub struct BestCandidate {
    settings: Settings,
    kernel: Kernel,
    fallbacks: Buffer,
    picture: ColorImage,
}

impl BestCandidate {
    /// Compiles its kernel.
    ///
    /// # Errors
    /// The kernel was refused.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let own = [
            Bind::uniform::<BestCandidateParams>(0, 1, "params"),
            Bind::texture_uint(2, 6, "trace_surface"),
            Bind::texture(2, 7, "trace_distance"),
            Bind::texture_uint(2, 8, "light_samples"),
            Bind::storage_texture(3, 0, "out_color", ColorImage::FORMAT),
            Bind::storage(3, 1, "out_fallbacks"),
        ];
        let kernel = Kernel::new(
            gpu,
            &KernelDesc {
                name: NAME,
                sources: &[&modulate::SOURCES[..], &[include_str!("best_candidate.wgsl")]].concat(),
                entry: "best_candidate",
                workgroup: WORKGROUP,
                bindings: &[&modulate::BINDS[..], &own].concat(),
                constants: &[],
            },
        )?;
        Ok(Self {
            settings: Settings::default(),
            kernel,
            fallbacks: gpu.storage(Room::Radiance, "BestCandidate::fallbacks", &[0u32; 2])?,
            picture: ColorImage::new(gpu, [1, 1])?,
        })
    }
}

impl Upsampler for BestCandidate {
    fn name(&self) -> &'static str {
        "best_candidate"
    }

    fn knobs(&mut self) -> Vec<Knob<'_>> {
        let Settings { rings, least_cosine, plane_test, plane_distance } = &mut self.settings;
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

    fn history_bytes(&self) -> u64 {
        0
    }

    fn resize(&mut self, gpu: &Gpu, display_size: [u32; 2], _specular: bool) -> Result<(), GpuError> {
        self.picture = ColorImage::new(gpu, display_size)?;
        Ok(())
    }

    fn upsample(
        &mut self,
        recorder: &mut Recorder<'_>,
        frame: &FrameInfo,
        uniform: &Uniform,
        scene: &GpuScene,
        trace: &GBuffer,
        light: &RadianceImage,
        display: &GBuffer,
        direct: Option<&RadianceImage>,
    ) -> ColorImage {
        use wgpu::BindingResource::TextureView as View;
        recorder.clear(&self.fallbacks);
        let params = recorder.uniform(&self.settings.params(frame, light, direct));
        let mut resources = modulate::resources(uniform, scene, light, display, direct).to_vec();
        resources.extend([
            params.binding(),
            View(trace.surface.view()),
            View(trace.distance.view()),
            View(light.samples.view()),
            View(self.picture.texture.view()),
            self.fallbacks.as_entire_binding(),
        ]);
        let [width, height] = self.picture.size();
        let workgroups = [width.div_ceil(WORKGROUP[0]), height.div_ceil(WORKGROUP[1]), 1];
        recorder.compute(NAME, &self.kernel, &resources, workgroups);
        recorder.output(NAME, &self.picture.texture);
        recorder.counter("upsample_fallbacks", &self.fallbacks, 0);
        self.picture.clone()
    }
}

#[cfg(test)]
mod tests;
