//! The kernels of a scene: what it does not have is not in them.

use super::{PASSES, PathBuild, PathParams, Structure, cache, variance};
use crate::{lights, noise};
use frame::scene_gpu::{self, GpuScene};
use frame::{Bind, Gpu, GpuError, Kernel, KernelDesc, RadianceImage, brdf, info, surface};
use wgpu::TextureFormat;

const PARAMS_WGSL: &str = "
struct PathParams {
    sample: u32, samples: u32, first_sample: u32, bounces: u32,
    lights: u32, rule: u32, roulette_from: u32, segments: u32,
    first_row: u32, rows: u32, has_areas: u32, emitter_count: u32,
    lights_stored: u32, emitter_share: f32, emitter_total: f32, sky_share: f32,
    branch: u32, feed_share: f32, even: u32, rest: u32,
}
// One would do. Where a uniform alone decides a branch, Mesa's software driver builds the kernel anew for each dispatch
// with the uniform's value in it; an index that it cannot foresee (0: there is one layer of groups) keeps it from that.
@group(0) @binding(1) var<uniform> params_of: array<PathParams, 2>;
var<private> params: PathParams;";
const PATH_WGSL: &str = include_str!("path.inc.wgsl");
const SEGMENT_WGSL: &str = include_str!("segment.inc.wgsl");
const PIXEL_WGSL: &str = include_str!("pixel.inc.wgsl");
const PIXEL_CAMERA_WGSL: &str = include_str!("pixel_camera.inc.wgsl");
const FIRST_GBUFFER_WGSL: &str = include_str!("first_gbuffer.inc.wgsl");
const FIRST_CAMERA_WGSL: &str = include_str!("first_camera.inc.wgsl");

const PATHS: Bind = Bind::storage(1, 30, "paths");
const PIXELS: Bind = Bind::storage(1, 31, "pixels");
const COUNTERS: Bind = Bind::storage(1, 33, "counters");
const OF_FRAME: [Bind; 2] =
    [Bind::uniform::<info::Frame>(0, 0, "frame"), Bind::uniform_array(0, 1, "params_of").of::<PathParams>()];

/// What every vertex of a path reads.
const OF_SCENE: [Bind; 4] =
    [scene_gpu::SKY_BIND, scene_gpu::SKY_TABLE_BIND, scene_gpu::BRDF_TABLE_BIND, scene_gpu::LIGHTS_BIND];

/// Makes kernels of one structure for one scene.
pub(super) struct Workshop<'a> {
    pub(super) gpu: &'a Gpu,
    pub(super) structure: &'a Structure,
    pub(super) scene: &'a GpuScene,
    pub(super) build: PathBuild,
    /// A pixel's first hit comes from its own camera ray, not from the G-buffer.
    pub(super) camera: bool,
}

impl Workshop<'_> {
    fn pixel(&self) -> &'static str {
        if self.camera { PIXEL_CAMERA_WGSL } else { PIXEL_WGSL }
    }

    /// Of one invocation per pixel.
    fn of_pixels(&self, entry: &str, last: &[&str], bindings: &[Bind]) -> Result<Kernel, GpuError> {
        self.kernel(entry, [8, 8, 1], last, bindings)
    }

    fn kernel(
        &self,
        entry: &str,
        workgroup: [u32; 3],
        last: &[&str],
        bindings: &[Bind],
    ) -> Result<Kernel, GpuError> {
        let shared = [
            info::WGSL,
            surface::WGSL,
            brdf::WGSL,
            noise::WGSL,
            scene_gpu::LIGHT_WGSL,
            lights::WGSL,
            scene_gpu::SKY_WGSL,
            scene_gpu::SKY_TABLE_WGSL,
            PARAMS_WGSL,
            self.pixel(),
        ];
        let sources: Vec<&str> =
            shared.iter().chain(&self.structure.sources).chain(&[PATH_WGSL]).chain(last).copied().collect();
        let needs = &self.scene.needs;
        let mut constants = vec![
            ("path_lights", f64::from(needs.shadow_rays)),
            ("path_areas", f64::from(self.build.next_event && self.scene.has_areas())),
            ("path_specular", f64::from(needs.specular)),
            ("path_cache", f64::from(self.has_cache())),
            ("path_one_lobe", f64::from(self.build.one_lobe)),
            ("path_transmission", f64::from(needs.transmission)),
            ("path_coverage", f64::from(needs.coverage)),
            ("path_passes", f64::from(PASSES)),
            ("noise_kind", f64::from(self.build.noise as u32)),
        ];
        constants.extend(self.build.rules().constants());
        if self.structure.of_triangles {
            constants.extend(self.scene.constants());
            constants.extend(self.build.conventions.of_triangles());
        }
        let desc =
            KernelDesc { name: entry, sources: &sources, entry, workgroup, bindings, constants: &constants };
        Ok(Kernel::new(self.gpu, &desc)?)
    }

    /// Bindings: frame, params, noise, sky, its table, BRDF table, lights, the structure's, paths, pixels, counters; then the
    /// G-buffer, if it is read.
    pub(super) fn start(&self) -> Result<Kernel, GpuError> {
        let mut bindings = OF_FRAME.to_vec();
        bindings.push(noise::MASK_BIND);
        bindings.extend(OF_SCENE);
        bindings.extend(&self.structure.binds);
        bindings.extend([PATHS, PIXELS, COUNTERS]);
        if !self.camera {
            bindings.extend([
                Bind::texture_uint(2, 0, "in_surface"),
                Bind::texture(2, 1, "in_distance"),
                Bind::texture_uint(2, 2, "in_face_normal"),
                Bind::texture_uint(2, 3, "in_motion_id"),
            ]);
        }
        let first = if self.camera { FIRST_CAMERA_WGSL } else { FIRST_GBUFFER_WGSL };
        self.of_pixels("path_start", &[noise::STRATIFIED_WGSL, first, include_str!("start.wgsl")], &bindings)
    }

    /// Voxels keep radiance for these paths.
    pub(super) fn has_cache(&self) -> bool {
        self.build.cache && cache::is_for(self.structure)
    }

    /// Bindings: frame, params, sky, its table, BRDF table, lights, the structure's, paths, pixels, counters; then the cache,
    /// if there is one.
    fn of_vertex(&self) -> Vec<Bind> {
        let mut bindings = OF_FRAME.to_vec();
        bindings.extend(OF_SCENE);
        bindings.extend(&self.structure.binds);
        bindings.extend([PATHS, PIXELS, COUNTERS]);
        if self.has_cache() {
            bindings.push(cache::BIND);
        }
        bindings
    }

    /// Bindings: those of a vertex.
    pub(super) fn segment(&self) -> Result<Kernel, GpuError> {
        let cache = if self.has_cache() { cache::WGSL } else { cache::NONE_WGSL };
        let sources = [cache, SEGMENT_WGSL, include_str!("segment.wgsl")];
        self.of_pixels("path_segment", &sources, &self.of_vertex())
    }

    /// Bindings: those of a vertex.
    pub(super) fn feed(&self) -> Result<Kernel, GpuError> {
        self.of_pixels("path_feed", &[cache::WGSL, cache::FEED_WGSL], &self.of_vertex())
    }

    /// Bindings: those of a vertex.
    pub(super) fn feed_segment(&self) -> Result<Kernel, GpuError> {
        let sources = [cache::WGSL, SEGMENT_WGSL, cache::FEED_SEGMENT_WGSL];
        self.of_pixels("path_feed_segment", &sources, &self.of_vertex())
    }

    /// Bindings: frame, params, paths, pixels, the cache.
    pub(super) fn store(&self) -> Result<Kernel, GpuError> {
        let mut bindings = OF_FRAME.to_vec();
        bindings.extend([PATHS, PIXELS, cache::BIND]);
        self.of_pixels("path_store", &[cache::WGSL, cache::STORE_WGSL], &bindings)
    }

    /// Bindings: the cache.
    pub(super) fn regions(&self) -> Result<Kernel, GpuError> {
        self.kernel("path_regions", [64, 1, 1], &[cache::WGSL, cache::STORE_WGSL], &[cache::BIND])
    }

    /// Bindings: frame, params and pixels where it is `of_pixels`, the sums where it is `of_sums`.
    pub(super) fn variance(
        &self,
        entry: &'static str,
        [of_pixels, of_sums]: [bool; 2],
        of_weights: bool,
    ) -> Result<Kernel, GpuError> {
        let mut bindings = Vec::new();
        if of_pixels {
            bindings.extend(OF_FRAME);
            bindings.push(PIXELS);
        }
        if of_sums {
            bindings.push(variance::SUMS);
        }
        let sources = [
            info::WGSL,
            noise::WGSL,
            PARAMS_WGSL,
            self.pixel(),
            "@group(1) @binding(31) var<storage, read_write> pixels: array<Pixel>;
fn path_index(id: vec2u) -> u32 { return id.y * frame.trace_size.x + id.x; }",
            variance::WGSL,
        ];
        let constants = [
            ("noise_kind", f64::from(self.build.noise as u32)),
            ("variance_of_weights", f64::from(of_weights)),
        ];
        let workgroup = [8, 8, 1];
        let desc = KernelDesc {
            name: entry,
            sources: &sources,
            entry,
            workgroup,
            bindings: &bindings,
            constants: &constants,
        };
        Ok(Kernel::new(self.gpu, &desc)?)
    }

    /// Bindings: frame, params, sky, the structure's, pixels, counters.
    pub(super) fn camera_ray(&self) -> Result<Kernel, GpuError> {
        let mut bindings = OF_FRAME.to_vec();
        bindings.push(scene_gpu::SKY_BIND);
        bindings.extend(&self.structure.binds);
        bindings.extend([PIXELS, COUNTERS]);
        self.of_pixels("path_camera", &[FIRST_CAMERA_WGSL, include_str!("camera.wgsl")], &bindings)
    }

    /// Bindings: frame, params, table, pixels, moments.
    pub(super) fn moments(&self) -> Result<Kernel, GpuError> {
        let mut bindings = OF_FRAME.to_vec();
        bindings.extend([scene_gpu::BRDF_TABLE_BIND, PIXELS, Bind::storage(3, 0, "moments")]);
        self.of_pixels("path_moments", &[FIRST_CAMERA_WGSL, include_str!("moments.wgsl")], &bindings)
    }
}

/// Bindings: frame, pixels, counters, both lobes, sample counts.
pub(super) fn resolve(gpu: &Gpu) -> Result<Kernel, GpuError> {
    let bindings = [
        OF_FRAME[0],
        Bind::storage_read(1, 31, "pixels"),
        COUNTERS,
        Bind::storage_texture(3, 0, "out_diffuse", RadianceImage::FORMAT),
        Bind::storage_texture(3, 1, "out_specular", RadianceImage::FORMAT),
        Bind::storage_texture(3, 2, "out_samples", TextureFormat::R32Uint),
    ];
    let sources = [info::WGSL, frame::HALF_WGSL, PIXEL_WGSL, include_str!("resolve.wgsl")];
    let desc = KernelDesc {
        name: "path_resolve",
        sources: &sources,
        entry: "path_resolve",
        workgroup: [8, 8, 1],
        bindings: &bindings,
        constants: &[],
    };
    Ok(Kernel::new(gpu, &desc)?)
}
